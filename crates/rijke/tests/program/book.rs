//! The book: what its pages say is what the program does.

use crate::{copy, example, rijke, scratch, short};
use serde_json::Value;
use std::{fs, path::Path};

/// Fenced blocks of a page that begin with "```" and `kind`.
pub(crate) fn blocks<'a>(page: &'a str, kind: &str) -> Vec<&'a str> {
    let mark = format!("```{kind}\n");
    let parts = page.split(mark.as_str()).skip(1);
    parts.filter_map(|part| part.split_once("\n```").map(|(block, _)| block)).collect()
}

/// Runs every command after a `$` in the console blocks of a page, and compares what is printed (standard
/// output, then standard error) with the lines below it.
pub(crate) fn follow(page: &str, folder: &Path) {
    for block in blocks(page, "console") {
        for step in block.split("$ ").filter(|step| !step.trim().is_empty()) {
            let (command, expected) = step.split_once('\n').unwrap_or((step, ""));
            let words: Vec<&str> = command.split_whitespace().skip(1).collect();
            let output = rijke(folder, &words);
            let said = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
            let (said, expected): (Vec<&str>, Vec<&str>) =
                (said.lines().map(str::trim_end).collect(), expected.lines().map(str::trim_end).collect());
            assert!(
                matches(&said, &expected),
                "{command}\nprints\n{}\nthe page has\n{}",
                said.join("\n"),
                expected.join("\n")
            );
            let fails = expected.iter().any(|line| line.starts_with("error:"));
            assert_eq!(output.status.success(), !fails, "{command}");
        }
    }
}

/// Whether lines are as expected; a line `...` stands for any lines, `...` within a line for any text.
/// Leftmost matches are enough, as for any pattern of this kind.
fn matches(said: &[&str], expected: &[&str]) -> bool {
    let pieces: Vec<&[&str]> = expected.split(|line| *line == "...").collect();
    let here = |at: usize, piece: &[&str]| {
        said.get(at..at + piece.len()).is_some_and(|lines| lines.iter().zip(piece).all(|(a, b)| alike(a, b)))
    };
    let mut at = 0;
    for (k, piece) in pieces.iter().enumerate() {
        let last = k + 1 == pieces.len();
        let found = match (k, last) {
            (0, _) => Some(0).filter(|at| here(*at, piece)),
            (_, true) => {
                said.len().checked_sub(piece.len()).filter(|start| *start >= at && here(*start, piece))
            }
            _ => (at..=said.len()).find(|start| here(*start, piece)),
        };
        let Some(start) = found else { return false };
        at = start + piece.len();
    }
    at == said.len()
}

fn alike(said: &str, expected: &str) -> bool {
    let mut left = said;
    for (k, part) in expected.split("...").map(str::trim).enumerate() {
        match left.find(part) {
            Some(at) if k > 0 || at == left.len() - left.trim_start().len() => {
                left = &left[at + part.len()..]
            }
            _ => return false,
        }
    }
    expected.contains("...") || left.is_empty()
}

#[test]
fn exact_expected_lines_match_what_they_should() {
    assert!(matches(&["a", "b 1 c", "d"], &["a", "...", "d"]) && matches(&["b 1 c"], &["b ... c"]));
    assert!(!matches(&["a", "d"], &["a"]) && !matches(&["b 1 c"], &["b ... d"]) && !matches(&["ab"], &["a"]));
}

/// The names that every study knows, whatever its rig and campaign.
#[test]
fn exact_the_page_of_symbols_is_that_of_the_program() {
    let folder = scratch("symbols");
    copy(&example("quarter-wave"), &folder.join("study"));
    let output = rijke(&folder, &["check", "study", "--names", "--json"]);
    let names: Vec<Value> = serde_json::from_slice(&output.stdout).unwrap();
    let text = |name: &Value, key: &str| name[key].as_str().unwrap().to_owned();
    let of_this_study = |name: &Value| {
        let meaning = text(name, "meaning");
        meaning == "factor of the campaign" || meaning.starts_with("number of the part")
    };
    let everywhere: Vec<&Value> = names.iter().filter(|name| !of_this_study(name)).collect();
    assert!(everywhere.len() > 20 && everywhere.len() < names.len());
    let row =
        |n: &&Value| format!("| `{}` | {} | {} |\n", text(n, "name"), text(n, "unit"), text(n, "meaning"));
    let rows: String = everywhere.iter().map(row).collect();
    let page = include_str!("../../../../docs/symbols.md");
    assert!(page.ends_with(&rows), "docs/symbols.md should end with\n{rows}");
}

#[test]
fn exact_the_page_of_commands_is_that_of_the_program() {
    let output = rijke(&scratch("reference"), &["man", "--markdown"]);
    let page = include_str!("../../../../docs/reference/commands.md");
    assert!(String::from_utf8(output.stdout).unwrap() == page, "run `cargo xtask reference`");
}

#[test]
fn exact_every_page_of_the_book_exists_and_the_matlab_example_is_a_candidate() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
    let summary = fs::read_to_string(docs.join("SUMMARY.md")).unwrap();
    let pages: Vec<&str> =
        summary.split("](").skip(1).filter_map(|rest| rest.split_once(')').map(|(page, _)| page)).collect();
    assert!(pages.len() > 15);
    for page in pages {
        assert!(docs.join(page).is_file(), "SUMMARY.md names {page}");
    }
    let matlab = fs::read_to_string(docs.join("from-matlab.md")).unwrap();
    let folder = scratch("from-matlab");
    short::paper(&folder.join("study"));
    fs::write(folder.join("study/candidates/own.toml"), blocks(&matlab, "toml")[0]).unwrap();
    let output = rijke(&folder, &["check", "study"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
