//! No circle of files inside a crate: of two files that need each other, neither can be read first.

use super::code;
use super::file::{Complaint, File};
use std::collections::{BTreeMap, BTreeSet};

/// Modules of a crate (as `a::b`; empty for its root), each with its code.
type Modules = BTreeMap<String, String>;

pub(super) fn check(files: &[File]) -> Vec<Complaint> {
    let mut crates: BTreeMap<&str, Modules> = BTreeMap::new();
    for file in files {
        let Some((folder, inside)) = file.path.split_once("/src/") else { continue };
        let Some(name) = inside.strip_suffix(".rs") else { continue };
        let name = name.strip_suffix("/mod").unwrap_or(name);
        let name = if matches!(name, "lib" | "main") { "" } else { name }.replace('/', "::");
        let blanked = code::blanked(&file.text);
        crates.entry(folder).or_default().insert(name, code::without_tests(&blanked).to_owned());
    }
    let mut complaints = Vec::new();
    for (folder, modules) in &crates {
        for circle in circles(&edges(modules)) {
            complaints.push(format!("{folder}: these modules need each other: {}", circle.join(", ")));
        }
    }
    complaints
}

/// Which module names which, by `crate::`, `self::`, `super::` or the name of a child. Names that a module
/// only hands on (`pub use`) are followed to the module that has them, and handing on needs nothing.
fn edges(modules: &Modules) -> BTreeMap<&str, BTreeSet<&str>> {
    let named: BTreeMap<&str, Vec<(bool, String)>> =
        modules.iter().map(|(name, code)| (&**name, paths(name, code, modules))).collect();
    let mut handed_on: BTreeMap<String, String> = BTreeMap::new();
    for (module, paths) in &named {
        for (_, path) in paths.iter().filter(|(public, _)| *public) {
            let leaf = path.rsplit("::").next().unwrap_or(path);
            handed_on.insert(join(module, leaf), path.clone());
        }
    }
    let owner = |path: &str| {
        let mut path = path.to_owned();
        // A chain of modules that hand on ends, but two that hand on to each other would not.
        for _ in 0..9 {
            let next = prefixes(&path).find_map(|prefix| handed_on.get(prefix));
            let Some(next) = next.filter(|next| **next != path) else { break };
            path.clone_from(next);
        }
        prefixes(&path).find_map(|prefix| modules.get_key_value(prefix)).map_or("", |(module, _)| &**module)
    };
    let uses = |(module, paths): (&&'_ str, &Vec<(bool, String)>)| {
        let module = modules.get_key_value(*module).map_or("", |(name, _)| &**name);
        let used = paths.iter().filter(|(public, _)| !public).map(|(_, path)| owner(path));
        (module, used.filter(|used| *used != module).collect())
    };
    named.iter().map(uses).collect()
}

/// A path and all paths that it starts with, the longest first.
fn prefixes(path: &str) -> impl Iterator<Item = &str> {
    std::iter::successors(Some(path), |path| path.rsplit_once("::").map(|(head, _)| head))
}

/// The paths inside the crate that a module names, from the root, and whether it only hands them on.
fn paths(module: &str, code: &str, modules: &Modules) -> Vec<(bool, String)> {
    let mut found = Vec::new();
    let mut rest = code;
    let mut elsewhere = String::new();
    // First the statements `use ...;`, then what stands in the rest.
    while let Some(start) = rest.find("use ") {
        let line = rest[..start].rfind(['\n', ';', '{', '}']).map_or(0, |n| n + 1);
        let before = rest[line..start].trim();
        let end = rest[start..].find(';').map_or(rest.len(), |n| start + n);
        if before.is_empty() || before.starts_with("pub") {
            elsewhere.push_str(&rest[..line]);
            let mut leaves = Vec::new();
            leaves_of(&rest[start + 4..end], "", &mut leaves);
            let inside = leaves.iter().filter_map(|leaf| absolute(module, leaf, modules));
            found.extend(inside.map(|path| (before.starts_with("pub"), path)));
            rest = &rest[end..];
        } else {
            elsewhere.push_str(&rest[..start + 4]);
            rest = &rest[start + 4..];
        }
    }
    elsewhere.push_str(rest);
    for word in
        elsewhere.split(|c: char| !c.is_alphanumeric() && c != '_' && c != ':').filter(|w| w.contains("::"))
    {
        found.extend(absolute(module, word.trim_matches(':'), modules).map(|path| (false, path)));
    }
    found
}

