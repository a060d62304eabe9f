//! A model point by point: residuals over every factor, and each point given all others.

use super::numbers::chance;
use crate::draw::html;
use rijke_engine::run::{
    Answer, AnswerPanel, Checks, Frame, FrameColumn, FrameRow, Layer, LayerLook, PointCheck, StageRecord,
    SumCheck, symbol,
};
use std::collections::BTreeMap;

/// The sums of residuals, and the table of points given all others.
pub(super) fn section(stage: &StageRecord) -> String {
    let Some(checks) = &stage.checks else { return String::new() };
    let sum = |s: &SumCheck| {
        let said = s
            .probability
            .map_or_else(|| "as the noise was chosen from them".to_owned(), |p| format!("p = {}", chance(p)));
        format!("{} {:.1} of {} ({said})", s.what, s.chi_squared, s.count)
    };
    let sums: Vec<String> = checks.sums.iter().map(sum).collect();
    let number = |v: Option<f64>| v.map_or(String::new(), |v| format!("{v:+.2}").replace('-', "\u{2212}"));
    let row = |p: &PointCheck| {
        let mark = if p.doubtful { "*" } else { "" };
        format!(
            "<tr><td>{}{mark}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{:.2}</td></tr>\n",
            html(&p.point),
            number(p.ln_left_out),
            number(p.ahead),
            p.shift
        )
    };
    let mut points: Vec<&PointCheck> = checks.points.iter().collect();
    points.sort_by(|a, b| b.ahead.unwrap_or(0.0).abs().total_cmp(&a.ahead.unwrap_or(0.0).abs()));
    let rows: String = points.into_iter().map(row).collect();
    let rival = checks
        .rival
        .as_ref()
        .map_or(String::new(), |id| format!("<th>nats ahead of <code>{}</code></th>", html(id)));
    let total: f64 = checks.points.iter().filter_map(|p| p.ahead).sum();
    let decided = if checks.rival.is_some() {
        format!(" Together the points are {total:+.1} nats ahead; a few that carry most of it decide the competition.").replace('-', "\u{2212}")
    } else {
        String::new()
    };
    format!(
        "<p>Squares of residuals in standard deviations of the noise: {}.</p>\n<details><summary>Each point foreseen from all others</summary><p>ln of \
         the density of its data given those of all other points, to first order.{decided} * the model moves far without this point: do not trust its \
         number to 0.05 nats.</p><div class=\"wide\"><table><thead><tr><th>point</th><th>ln density, nats</th>{}<th>parameters move without it, \
         sd</th></tr></thead><tbody>\n{rows}</tbody></table></div></details>\n",
        sums.join("; "),
        if rival.is_empty() { "<th></th>".to_owned() } else { rival },
    )
}

/// A number of a point: measured, its standard deviation, predicted, and the residual in standard deviations.
type Said = (f64, f64, f64, Option<f64>);

/// Stage, mode, growth rate (1/s) and frequency (Hz).
type SaidOfMode<'a> = (&'a str, &'a str, [Option<Said>; 2]);

/// What the page says of every measured point under the pointer, as JSON by its name: stage, mode, growth
/// rate (1/s) and frequency (Hz).
pub(super) fn said(stages: &[StageRecord]) -> String {
    let mut all: BTreeMap<&str, Vec<SaidOfMode<'_>>> = BTreeMap::new();
    let rounded = |v: f64, digits: i32| (v * 10f64.powi(digits)).round() / 10f64.powi(digits);
    for stage in stages {
        let going = |m: &&rijke_engine::run::ModelRecord| {
            m.id == stage.chosen && m.predicted.len() == stage.measured.len()
        };
        let Some(model) = stage.models.iter().find(going) else { continue };
        for (k, (m, predicted)) in stage.measured.iter().zip(model.shown()).enumerate() {
            let residual = |part: usize| stage.checks.as_ref().and_then(|c| c.residuals.get(k)?[part]);
            let number = |measured: Option<[f64; 2]>, part: usize, scale: f64| {
                let [value, sd, predicted] =
                    [measured?[0], measured?[1], predicted[part]].map(|v| rounded(scale * v, 3));
                Some((value, sd, predicted, residual(part).map(|r| rounded(r, 1))))
            };
            let both =
                [number(m.growth_rate, 0, 1.0), number(m.angular_frequency, 1, rijke_study::hertz(1.0))];
            all.entry(&m.point).or_default().push((&stage.id, &m.mode, both));
        }
    }
    // A script ends where this text stands, whatever it is in.
    serde_json::to_string(&all).unwrap_or_default().replace('<', "\\u003c")
}

