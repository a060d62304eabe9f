//! A table of numbers with names and units: what answers consist of, what figures draw, what claims are
//! about.

use serde::{Deserialize, Serialize};

/// A table of numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// What each number is.
    pub columns: Vec<FrameColumn>,
    /// The rows.
    pub rows: Vec<FrameRow>,
}

/// A column of a table.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FrameColumn {
    /// Name, as claims call it.
    pub name: String,
    /// Name on axes and in headings.
    pub label: String,
    /// Unit.
    pub unit: String,
}

/// A row of a table.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrameRow {
    /// What it is about: an operating point, a model, a set of microphones.
    pub label: String,
    /// The series to which it belongs.
    pub series: String,
    /// The mode that it is about, where points have several.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub mode: String,
    /// A number per column; none where there is none.
    pub values: Vec<Option<f64>>,
}

impl FrameColumn {
    /// A column whose label is its name.
    #[must_use]
    pub fn new(name: &str, label: &str, unit: &str) -> Self {
        Self { name: name.to_owned(), label: label.to_owned(), unit: unit.to_owned() }
    }
}

impl Frame {
    /// The place of a column.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|c| c.name == name)
    }

    /// The numbers of a column, row by row.
    #[must_use]
    pub fn numbers(&self, column: usize) -> Vec<Option<f64>> {
        self.rows.iter().map(|row| row.values.get(column).copied().flatten()).collect()
    }
}

/// A number that is one.
#[must_use]
pub(super) fn finite(value: f64) -> Option<f64> {
    Some(value).filter(|v| v.is_finite())
}
