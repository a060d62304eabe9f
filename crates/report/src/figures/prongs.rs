//! Fig. 4 and Table 2, and Table 3: competing models of a part of the rig.

use crate::{
    draw::{Axis, Figure, INK, Key, Mark, Panel, fixed, model_stroke},
    page::Item,
    sheet::{Cell, Sheet},
    table::Table,
};
use rijke_studies::{CurvePoint, MeasuredPoint, ParameterValue, ProngModel, Prongs};

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
    let verdict = if study.winner == study.published_winner {
        format!("The evidence selects the same model as in the paper: {}.", name(study, &study.winner))
    } else {
        format!(
            "The evidence selects {}; the paper, with its own data, selects {}.",
            name(study, &study.winner),
            name(study, &study.published_winner)
        )
    };
    Item {
        id: part.id,
        title: part.title.to_owned(),
        introduction: format!(
            "{} models of {}, trained on the same {} operating points and ranked by marginal likelihood. {verdict} \
             Kendall's \u{3c4} between the two orders is {}. Models whose number starts with + are not in the paper.",
            study.models.len(),
            part.what,
            study.measured.len(),
            fixed(study.kendall_tau, 2)
        ),
        figures: vec![figure(study, part)],
        tables: vec![ranking(study, part), parameters(study, part)],
        sheets: vec![curves(study, part), evidence(study, part), values(study, part)],
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
             measurement noise that maximises its posterior.",
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

/// Table 2 beside the published one.
fn ranking(study: &Prongs, part: &Part) -> Table {
    let head = [
        "Model",
        "What it contains",
        "Parameters",
        "ln BFL",
        "ln OF",
        "ln ML",
        "paper: ln BFL",
        "ln OF",
        "ln ML",
    ];
    let signed = |v: f64| if v >= 0.0 { format!("+{}", fixed(v, 4)) } else { fixed(v, 4) };
    let row = |(i, model): (usize, &ProngModel)| {
        let mut row = vec![number(i, model), model.label.clone(), model.parameters.len().to_string()];
        for evidence in [model.evidence, model.published] {
            row.extend(match evidence {
                Some(e) => [e.ln_best_fit, e.ln_occam, e.ln_marginal].map(signed),
                None => ["\u{2013}"; 3].map(String::from),
            });
        }
        row
    };
    Table {
        id: part.files[1],
        caption: format!(
            "Best-fit likelihood (BFL), Occam factor (OF) and marginal likelihood (ML), natural logarithms per operating \
             point, ours and as published in {}. The row of the highest marginal likelihood is marked. The two sets of data \
             differ, so only the order and the differences can agree.",
            part.table
        ),
        head: head.map(String::from).to_vec(),
        rows: study.models.iter().enumerate().map(row).collect(),
        marked: study.models.iter().position(|m| m.id == study.winner),
    }
}

/// The trained parameters and the noise each model needs.
fn parameters(study: &Prongs, part: &Part) -> Table {
    let head = [
        "Model",
        "Parameters, most probable \u{b1} sd",
        "noise of *s*_{r} / s^{-1}",
        "noise of *s*_{i} / rad s^{-1}",
        "noise of *P*",
    ];
    let row = |(i, model): (usize, &ProngModel)| {
        let parameter = |p: &ParameterValue| {
            let unit = if p.unit == "1" { String::new() } else { format!(" {}", p.unit) };
            format!("{} = {} \u{b1} {}{unit}", p.symbol, fixed(p.value, 4), fixed(p.sd, 4))
        };
        let parameters = model.parameters.iter().map(parameter).collect::<Vec<_>>().join("; ");
        let noise = [model.growth_rate_noise_sd, model.angular_frequency_noise_sd, model.pressure_noise_sd];
        [number(i, model), parameters].into_iter().chain(noise.map(|sd| fixed(sd, 4))).collect()
    };
    let caption = "Trained parameters, with standard deviations by Laplace's method, and the standard deviation of the \
                   measurement noise that maximises each model's posterior."
        .to_owned();
    let rows = study.models.iter().enumerate().map(row).collect();
    Table { id: part.files[2], caption, head: head.map(String::from).to_vec(), rows, marked: None }
}

/// Fig. 4: a row per operating point.
fn curves(study: &Prongs, part: &Part) -> Sheet {
    let fixed_head = [
        "point",
        "position_m",
        "ambient_temperature_k",
        "growth_rate_per_s",
        "growth_rate_sd_per_s",
        "angular_frequency_rad_per_s",
        "angular_frequency_sd_rad_per_s",
    ];
    let mut head = fixed_head.map(String::from).to_vec();
    for model in &study.models {
        head.push(format!("{}_growth_rate_per_s", model.id));
        head.push(format!("{}_angular_frequency_rad_per_s", model.id));
    }
    let row = |(k, p): (usize, &MeasuredPoint)| {
        let measured = [
            p.position_m,
            p.ambient_temperature,
            p.growth_rate,
            p.growth_rate_sd,
            p.angular_frequency,
            p.angular_frequency_sd,
        ];
        let mut row = vec![Cell::from(&*p.id)];
        row.extend(measured.map(Cell::from));
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

/// Table 2: a row per model.
fn evidence(study: &Prongs, part: &Part) -> Sheet {
    let head = [
        "model",
        "contains",
        "parameters",
        "ln_best_fit",
        "ln_occam",
        "ln_marginal",
        "published_ln_best_fit",
        "published_ln_occam",
        "published_ln_marginal",
        "growth_rate_noise_sd_per_s",
        "angular_frequency_noise_sd_rad_per_s",
        "pressure_noise_sd",
    ];
    let row = |model: &ProngModel| {
        let mut row = vec![
            Cell::from(&*model.id),
            Cell::from(&*model.label),
            Cell::from(model.parameters.len() as f64),
        ];
        for evidence in [model.evidence, model.published] {
            row.extend(match evidence {
                Some(e) => [e.ln_best_fit, e.ln_occam, e.ln_marginal].map(Cell::from),
                None => [Cell::Empty, Cell::Empty, Cell::Empty],
            });
        }
        row.extend(
            [model.growth_rate_noise_sd, model.angular_frequency_noise_sd, model.pressure_noise_sd]
                .map(Cell::from),
        );
        row
    };
    Sheet {
        id: part.files[1],
        head: head.map(String::from).to_vec(),
        rows: study.models.iter().map(row).collect(),
    }
}

/// The trained parameters: a row per model and parameter.
fn values(study: &Prongs, part: &Part) -> Sheet {
    let head = ["model", "parameter", "unit", "most_probable", "sd"].map(String::from).to_vec();
    let rows = study.models.iter().flat_map(|model| {
        model.parameters.iter().map(|p| {
            vec![
                Cell::from(&*model.id),
                Cell::from(&*p.name),
                Cell::from(&*p.unit),
                Cell::from(p.value),
                Cell::from(p.sd),
            ]
        })
    });
    Sheet { id: part.files[2], head, rows: rows.collect() }
}

/// Row of the paper's table, or the rank in ours for a candidate that the paper does not have.
fn number(index: usize, model: &ProngModel) -> String {
    model.number.map_or_else(|| format!("+{}", index + 1), |n| n.to_string())
}

fn title(index: usize, model: &ProngModel) -> String {
    format!("{}: {}", number(index, model), model.label)
}

fn name(study: &Prongs, id: &str) -> String {
    let found = study.models.iter().enumerate().find(|(_, m)| m.id == id);
    found.map_or_else(|| id.to_owned(), |(i, m)| format!("model {} ({})", number(i, m), m.label))
}
