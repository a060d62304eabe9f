//! Rules for sources: every file is part of a crate, short, finished, and its tests say the kind of evidence.

use super::code;
use super::file::{Complaint, File};
use std::collections::BTreeSet;

/// Files are meant to be near 200 lines; at twice that a file has become two.
const MAX_LINES: usize = 400;

/// Kinds of evidence (docs/conventions.md).
const PREFIXES: [&str; 9] =
    ["exact_", "order_", "oracle_", "paper_", "lab_", "regress_", "message_", "behaviour_", "coverage_"];

pub(super) fn check(files: &[File]) -> Vec<Complaint> {
    let sources: Vec<_> = files.iter().filter(|f| f.path.ends_with(".rs")).collect();
    let paths: BTreeSet<_> = sources.iter().map(|f| &*f.path).collect();
    let mut complaints: Vec<_> = sources.iter().flat_map(|f| check_text(f)).collect();
    complaints.extend(sources.iter().flat_map(|f| unused_files(f, &sources, &paths)));
    complaints.extend(sources.iter().filter_map(|f| check_front_page(f, files)));
    complaints.extend(sources.iter().flat_map(|f| unbounded_reads(f)));
    complaints.extend(sources.iter().flat_map(|f| wide_comments(f)));
    complaints.extend(sources.iter().flat_map(|f| gaps(f)));
    complaints
}

/// The median length of the sources of crates, lines.
pub(super) fn median_lines(files: &[File]) -> usize {
    let sources = files.iter().filter(|f| f.path.contains("/src/") && f.path.ends_with(".rs"));
    let mut lines: Vec<usize> = sources.map(|f| f.text.lines().count()).collect();
    lines.sort_unstable();
    lines.get(lines.len() / 2).copied().unwrap_or(0)
}

/// A library whose front page is its README opens with this.
const README: &str = "#![doc = include_str!(\"../README.md\")]";

/// The front page of a library says its conventions: its README, or its own first lines.
fn check_front_page(File { path, text }: &File, files: &[File]) -> Option<Complaint> {
    let folder = path.strip_prefix("crates/")?.strip_suffix("/src/lib.rs")?;
    let says = if text.starts_with(README) {
        let readme = format!("crates/{folder}/README.md");
        files.iter().any(|f| f.path == readme && f.text.lines().any(|l| l == "## Conventions"))
    } else {
        text.lines().any(|l| l == "//! # Conventions")
    };
    (!says).then(|| format!("{path}: the crate's front page lacks a section `Conventions`"))
}

fn check_text(File { path, text }: &File) -> Vec<Complaint> {
    let mut complaints = Vec::new();
    let lines = text.lines().count();
    if lines > MAX_LINES {
        complaints
            .push(format!("{path}: {lines} lines, cut it where it changes subject (limit {MAX_LINES})"));
    }
    if !text.starts_with("//!") && !text.starts_with(README) {
        complaints.push(format!("{path}:1: open with a line `//! ...` that says what the file is for"));
    }
    let mut in_test = false;
    for (number, line) in (1..).zip(text.lines().map(str::trim)) {
        for mark in ["TODO", "FIXME", "XXX", "HACK"] {
            if line.split_once("//").is_some_and(|(_, comment)| comment.trim_start().starts_with(mark)) {
                complaints.push(format!("{path}:{number}: do it or say in words what is not done ({mark})"));
            }
        }
        in_test |= line == "#[test]";
        let name = line.strip_prefix("fn ").and_then(|l| l.split_once('(')).map(|(name, _)| name);
        if let (true, Some(name)) = (in_test, name) {
            in_test = false;
            if !PREFIXES.iter().any(|p| name.starts_with(p)) {
                let prefixes = PREFIXES.join(", ");
                complaints.push(format!("{path}:{number}: test {name} must say its evidence ({prefixes})"));
            }
        }
    }
    complaints
}

/// Who reads a file that somebody else gave does so by the one function that refuses pipes, devices and what
/// has no end.
fn unbounded_reads(file: &File) -> Vec<Complaint> {
    let of_a_crate = file.path.starts_with("crates/") && file.path.contains("/src/");
    if !of_a_crate || file.path.ends_with("numerics/src/files.rs") {
        return Vec::new();
    }
    let blanked = code::blanked(&file.text);
    let lines = (1..).zip(code::without_tests(&blanked).lines());
    let unbounded =
        |line: &str| ["fs::read_to_string(", "File::open(", ".from_path("].iter().any(|c| line.contains(c));
    lines
        .filter(|(_, line)| unbounded(line) && !line.contains("Writer"))
        .map(|(k, _)| {
            format!(
                "{}:{k}: use rijke_numerics::read_text or open_file, which refuses pipes, devices and files without end",
                file.path
            )
        })
        .collect()
}

/// Columns of a line that is a comment.
const COMMENT: usize = 110;

/// Comments that are too wide to be read beside code; what stands between fences is code.
fn wide_comments(File { path, text }: &File) -> Vec<Complaint> {
    let mut fenced = false;
    let mut complaints = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let comment =
            line.trim_start().strip_prefix("//").map(|c| c.trim_start_matches(['/', '!']).trim_start());
        fenced ^= comment.is_some_and(|c| c.starts_with("```"));
        let count = line.chars().count();
        if comment.is_some() && !fenced && count > COMMENT {
            complaints.push(format!("{path}:{number}: a comment of {count} columns, break it at {COMMENT}"));
        }
    }
    complaints
}

/// A run of so many blanks within a text was a break of its line.
const GAP: &str = "        ";

