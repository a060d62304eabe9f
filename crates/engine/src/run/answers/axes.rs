//! The axis of a figure and its series, from the factors of a campaign.

use super::super::course::Run;
use super::super::frame::{FrameColumn, FrameRow, ShownUnit, finite};
use super::answer::{AnswerPanel, Layer, LayerLook};
use crate::Observed;
use rijke_study::plan::Question;
use rijke_study::{Factor, Point};
use std::collections::{BTreeMap, BTreeSet};

/// Unit and label of what modes are compared by.
pub(super) const GROWTH_RATE: [&str; 3] = ["growth_rate", "Growth rate", "1/s"];
pub(super) const ANGULAR_FREQUENCY: [&str; 3] = ["angular_frequency", "Angular frequency", "rad/s"];

impl Run {
    /// The factor along the axis: the one that the question names, or that has the most values at these
    /// points.
    pub(super) fn axis<'p>(
        &self,
        question: &Question,
        points: impl Iterator<Item = &'p Point> + Clone,
    ) -> Option<usize> {
        let values = |k: usize| {
            let mut all: Vec<f64> = points.clone().map(|p| p.factors[k]).filter(|v| v.is_finite()).collect();
            all.sort_by(f64::total_cmp);
            all.dedup_by(|a, b| (*a - *b).abs() < 1e-12);
            all.len()
        };
        let usual = || {
            let counted = (0..self.study.campaign.factors.len()).map(|k| (k, values(k)));
            let most = counted.max_by_key(|(k, count)| (*count, std::cmp::Reverse(*k)));
            most.filter(|(_, count)| *count > 1).map(|(k, _)| k)
        };
        question.over.or_else(usual)
    }

    /// The name of the series of a point: the value of the question's factor, or the row of the campaign.
    pub(super) fn series(&self, question: &Question, point: &Point) -> String {
        match question.series {
            Some(k) if point.factors[k].is_finite() => self.study.campaign.factors[k].said(point.factors[k]),
            _ => point.row.clone(),
        }
    }

    /// A column per factor.
    pub(crate) fn factor_columns(&self) -> Vec<FrameColumn> {
        self.study.campaign.factors.iter().map(factor_column).collect()
    }

    /// A row of a mode that begins with the factors of its point.
    pub(super) fn row_of(&self, question: &Question, point: &Point, mode: &str, numbers: &[f64]) -> FrameRow {
        FrameRow {
            label: point.id.clone(),
            series: self.series(question, point),
            mode: mode.to_owned(),
            values: point.factors.iter().chain(numbers).map(|v| finite(*v)).collect(),
        }
    }
}

/// Growth rate and angular frequency of an observation with their standard deviations; NaN where they were
/// not measured.
pub(super) fn measured(observed: &Observed) -> [f64; 4] {
    let mode = &observed.mode;
    let sd = |k: usize| mode.covariance[(k, k)].sqrt();
    let growth = mode.growth_rate.map_or([f64::NAN; 2], |v| [v, sd(0)]);
    let second = usize::from(mode.growth_rate.is_some());
    let frequency = mode.angular_frequency.map_or([f64::NAN; 2], |v| [v, sd(second)]);
    [growth[0], growth[1], frequency[0], frequency[1]]
}

/// The columns of [`measured`].
pub(super) fn measured_columns() -> Vec<FrameColumn> {
    let [g, w] = [GROWTH_RATE, ANGULAR_FREQUENCY];
    [g, w]
        .into_iter()
        .flat_map(|[name, label, unit]| {
            let label = format!("{label}, measured");
            [
                FrameColumn::new(name, &label, unit),
                FrameColumn::new(&format!("{name}_sd"), &format!("{label}, sd"), unit),
            ]
        })
        .collect()
}

/// The columns of what a model misses, behind that of the axis.
pub(super) fn missed_columns() -> impl Iterator<Item = FrameColumn> {
    [GROWTH_RATE, ANGULAR_FREQUENCY].into_iter().flat_map(|[name, label, unit]| {
        let label = format!("{label}, measured less predicted");
        [
            FrameColumn::new(&format!("{name}_missed"), &label, unit),
            FrameColumn::new(&format!("{name}_missed_sd"), &format!("{label}, sd"), unit),
        ]
    })
}

