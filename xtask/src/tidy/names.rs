//! One name, one meaning: no public type of the workspace is called as another.

use super::code;
use super::file::{Complaint, File};
use std::collections::BTreeMap;

/// Names that still have more than one meaning, until they are told apart.
const KNOWN: [&str; 36] = [
    "Ambient",
    "BaseState",
    "Budget",
    "Calibration",
    "Campaign",
    "Chain",
    "Dual",
    "Duct",
    "Effect",
    "Entry",
    "Fault",
    "Fit",
    "Health",
    "LawError",
    "Layout",
    "March",
    "Method",
    "Misfit",
    "Mode",
    "Noise",
    "Observations",
    "Observed",
    "ParameterRecord",
    "Parameters",
    "Part",
    "Problem",
    "Reading",
    "Record",
    "Rig",
    "Run",
    "StatedChannels",
    "Stretch",
    "Tension",
    "Varying",
    "Wall",
    "Warning",
];

const KINDS: [&str; 5] = ["struct", "enum", "trait", "type", "union"];

pub(super) fn check(files: &[File]) -> Vec<Complaint> {
    check_with(files, &KNOWN)
}

fn check_with(files: &[File], known: &[&str]) -> Vec<Complaint> {
    let mut places: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for file in files.iter().filter(|f| f.path.starts_with("crates/") && f.path.contains("/src/")) {
        for name in public_types(&file.text) {
            places.entry(name).or_default().push(&file.path);
        }
    }
    places.retain(|_, places| places.len() > 1);
    let new = places.iter().filter(|(name, _)| !known.contains(&&***name));
    let mut complaints: Vec<Complaint> = new
        .map(|(name, places)| format!("{name} is the name of several public types: {}", places.join(", ")))
        .collect();
    for name in known.iter().filter(|name| !places.contains_key(**name)) {
        complaints.push(format!("{name} has one meaning now, take it off the list of tidy/names.rs"));
    }
    complaints
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
        let found = check_with(&files, &[]);
        assert_eq!(
            found,
            ["Fit is the name of several public types: crates/a/src/lib.rs, crates/b/src/fit.rs"]
        );
        assert!(check_with(&files, &["Fit"]).is_empty());
        assert!(check_with(&files[1..], &["Fit"])[0].contains("has one meaning now"));
    }
}
