//! One name, one meaning: no public type of the workspace is called as another.

use super::code;
use super::file::{Complaint, File};
use std::collections::BTreeMap;

const KINDS: [&str; 5] = ["struct", "enum", "trait", "type", "union"];

pub(super) fn check(files: &[File]) -> Vec<Complaint> {
    let mut places: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for file in files.iter().filter(|f| f.path.starts_with("crates/") && f.path.contains("/src/")) {
        for name in public_types(&file.text) {
            places.entry(name).or_default().push(&file.path);
        }
    }
    let shared = places.iter().filter(|(_, places)| places.len() > 1);
    shared
        .map(|(name, places)| format!("{name} is the name of several public types: {}", places.join(", ")))
        .collect()
}

/// Names of the types that a source declares as `pub`.
fn public_types(text: &str) -> Vec<String> {
    let blanked = code::blanked(text);
    let lines = code::without_tests(&blanked).lines().filter_map(|line| line.trim().strip_prefix("pub "));
    let declared = lines.filter_map(|line| {
        let (kind, rest) = line.split_once(' ')?;
        KINDS.contains(&kind).then(|| code::words(rest).next().map(String::from))?
    });
    declared.collect()
}

#[cfg(test)]
mod tests {
    use super::{super::file::file, *};

    #[test]
    fn behaviour_a_second_type_of_one_name_is_refused_until_it_is_known() {
        let files = [
            file("crates/a/src/lib.rs", "pub struct Fit<T>(T);\npub(crate) struct Own;\n"),
            file("crates/b/src/fit.rs", "    pub enum Fit {}\nstruct Own;\n"),
            file("crates/b/tests/a.rs", "pub struct Fit;"),
        ];
        let found = check(&files);
        assert_eq!(
            found,
            ["Fit is the name of several public types: crates/a/src/lib.rs, crates/b/src/fit.rs"]
        );
        assert!(check(&files[1..]).is_empty());
    }
}
