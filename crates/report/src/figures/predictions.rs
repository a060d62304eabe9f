//! Figs. 8 to 11: one trained model against all hot operating points.

use super::measured::{MEASURED, PREDICTED, measured, predicted};
use super::powers::{colours, legend, position_axis, powers};
use super::ranking::valued;
use crate::{
    comparison::{Comparison, Verdict},
    draw::{Axis, Figure, Key, Mark, Panel, Stroke, fixed},
    page::Item,
    sheet::{Cell, Sheet},
    table::Table,
};
use rijke_studies::{HotPoint, HotPredictions, MeasuredPoint, PredictedPoint};

const SIZE: [f64; 2] = [560.0, 440.0];

/// Which of the four figures.
pub(crate) struct Which {
    id: &'static str,
    title: &'static str,
    files: [&'static str; 2],
    compare: fn(&HotPredictions) -> Vec<Comparison>,
}

/// Fig. 8.
pub(crate) const FIGURE_8: Which = Which {
    id: "no-damping-fitted",
    title: "Figure 8: heat release fitted, damping from the literature",
    files: ["figure-8", "figure-8-parameters"],
    compare: under_damped,
};

/// Fig. 9.
pub(crate) const FIGURE_9: Which = Which {
    id: "wall-fitted",
    title: "Figure 9: all missing damping put into the wall",
    files: ["figure-9", "figure-9-parameters"],
    compare: wall_factor,
};

/// Fig. 10.
pub(crate) const FIGURE_10: Which = Which {
    id: "chosen-model",
    title: "Figure 10: the model that the evidence chooses",
    files: ["figure-10", "figure-10-parameters"],
    compare: accurate,
};

/// Fig. 11.
pub(crate) const FIGURE_11: Which = Which {
    id: "eight-points",
    title: "Figure 11: the chosen model, trained on a few operating points",
    files: ["figure-11", "figure-11-parameters"],
    compare: extrapolates,
};

/// Everything the page shows of this study.
pub(crate) fn item(study: &HotPredictions, which: &Which) -> Item {
    let [growth, frequency] = [GROWTH_RATE, FREQUENCY].map(|q| misfit(study, q, |_| true));
    Item {
        id: which.id,
        title: which.title.to_owned(),
        introduction: format!(
            "{} Trained on {} of the {} hot operating points; root mean square misfit over all of them {} 1/s and {} rad/s.",
            sentence(&study.model),
            study.trained_on.len(),
            study.measured.len(),
            fixed(growth, 3),
            fixed(frequency, 2)
        ),
        comparisons: (which.compare)(study),
        figures: vec![figure(study, which)],
        tables: vec![parameters(study, which)],
        sheets: vec![sheet(study, which)],
        checks: study.checks.clone(),
        provenance: Some(study.provenance.clone()),
    }
}

/// With a capital and a full stop.
fn sentence(text: &str) -> String {
    let mut letters = text.trim_end_matches('.').chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    format!("{first}{}.", letters.as_str())
}

/// What is drawn of a point, and the noise that the model needs.
#[derive(Clone, Copy)]
struct Quantity {
    measured: fn(&MeasuredPoint) -> f64,
    predicted: fn(&PredictedPoint) -> f64,
    predicted_sd: fn(&PredictedPoint) -> f64,
    noise: fn(&HotPredictions) -> f64,
    unit: &'static str,
}

const GROWTH_RATE: Quantity = Quantity {
    measured: |p| p.growth_rate,
    predicted: |p| p.growth_rate,
    predicted_sd: |p| p.growth_rate_sd,
    noise: |s| s.growth_rate_noise_sd,
    unit: "1/s",
};

const FREQUENCY: Quantity = Quantity {
    measured: |p| p.angular_frequency,
    predicted: |p| p.angular_frequency,
    predicted_sd: |p| p.angular_frequency_sd,
    noise: |s| s.angular_frequency_noise_sd,
    unit: "rad/s",
};

fn pairs(study: &HotPredictions) -> impl Iterator<Item = (&HotPoint, &PredictedPoint)> {
    study.measured.iter().zip(&study.predicted)
}

/// Root mean square of measured less predicted over the wanted points.
fn misfit(study: &HotPredictions, q: Quantity, wanted: impl Fn(&HotPoint) -> bool) -> f64 {
    let squares: Vec<f64> = pairs(study)
        .filter(|(m, _)| wanted(m))
        .map(|(m, p)| ((q.measured)(&m.measured) - (q.predicted)(p)).powi(2))
        .collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
}

/// Fig. 8: the paper's model over-predicts the growth rate, and turns positive.
fn under_damped(study: &HotPredictions) -> Vec<Comparison> {
    let over = pairs(study).filter(|(m, p)| p.growth_rate > m.measured.growth_rate).count();
    let of = study.measured.len();
    let highest = pairs(study).max_by(|a, b| a.1.growth_rate.total_cmp(&b.1.growth_rate));
    let mut all = vec![Comparison {
        what: "predicted growth rate beside the measured".to_owned(),
        paper: "\u{201c}always over-predicts\u{201d}".to_owned(),
        ours: format!("too high at {over} of {of} points"),
        verdict: Verdict::of(over == of),
        sentence: "The model lacks the drag of prongs, heater and thermocouples.".to_owned(),
    }];
    all.extend(highest.map(|(m, p)| {
        let near = (m.measured.position_m - 0.25).abs() < 0.11;
        Comparison {
            what: "highest predicted growth rate".to_owned(),
            paper: "positive, at high power near *X*_{h} = 0.25".to_owned(),
            ours: format!(
                "{} s^{{-1}} at {} W, *X*_{{h}} = {} m",
                fixed(p.growth_rate, 2),
                fixed(m.power_w, 0),
                fixed(m.measured.position_m, 2)
            ),
            verdict: Verdict::of(p.growth_rate > 0.0 && near),
            sentence: "All measured points decay, so a positive growth rate reveals the error of the model."
                .to_owned(),
        }
    }));
    all
}

/// Fig. 9: the fitted wall-loss factor.
fn wall_factor(study: &HotPredictions) -> Vec<Comparison> {
    let eta = study.parameters.iter().find(|p| p.name == "eta");
    eta.map(|eta| Comparison {
        what: "wall-loss factor that makes up for the missing drag".to_owned(),
        paper: "1.67".to_owned(),
        ours: format!("{} \u{b1} {}", fixed(eta.value, 2), fixed(eta.sd, 2)),
        verdict: Verdict::of((eta.value - 1.67).abs() < 0.17),
        sentence: "It stands for the drag of prongs, heater and thermocouples of the rig at hand; within a tenth of the paper's \
                   counts as the same."
            .to_owned(),
    })
    .into_iter()
    .collect()
}

/// Fig. 10: accurate everywhere.
fn accurate(study: &HotPredictions) -> Vec<Comparison> {
    let [growth, frequency] = study.coverage.map(|c| 100.0 * c);
    let all = (90.0..=99.0).contains(&growth) && (90.0..=99.0).contains(&frequency);
    vec![Comparison {
        what: "hot points within 2 predicted sd".to_owned(),
        paper: "\u{201c}quantitatively accurate over the entire operating range\u{201d}".to_owned(),
        ours: format!("{} % of growth rates, {} % of frequencies", fixed(growth, 0), fixed(frequency, 0)),
        verdict: Verdict::of(all),
        sentence: if all {
            "Between 90 and 99 % is what an honest standard deviation gives; the paper states no share."
                .to_owned()
        } else {
            "An honest standard deviation gives between 90 and 99 %; the paper states no share.".to_owned()
        },
    }]
}

/// Fig. 11: a few points are enough.
fn extrapolates(study: &HotPredictions) -> Vec<Comparison> {
    let used = |m: &HotPoint| study.trained_on.contains(&m.measured.id);
    let [inside, outside] = [true, false].map(|which| misfit(study, GROWTH_RATE, |m| used(m) == which));
    let shares = study.coverage_elsewhere.map(|c| c.map(|c| 100.0 * c));
    let shares = shares.filter(|_| study.trained_on.len() < study.measured.len());
    shares
        .map(|[growth, frequency]| Comparison {
            what: format!("points that were not among the {} used in training", study.trained_on.len()),
            paper: "\u{201c}almost indistinguishable from Fig. 10\u{201d}".to_owned(),
            ours: format!(
                "{} % of growth rates and {} % of frequencies within 2 sd; misfit {} s^{{-1}}, {} s^{{-1}} at those used",
                fixed(growth, 0),
                fixed(frequency, 0),
                fixed(outside, 3),
                fixed(inside, 3)
            ),
            verdict: Verdict::of(growth >= 90.0 && frequency >= 90.0),
            sentence: "At least 90 % within 2 standard deviations counts as a successful extrapolation.".to_owned(),
        })
        .into_iter()
        .collect()
}

fn figure(study: &HotPredictions, which: &Which) -> Figure {
    let powers = powers(study.measured.iter().map(|m| m.power_w));
    let mut legend = legend(&powers);
    legend.push(Key { mark: Mark::Patch("#3c7bb0"), label: "predicted, \u{b1}2 sd".to_owned() });
    legend.push(Key {
        mark: Mark::Dot("#444"),
        label: "measured, \u{b1}2 sd of the noise that the model needs".to_owned(),
    });
    if study.trained_on.len() < study.measured.len() {
        legend.push(Key {
            mark: Mark::Cross(Stroke::solid("#000", 1.6)),
            label: "used in training".to_owned(),
        });
    }
    Figure {
        id: which.files[0],
        title: "Growth rate and angular frequency of the hot operating points, measured and predicted".to_owned(),
        caption: "(a) Growth rate and (b) angular frequency of the first mode against the position of the heater, one colour per \
                  power: measured (dots) and predicted (lines). Patches: two standard deviations of the prediction for a new measurement, \
                  from parameters, base flow and noise. Bars: two standard deviations of the measurement noise that \
                  maximises the posterior of this model."
            .to_owned(),
        columns: 2,
        panels: vec![
            panel(study, &powers, "(a)", "Growth rate *s*_{r} / s^{-1}", GROWTH_RATE),
            panel(study, &powers, "(b)", "Angular frequency *s*_{i} / rad s^{-1}", FREQUENCY),
        ],
        legend,
        data: Some(study.provenance.data),
    }
}

fn panel(study: &HotPredictions, powers: &[f64], tag: &str, label: &str, q: Quantity) -> Panel {
    let bar = 2.0 * (q.noise)(study);
    let held = pairs(study).flat_map(|(m, p)| {
        let value = (q.measured)(&m.measured);
        [value - bar, value + bar, (q.predicted)(p)]
    });
    let mut panel = Panel::new(tag, SIZE, position_axis(), Axis::covering(label, held.collect::<Vec<_>>()));
    if q.unit == "1/s" {
        panel.horizontal(0.0, &Stroke::dashed("#999", 0.8, "2 3"));
    }
    for (power, colour) in colours(powers) {
        let points: Vec<_> = pairs(study).filter(|(m, _)| m.power_w == power).collect();
        let band = |(m, p): &(&HotPoint, &PredictedPoint)| {
            let (value, half) = ((q.predicted)(p), 2.0 * (q.predicted_sd)(p));
            [m.measured.position_m, value - half, value + half]
        };
        panel.band(&points.iter().map(band).collect::<Vec<_>>(), colour, 0.1);
        let line: Vec<_> = points.iter().map(|(m, p)| [m.measured.position_m, (q.predicted)(p)]).collect();
        panel.curve(&line, &Stroke::solid(colour, 1.5));
        for (m, p) in points {
            let at = [m.measured.position_m, (q.measured)(&m.measured)];
            panel.error_bar(at, bar, 0.0, &Stroke::solid(colour, 0.9));
            let remark = format!(
                "{}: measured {}, predicted {} {}",
                m.measured.id,
                fixed(at[1], 3),
                fixed((q.predicted)(p), 3),
                q.unit
            );
            panel.dot(at, 2.4, colour, &remark);
            let few = study.trained_on.len() < study.measured.len();
            if few && study.trained_on.contains(&m.measured.id) {
                panel.cross(at, 5.0, &Stroke::solid("#000", 1.6));
            }
        }
    }
    panel
}

fn parameters(study: &HotPredictions, which: &Which) -> Table {
    let rows = study.parameters.iter().map(|p| vec![p.name.clone(), valued(p)]);
    Table {
        id: which.files[1],
        caption: format!(
            "Parameters of the model ({}), \u{b1} standard deviation; those without one are held.",
            study.candidates.join(", ")
        ),
        head: ["Parameter", "Value"].map(String::from).to_vec(),
        rows: rows.collect(),
        ..Table::default()
    }
}

fn sheet(study: &HotPredictions, which: &Which) -> Sheet {
    let own = ["trained_on", "power_w", "heater_velocity_m_per_s", "heater_velocity_sd_m_per_s"];
    let row = |(m, p): (&HotPoint, &PredictedPoint)| {
        let used = f64::from(u8::from(study.trained_on.contains(&m.measured.id)));
        let own = [used, m.power_w, m.heater_velocity, m.heater_velocity_sd].map(Cell::from);
        measured(&m.measured).into_iter().chain(own).chain(predicted(p)).collect()
    };
    Sheet {
        id: which.files[0],
        head: MEASURED.into_iter().chain(own).chain(PREDICTED).map(String::from).collect(),
        rows: pairs(study).map(row).collect(),
    }
}