/// The single paths of a tree `a::{b, c::{d, e as f}}`.
fn leaves_of(tree: &str, prefix: &str, leaves: &mut Vec<String>) {
    let (mut depth, mut start) = (0, 0);
    let mut parts = Vec::new();
    for (k, c) in tree.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&tree[start..k]);
                start = k + 1;
            }
            _ => {}
        }
    }
    parts.push(&tree[start..]);
    for part in parts.into_iter().map(str::trim).filter(|part| !part.is_empty()) {
        match part.split_once('{') {
            Some((head, inner)) => {
                let head = join(prefix, head.trim().trim_end_matches("::"));
                leaves_of(inner.trim_end().strip_suffix('}').unwrap_or(inner), &head, leaves);
            }
            None => leaves.push(join(prefix, part.split_whitespace().next().unwrap_or(part))),
        }
    }
}

/// A path from the root of the crate; none if it leads out of it.
fn absolute(module: &str, path: &str, modules: &Modules) -> Option<String> {
    let (first, rest) = path.split_once("::").unwrap_or((path, ""));
    let parent = |m: &str| m.rsplit_once("::").map_or_else(String::new, |(parent, _)| parent.to_owned());
    match first {
        "crate" => Some(rest.to_owned()),
        "self" => absolute_below(module, rest),
        "super" => match rest.strip_prefix("super::") {
            Some(rest) => absolute(&parent(module), &format!("super::{rest}"), modules),
            None => absolute_below(&parent(module), rest),
        },
        child if modules.contains_key(&join(module, child)) => absolute_below(module, path),
        _ => None,
    }
}

fn absolute_below(module: &str, path: &str) -> Option<String> {
    Some(join(module, path.trim_end_matches("::self")))
}

fn join(head: &str, tail: &str) -> String {
    match (head, tail) {
        ("", tail) => tail.to_owned(),
        (head, "" | "self") => head.to_owned(),
        (head, tail) => format!("{head}::{tail}"),
    }
}

/// Every module that one needs, at first or second hand.
fn reach<'a>(start: &'a str, edges: &BTreeMap<&'a str, BTreeSet<&'a str>>) -> BTreeSet<&'a str> {
    let (mut seen, mut open) = (BTreeSet::new(), vec![start]);
    while let Some(module) = open.pop() {
        let next = edges.get(module).into_iter().flatten();
        open.extend(next.filter(|next| seen.insert(**next)));
    }
    seen
}

/// Sets of modules that reach each other, each sorted; the root of the crate is called `lib`.
fn circles(edges: &BTreeMap<&str, BTreeSet<&str>>) -> BTreeSet<Vec<String>> {
    let reached: BTreeMap<&str, BTreeSet<&str>> = edges.keys().map(|m| (*m, reach(m, edges))).collect();
    let circle = |module: &&str| -> Vec<String> {
        let mutual =
            reached[*module].iter().filter(|other| reached.get(**other).is_some_and(|r| r.contains(*module)));
        mutual.map(|m| if m.is_empty() { "lib".to_owned() } else { (*m).to_owned() }).collect()
    };
    reached.keys().map(circle).filter(|circle| circle.len() > 1).collect()
}

#[cfg(test)]
mod tests {
    use super::{super::file::file, *};

    fn found(files: &[(&str, &str)]) -> Vec<Complaint> {
        let files: Vec<File> =
            files.iter().map(|(path, text)| file(&format!("crates/a/src/{path}"), text)).collect();
        check(&files)
    }

    #[test]
    fn behaviour_a_circle_is_refused_however_it_is_named() {
        let circle = ["crates/a: these modules need each other: b, c"];
        let root = ("lib.rs", "mod b; mod c; pub use b::B; pub use c::{C, D as E};");
        assert_eq!(found(&[root, ("b.rs", "use crate::c::C;"), ("c.rs", "use super::b;")]), circle);
        // Through what the root hands on, and in the middle of code.
        assert_eq!(
            found(&[root, ("b.rs", "use crate::{C, x};"), ("c.rs", "fn f() { crate::B::new() }")]),
            circle
        );
    }

    #[test]
    fn behaviour_a_parent_and_a_child_that_need_each_other_are_a_circle() {
        let child = ("b/c.rs", "use super::X;");
        let found_with = |parent| found(&[("lib.rs", "mod b;"), ("b/mod.rs", parent), child]);
        assert_eq!(
            found_with("mod c; fn f() { c::g() }"),
            ["crates/a: these modules need each other: b, b::c"]
        );
        assert!(found_with("mod c; pub(crate) use c::g;").is_empty(), "a name that is handed on is no need");
    }

    #[test]
    fn behaviour_tests_and_comments_do_not_count() {
        let c = "// use crate::b;\n#[cfg(test)]\nmod tests {\n use crate::b::B;\n}";
        assert!(found(&[("lib.rs", ""), ("b.rs", "use crate::c::C;"), ("c.rs", c)]).is_empty());
    }
}
