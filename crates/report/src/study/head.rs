//! What the page of a study says beside its stages.

use rijke_rig::DataKind;
use rijke_study::Claims;

/// What a page says of a study, beside its stages.
#[derive(Clone, Debug)]
pub struct StudyHead {
    /// Its name.
    pub name: String,
    /// The question that it answers.
    pub question: String,
    /// Measured or virtual.
    pub kind: DataKind,
    /// Where the data come from.
    pub source: String,
    /// The factors of the campaign: name and unit.
    pub factors: Vec<(String, String)>,
    /// What others published of the rig.
    pub claims: Claims,
}
