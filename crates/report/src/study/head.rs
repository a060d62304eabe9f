//! What the page of a study says beside its stages.

use rijke_rig::DataKind;
use rijke_study::{Claims, Factor, ObservedModes, Study};

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
    /// The factors of the campaign.
    pub factors: Vec<Factor>,
    /// What others published of the rig.
    pub claims: Claims,
    /// Path of the page of stages that train on responses, if the study has such stages beside those of
    /// modes.
    pub beside: Option<String>,
    /// What the competitions of those stages found, a sentence of HTML for each.
    pub found_beside: Vec<String>,
}

impl StudyHead {
    /// The head of the page of a study.
    #[must_use]
    pub fn of(study: &Study, observations: &ObservedModes) -> Self {
        Self {
            name: study.plan.name.clone(),
            question: study.plan.question.clone(),
            kind: observations.kind,
            source: observations.source.clone(),
            factors: study.campaign.factors.clone(),
            claims: study.claims.clone(),
            beside: (!study.plan.responses.is_empty()).then(|| "responses/index.html".to_owned()),
            found_beside: Vec::new(),
        }
    }
}
