//! The first screen: the model that was found as equations with its numbers, and what it does not explain.

use super::numbers::{two_digits, with_uncertainty};
use super::tables::{chosen, formula};
use rijke_draw::html;
use rijke_engine::run::{MeasuredRecord, StageRecord, TrainedParameter};

/// The stage whose model the first screen shows: the last that ranked several models, else the last.
pub(super) fn stage(stages: &[StageRecord]) -> Option<&StageRecord> {
    let competes = |s: &&StageRecord| s.models.iter().filter(|m| m.evidence.is_some()).count() > 1;
    stages.iter().rev().find(competes).or_else(|| stages.last())
}

/// Its equations, its `figure` and what it leaves.
pub(super) fn section(stage: &StageRecord, figure: &str) -> String {
    let Some(model) = chosen(stage) else { return figure.to_owned() };
    let law = |(place, law): &(String, String)| {
        format!("<li>{} = <code>{}</code></li>\n", html(place), formula(law))
    };
    let laws: String = model.laws.iter().map(law).collect();
    let number = |p: &TrainedParameter| {
        let unit = if p.unit == "1" { String::new() } else { format!(" {}", html(&p.unit)) };
        format!("<code>{}</code> = {}{unit}", html(&p.name), with_uncertainty(p.value, p.sd))
    };
    let numbers: Vec<String> = model.parameters.iter().map(number).collect();
    let with =
        if numbers.is_empty() { String::new() } else { format!("<p>with {}</p>\n", numbers.join(", ")) };
    let laws = if laws.is_empty() { laws } else { format!("<ul class=\"laws\">\n{laws}</ul>\n") };
    let left = match unexplained(stage) {
        left if left.is_empty() => String::new(),
        left => format!("<p><b>Not explained:</b> {}</p>\n", left.join(" ")),
    };
    format!("<h2 id=\"found\">{}</h2>\n{laws}{with}{figure}{left}", html(&model.label))
}

/// What the model leaves of the data, and what these ask for.
fn unexplained(stage: &StageRecord) -> Vec<String> {
    let Some(model) = chosen(stage) else { return Vec::new() };
    // Measured with its standard deviation, and predicted.
    type Pick = fn(&MeasuredRecord) -> Option<[f64; 2]>;
    let kinds: [(Pick, &str, &str); 2] = [
        (|m| m.growth_rate, "Growth rates", "1/s"),
        (|m| m.angular_frequency, "Angular frequencies", "rad/s"),
    ];
    let missed = |(k, (of, what, unit)): (usize, (Pick, &str, &str))| {
        let both = stage.measured.iter().zip(model.shown());
        let found: Vec<[f64; 2]> =
            both.filter_map(|(m, p)| of(m).map(|[value, sd]| [value - p[k], sd])).collect();
        let rms = |i: usize| (found.iter().map(|f| f[i] * f[i]).sum::<f64>() / found.len() as f64).sqrt();
        (!found.is_empty()).then(|| {
            let [off, sd] = [rms(0), rms(1)].map(two_digits);
            let with =
                if model.fitted.is_empty() { "" } else { ", with the errors that points share as estimated" };
            format!(
                "{what} are missed by {off} {unit}, root mean square{with}, and were measured to {sd} {unit}."
            )
        })
    };
    let first = stage.missing.as_ref().and_then(|missing| missing.families.first());
    let asked = first.map(|family| {
        if !family.is_required() {
            "No further term gains more than chance would.".to_owned()
        } else {
            format!(
                "The data require a further term: {} would gain {:.1} nats. The uncertainties above assume a complete model{}.",
                html(&family.first.words()),
                family.first.gain,
                stage.moved_since.iter().map(|said| format!("; {}", html(said))).collect::<String>()
            )
        }
    });
    let lengths = stage.lengths.as_ref().map(|lengths| format!("{}.", html(&lengths.words())));
    kinds.into_iter().enumerate().filter_map(missed).chain(asked).chain(lengths).collect()
}
