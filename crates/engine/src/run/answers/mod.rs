//! The answers to a study's questions: tables of numbers, and which of them a figure shows. A new kind of
//! question is a file here and a line in [`Run::answer`].
//!
//! Knows trained stages, and neither how they were trained nor how a figure is drawn.

mod axes;
mod beside;
mod contours;
mod nodes;
mod point_by_point;
mod prediction;
mod ranking;
mod stability;

pub use axes::{symbol, with_sd};
pub use beside::{gains_along, left_out_table, residuals_over_factors};
pub use nodes::MapNodes;
pub use stability::stability;

use super::course::Run;
use super::frame::{Frame, FrameRow};
use super::record::TrainedParameter;
use crate::EngineError;
use rijke_study::plan::{Ask, Question};
use serde::{Deserialize, Serialize};

/// The answer to a question.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// Name of the question.
    pub id: String,
    /// What it is called.
    pub title: String,
    /// What the tables hold, in a sentence or two.
    pub caption: String,
    /// The parameters of the model, if there is one.
    pub parameters: Vec<TrainedParameter>,
    /// The tables; claims are about the first.
    pub frames: Vec<Frame>,
    /// What a figure shows of them.
    pub panels: Vec<AnswerPanel>,
}

/// A pair of axes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AnswerPanel {
    /// Label of the horizontal axis.
    pub x: String,
    /// Label of the vertical axis.
    pub y: String,
    /// What is drawn, the first below the others.
    pub layers: Vec<Layer>,
}

/// Columns of a table, drawn.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Layer {
    /// Number of the table.
    pub frame: usize,
    /// How it is drawn; rows of one series have one colour.
    pub look: LayerLook,
    /// The column along the axis.
    pub x: usize,
    /// The column that is drawn.
    pub y: usize,
    /// The column of its standard deviation, if it has one.
    pub sd: Option<usize>,
    /// The mode whose rows are drawn; all rows if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mode: Option<String>,
}

impl Layer {
    /// The rows of a table that it draws.
    pub fn rows<'a>(&'a self, frame: &'a Frame) -> impl Iterator<Item = &'a FrameRow> {
        frame.rows.iter().filter(|row| self.mode.as_ref().is_none_or(|mode| *mode == row.mode))
    }
}

/// How columns are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LayerLook {
    /// A dot per row, with a bar of two standard deviations.
    Dots,
    /// A short dash per row, in the colour of the series.
    Dashes,
    /// A line through the rows of each series.
    Line,
    /// A band of two standard deviations about a line through the rows of each series.
    Band,
    /// The ellipse of one and two standard deviations of each row; `sd` is the column of the covariance, and
    /// the two variances are the columns before it.
    Ellipse,
    /// Growth rates over a grid of `x` and `y`, filled, with the boundary of stability and its band; `sd` is
    /// the column of their standard deviation, and they are the column before it. Where a node has several
    /// rows, the largest counts.
    GrowthMap,
    /// The same numbers as the probability that the growth rate is positive, taken as normal.
    ChanceMap,
    /// A cross per row, whose name the legend has.
    Cross,
}

impl Run {
    /// The models of a stage that has run against what was measured, over the factor with the most values;
    /// what the model that goes on predicts at the points of a stage that had nothing to train on.
    ///
    /// # Errors
    /// As [`Run::answer`].
    pub fn overview(&self, stage: &str) -> Result<Answer, EngineError> {
        let title = self.study.plan.stage(stage).map_or(stage, |(_, s)| &s.title).to_owned();
        let ask = match (self.study.plan.stage(stage), self.chosen(stage)) {
            (Some((_, plan)), Some(chosen)) if chosen.observed.is_empty() => {
                Ask::Prediction { points: plan.points.clone(), trained_on: None }
            }
            _ => Ask::Ranking,
        };
        let (id, stage) = (stage.to_owned(), stage.to_owned());
        self.answer(&Question { id, title, stage, over: None, series: None, ask })
    }

    /// The answer to a question, once its stage has run.
    ///
    /// # Errors
    /// [`EngineError::NoPoint`], and those of training.
    pub fn answer(&self, question: &Question) -> Result<Answer, EngineError> {
        let (frames, panels, parameters, caption) = match &question.ask {
            Ask::Ranking => self.ranking(question),
            Ask::Contours { sets } => self.contours(question, sets),
            Ask::PointByPoint(one) => self.point_by_point(question, one),
            Ask::Prediction { points, trained_on } => self.prediction(question, points, trained_on.as_ref()),
        }?;
        Ok(Answer {
            id: question.id.clone(),
            title: question.title.clone(),
            caption,
            parameters,
            frames,
            panels,
        })
    }
}

/// Tables, panels, parameters and caption.
type Found = (Vec<Frame>, Vec<AnswerPanel>, Vec<TrainedParameter>, String);
