//! Figs. 6 and 7: the feedback from velocity to heat release, inferred point by point.

use super::powers::{certain, colours, legend, position_axis, powers};
use crate::{
    comparison::{Comparison, Verdict},
    draw::{Axis, Figure, Key, Mark, Panel, Stroke, fixed},
    page::Item,
    sheet::{Cell, Sheet},
};
use rijke_studies::{Feedback, FeedbackPoint};

const SIZE: [f64; 2] = [560.0, 380.0];

/// Which of the two figures.
pub(crate) struct Which {
    id: &'static str,
    title: &'static str,
    file: &'static str,
}

/// Fig. 6.
pub(crate) const FIGURE_6: Which =
    Which { id: "feedback", title: "Figure 6: heat release inferred point by point", file: "figure-6" };

/// Fig. 7.
pub(crate) const FIGURE_7: Which = Which {
    id: "feedback-naive",
    title: "Figure 7: the same with drag and blockage left out",
    file: "figure-7",
};

/// Everything the page shows of this study.
pub(crate) fn item(study: &Feedback, which: &Which) -> Item {
    Item {
        id: which.id,
        title: which.title.to_owned(),
        introduction: format!(
            "The complex feedback coefficient k_eu, inferred from growth rate, frequency and mode shape of each of the {} hot \
             operating points by itself. The other components: {}.",
            study.points.len(),
            study.model
        ),
        comparisons: comparisons(study, which),
        figures: vec![figure(study, which)],
        tables: Vec::new(),
        sheets: vec![sheet(study, which)],
        checks: study.checks.clone(),
        provenance: Some(study.provenance.clone()),
    }
}

/// Points of which the paper speaks: away from the middle of the tube, below its upper end, and above 15 W.
fn clear(study: &Feedback) -> impl Iterator<Item = &FeedbackPoint> {
    study
        .points
        .iter()
        .filter(|p| (p.position_m - 0.5).abs() > 0.12 && p.position_m < 0.78 && p.power_w > 15.0)
}

/// Mean and standard deviation.
fn spread(values: &[f64]) -> [f64; 2] {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
    [mean, variance.sqrt()]
}

fn comparisons(study: &Feedback, which: &Which) -> Vec<Comparison> {
    let lags: Vec<f64> = clear(study).map(|p| p.lag).collect();
    if lags.len() < 4 {
        return Vec::new();
    }
    let half = |below: bool| {
        let side = clear(study).filter(|p| (p.position_m < 0.5) == below);
        spread(&side.map(|p| p.lag).collect::<Vec<_>>())[0]
    };
    let (jump, lag) = ((half(true) - half(false)).abs(), spread(&lags));
    if which.file == "figure-7" {
        return vec![Comparison {
            what: "lag below and above the middle of the tube".to_owned(),
            paper: "\u{201c}seems to change discontinuously around *X*_{h} = 0.5\u{201d}".to_owned(),
            ours: format!("means differ by {} rad", fixed(jump, 2)),
            verdict: Verdict::of(jump > 0.2),
            sentence: "A jump above 0.2 rad counts: there is no physical reason for any; it makes up for what the model lacks."
                .to_owned(),
        }];
    }
    let gain = spread(&clear(study).map(|p| p.modulus_per_watt).collect::<Vec<_>>());
    let relative = gain[1] / gain[0].abs();
    vec![
        Comparison {
            what: "|*k*_{eu}|/*Q*_{h} above 15 W, away from *X*_{h} = 0.5 and below 0.8".to_owned(),
            paper: "\u{201c}independent of the heater position and heater power\u{201d}".to_owned(),
            ours: format!("varies by {} % (1 sd)", fixed(100.0 * relative, 1)),
            verdict: Verdict::of(relative < 0.15),
            sentence: "Below 15 % counts as flat; the paper shows its values in a picture only.".to_owned(),
        },
        Comparison {
            what: "lag of the heat release, same points".to_owned(),
            paper: "\u{201c}independent of the heater position and heater power\u{201d}".to_owned(),
            ours: format!("{} \u{b1} {} rad (1 sd over points)", fixed(lag[0], 2), fixed(lag[1], 2)),
            verdict: Verdict::of(lag[1] < 0.2),
            sentence: "A spread below 0.2 rad counts as flat; the paper shows its values in a picture only."
                .to_owned(),
        },
    ]
}

