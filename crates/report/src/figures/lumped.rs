//! Where the wall loss lives: the paper's lumped scheme against the exact lossy line.

use crate::{
    draw::{Axis, Figure, Key, Mark, Panel, Stroke, fixed},
    page::Item,
    sheet::{Cell, Sheet},
    table::Table,
};
use rijke_studies::{LumpedConvergence, LumpedRow};

const SIZE: [f64; 2] = [560.0, 340.0];
const GROWTH_RATE: Stroke = Stroke::solid("#0072b2", 1.6);
const FREQUENCY: Stroke = Stroke::dashed("#d55e00", 1.6, "5 3");

/// Everything the page shows of this study.
pub(crate) fn item(study: &LumpedConvergence) -> Item {
    Item {
        id: "lumped",
        title: "Section 5: lumped wall loss against the exact line".to_owned(),
        introduction: format!(
            "The paper puts the wall loss into N \u{2212} 1 jumps between N equal elements. The first mode of the empty tube \
             then approaches that of the exact lossy line, s = {} + {} i in 1/s, as the elements become shorter. Elsewhere on \
             this page the exact line is used.",
            fixed(study.exact[0], 4),
            fixed(study.exact[1], 3)
        ),
        comparisons: Vec::new(),
        figures: vec![figure(study)],
        tables: vec![table(study)],
        sheets: vec![sheet(study)],
        checks: study.checks.clone(),
        provenance: None,
    }
}

fn figure(study: &LumpedConvergence) -> Figure {
    type Curve = (Stroke, fn(&LumpedRow) -> f64, &'static str);
    let curves: [Curve; 2] = [
        (GROWTH_RATE, |r| 100.0 * r.growth_rate_error, "growth rate"),
        (FREQUENCY, |r| 100.0 * r.angular_frequency_error, "angular frequency"),
    ];
    let values = curves.iter().flat_map(|(_, error, _)| study.rows.iter().map(error)).chain([0.0]);
    let y = Axis::covering("Relative error / %", values);
    let x = Axis::new("1 / number of elements", 0.0, 0.105).with_step(0.02);
    let mut panel = Panel::new("", SIZE, x, y);
    let mut legend = Vec::new();
    for (stroke, error, name) in curves {
        let points: Vec<_> = study.rows.iter().map(|r| [1.0 / r.elements as f64, error(r)]).collect();
        panel.curve(&points, &stroke);
        for (point, row) in points.iter().zip(&study.rows) {
            panel.dot(
                *point,
                2.6,
                stroke.colour,
                &format!("{} elements: {} %", row.elements, fixed(point[1], 3)),
            );
        }
        legend.push(Key { mark: Mark::Line(stroke), label: name.to_owned() });
    }
    Figure {
        id: "lumped",
        title: "Error of the lumped scheme against the length of its elements".to_owned(),
        caption: "Relative error of the first mode with the wall loss lumped between *N* elements. The error of the growth \
                  rate falls as 1/*N*."
            .to_owned(),
        columns: 1,
        panels: vec![panel],
        legend,
        data: None,
    }
}

fn table(study: &LumpedConvergence) -> Table {
    let head = [
        "Elements",
        "*s*_{r} / s^{-1}",
        "*s*_{i} / rad s^{-1}",
        "error of *s*_{r} / %",
        "error of *s*_{i} / %",
        "order",
    ];
    let row = |row: &LumpedRow| {
        let [growth, frequency] = row.eigenvalue;
        vec![
            row.elements.to_string(),
            fixed(growth, 4),
            fixed(frequency, 3),
            fixed(100.0 * row.growth_rate_error, 3),
            fixed(100.0 * row.angular_frequency_error, 4),
            row.order.map_or_else(String::new, |o| fixed(o, 3)),
        ]
    };
    Table {
        id: "lumped",
        caption: "Order: binary logarithm of the ratio of the errors of s_r in one row and the next."
            .to_owned(),
        head: head.map(String::from).to_vec(),
        rows: study.rows.iter().map(row).collect(),
        ..Table::default()
    }
}

fn sheet(study: &LumpedConvergence) -> Sheet {
    let head = [
        "elements",
        "growth_rate_per_s",
        "angular_frequency_rad_per_s",
        "growth_rate_relative_error",
        "angular_frequency_relative_error",
    ];
    let row = |row: &LumpedRow| {
        let [growth, frequency] = row.eigenvalue;
        let errors = [row.growth_rate_error, row.angular_frequency_error];
        [row.elements as f64, growth, frequency].into_iter().chain(errors).map(Cell::from).collect()
    };
    Sheet { id: "lumped", head: head.map(String::from).to_vec(), rows: study.rows.iter().map(row).collect() }
}
