//! A crate is defined by what it must not know: the manifests hold the arrows of `docs/ARCHITECTURE.md` and
//! no others.

use super::file::{Complaint, File};
use std::collections::{BTreeMap, BTreeSet};

/// The page that lists the arrows.
const PAGE: &str = "docs/ARCHITECTURE.md";

/// Libraries that one crate only may use: (library, crate, why).
const CONFINED: [(&str, &str, &str); 3] = [
    ("faer", "numerics", "dense algebra stays behind one file"),
    ("minijinja", "report", "only report writes pages"),
    ("indicatif", "rijke", "only the command line talks to a terminal"),
];

type Arrows = BTreeMap<String, BTreeSet<String>>;

pub(super) fn check(files: &[File]) -> Vec<Complaint> {
    let Some(page) = files.iter().find(|f| f.path == PAGE) else {
        return vec![format!("{PAGE}: missing")];
    };
    let manifests: Vec<_> = files.iter().filter_map(|f| Some((folder(&f.path)?, f))).collect();
    let crates: BTreeSet<_> = manifests.iter().map(|(folder, _)| (*folder).to_owned()).collect();
    let listed = listed(&page.text, &crates);
    manifests.iter().flat_map(|(folder, manifest)| check_manifest(folder, manifest, &listed)).collect()
}

/// The folder of a crate's manifest: `crates/FOLDER/Cargo.toml`, or xtask.
fn folder(path: &str) -> Option<&str> {
    let folder = path.strip_suffix("/Cargo.toml")?;
    folder.strip_prefix("crates/").or((folder == "xtask").then_some(folder))
}

fn check_manifest(folder: &str, File { path, text }: &File, listed: &Arrows) -> Vec<Complaint> {
    let manifest: toml::Table = match text.parse() {
        Ok(manifest) => manifest,
        Err(error) => return vec![format!("{path}: {error}")],
    };
    let mut complaints = Vec::new();
    let name = manifest.get("package").and_then(|p| p.get("name")).and_then(|n| n.as_str());
    let expected =
        if matches!(folder, "xtask" | "rijke") { folder.to_owned() } else { format!("rijke-{folder}") };
    if name != Some(&expected) {
        complaints.push(format!("{path}: the package must be called {expected}"));
    }
    if manifest.get("lints").and_then(|l| l.get("workspace")).and_then(toml::Value::as_bool) != Some(true) {
        complaints.push(format!("{path}: add [lints] workspace = true"));
    }
    let tables = ["dependencies", "dev-dependencies", "build-dependencies"];
    let dependencies: BTreeSet<&str> = tables
        .iter()
        .filter_map(|t| manifest.get(*t)?.as_table())
        .flat_map(toml::Table::keys)
        .map(|k| &**k)
        .collect();
    let none = BTreeSet::new();
    let allowed = listed.get(folder).unwrap_or(&none);
    let used: BTreeSet<_> = dependencies.iter().filter_map(|d| d.strip_prefix("rijke-")).collect();
    for other in used.iter().filter(|u| !allowed.contains(**u)) {
        complaints.push(format!("{path}: {folder} must not know {other} ({PAGE} lists the arrows)"));
    }
    for other in allowed.iter().filter(|a| !used.contains(&***a)) {
        complaints.push(format!("{PAGE}: {folder} does not use {other}, remove the arrow"));
    }
    for (library, owner, why) in CONFINED {
        if dependencies.contains(library) && folder != owner {
            complaints.push(format!("{path}: only {owner} may use {library}, because {why}"));
        }
    }
    complaints
}

/// Reads lines such as `rig -> numerics flow -> rig, inference`; `everything above` stands for all crates.
fn listed(page: &str, crates: &BTreeSet<String>) -> Arrows {
    let mut arrows = Arrows::new();
    for line in page.lines().filter(|l| l.contains(" -> ") && !l.contains('`')) {
        let words: Vec<_> = line.split_whitespace().collect();
        let heads: Vec<_> = (1..words.len()).filter(|&i| words[i] == "->").collect();
        for (n, &head) in heads.iter().enumerate() {
            let end = heads.get(n + 1).map_or(words.len(), |next| next - 1);
            let (user, used) = (words[head - 1], &words[head + 1..end]);
            let used = if used == ["everything", "above"] {
                crates.iter().filter(|c| *c != user && *c != "xtask").cloned().collect()
            } else {
                used.iter().map(|u| u.trim_end_matches(',').to_owned()).collect()
            };
            arrows.insert(user.to_owned(), used);
        }
    }
    arrows
}

#[cfg(test)]
mod tests {
    use super::{super::file::file, *};

    const ARROWS: &str = "rig -> numerics      flow  -> rig, numerics\ncli -> everything above\n";

    fn complaints(folder: &str, dependencies: &str) -> Vec<Complaint> {
        let manifest = format!(
            "[package]\nname = 'rijke-{folder}'\n[lints]\nworkspace = true\n[dependencies]\n{dependencies}"
        );
        check(&[file(PAGE, ARROWS), file(&format!("crates/{folder}/Cargo.toml"), &manifest)])
    }

    #[test]
    fn exact_listed_arrows_pass() {
        assert!(complaints("flow", "rijke-rig.workspace = true\nrijke-numerics.workspace = true").is_empty());
    }

    #[test]
    fn exact_an_unlisted_arrow_is_refused() {
        let found = complaints("rig", "rijke-flow.workspace = true\nrijke-numerics.workspace = true");
        assert_eq!(
            found,
            ["crates/rig/Cargo.toml: rig must not know flow (docs/ARCHITECTURE.md lists the arrows)"]
        );
        // In any table of dependencies.
        let found = complaints("rig", "rijke-numerics = '1'\n[dev-dependencies]\nrijke-lab = '1'");
        assert!(found[0].contains("must not know lab"), "{found:?}");
    }

    #[test]
    fn exact_an_arrow_that_is_gone_is_refused() {
        assert_eq!(
            complaints("rig", ""),
            ["docs/ARCHITECTURE.md: rig does not use numerics, remove the arrow"]
        );
    }

    #[test]
    fn exact_confined_libraries_and_names_are_refused() {
        let found = complaints("rig", "rijke-numerics = '1'\nfaer = '1'");
        assert!(found[0].contains("only numerics may use faer"), "{found:?}");
        let found = check(&[file(PAGE, ARROWS), file("crates/x/Cargo.toml", "[package]\nname = 'y'")]);
        assert_eq!(found.len(), 2, "{found:?}");
    }

    #[test]
    fn exact_everything_above_is_every_crate() {
        let crates = ["cli", "flow", "rig", "xtask"].map(String::from).into();
        assert_eq!(listed(ARROWS, &crates)["cli"], ["flow", "rig"].map(String::from).into());
    }
}
