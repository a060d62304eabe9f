//! The candidates that the studies compare: the files in `fixtures/candidates`, embedded.

use crate::StudyError;
use rijke_candidates::{Candidate, Catalogue};

const FILES: [(&str, &str); 5] = [
    ("fixtures/candidates/tube.toml", include_str!("../fixtures/candidates/tube.toml")),
    ("fixtures/candidates/prongs.toml", include_str!("../fixtures/candidates/prongs.toml")),
    ("fixtures/candidates/heater.toml", include_str!("../fixtures/candidates/heater.toml")),
    ("fixtures/candidates/heat-release.toml", include_str!("../fixtures/candidates/heat-release.toml")),
    ("fixtures/candidates/beyond.toml", include_str!("../fixtures/candidates/beyond.toml")),
];

/// Every candidate of the files above.
///
/// # Errors
/// [`StudyError::Catalogue`] if an embedded file is broken, which a test excludes.
pub fn catalogue() -> Result<Catalogue, StudyError> {
    let mut all = Catalogue::default();
    for (name, text) in FILES {
        all = all.joined(Catalogue::from_toml(text, name)?);
    }
    Ok(all)
}

/// The candidates called `ids`, in that order.
///
/// # Errors
/// [`StudyError::NoCandidate`] for one that is not in the catalogue.
pub fn chosen(catalogue: &Catalogue, ids: &[&str]) -> Result<Vec<Candidate>, StudyError> {
    let get = |id: &&str| catalogue.get(id).cloned().ok_or_else(|| StudyError::NoCandidate((*id).to_owned()));
    ids.iter().map(get).collect()
}