/// Panels of those columns in table `frame`, whose first column is the axis.
pub(super) fn missed(x_label: &str, frame: usize, modes: &[Option<&str>]) -> Vec<AnswerPanel> {
    let panel = |(mode, k): (Option<&str>, usize)| {
        let [_, label, unit] = [GROWTH_RATE, ANGULAR_FREQUENCY][k];
        let label = mode.map_or(format!("{label} missed"), |mode| format!("{label} of mode {mode} missed"));
        let y = 1 + 2 * k;
        let mode = mode.map(str::to_owned);
        AnswerPanel {
            x: x_label.to_owned(),
            y: axis_label(&FrameColumn::new("", &label, unit)),
            layers: vec![Layer { frame, look: LayerLook::Dots, x: 0, y, sd: Some(y + 1), mode }],
        }
    };
    modes.iter().flat_map(|mode| [(*mode, 0), (*mode, 1)]).map(panel).collect()
}

/// The column of a factor: its numbers in SI, shown in the unit of the campaign.
pub(crate) fn factor_column(factor: &Factor) -> FrameColumn {
    let (unit, shown) = (factor.unit_in_print(), &factor.shown);
    let other = (unit != shown.text()).then(|| ShownUnit {
        unit: shown.to_string(),
        zero: shown.offset(),
        one: shown.factor(),
    });
    FrameColumn { shown: other, ..FrameColumn::new(&factor.name, &symbol(&factor.name), &unit) }
}

/// A label with its unit.
pub(crate) fn axis_label(column: &FrameColumn) -> String {
    match column.shown_unit() {
        "1" => column.label.clone(),
        unit => format!("{} / {}", column.label, in_print(unit)),
    }
}

/// A name of files in print, in the markup of labels: `X_h` becomes an italic X with h below.
pub fn symbol(name: &str) -> String {
    match name.split_once('_') {
        Some((base, below)) if base.chars().count() == 1 => format!("*{base}*_{{{below}}}"),
        None if name.chars().count() == 1 => format!("*{name}*"),
        _ => name.replace('_', " "),
    }
}

/// A unit as figures print it: `1/s` becomes s^{-1}.
fn in_print(unit: &str) -> String {
    match unit {
        "1/s" => "s^{\u{2212}1}".to_owned(),
        "rad/s" => "rad s^{\u{2212}1}".to_owned(),
        other => other.to_owned(),
    }
}

/// The modes that have panels of their own: all, where each was met at several values of the axis; else none,
/// and one pair of panels holds them together.
pub(super) fn apart<'a>(met: impl Iterator<Item = (&'a str, f64)>) -> Vec<Option<&'a str>> {
    let mut values: BTreeMap<&str, BTreeSet<u64>> = BTreeMap::new();
    met.filter(|(_, x)| x.is_finite()).for_each(|(mode, x)| {
        values.entry(mode).or_default().insert(x.to_bits());
    });
    if values.len() > 1 && values.values().all(|of| of.len() > 1) {
        values.into_keys().map(Some).collect()
    } else {
        vec![None]
    }
}

/// Table, look, and columns of growth rate and angular frequency with those of their standard deviations.
pub(super) type Below = (usize, LayerLook, [usize; 2], [Option<usize>; 2]);

/// Two panels over column `x` for every one of `modes`: growth rate and angular frequency, which stand at
/// `first` and two columns further in table 0; `others` are layers below them.
pub(super) fn growth_and_frequency(
    x_label: &str,
    x: usize,
    first: usize,
    others: &[Below],
    modes: &[Option<&str>],
) -> Vec<AnswerPanel> {
    // Their frequencies lie far apart, next to which nothing else is seen.
    let both = [GROWTH_RATE, ANGULAR_FREQUENCY];
    modes
        .iter()
        .flat_map(|mode| both.into_iter().enumerate().map(move |(k, names)| (*mode, k, names)))
        .map(|(mode, k, [_, label, unit])| {
            let label = mode.map_or(label.to_owned(), |mode| format!("{label} of mode {mode}"));
            let mode = mode.map(str::to_owned);
            let below = others.iter().map(|(frame, look, y, sd)| Layer {
                frame: *frame,
                look: *look,
                x,
                y: y[k],
                sd: sd[k],
                mode: mode.clone(),
            });
            let y = first + 2 * k;
            let dots = Layer { frame: 0, look: LayerLook::Dots, x, y, sd: Some(y + 1), mode: mode.clone() };
            AnswerPanel {
                x: x_label.to_owned(),
                y: axis_label(&FrameColumn::new("", &label, unit)),
                layers: below.chain([dots]).collect(),
            }
        })
        .collect()
}
