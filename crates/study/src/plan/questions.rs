//! What can be asked of a study: a small set of questions that each exists once.

use super::Selection;
use serde::Deserialize;
use std::collections::BTreeMap;

/// A question, and what it is asked of.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "ask", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Question {
    /// The table of a stage's competitors, and their curves over a factor.
    Ranking {
        /// Name of the answer.
        id: String,
        /// The stage.
        stage: String,
        /// The factor along the axis; none for no curves.
        over: Option<String>,
    },
    /// The posterior of some parameters for some sets of microphones.
    Contours {
        /// Name of the answer.
        id: String,
        /// The stage.
        stage: String,
        /// Sets of microphones; every set that holds the reference if empty.
        #[serde(default)]
        sets: Vec<Vec<String>>,
    },
    /// The coefficients of one role, inferred at every point by itself.
    PointByPoint {
        /// Name of the answer.
        id: String,
        /// The stage whose posterior is taken for known.
        stage: String,
        /// Role and candidate that is free at every point.
        with: BTreeMap<String, String>,
        /// Roles that are taken away.
        #[serde(default)]
        without: Vec<String>,
        /// The points.
        points: Selection,
    },
    /// Predictions of the model that a stage chose.
    Prediction {
        /// Name of the answer.
        id: String,
        /// The stage.
        stage: String,
        /// The points that are predicted.
        points: Selection,
        /// The points that train; those of the stage if absent.
        trained_on: Option<Selection>,
        /// The factor along the axis.
        over: Option<String>,
    },
}

impl Question {
    /// Name of the answer.
    #[must_use]
    pub fn id(&self) -> &str {
        match self {
            Self::Ranking { id, .. }
            | Self::Contours { id, .. }
            | Self::PointByPoint { id, .. }
            | Self::Prediction { id, .. } => id,
        }
    }

    /// The stage that it is asked of.
    #[must_use]
    pub fn stage(&self) -> &str {
        match self {
            Self::Ranking { stage, .. }
            | Self::Contours { stage, .. }
            | Self::PointByPoint { stage, .. }
            | Self::Prediction { stage, .. } => stage,
        }
    }
}
