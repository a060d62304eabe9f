//! Fig. 4 and Table 2, and Table 3: competing models of a part of the rig.

use super::measured::{MEASURED, measured};
use super::ranking::{Ranking, title};
use crate::{
    draw::{Axis, Figure, INK, Key, Mark, Panel, fixed, model_stroke},
    page::Item,
    sheet::{Cell, Sheet},
};
use rijke_studies::{CurvePoint, MeasuredPoint, ProngModel, Prongs};

const SIZE: [f64; 2] = [560.0, 380.0];
/// Distance between the bars of neighbouring models at one measured point, pixels.
const OFFSET: f64 = 2.6;

/// Which part of the rig competing models describe, in the words of the page.
pub(crate) struct Part {
    id: &'static str,
    title: &'static str,
    what: &'static str,
    table: &'static str,
    files: [&'static str; 3],
    position: &'static str,
}

/// Table 2 and Fig. 4.
pub(crate) const PRONGS: Part = Part {
    id: "prongs",
    title: "Table 2 and Figure 4: drag and blockage of the prongs",
    what: "what the prongs do to the first mode",
    table: "Table 2",
    files: ["figure-4", "table-2", "table-2-parameters"],
    position: "Prong position *X*_{p} / m",
};

/// Table 3.
pub(crate) const HEATER: Part = Part {
    id: "heater",
    title: "Table 3: drag and blockage of the heater, switched off",
    what: "what the cold heater does to the first mode",
    table: "Table 3",
    files: ["table-3-curves", "table-3", "table-3-parameters"],
    position: "Heater position *X*_{h} / m",
};

/// Everything the page shows of this study.
pub(crate) fn item(study: &Prongs, part: &Part) -> Item {
    let ranking = Ranking {
        models: &study.models,
        winner: &study.winner,
        published_winner: &study.published_winner,
        kendall_tau: study.kendall_tau,
        checks: &study.checks,
        points: study.measured.len(),
        table: part.table,
        files: [part.files[1], part.files[2]],
    };
    Item {
        id: part.id,
        title: part.title.to_owned(),
        introduction: format!(
            "{} models of {}, trained on the same {} operating points and ranked by marginal likelihood. Models \
             whose number starts with + are not in the paper.",
            study.models.len(),
            part.what,
            study.measured.len()
        ),
        comparisons: ranking.comparisons(),
        figures: vec![figure(study, part)],
        tables: vec![ranking.table(), ranking.parameters()],
        sheets: vec![curves(study, part), ranking.evidence(), ranking.values()],
        checks: study.checks.clone(),
        provenance: Some(study.provenance.clone()),
    }
}

/// The models that the paper has, with their places in the study.
fn drawn(study: &Prongs) -> impl Iterator<Item = (usize, &ProngModel)> {
    study.models.iter().enumerate().filter(|(_, m)| m.number.is_some())
}

fn figure(study: &Prongs, part: &Part) -> Figure {
    let mut legend = vec![Key { mark: Mark::Dot(INK), label: "measured, mean of the repeats".to_owned() }];
    for (i, model) in drawn(study) {
        legend.push(Key { mark: Mark::Line(model_stroke(i)), label: title(i, model) });
    }
    Figure {
        id: part.files[0],
        title: format!("Growth rate and angular frequency against position, models of {}", part.table),
        caption: format!(
            "(a) Growth rate and (b) angular frequency of the first mode against position. Dots: measured. Lines: models \
             of {} at their most probable parameters, each point at the temperature of its own day, hence the steps. Bars: \
             for each model, from the first on the left to the last on the right, two standard deviations of the \
             measurement noise that maximises its posterior. They do not hold what dots scatter by because the ends come out a \
             little different at each setting of the rig, which the mode shapes show, alike for all models.",
            part.table
        ),
        columns: 2,
        panels: vec![
            panel(study, part, "(a)", "Growth rate *s*_{r} / s^{-1}", &GROWTH_RATE),
            panel(study, part, "(b)", "Angular frequency *s*_{i} / rad s^{-1}", &FREQUENCY),
        ],
        legend,
        data: Some(study.provenance.data),
    }
}

/// One of the two quantities of Fig. 4.
struct Quantity {
    measured: fn(&MeasuredPoint) -> f64,
    predicted: fn(&CurvePoint) -> f64,
    noise: fn(&ProngModel) -> f64,
    unit: &'static str,
}

const GROWTH_RATE: Quantity = Quantity {
    measured: |p| p.growth_rate,
    predicted: |p| p.growth_rate,
    noise: |m| m.growth_rate_noise_sd,
    unit: "1/s",
};

const FREQUENCY: Quantity = Quantity {
    measured: |p| p.angular_frequency,
    predicted: |p| p.angular_frequency,
    noise: |m| m.angular_frequency_noise_sd,
    unit: "rad/s",
};

fn panel(study: &Prongs, part: &Part, tag: &str, label: &str, q: &Quantity) -> Panel {
    let dots = study.measured.iter().map(q.measured);
    let lines = drawn(study).flat_map(|(_, m)| m.at_points.iter().map(q.predicted));
    let bars = drawn(study).flat_map(|(_, m)| {
        let bar = 2.0 * (q.noise)(m);
        study.measured.iter().flat_map(move |p| [(q.measured)(p) - bar, (q.measured)(p) + bar])
    });
    let y = Axis::covering(label, dots.chain(lines).chain(bars));
    let x = Axis::new(part.position, -0.03, 1.0).with_step(0.2);
    let mut panel = Panel::new(tag, SIZE, x, y);
    let middle = 0.5 * (drawn(study).count().max(1) - 1) as f64;
    for (i, model) in drawn(study) {
        let stroke = model_stroke(i);
        let mut line: Vec<[f64; 2]> = Vec::new();
        for p in &model.at_points {
            // Where the next row of the campaign starts again from below, the line is interrupted.
            if line.last().is_some_and(|last| last[0] >= p.position_m) {
                line.push([f64::NAN; 2]);
            }
            line.push([p.position_m, (q.predicted)(p)]);
        }
        panel.curve(&line, &stroke);
        let thin = crate::draw::Stroke::solid(stroke.colour, 0.9);
        for p in &study.measured {
            let centre = [p.position_m, (q.measured)(p)];
            panel.error_bar(centre, 2.0 * (q.noise)(model), OFFSET * (i as f64 - middle), &thin);
        }
    }
    for p in &study.measured {
        let value = (q.measured)(p);
        panel.dot([p.position_m, value], 2.6, INK, &format!("{}: {} {}", p.id, fixed(value, 3), q.unit));
    }
    panel
}

/// Fig. 4: a row per operating point.
fn curves(study: &Prongs, part: &Part) -> Sheet {
    let mut head = MEASURED.map(String::from).to_vec();
    for model in &study.models {
        head.push(format!("{}_growth_rate_per_s", model.id));
        head.push(format!("{}_angular_frequency_rad_per_s", model.id));
    }
    let row = |(k, p): (usize, &MeasuredPoint)| {
        let mut row = measured(p);
        for model in &study.models {
            row.extend(match model.at_points.get(k) {
                Some(point) => [point.growth_rate, point.angular_frequency].map(Cell::from),
                None => [Cell::Empty, Cell::Empty],
            });
        }
        row
    };
    Sheet { id: part.files[0], head, rows: study.measured.iter().enumerate().map(row).collect() }
}
