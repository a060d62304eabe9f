//! Modes as a table, as CSV and as JSON.

use super::advice::{Advice, names};
use super::chain::{Case, Line};
use crate::{
    csv_table::{csv_table, texts},
    failure::{Classify, Failure},
    ui::Ui,
};
use rijke_network::{Modes, SmallChange};
use rijke_report::ModeCurves;
use serde::Serialize;
use std::f64::consts::PI;
use std::fmt::Write;

#[derive(Serialize)]
struct Answer<'a> {
    name: &'a Option<String>,
    counted: usize,
    found: usize,
    poles: usize,
    modes: Vec<Line>,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    sensitivity: &'a [Advice],
}

fn found(modes: &Modes) -> usize {
    modes.modes.iter().map(|m| m.multiplicity).sum()
}

pub(super) fn json(
    case: &Case,
    modes: &Modes,
    lines: Vec<Line>,
    advice: &[Advice],
    ui: &Ui,
) -> Result<(), Failure> {
    let answer = Answer {
        name: &case.title,
        counted: modes.counted,
        found: found(modes),
        poles: modes.poles,
        modes: lines,
        sensitivity: advice,
    };
    ui.document(serde_json::to_string_pretty(&answer).or_failed()?);
    Ok(())
}

pub(super) fn table(case: &Case, modes: &Modes, lines: &[Line], ui: &Ui) {
    let [low, high] = case.region.omega.map(|w| w / (2.0 * PI));
    let [left, right] = case.region.sigma;
    if let Some(name) = &case.title {
        ui.say(name);
    }
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in lines.iter().flat_map(|l| &l.by_elements) {
        if !names.contains(&name.as_str()) {
            names.push(name);
        }
    }
    let mut header = vec![
        "frequency\nHz",
        "growth\n1/s",
        "upstream\nend",
        "downstream\nend",
        "viscous\nwall",
        "thermal\nwall",
    ];
    header.extend(names.iter());
    header.extend(["condition", "residual"]);
    let row = |l: &Line| {
        let number = |v: f64| if v.abs() < 1e-9 { "0".to_owned() } else { format!("{v:.4}") };
        let mut row = vec![format!("{:.4}", l.frequency_hz), format!("{:.4}", l.growth_rate)];
        row.extend(
            [l.by_upstream_end, l.by_downstream_end, l.by_viscous_loss, l.by_thermal_loss].map(number),
        );
        for name in &names {
            let share = l.by_elements.iter().find(|(n, _)| n == name);
            row.push(share.map_or_else(|| "0".to_owned(), |(_, v)| number(*v)));
        }
        row.extend([format!("{:.1}", l.condition), format!("{:.0e}", l.residual)]);
        row
    };
    if !lines.is_empty() {
        ui.table(header, lines.iter().map(row));
        ui.say("The columns between growth and condition are its parts, in 1/s; they add up to it.");
        let ruled = lines.iter().filter_map(|l| l.by_the_rule_of_oscilos);
        let ruled: Vec<String> =
            ruled.map(|[frequency, growth]| format!("{frequency:.4} Hz {growth:+.4} 1/s")).collect();
        if !ruled.is_empty() {
            ui.say(format!("With open ends by OSCILOS_lite's own rule: {}.", ruled.join(", ")));
        }
        let noisy = lines.iter().filter_map(|l| Some((l, l.by_noise_of_tables.filter(|by| by.found > 1)?)));
        let noisy: Vec<String> = noisy
            .map(|(l, by)| {
                format!(
                    "{:.2} +- {:.2} Hz {:+.2} +- {:.2} 1/s",
                    l.frequency_hz, by.frequency_sd_hz, l.growth_rate, by.growth_rate_sd
                )
            })
            .collect();
        if !noisy.is_empty() {
            ui.say(format!("By the noise of measured tables (standard deviations): {}.", noisy.join(", ")));
        }
    }
    let poles = if modes.poles > 0 {
        format!(", {} of laws told apart from them", crate::number::counted(modes.poles, "pole"))
    } else {
        String::new()
    };
    ui.say(format!(
        "{} of {} modes found{poles} between {low:.1} and {high:.1} Hz, {left} and {right} 1/s.",
        found(modes),
        modes.counted
    ));
}

pub(super) fn csv(lines: &[Line], ui: &Ui) -> Result<(), Failure> {
    let head = [
        "frequency [Hz]",
        "growth_rate [1/s]",
        "residual",
        "condition",
        "multiplicity",
        "upstream_end [1/s]",
        "downstream_end [1/s]",
        "viscous_wall [1/s]",
        "thermal_wall [1/s]",
        "elements [1/s]",
    ];
    let row = |l: &Line| {
        let [frequency, growth] = [l.frequency_hz, l.growth_rate].map(|v| v.to_string());
        let (residual, multiplicity) = (format!("{:e}", l.residual), l.multiplicity.to_string());
        let elements: f64 = l.by_elements.iter().map(|(_, v)| v).sum();
        let shares = [l.by_upstream_end, l.by_downstream_end, l.by_viscous_loss, l.by_thermal_loss, elements];
        [frequency, growth, residual, l.condition.to_string(), multiplicity]
            .into_iter()
            .chain(shares.map(|v| v.to_string()))
            .collect()
    };
    ui.say(csv_table(std::iter::once(texts(&head)).chain(lines.iter().map(row)))?.trim_end());
    Ok(())
}

/// Shapes and sensitivities along x as CSV. The rows of a mode begin with its keys, whose columns `keys`
/// names.
pub(crate) fn along<'a>(keys: &str, modes: impl Iterator<Item = (String, &'a ModeCurves)>) -> String {
    let (mut rows, mut columns) = (String::new(), SmallChange::ALL.map(|change| names(change)[1]).to_vec());
    for (key, mode) in modes {
        if mode.changes.is_empty() {
            columns.clear();
        }
        for (k, x) in mode.x.iter().enumerate() {
            let numbers = [*x, mode.pressure[k], mode.velocity[k]].into_iter();
            let numbers = numbers.chain(mode.changes.iter().map(|c| c.1[k])).map(|v| format!(",{v}"));
            // Writing to a string cannot fail.
            let _ = writeln!(rows, "{key}{}", numbers.collect::<String>());
        }
    }
    let columns: String = columns.iter().map(|column| format!(",{column}")).collect();
    format!("{keys},x [m],pressure,velocity_times_rho_c{columns}\n{rows}")
}
