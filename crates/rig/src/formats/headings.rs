//! Columns by their names.

use crate::problem::Problem;
use crate::units::Heading;

/// Whether a heading is of this name, with or without the unit behind it.
pub(crate) fn is_named(heading: &str, name: &str) -> bool {
    heading == name || Heading::parse(heading).is_ok_and(|h| h.name == name)
}

/// The one column of a name.
pub(crate) fn named(headings: &[String], name: &str) -> Result<usize, Problem> {
    let exact = headings.iter().filter(|h| *h == name).count() == 1;
    let mut found =
        headings.iter().enumerate().filter(|(_, h)| if exact { *h == name } else { is_named(h, name) });
    match (found.next(), found.next()) {
        (Some((column, _)), None) => Ok(column),
        (Some(_), Some(_)) => Err(Problem::Duplicate { name: name.into() }),
        (None, _) => Err(Problem::NoSuchHeading { name: name.into(), known: headings.to_vec() }),
    }
}
