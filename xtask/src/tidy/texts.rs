//! Rules for pages: links between files of the repository lead somewhere, and every page of the book stands
//! in its table of contents.

use super::file::{Complaint, File};
use std::collections::BTreeSet;

/// The table of contents of the book.
const SUMMARY: &str = "docs/SUMMARY.md";

pub(super) fn check(files: &[File]) -> Vec<Complaint> {
    // Only files that were read can be checked: pages, sources and manifests.
    let known: BTreeSet<_> = files.iter().map(|f| f.path.clone()).collect();
    let pages = files.iter().filter(|f| f.path.ends_with(".md"));
    let mut complaints: Vec<Complaint> = pages
        .flat_map(|page| {
            links(page)
                .filter(|(_, target)| !known.contains(target))
                .map(|(line, target)| format!("{}:{line}: the link to {target} leads nowhere", page.path))
                .collect::<Vec<_>>()
        })
        .collect();
    complaints.extend(outside_the_book(files));
    complaints.extend(files.iter().filter(|f| f.path.ends_with(".md")).flat_map(wide_lines));
    complaints
}

/// Columns of a line of a page.
const LINE: usize = 120;
/// Pages that the program writes.
const WRITTEN: [&str; 2] = ["docs/reference/", "docs/symbols.md"];

/// Lines of pages that are too wide; tables and what stands between fences are not broken.
fn wide_lines(File { path, text }: &File) -> Vec<Complaint> {
    let mut fenced = false;
    let mut complaints = Vec::new();
    for (number, line) in (1..).zip(text.lines()).filter(|_| !WRITTEN.iter().any(|w| path.starts_with(w))) {
        fenced ^= line.trim_start().starts_with("```");
        let (count, words) = (line.chars().count(), line.split_whitespace().count());
        if count > LINE && !fenced && words > 2 && !line.trim_start().starts_with('|') {
            complaints.push(format!("{path}:{number}: a line of {count} columns, break it at {LINE}"));
        }
    }
    complaints
}

/// The pages under `docs` that its `SUMMARY.md` does not name: mdBook leaves them out without a word.
fn outside_the_book(files: &[File]) -> Vec<Complaint> {
    let Some(summary) = files.iter().find(|f| f.path == SUMMARY) else { return Vec::new() };
    let named: BTreeSet<String> = links(summary).map(|(_, target)| target).collect();
    let pages =
        files.iter().filter(|f| f.path.starts_with("docs/") && f.path.ends_with(".md") && f.path != SUMMARY);
    pages
        .filter(|f| !named.contains(&f.path))
        .map(|f| format!("{}: {SUMMARY} does not name it", f.path))
        .collect()
}

/// The relative links of a page to pages, sources and manifests: line and target from the root.
fn links(page: &File) -> impl Iterator<Item = (usize, String)> {
    let folder = page.path.rsplit_once('/').map_or("", |(folder, _)| folder);
    (1..).zip(page.text.lines()).flat_map(move |(number, line)| {
        line.split("](").skip(1).filter_map(move |rest| {
            let target = rest.split([')', '#', ' ']).next()?;
            let checked =
                [".md", ".rs", ".toml"].iter().any(|e| target.ends_with(e)) && !target.contains("://");
            checked.then(|| (number, resolve(folder, target)))
        })
    })
}

/// Joins a folder and a relative path, both with `/`.
fn resolve(folder: &str, target: &str) -> String {
    let mut parts: Vec<_> = folder.split('/').filter(|p| !p.is_empty()).collect();
    for part in target.split('/') {
        match part {
            "." => {}
            ".." => drop(parts.pop()),
            part => parts.push(part),
        }
    }
    parts.join("/")
}

#[cfg(test)]
mod tests {
    use super::{super::file::file, *};

    #[test]
    fn exact_links_are_followed() {
        let page = |text| file("docs/a.md", text);
        let check = |text| check(&[page(text), file("docs/b.md", ""), file("README.md", "")]);
        assert!(check("[b](b.md) and [r](../README.md#what), [w](https://x.org/c.md)").is_empty());
        assert_eq!(check("\n[c](sub/../c.md)"), ["docs/a.md:2: the link to docs/c.md leads nowhere"]);
    }

    #[test]
    fn exact_every_page_of_the_book_is_named() {
        let summary = file("docs/SUMMARY.md", "- [a](a.md)");
        let found = check(&[file("docs/a.md", ""), file("docs/x/b.md", ""), summary]);
        assert_eq!(found, ["docs/x/b.md: docs/SUMMARY.md does not name it"]);
    }
}
