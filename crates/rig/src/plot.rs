//! Curves over time, frequency or place as numbers, panel by panel: what a figure of records and of what was
//! fitted to them shows.

use crate::DataKind;

/// A figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// What is shown, in one line.
    pub title: String,
    /// Measured or virtual.
    pub data: DataKind,
    /// Side by side, two in a row.
    pub panels: Vec<PlotPanel>,
}

/// One pair of axes.
#[derive(Clone, Debug, PartialEq)]
pub struct PlotPanel {
    /// Label of the horizontal axis, with unit.
    pub x: String,
    /// Label of the vertical axis, with unit.
    pub y: String,
    /// The curves; those without a name are left out of the legend.
    pub curves: Vec<PlotCurve>,
    /// Places of vertical lines.
    pub marks: Vec<f64>,
    /// Where the horizontal axis counts things, their names, from 0 on; else empty.
    pub places: Vec<String>,
}

/// One curve.
#[derive(Clone, Debug, PartialEq)]
pub struct PlotCurve {
    /// Name in the legend; empty for none.
    pub name: String,
    /// How it is drawn.
    pub look: Look,
    /// Its points.
    pub points: Vec<[f64; 2]>,
}

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// Thick and light: what was recorded.
    Record,
    /// Thin and dark: what was fitted.
    Fit,
    /// One of several channels: which, of how many.
    Channel(usize, usize),
    /// Dots of the colour of the curve with this number.
    Dots(usize),
    /// The area that the curve encloses, in the colour with this number, pale.
    Patch(usize),
}

impl PlotPanel {
    /// A pair of axes with curves, without vertical lines.
    #[must_use]
    pub fn new(x: &str, y: &str, curves: Vec<PlotCurve>) -> Self {
        Self { x: x.to_owned(), y: y.to_owned(), curves, marks: Vec::new(), places: Vec::new() }
    }
}

impl PlotCurve {
    /// A curve.
    #[must_use]
    pub fn new(name: &str, look: Look, points: Vec<[f64; 2]>) -> Self {
        Self { name: name.to_owned(), look, points }
    }
}