/// The points as a table of numbers.
pub(super) fn points(checks: &Checks) -> Frame {
    let columns = [
        ("ln_left_out", "ln density given all others", "1"),
        ("ahead", "nats ahead of the rival", "1"),
        ("shift", "shift of the parameters", "1"),
    ];
    let row = |p: &PointCheck| FrameRow {
        label: p.point.clone(),
        series: if p.doubtful { "doubtful".to_owned() } else { String::new() },
        values: vec![p.ln_left_out, p.ahead, Some(p.shift)],
        ..FrameRow::default()
    };
    Frame {
        columns: columns.map(|(name, label, unit)| FrameColumn::new(name, label, unit)).to_vec(),
        rows: checks.points.iter().map(row).collect(),
    }
}

/// The residuals over every factor that varies, and over the frequency; none where nothing varies.
pub(super) fn residuals(factors: &[(String, String)], stage: &StageRecord) -> Option<Answer> {
    let checks = stage.checks.as_ref()?;
    let factors = || factors.iter().map(|(name, unit)| (name.as_str(), unit.as_str()));
    let mut columns: Vec<FrameColumn> =
        factors().map(|(name, unit)| FrameColumn::new(name, &symbol(name), unit)).collect();
    columns.push(FrameColumn::new("frequency", "Frequency", "Hz"));
    columns.push(FrameColumn::new("residual", "Residual, given all other points", "1"));
    let last = columns.len() - 1;
    let row = |(m, r): (&rijke_engine::run::MeasuredRecord, &[Option<f64>; 2]), k: usize| {
        let frequency = m.angular_frequency.map(|[v, _]| rijke_study::hertz(v));
        let mut values = m.factors.clone();
        values.extend([frequency, r[k]]);
        let series = ["growth rate", "frequency"][k].to_owned();
        FrameRow { label: m.point.clone(), series, mode: m.mode.clone(), values }
    };
    let both = || stage.measured.iter().zip(&checks.residuals);
    let rows: Vec<FrameRow> = (0..2).flat_map(|k| both().map(move |pair| row(pair, k))).collect();
    let varies = |k: &usize| {
        let mut values = rows.iter().filter_map(|r| r.values[*k]);
        let first = values.next();
        values.any(|v| Some(v) != first)
    };
    let shown: Vec<usize> = (0..last).filter(varies).collect();
    let layer = |k: usize| Layer { frame: 0, look: LayerLook::Dots, x: k, y: last, sd: None, mode: None };
    let panel = |&k: &usize| AnswerPanel {
        x: if columns[k].unit == "1" {
            columns[k].label.clone()
        } else {
            format!("{} / {}", columns[k].label, columns[k].unit)
        },
        y: "Residual / sd".to_owned(),
        layers: vec![layer(k)],
    };
    let panels: Vec<AnswerPanel> = shown.iter().map(panel).collect();
    (!panels.is_empty()).then(|| Answer {
        id: format!("{}-residuals", stage.id),
        title: format!("{}: residuals over every factor", stage.title),
        caption: "What was measured less what all other points foresee, in standard deviations of that."
            .to_owned(),
        parameters: Vec::new(),
        frames: vec![Frame { columns: columns.clone(), rows: rows.clone() }],
        panels,
    })
}