/// A quantity of a point with its standard deviation.
type Quantity = fn(&FeedbackPoint) -> [f64; 2];

fn figure(study: &Feedback, which: &Which) -> Figure {
    let powers = powers(study.points.iter().map(|p| p.power_w));
    let mut legend = legend(&powers);
    legend.push(Key { mark: Mark::Patch("#3c7bb0"), label: "\u{b1}2 standard deviations".to_owned() });
    let gain: Quantity = |p| [1e3 * p.modulus_per_watt, 1e3 * p.modulus_per_watt_sd];
    let lag: Quantity = |p| [p.lag, p.lag_sd];
    Figure {
        id: which.file,
        title: "Modulus and lag of the feedback coefficient k_eu against heater position and power".to_owned(),
        caption: "Local feedback coefficient from velocity to heat release, *k*_{eu} = \u{2212}|*k*_{eu}| e^{-i lag}, inferred \
                  independently at each power and position of the heater. (a) |*k*_{eu}|/*Q*_{h}; (b) lag of the heat release \
                  behind the velocity. Lines: most probable values; patches: \u{b1}2 standard deviations."
            .to_owned(),
        columns: 2,
        panels: vec![
            panel(study, &powers, "(a)", "|*k*_{eu}| / *Q*_{h} / kW^{-1}", gain),
            panel(study, &powers, "(b)", "Lag of heat release / rad", lag),
        ],
        legend,
        data: Some(study.provenance.data),
    }
}

fn panel(study: &Feedback, powers: &[f64], tag: &str, label: &str, of: Quantity) -> Panel {
    let all: Vec<_> = study.points.iter().map(of).collect();
    let mut panel = Panel::new(tag, SIZE, position_axis(), Axis::covering(label, certain(&all)));
    for (power, colour) in colours(powers) {
        let points: Vec<_> = study.points.iter().filter(|p| p.power_w == power).collect();
        let band = |p: &&FeedbackPoint| {
            let [value, sd] = of(p);
            [p.position_m, value - 2.0 * sd, value + 2.0 * sd]
        };
        panel.band(&points.iter().map(band).collect::<Vec<_>>(), colour, 0.14);
    }
    for (power, colour) in colours(powers) {
        let points: Vec<_> = study.points.iter().filter(|p| p.power_w == power).collect();
        let line: Vec<_> = points.iter().map(|p| [p.position_m, of(p)[0]]).collect();
        panel.curve(&line, &Stroke::solid(colour, 1.6));
        for p in points {
            let [value, sd] = of(p);
            let remark = format!("{}: {} \u{b1} {}", p.id, fixed(value, 3), fixed(sd, 3));
            panel.dot([p.position_m, value], 2.0, colour, &remark);
        }
    }
    panel
}

fn sheet(study: &Feedback, which: &Which) -> Sheet {
    let head = [
        "point",
        "position_m",
        "power_w",
        "heater_velocity_m_per_s",
        "k_eu_re",
        "k_eu_im",
        "var_re",
        "cov_re_im",
        "var_im",
        "modulus_per_watt",
        "modulus_per_watt_sd",
        "lag_rad",
        "lag_sd_rad",
    ];
    let row = |p: &FeedbackPoint| {
        let numbers = [
            p.position_m,
            p.power_w,
            p.heater_velocity,
            p.k_eu[0],
            p.k_eu[1],
            p.covariance[0][0],
            p.covariance[0][1],
            p.covariance[1][1],
            p.modulus_per_watt,
            p.modulus_per_watt_sd,
            p.lag,
            p.lag_sd,
        ];
        [Cell::from(&*p.id)].into_iter().chain(numbers.map(Cell::from)).collect()
    };
    Sheet {
        id: which.file,
        head: head.map(String::from).to_vec(),
        rows: study.points.iter().map(row).collect(),
    }
}
