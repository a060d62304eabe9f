//! The answer to a question: tables of numbers, and which of them a figure shows.

use super::super::frame::{Frame, FrameRow};
use super::super::parameter::TrainedParameter;
use rijke_study::plan::Question;
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

impl Answer {
    /// The answer with every number in the unit in which it is shown.
    #[must_use]
    pub fn in_print(&self) -> Self {
        Self { frames: self.frames.iter().map(Frame::in_print).collect(), ..self.clone() }
    }

    pub(super) fn of(question: &Question, (frames, panels, parameters, caption): Found) -> Self {
        let (id, title) = (question.id.clone(), question.title.clone());
        Self { id, title, caption, parameters, frames, panels }
    }
}

/// Tables, panels, parameters and caption.
pub(super) type Found = (Vec<Frame>, Vec<AnswerPanel>, Vec<TrainedParameter>, String);
