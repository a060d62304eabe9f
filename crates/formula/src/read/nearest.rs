//! Which known name was meant.

use super::problem::FormulaProblem;

/// The complaint about a name that is none of `known`.
pub(crate) fn unknown<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> FormulaProblem {
    let known: Vec<&str> = known.collect();
    let suggestion = nearest(name, &known).map(str::to_owned);
    FormulaProblem::UnknownName { name: name.to_owned(), suggestion, known: known.join(", ") }
}

/// The known word within two edits of `name` (one for short names), if any.
fn nearest<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    let allowed = if name.chars().count() > 3 { 2 } else { 1 };
    let (distance, best) = known.iter().map(|k| (edits(name, k), *k)).min_by_key(|(d, _)| *d)?;
    (distance <= allowed).then_some(best)
}

/// Levenshtein distance, upper and lower case alike.
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.to_lowercase().chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.to_lowercase().chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &y) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}
