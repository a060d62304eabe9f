//! Fig. 12: the posterior of the empty tube from every set of microphones that holds the reference microphone.

use super::empty_tube::{PAIRS, ellipse, roman};
use crate::{
    comparison::{Comparison, Verdict},
    draw::{Axis, Figure, Key, Mark, Panel, Stroke, fixed},
    page::Item,
};
use rijke_studies::{Case, Microphones};

const SIZE: [f64; 2] = [330.0, 280.0];
const CONTOUR: Stroke = Stroke::solid("#0072b2", 0.9);
const PREDICTED: Stroke = Stroke::dashed("#d55e00", 1.0, "5 3");
const LABELS: [&str; 3] = ["|*R*|", "\u{2220}*R* / rad", "*\u{3b7}*"];

/// Everything the page shows of this study.
pub(crate) fn item(study: &Microphones) -> Item {
    Item {
        id: "microphones",
        title: "Figure 12: how many microphones are needed".to_owned(),
        introduction: format!(
            "Three standard deviations of the posterior of the empty tube for each of the {} sets of microphones that hold \
             the reference microphone.",
            study.sets.len()
        ),
        comparisons: comparisons(study),
        figures: vec![figure(study)],
        tables: Vec::new(),
        sheets: Vec::new(),
        checks: study.checks.clone(),
        provenance: Some(study.provenance.clone()),
    }
}

/// What section 6.7 says of Fig. 12.
fn comparisons(study: &Microphones) -> Vec<Comparison> {
    let Some(all) = study.sets.last() else { return Vec::new() };
    // How much wider than with all microphones the worst parameter of a set is.
    let wider = |case: &Case| {
        let of = |k: usize| (case.covariance[k][k] / all.covariance[k][k]).sqrt();
        (0..all.mean.len()).map(of).fold(0.0, f64::max)
    };
    let pairs: Vec<f64> = study.sets.iter().filter(|s| s.microphones.len() == 2).map(wider).collect();
    if pairs.is_empty() {
        return Vec::new();
    }
    let (best, worst) = pairs.iter().fold((f64::INFINITY, 0.0f64), |(b, w), v| (b.min(*v), w.max(*v)));
    vec![
        Comparison {
            what: "two microphones: the choice of the pair".to_owned(),
            paper: "\u{201c}depend strongly on which pair\u{201d}".to_owned(),
            ours: format!("{} to {} times the sd of all", fixed(best, 1), fixed(worst, 1)),
            verdict: Verdict::of(worst > 2.0 * best),
            sentence: "The worst parameter of each pair, beside all microphones.".to_owned(),
        },
        Comparison {
            what: "the best pair beside all microphones".to_owned(),
            paper: "\u{201c}nearly the same uncertainty\u{201d}".to_owned(),
            ours: format!("{} times the sd of all", fixed(best, 1)),
            verdict: Verdict::of(best < 2.0),
            sentence: "Within a factor of two counts as nearly the same; the noise that is assumed is the same for every set."
                .to_owned(),
        },
    ]
}

fn figure(study: &Microphones) -> Figure {
    let most = study.sets.iter().map(|s| s.microphones.len()).max().unwrap_or(0);
    let mut panels = Vec::new();
    for (pair, letter) in PAIRS.iter().zip(["a", "b", "c"]) {
        let axes = pair.map(|k| {
            let spans = study.sets.iter().flat_map(|case| {
                let half = 3.0 * case.covariance[k][k].sqrt();
                [case.mean[k] - half, case.mean[k] + half]
            });
            Axis::covering(LABELS[k], spans.chain([study.predicted[k]])).with_most_ticks(4)
        });
        for count in 1..=most {
            let tag = format!("({letter}.{}) {count} of {most}", roman(count));
            let [x, y] = axes.clone();
            let mut panel = Panel::new(&tag, SIZE, x, y);
            panel.vertical(study.predicted[pair[0]], &PREDICTED);
            panel.horizontal(study.predicted[pair[1]], &PREDICTED);
            for case in study.sets.iter().filter(|s| s.microphones.len() == count) {
                panel.contour(&ellipse(case, *pair, 3.0), &CONTOUR, "none", 0.0);
            }
            panels.push(panel);
        }
    }
    Figure {
        id: "figure-12",
        title: "Posterior of the empty tube from every set of microphones".to_owned(),
        caption: "Contours of 3 standard deviations from every set of microphones that holds the reference microphone, from \
                  one microphone (i) to all (viii)."
            .to_owned(),
        columns: 4,
        panels,
        legend: vec![
            Key { mark: Mark::Line(CONTOUR), label: "3 standard deviations, one set".to_owned() },
            Key { mark: Mark::Line(PREDICTED), label: "predicted by Levine\u{2013}Schwinger and Rayleigh".to_owned() },
        ],
        data: Some(study.provenance.data),
    }
}