/// Texts whose lines were joined without their margins: they are printed with a gap.
fn gaps(File { path, text }: &File) -> Vec<Complaint> {
    let words = |part: &str, last: bool| {
        let c = if last { part.chars().next_back() } else { part.trim_start().chars().next() };
        c.is_some_and(|c| c.is_alphanumeric() || ",;:.".contains(c))
    };
    let has_gap = |line: &str| {
        let line = line.trim();
        !line.starts_with("//")
            && line.split_once(GAP).is_some_and(|(before, after)| words(before, true) && words(after, false))
    };
    let printed = path.starts_with("crates/") && path.contains("/src/");
    let lines = (1..).zip(text.lines()).filter(|(_, line)| printed && has_gap(line));
    lines.map(|(k, _)| format!("{path}:{k}: a text with a gap, end its line with a backslash")).collect()
}

/// A file under `src` that no `mod` line of its parent names is not compiled, however good it looks. A macro
/// of the parent that declares each `$file` of a list counts, with a line `name::...,` of that list.
fn unused_files(file: &File, sources: &[&File], paths: &BTreeSet<&str>) -> Option<Complaint> {
    let (root, inside) = file.path.split_once("/src/")?;
    let module = inside.strip_suffix(".rs")?;
    let module = module.strip_suffix("/mod").unwrap_or(module);
    if ["lib", "main"].contains(&module) || module.starts_with("bin/") {
        return None;
    }
    let (folder, name) = module.rsplit_once('/').unwrap_or(("", module));
    let parents = match folder {
        "" => vec![format!("{root}/src/lib.rs"), format!("{root}/src/main.rs")],
        folder => vec![format!("{root}/src/{folder}/mod.rs"), format!("{root}/src/{folder}.rs")],
    };
    let declares = |f: &&File| {
        let listed = |l: &str| l.starts_with(&format!("{name}::")) && l.ends_with(',');
        let by_macro = f.text.contains("mod $file;");
        let line = |l: &str| l.ends_with(&format!("mod {name};")) || by_macro && listed(l);
        parents.contains(&f.path) && f.text.lines().any(|l| line(l.trim()))
    };
    let declared = parents.iter().any(|p| paths.contains(&**p)) && sources.iter().any(declares);
    (!declared)
        .then(|| format!("{}: no `mod {name};` in {}, so nobody uses it", file.path, parents.join(" or ")))
}

#[cfg(test)]
mod tests {
    use super::{super::file::file, *};

    fn complaints(text: &str) -> String {
        check(&[file("crates/a/src/main.rs", text)]).join("\n")
    }

    #[test]
    fn behaviour_wide_comments_are_complained_of() {
        let wide = "word ".repeat(23);
        assert!(complaints(&format!("//! What.\n    /// {wide}\n")).contains("main.rs:2: a comment of"));
        assert_eq!(complaints(&format!("//! What.\n//! ```\n//! {wide}\n//! ```\n")), "");
    }

    #[test]
    fn behaviour_gaps_in_texts_are_complained_of() {
        let text =
            |gap: &str| format!("//! What.\nfn f() {{\n        say(\"one thing:{gap}another\");\n}}\n");
        assert!(complaints(&text(GAP)).contains("main.rs:3: a text with a gap"));
        assert_eq!(complaints(&text(" ")), "");
    }

    #[test]
    fn behaviour_unbounded_reads_are_complained_of_outside_tests() {
        let read = "//! What.\nfn f() { std::fs::read_to_string(p); }\n";
        assert!(
            complaints(read).contains("main.rs:2: use rijke_numerics::read_text"),
            "{}",
            complaints(read)
        );
        let tested = format!("//! What.\n#[cfg(test)]\nmod tests {{\n{}}}\n", &read[11..]);
        assert_eq!(complaints(&tested), "");
    }

    #[test]
    fn exact_a_good_file_passes() {
        assert_eq!(
            complaints("//! What.\nmod tests {\n    #[test]\n    fn exact_x() {}\n    fn helper() {}\n}\n"),
            ""
        );
    }

    #[test]
    fn exact_each_rule_fails_once() {
        assert!(complaints(&format!("//! A.\n{}", "\n".repeat(400))).contains("401 lines"));
        assert!(complaints("fn main() {}").contains("open with a line"));
        assert!(complaints("//! A.\n// TODO later").contains(":2: do it"));
        assert!(complaints("//! A.\n#[test]\n#[ignore]\nfn works() {}").contains(":4: test works must say"));
        let library = check(&[file("crates/a/src/lib.rs", "//! A.")]);
        assert!(library[0].contains("`Conventions`"), "{library:?}");
        let readme = |text| {
            let root = file("crates/a/src/lib.rs", README);
            check(&[root, file("crates/a/README.md", text)])
        };
        assert!(readme("# a\n\n## Conventions\n").is_empty());
        assert!(readme("# a\n")[0].contains("`Conventions`"));
    }

    #[test]
    fn exact_a_file_outside_the_module_tree_is_refused() {
        let root = || file("crates/a/src/main.rs", "//! A.\nmod b;\npub mod c;");
        let found = |path: &str, extra: Option<File>| {
            let files = [root(), file(path, "//! B.")].into_iter().chain(extra);
            check(&files.collect::<Vec<_>>())
        };
        assert!(found("crates/a/src/b.rs", None).is_empty());
        assert!(found("crates/a/src/c/mod.rs", None).is_empty());
        assert!(found("crates/a/src/d.rs", None)[0].contains("no `mod d;`"));
        assert!(found("crates/a/src/b/e.rs", None)[0].contains("no `mod e;`"));
        assert!(found("crates/a/src/b/e.rs", Some(file("crates/a/src/b.rs", "//! B.\nmod e;"))).is_empty());
    }
}
