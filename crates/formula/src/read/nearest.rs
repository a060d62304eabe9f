//! Which known name was meant.

use super::problem::FormulaProblem;
use rijke_numerics::words::nearest;

/// The complaint about a name that is none of `known`.
pub(crate) fn unknown<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> FormulaProblem {
    let known: Vec<&str> = known.collect();
    let suggestion = nearest(name, &known).map(str::to_owned);
    FormulaProblem::UnknownName { name: name.to_owned(), suggestion, known: known.join(", ") }
}
