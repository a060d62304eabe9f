//! The figure of a stage: measured points and what its models predict, over the factor that varies most.

use super::StudyHead;
use crate::draw::{Axis, Figure, INK, Key, Mark, Panel, model_stroke};
use rijke_engine::run::{ModelRecord, StageRecord};

const SIZE: [f64; 2] = [520.0, 360.0];

/// How many models a figure shows.
const MOST_MODELS: usize = 7;

/// Growth rate and frequency over the factor with the most values; nothing where none varies.
pub(super) fn of(head: &StudyHead, stage: &StageRecord) -> Vec<Figure> {
    let values = |k: usize| -> Vec<f64> {
        let mut all: Vec<f64> =
            stage.measured.iter().filter_map(|m| m.factors.get(k).copied().flatten()).collect();
        all.sort_by(f64::total_cmp);
        all.dedup_by(|a, b| (*a - *b).abs() < 1e-12);
        all
    };
    let Some((factor, axis)) =
        (0..head.factors.len()).map(|k| (k, values(k))).max_by_key(|(k, v)| (v.len(), std::cmp::Reverse(*k)))
    else {
        return Vec::new();
    };
    if axis.len() < 2 {
        return Vec::new();
    }
    let mut models: Vec<&ModelRecord> =
        stage.models.iter().filter(|m| m.predicted.len() == stage.measured.len()).collect();
    let evidence = |m: &ModelRecord| m.evidence.map_or(f64::NEG_INFINITY, |e| e.ln_marginal);
    models.sort_by(|a, b| evidence(b).total_cmp(&evidence(a)));
    models.truncate(MOST_MODELS);
    let (name, unit) = &head.factors[factor];
    let label = format!("{name} / {unit}");
    let panels = [("Growth rate / s^{\u{2212}1}", 0), ("Angular frequency / rad s^{\u{2212}1}", 1)]
        .into_iter()
        .filter_map(|(title, k)| panel(stage, &models, factor, [&label, title], &axis, k))
        .collect();
    let key =
        |(i, m): (usize, &&ModelRecord)| Key { mark: Mark::Line(model_stroke(i)), label: m.label.clone() };
    let legend = std::iter::once(Key { mark: Mark::Dot(INK), label: "measured".into() })
        .chain(models.iter().enumerate().map(key))
        .collect();
    vec![Figure {
        id: "stage",
        title: stage.title.clone(),
        caption: format!(
            "{}: measured modes (dots) and the models with the most evidence (dashes at the measured points).",
            stage.title
        ),
        columns: 2,
        panels,
        legend,
        data: Some(head.kind),
    }]
}

fn panel(
    stage: &StageRecord,
    models: &[&ModelRecord],
    factor: usize,
    [x_label, y_label]: [&str; 2],
    axis: &[f64],
    k: usize,
) -> Option<Panel> {
    let measured =
        |m: &rijke_engine::run::MeasuredRecord| if k == 0 { m.growth_rate } else { m.angular_frequency };
    let points: Vec<(f64, [f64; 2], String)> = stage
        .measured
        .iter()
        .filter_map(|m| Some((m.factors[factor]?, measured(m)?, m.point.clone())))
        .collect();
    let all =
        points.iter().map(|p| p.1[0]).chain(models.iter().flat_map(|m| m.predicted.iter().map(|p| p[k])));
    let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    if !(low.is_finite() && high.is_finite()) {
        return None;
    }
    let room = (0.08 * (high - low)).max(1e-6 * high.abs());
    let (from, to) = (axis[0], axis[axis.len() - 1]);
    let side = 0.06 * (to - from);
    let mut panel = Panel::new(
        "",
        SIZE,
        Axis::new(x_label, from - side, to + side),
        Axis::new(y_label, low - room, high + room),
    );
    let half = 0.018 * (to - from + 2.0 * side);
    for (i, model) in models.iter().enumerate().rev() {
        for (m, p) in stage.measured.iter().zip(&model.predicted) {
            if let Some(x) = m.factors[factor] {
                panel.curve(&[[x - half, p[k]], [x + half, p[k]]], &model_stroke(i));
            }
        }
    }
    for (x, [value, sd], id) in &points {
        panel.error_bar([*x, *value], 2.0 * sd, 0.0, &crate::draw::Stroke::solid(INK, 1.0));
        panel.dot([*x, *value], 2.8, INK, &format!("{id}: {value:.3} \u{b1} {sd:.3}"));
    }
    Some(panel)
}
