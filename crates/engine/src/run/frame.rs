//! A table of numbers with names and units: what answers consist of, what figures draw, what claims are
//! about.

use rijke_numerics::words::to_digits;
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameColumn {
    /// Name, as claims call it.
    pub name: String,
    /// Name on axes and in headings.
    pub label: String,
    /// Unit.
    pub unit: String,
    /// The unit in which figures and tables show it, where that is another.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shown: Option<ShownUnit>,
}

/// A unit in which numbers are shown: a number is `zero + one * shown`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShownUnit {
    /// Its name.
    pub unit: String,
    /// What the number 0 of it is.
    pub zero: f64,
    /// How many units of the numbers one of it is.
    pub one: f64,
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

impl FrameRow {
    /// The number in a column, if there is one.
    #[must_use]
    pub fn number(&self, column: usize) -> Option<f64> {
        self.values.get(column).copied().flatten()
    }
}

impl FrameColumn {
    /// A column whose label is its name.
    #[must_use]
    pub fn new(name: &str, label: &str, unit: &str) -> Self {
        Self { name: name.to_owned(), label: label.to_owned(), unit: unit.to_owned(), shown: None }
    }

    /// The unit in which it is shown.
    #[must_use]
    pub fn shown_unit(&self) -> &str {
        self.shown.as_ref().map_or(&self.unit, |shown| &shown.unit)
    }

    /// A number of it as it is shown, to twelve digits where the unit is another.
    #[must_use]
    pub fn shown_of(&self, value: f64) -> f64 {
        let Some(ShownUnit { zero, one, .. }) = &self.shown else { return value };
        to_digits((value - zero) / one, 12)
    }
}

impl Frame {
    /// The place of a column.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|c| c.name == name)
    }

    /// The table with every number in the unit in which it is shown.
    #[must_use]
    pub fn in_print(&self) -> Self {
        let mut table = self.clone();
        for (k, column) in table.columns.iter_mut().enumerate().filter(|(_, c)| c.shown.is_some()) {
            let own = table.rows.iter_mut().filter_map(|row| row.values.get_mut(k)?.as_mut());
            own.for_each(|value| *value = column.shown_of(*value));
            let shown = column.shown.take();
            column.unit = shown.map_or_else(String::new, |shown| shown.unit);
        }
        table
    }

    /// The numbers of a column, row by row.
    #[must_use]
    pub fn numbers(&self, column: usize) -> Vec<Option<f64>> {
        self.rows.iter().map(|row| row.number(column)).collect()
    }
}

/// A number that is one.
#[must_use]
pub(super) fn finite(value: f64) -> Option<f64> {
    Some(value).filter(|v| v.is_finite())
}
