//! Pictures of one record: curves over time or frequency, panel by panel.

use crate::draw::{Axis, COLUMN, Figure, INK, Key, Mark, Panel, Stroke, model_stroke, scale_colour};
use rijke_rig::DataKind;

/// What was recorded and what was fitted to it.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordFigure {
    /// What is shown, in one line.
    pub title: String,
    /// Measured or virtual.
    pub data: DataKind,
    /// Side by side, two in a row.
    pub panels: Vec<RecordPanel>,
}

/// One pair of axes.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordPanel {
    /// Label of the horizontal axis, with unit.
    pub x: String,
    /// Label of the vertical axis, with unit.
    pub y: String,
    /// The curves; those without a name are left out of the legend.
    pub curves: Vec<RecordCurve>,
    /// Places of vertical lines.
    pub marks: Vec<f64>,
}

/// One curve.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordCurve {
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

const SIZE: [f64; 2] = [COLUMN, 240.0];

impl RecordFigure {
    /// The figure as the text of an SVG file.
    #[must_use]
    pub fn svg(&self) -> String {
        let mut legend: Vec<Key> = Vec::new();
        for curve in self.panels.iter().flat_map(|p| &p.curves) {
            if !curve.name.is_empty() && legend.iter().all(|key| key.label != curve.name) {
                let mark = match curve.look {
                    Look::Dots(index) => Mark::Dot(model_stroke(index).colour),
                    Look::Patch(index) => Mark::Patch(model_stroke(index).colour),
                    look => Mark::Line(look.stroke()),
                };
                legend.push(Key { mark, label: curve.name.clone() });
            }
        }
        let tagged = self.panels.iter().enumerate();
        let figure = Figure {
            title: self.title.clone(),
            caption: String::new(),
            columns: self.panels.len().min(2),
            panels: tagged.map(|(k, p)| p.draw(&format!("({})", char::from(b'a' + k as u8)))).collect(),
            legend,
            data: Some(self.data),
        };
        figure.svg()
    }
}

impl RecordPanel {
    fn draw(&self, tag: &str) -> Panel {
        let points = || self.curves.iter().flat_map(|c| &c.points);
        let limits =
            points().fold([f64::INFINITY, f64::NEG_INFINITY], |l, p| [l[0].min(p[0]), l[1].max(p[0])]);
        let dots = self.curves.iter().any(|c| matches!(c.look, Look::Dots(_)));
        let x = match limits[0] < limits[1] && !dots {
            true => Axis::new(&self.x, limits[0], limits[1]),
            false => Axis::covering(&self.x, points().map(|p| p[0])),
        };
        let mut panel = Panel::new(tag, SIZE, x, Axis::covering(&self.y, points().map(|p| p[1])));
        for mark in &self.marks {
            panel.vertical(*mark, &Stroke::dashed("#999", 1.0, "3 3"));
        }
        for curve in self.curves.iter().filter(|c| !c.points.is_empty()) {
            match curve.look {
                Look::Dots(index) => {
                    for point in &curve.points {
                        panel.dot(*point, 3.5, model_stroke(index).colour, &curve.name);
                    }
                }
                Look::Patch(index) => {
                    let edge = Stroke::solid("none", 0.0);
                    panel.contour(&curve.points, &edge, model_stroke(index).colour, 0.3);
                }
                look => panel.curve(&curve.points, &look.stroke()),
            }
        }
        panel
    }
}

impl Look {
    fn stroke(self) -> Stroke {
        match self {
            Self::Record => Stroke::solid("#86b3d1", 2.0),
            Self::Fit => Stroke::solid(INK, 0.9),
            Self::Channel(index, count) => Stroke::solid(scale_colour(index, count), 1.2),
            Self::Dots(index) | Self::Patch(index) => model_stroke(index),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_every_curve_is_drawn_and_named_once() {
        let curve = |name: &str, look| RecordCurve {
            name: name.to_owned(),
            look,
            points: vec![[0.0, 1.0], [1.0, -1.0], [2.0, 0.5]],
        };
        let panel =
            |curves| RecordPanel { x: "time / s".into(), y: "p / Pa".into(), curves, marks: vec![0.4] };
        let panels = vec![
            panel(vec![curve("record", Look::Record), curve("fit", Look::Fit)]),
            panel(vec![curve("record", Look::Record), curve("", Look::Dots(1))]),
            panel(vec![]),
        ];
        let svg = RecordFigure { title: "T".into(), data: DataKind::Virtual, panels }.svg();
        assert_eq!(svg.matches(">record<").count(), 1);
        assert_eq!(svg.matches("<circle").count(), 3);
        // On every panel, and in the description of the whole.
        assert_eq!(svg.matches("virtual data").count(), 4);
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }
}
