//! A test that asserts nothing cannot fail, whatever the program does.

use super::code;
use super::file::{Complaint, File};
use std::collections::BTreeSet;

/// Helpers of other files that judge, though their names do not say so: orders of remainders, and the pages
/// that a test follows.
const JUDGES: [&str; 2] = ["slopes_near", "follow"];

/// Tests that may do without: (file, test, why).
const KNOWN: [(&str, &str, &str); 0] = [];

pub(super) fn check(files: &[File]) -> Vec<Complaint> {
    check_with(files, &KNOWN)
}

fn check_with(files: &[File], known: &[(&str, &str, &str)]) -> Vec<Complaint> {
    let found: Vec<_> =
        files.iter().filter(|f| f.path.ends_with(".rs")).flat_map(without_assertion).collect();
    let is_known = |path: &str, name: &str| known.iter().any(|(p, n, _)| (*p, *n) == (path, name));
    let mut complaints: Vec<Complaint> = found
        .iter()
        .filter(|(path, name, _)| !is_known(path, name))
        .map(|(path, name, line)| format!("{path}:{line}: test {name} asserts nothing, so it cannot fail"))
        .collect();
    for (path, name, _) in known {
        if !found.iter().any(|(p, n, _)| (&**p, &**n) == (*path, *name)) {
            complaints.push(format!("{path}: test {name} is no exception any more, take it off the list"));
        }
    }
    complaints
}

/// File, name and line of the tests of a file that assert nothing. A test called `..._panic` asserts that
/// nothing panics.
fn without_assertion(File { path, text }: &File) -> Vec<(String, String, usize)> {
    let blanked = code::blanked(text);
    let functions = code::functions(&blanked);
    // Helpers of the same file that assert, at first or second hand.
    let mut helpers = BTreeSet::new();
    loop {
        let more: Vec<&str> = functions
            .iter()
            .filter(|f| !helpers.contains(f.name) && asserts(f.text, &helpers))
            .map(|f| f.name)
            .collect();
        if more.is_empty() {
            break;
        }
        helpers.extend(more);
    }
    let tests =
        functions.iter().filter(|f| f.is_test && !f.name.ends_with("_panic") && !asserts(f.text, &helpers));
    tests.map(|f| (path.clone(), f.name.to_owned(), f.line)).collect()
}

/// Whether a function judges: by an assertion, a panic of its own, a helper that says so by its name or is
/// known to judge, or an error that it hands on.
fn asserts(text: &str, helpers: &BTreeSet<&str>) -> bool {
    let (head, body) = text.split_once('{').unwrap_or((text, ""));
    let hands_on = head.contains("Result<") && body.contains('?');
    let judges = |word: &str| {
        let by_name = ["assert", "prop_assert", "check", "expect_"].iter().any(|p| word.starts_with(p));
        by_name || word == "panic" || word == "unwrap_err" || helpers.contains(word) || JUDGES.contains(&word)
    };
    hands_on || code::words(body).any(judges)
}

#[cfg(test)]
mod tests {
    use super::{super::file::file, *};

    fn complaints(body: &str) -> Vec<Complaint> {
        check_with(
            &[file(
                "a.rs",
                &format!(
                    "#[test]\nfn exact_a() {{ {body} }}\nfn helper() {{ inner() }}\nfn inner() {{ assert!(true) }}"
                ),
            )],
            &[],
        )
    }

    #[test]
    fn behaviour_a_test_without_assertion_is_refused() {
        assert_eq!(complaints("println!(\"assert!\"); f().unwrap(); g().expect(\"\")").len(), 1);
        assert!(complaints("f()")[0].starts_with("a.rs:2: test exact_a asserts nothing"));
    }

    #[test]
    fn behaviour_what_judges_passes() {
        for body in ["assert_eq!(1, 1)", "check(f)", "helper()", "f().unwrap_err();", "if x { panic!() }"] {
            assert_eq!(complaints(body), [""; 0], "{body}");
        }
        let result = "#[test]\nfn exact_a() -> Result<(), E> { f()?; Ok(()) }";
        assert!(check_with(&[file("a.rs", result)], &[]).is_empty());
    }

    #[test]
    fn behaviour_an_exception_ends_with_its_reason() {
        let bare = file("a.rs", "#[test]\nfn exact_a() { f() }");
        let known = [("a.rs", "exact_a", "it draws a picture")];
        assert!(check_with(&[bare], &known).is_empty());
        let found = check_with(&[file("a.rs", "")], &known);
        assert_eq!(found, ["a.rs: test exact_a is no exception any more, take it off the list"]);
    }
}
