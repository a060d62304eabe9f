//! A model point by point: residuals over every factor, and each point given all others.

use super::numbers::chance;
use rijke_draw::html;
use rijke_engine::run::{PointCheck, StageRecord, SumCheck};
use rijke_numerics::words::capitalised;
use std::collections::BTreeMap;

/// The sums of residuals, and the table of points given all others.
pub(super) fn section(stage: &StageRecord) -> String {
    let Some(checks) = &stage.checks else { return String::new() };
    let sum = |s: &SumCheck| {
        let said = s.probability.map_or_else(
            || "no p: the size of their misfit was chosen so that this sum is near their number".to_owned(),
            |p| format!("p = {}", chance(p)),
        );
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
    let doubts: String =
        checks.doubts().iter().map(|said| format!("<p>{}.</p>\n", html(&capitalised(said)))).collect();
    format!(
        "{doubts}<p>Sum of squared residuals, each over its whole variance (measured error, misfit, and errors that points share, such as that of the gas), \
         of how many data: {}. p is the share of data made by this model itself that leave a larger sum after the same fit.</p>\n<details><summary>Each point predicted from all others</summary><p>ln of \
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
