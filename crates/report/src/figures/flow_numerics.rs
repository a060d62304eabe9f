//! Numerics of the pipe flow: orders, and how well the energy closes.

use crate::{
    draw::{Axis, Figure, Key, Mark, Panel, Stroke, fixed, model_stroke},
    page::Item,
    sheet::{Cell, Sheet},
    table::Table,
};
use rijke_studies::{FlowNumerics, FlowOrder};

const SIZE: [f64; 2] = [480.0, 320.0];
const NAMES: [&str; 3] =
    ["arrival time, \u{b5}s", "velocity at the heater, mm s^{-1}", "highest temperature, K"];
const SECOND: Stroke = Stroke::dashed("#999", 1.2, "4 3");

/// Everything the page shows of this study.
pub(crate) fn item(study: &FlowNumerics) -> Item {
    Item {
        id: "flow-numerics",
        title: "Section 3.1: numerics of the pipe flow".to_owned(),
        introduction: format!(
            "Errors of the flow model against its limit, with the heater at {} m, and what is missing in its balance of energy. Nothing \
             here depends on data.",
            fixed(study.heater_m, 2)
        ),
        comparisons: Vec::new(),
        figures: vec![figure(study)],
        tables: vec![table(study)],
        sheets: vec![sheet(study), energies(study)],
        checks: study.checks.clone(),
        provenance: None,
    }
}

fn figure(study: &FlowNumerics) -> Figure {
    let key = |stroke: Stroke, label: &str| Key { mark: Mark::Line(stroke), label: label.to_owned() };
    let mut legend: Vec<Key> = NAMES.iter().enumerate().map(|(k, name)| key(model_stroke(k), name)).collect();
    legend.push(key(SECOND, "second order; goal for the energy"));
    Figure {
        id: "flow-numerics",
        title: "Orders and energy of the pipe flow".to_owned(),
        caption: "(a) Errors of the steady state at 180 W against the number of cells, (b) errors 120 s after a step from 80 to 180 W \
                  against the step; the grey lines have second order. (c) What is missing in the balance of energy of steady states \
                  at 15 places of the heater, over the power, and (d) over the staircase of powers of the paper, over what was supplied so \
                  far; grey: the goal of 1e-10. All axes but power and time are decimal logarithms."
            .to_owned(),
        columns: 2,
        panels: vec![
            orders("(a)", "lg of number of cells", &study.cells, -2.0),
            orders("(b)", "lg of step / s", &study.steps, 2.0),
            at_rest(study),
            in_motion(study),
        ],
        legend,
        data: None,
    }
}

/// Errors with a line of the given slope through the first of them.
fn orders(tag: &str, label: &str, rows: &[FlowOrder], slope: f64) -> Panel {
    let point = |r: &FlowOrder, k: usize| [r.size.log10(), r.errors[k].abs().log10()];
    let all = || rows.iter().flat_map(|r| (0..3).map(|k| point(r, k)));
    let x = Axis::covering(label, all().map(|p| p[0]));
    let y = Axis::covering("lg of |error|", all().map(|p| p[1]));
    let mut panel = Panel::new(tag, SIZE, x, y);
    for k in 0..3 {
        let points: Vec<_> = rows.iter().map(|r| point(r, k)).collect();
        if let Some([x0, y0]) = points.first().copied() {
            let line: Vec<_> = points.iter().map(|p| [p[0], y0 + slope * (p[0] - x0)]).collect();
            panel.curve(&line, &SECOND);
        }
        panel.curve(&points, &model_stroke(k));
        for (point, row) in points.iter().zip(rows) {
            panel.dot(*point, 2.6, model_stroke(k).colour, &format!("{}: {:.2e}", NAMES[k], row.errors[k]));
        }
    }
    panel
}

/// lg of what is missing; nothing at all counts as a thousandth of the rounding of one number.
fn lg(missing: f64) -> f64 {
    missing.max(1e-19).log10()
}

fn at_rest(study: &FlowNumerics) -> Panel {
    let values = study.at_rest.iter().map(|r| lg(r[2])).chain([-10.0]);
    let x = Axis::covering("Power of the heater / W", study.at_rest.iter().map(|r| r[1]));
    let mut panel = Panel::new("(c)", SIZE, x, Axis::covering("lg of missing share", values));
    panel.horizontal(-10.0, &SECOND);
    for [place, power, missing] in &study.at_rest {
        let remark = format!("{} m, {} W: {missing:.1e}", fixed(*place, 2), fixed(*power, 0));
        panel.dot([*power, lg(*missing)], 2.2, model_stroke(0).colour, &remark);
    }
    panel
}

fn in_motion(study: &FlowNumerics) -> Panel {
    let points: Vec<_> =
        study.in_motion.iter().map(|[time, missing]| [time / 3600.0, lg(*missing)]).collect();
    let x = Axis::covering("Time / h", points.iter().map(|p| p[0]));
    let y = Axis::covering("lg of missing share", points.iter().map(|p| p[1]).chain([-10.0]));
    let mut panel = Panel::new("(d)", SIZE, x, y);
    panel.horizontal(-10.0, &SECOND);
    panel.curve(&points, &model_stroke(0));
    panel
}

fn table(study: &FlowNumerics) -> Table {
    let row = |(what, r): (&str, &FlowOrder)| {
        let order = |k: usize| r.orders.map_or_else(String::new, |o| fixed(o[k], 2));
        let [t, u, temperature] = r.errors;
        let size = if what == "cells" { fixed(r.size, 0) } else { fixed(r.size, 2) };
        vec![
            format!("{size} {what}"),
            format!("{t:.1e}"),
            order(0),
            format!("{u:.1e}"),
            order(1),
            format!("{temperature:.1e}"),
            order(2),
        ]
    };
    let cells = study.cells.iter().map(|r| ("cells", r));
    let head = ["", NAMES[0], "order", NAMES[1], "order", NAMES[2], "order"];
    Table {
        id: "flow-numerics",
        caption: "Errors against the limit. The first row of each kind is what the program uses, but for the step, which is 15 s."
            .to_owned(),
        head: head.map(String::from).to_vec(),
        rows: cells.chain(study.steps.iter().map(|r| ("s", r))).map(row).collect(),
        line_above: Some(study.cells.len()),
        ..Table::default()
    }
}

fn sheet(study: &FlowNumerics) -> Sheet {
    let head =
        ["kind", "size", "arrival_time_error_us", "heater_velocity_error_mm_per_s", "temperature_error_k"];
    let row = |kind: &str, r: &FlowOrder| {
        [Cell::from(kind), Cell::from(r.size)].into_iter().chain(r.errors.map(Cell::from)).collect()
    };
    let cells = study.cells.iter().map(|r| row("cells", r));
    let rows = cells.chain(study.steps.iter().map(|r| row("step_s", r))).collect();
    Sheet { id: "flow-orders", head: head.map(String::from).to_vec(), rows }
}

fn energies(study: &FlowNumerics) -> Sheet {
    let head = ["heater_m", "power_w", "missing_share"];
    let rows = study.at_rest.iter().map(|r| r.map(Cell::from).into_iter().collect()).collect();
    Sheet { id: "flow-energy", head: head.map(String::from).to_vec(), rows }
}
