//! Fig. 5: the model of all cold components against every cold experiment.

use super::measured::{MEASURED, PREDICTED, measured, predicted};
use super::ranking::valued;
use crate::{
    comparison::{Comparison, Verdict},
    draw::{Axis, Figure, Key, Mark, Panel, Stroke, Symbol, fixed},
    page::Item,
    sheet::Sheet,
    table::Table,
};
use rijke_studies::{Cold, ColdSeries, MeasuredPoint, PredictedPoint};

const SIZE: [f64; 2] = [560.0, 400.0];
/// Neighbours farther apart are not joined by a line, m.
const GAP: f64 = 0.11;

/// Everything the page shows of this study.
pub(crate) fn item(study: &Cold) -> Item {
    Item {
        id: "cold",
        title: "Figure 5: all cold experiments".to_owned(),
        introduction: format!(
            "One model of tube, ends, prongs, heater and thermocouples ({}), trained part by part, against every experiment \
             with the heater off.",
            study.candidates.join(", ")
        ),
        comparisons: vec![comparison(study)],
        figures: vec![figure(study)],
        tables: vec![parameters(study)],
        sheets: vec![sheet(study)],
        checks: study.checks.clone(),
        provenance: Some(study.provenance.clone()),
    }
}

/// Symbol and colour of a row, as the paper draws them.
fn look(series: &ColdSeries) -> (Symbol, &'static str) {
    match series.row.as_str() {
        "C3" => (Symbol::Square, "#7b3294"),
        row if row.starts_with('H') => (Symbol::Triangle, "#d1700a"),
        _ => (Symbol::Circle, "#0072b2"),
    }
}

/// A quantity of a measured and of a predicted point.
type Quantity = (fn(&MeasuredPoint) -> f64, fn(&PredictedPoint) -> f64, &'static str);
const GROWTH_RATE: Quantity = (|p| p.growth_rate, |p| p.growth_rate, "1/s");
const FREQUENCY: Quantity = (|p| p.angular_frequency, |p| p.angular_frequency, "rad/s");

fn pairs(study: &Cold) -> impl Iterator<Item = (&ColdSeries, &MeasuredPoint, &PredictedPoint)> {
    study.series.iter().flat_map(|s| s.measured.iter().zip(&s.predicted).map(move |(m, p)| (s, m, p)))
}

/// Root mean square of measured less predicted.
fn misfit(study: &Cold, (measured, predicted, _): Quantity) -> f64 {
    let squares: Vec<f64> = pairs(study).map(|(_, m, p)| (measured(m) - predicted(p)).powi(2)).collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
}

fn comparison(study: &Cold) -> Comparison {
    let spread = |of: fn(&MeasuredPoint) -> f64| {
        let values: Vec<f64> = pairs(study).map(|(_, m, _)| of(m)).collect();
        let (low, high) =
            values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
        high - low
    };
    let (growth, frequency) = (misfit(study, GROWTH_RATE), misfit(study, FREQUENCY));
    let share = growth / spread(GROWTH_RATE.0);
    Comparison {
        what: "calibrated model beside all cold experiments".to_owned(),
        paper: "lines through the points of rows C1, C2, C3 and H0".to_owned(),
        ours: format!(
            "misfit {} s^{{-1}} and {} rad s^{{-1}} (root mean square)",
            fixed(growth, 3),
            fixed(frequency, 2)
        ),
        verdict: Verdict::of(share < 0.05),
        sentence: format!(
            "The misfit of the growth rate is {} % of its range over all cold points; below 5 % the lines of the figure go \
             through the points.",
            fixed(100.0 * share, 1)
        ),
    }
}

fn figure(study: &Cold) -> Figure {
    let mut legend: Vec<Key> = Vec::new();
    for series in &study.series {
        let (symbol, colour) = look(series);
        let label = format!("{}: {}", series.row, series.label);
        legend.push(Key { mark: Mark::Symbol(symbol, colour), label });
    }
    legend.push(Key { mark: Mark::Line(Stroke::solid("#555", 1.3)), label: "model".to_owned() });
    Figure {
        id: "figure-5",
        title: "Growth rate and angular frequency of all cold experiments, measured and predicted".to_owned(),
        caption: "(a) Growth rate and (b) angular frequency of the first mode, measured (symbols) and predicted (lines), for all \
                  cold experiments, against the position of heater or prongs; 0 is the empty tube. Each point is predicted at \
                  the ambient temperature of its own day, hence the jagged lines."
            .to_owned(),
        columns: 2,
        panels: vec![
            panel(study, "(a)", "Growth rate *s*_{r} / s^{-1}", GROWTH_RATE),
            panel(study, "(b)", "Angular frequency *s*_{i} / rad s^{-1}", FREQUENCY),
        ],
        legend,
        data: Some(study.provenance.data),
    }
}

fn panel(study: &Cold, tag: &str, label: &str, (measured, predicted, unit): Quantity) -> Panel {
    let y = Axis::covering(label, pairs(study).flat_map(|(_, m, p)| [measured(m), predicted(p)]));
    let x = Axis::new("Position of heater or prongs *X* / m", -0.03, 1.0).with_step(0.2);
    let mut panel = Panel::new(tag, SIZE, x, y);
    for series in &study.series {
        let (symbol, colour) = look(series);
        let places = series.measured.iter().zip(&series.predicted);
        let mut line: Vec<[f64; 2]> = Vec::new();
        for (m, p) in places {
            // The empty tube and a heater far inside are not two points of one curve.
            if line.last().is_some_and(|last| m.position_m - last[0] > GAP) {
                line.push([f64::NAN; 2]);
            }
            line.push([m.position_m, predicted(p)]);
        }
        panel.curve(&line, &Stroke::solid(colour, 1.3));
        for m in &series.measured {
            let value = measured(m);
            let remark = format!("{}: {} {unit}", m.id, fixed(value, 3));
            panel.symbol([m.position_m, value], symbol, colour, &remark);
        }
    }
    panel
}

fn parameters(study: &Cold) -> Table {
    let rows = study.parameters.iter().map(|p| vec![p.name.clone(), valued(p)]);
    Table {
        id: "figure-5",
        caption: "All parameters after the last cold stage, \u{b1} standard deviation.".to_owned(),
        head: ["Parameter", "Value"].map(String::from).to_vec(),
        rows: rows.collect(),
        ..Table::default()
    }
}

fn sheet(study: &Cold) -> Sheet {
    let head = MEASURED.into_iter().chain(PREDICTED).map(String::from).collect();
    let rows = pairs(study).map(|(_, m, p)| measured(m).into_iter().chain(predicted(p)).collect());
    Sheet { id: "figure-5", head, rows: rows.collect() }
}
