//! The answers to a study's questions: tables of numbers, and which of them a figure shows. A new kind of
//! question is a file here, and a line in `questions!`.
//!
//! Knows trained stages, and neither how they were trained nor how a figure is drawn.

mod answer;
mod axes;
mod beside;
mod kinds;
mod nodes;
mod predicting;
mod stability;

/// The kinds of questions: the file of each, and what it asks.
macro_rules! questions {
    ($($file:ident::$kind:ident,)*) => {
        $(mod $file;)*
        const KINDS: &[Kind] = &[$(Kind::of::<$file::$kind>()),*];
    };
}

questions! {
    ranking::Ranking,
    contours::Contours,
    point_by_point::PointByPoint,
    prediction::Prediction,
    effects::Effects,
    law::Law,
}

pub use answer::{Answer, AnswerPanel, Layer, LayerLook};
pub use axes::symbol;
pub(super) use axes::{axis_label, factor_column};
pub use beside::{gains_along, left_out_table, residuals_over_factors};
pub use nodes::MapNodes;
pub use stability::stability;

use super::course::Run;
use crate::EngineError;
use kinds::{Ask, Kind};
use rijke_study::plan::{Question, Selection};
use rijke_study::{Study, StudyError};
use std::path::Path;

impl Run {
    /// The models of a stage that has run against what was measured, over the factor with the most values;
    /// what the model that goes on predicts at the points of a stage that had nothing to train on.
    ///
    /// # Errors
    /// As [`Run::answer`].
    pub fn overview(&self, stage: &str) -> Result<Answer, EngineError> {
        let known = self.study.plan.stage(stage).map(|(_, plan)| plan);
        let question = Question::of_stage("", stage, known.map_or(stage, |plan| &plan.title));
        let found = match (known, self.chosen(stage)) {
            (Some(plan), Some(chosen)) if chosen.observed.is_empty() => {
                prediction::Prediction::at(plan.points.clone()).answer(self, &question)
            }
            _ => ranking::Ranking {}.answer(self, &question),
        };
        Ok(Answer::of(&question, found?))
    }

    /// The answer to a question, once its stage has run.
    ///
    /// # Errors
    /// [`EngineError::NoPoint`], and those of training.
    pub fn answer(&self, question: &Question) -> Result<Answer, EngineError> {
        let found = (Kind::named(KINDS, question)?.answer)(self, question)?;
        Ok(Answer::of(question, found))
    }
}

/// Reads the folder of a study as [`Study::open`] does, the keys of its questions too.
///
/// # Errors
/// File, line and remedy.
pub fn open(folder: &Path) -> Result<Study, StudyError> {
    let study = Study::open(folder)?;
    check(&study)?;
    Ok(study)
}

/// Checks the keys of the questions of a study.
pub(super) fn check(study: &Study) -> Result<(), StudyError> {
    study
        .plan
        .questions
        .iter()
        .try_for_each(|question| (Kind::named(KINDS, question)?.check)(study, question))
}

/// The points at which a question needs the model of its stage to be defined.
pub(super) fn foreseen(question: &Question) -> Result<Option<Selection>, StudyError> {
    (Kind::named(KINDS, question)?.foresees)(question)
}

/// The kinds of questions, each with the keys that it adds to those of all.
pub fn keys_of_questions() -> impl Iterator<Item = (&'static str, &'static [&'static str])> {
    KINDS.iter().map(|kind| (kind.name, (kind.keys)()))
}
