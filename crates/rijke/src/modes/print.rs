//! Modes as a table.

use crate::ui::Ui;
use rijke_engine::folder::{FoundModes, ModeCase, ModeLine};
use rijke_network::Advice;
use rijke_numerics::words::counted;
use std::f64::consts::PI;

/// What modes move by in more pieces is shown from here on, Hz and 1/s.
const SHOWN: f64 = 0.01;

pub(super) fn table(case: &ModeCase, found: &FoundModes, ui: &Ui) {
    let [low, high] = case.region.omega.map(|w| w / (2.0 * PI));
    let [left, right] = case.region.sigma;
    let lines = &found.modes;
    if let Some(name) = &found.name {
        ui.say(name);
    }
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in lines.iter().flat_map(|l| &l.by_elements) {
        if !names.contains(&name.as_str()) {
            names.push(name);
        }
    }
    let parts = "frequency\nHz,growth\n1/s,upstream\nend,downstream\nend,viscous\nwall,thermal\nwall";
    let mut header: Vec<&str> = parts.split(',').collect();
    header.extend(names.iter());
    header.extend(["condition", "residual"]);
    let row = |l: &ModeLine| {
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
        ui.say("The columns between growth and condition are parts of the growth rate, in 1/s; they add up to it. Condition: the largest factor by which relative errors of ducts and coefficients are magnified in s.");
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
    let moved = |l: &ModeLine| l.by_twice_as_many_pieces.unwrap_or_default();
    if lines.iter().any(|l| moved(l).iter().any(|by| by.abs() > SHOWN)) {
        let all: Vec<String> = lines
            .iter()
            .map(|l| (l, moved(l)))
            .map(|(l, [frequency, growth])| {
                format!("{:.2} Hz by {frequency:+.3} Hz and {growth:+.3} 1/s", l.frequency_hz)
            })
            .collect();
        ui.say(format!(
            "With twice as many pieces for slopes, cones and spread flames the modes would be elsewhere: {}. If that is too much, give these ducts and flames more `pieces`.",
            all.join(", ")
        ));
    }
    let poles = if found.poles > 0 {
        format!(", {} of the laws excluded", counted(found.poles, "pole"))
    } else {
        String::new()
    };
    ui.say(format!(
        "{} of {} modes found{poles} between {low:.1} and {high:.1} Hz, {left} and {right} 1/s.",
        found.found, found.counted
    ));
}

pub(super) fn advice(modes: usize, advice: &[Advice], ui: &Ui) {
    if advice.is_empty() {
        return;
    }
    let head = ["mode\nHz", "small change", "best place\nm", "growth rate\nchanges by, 1/s"];
    let row = |Advice { frequency_hz, best }: &Advice| {
        let effect = if best.growth_rate_change < 0.0 {
            format!("{:.4}", best.growth_rate_change)
        } else {
            "nowhere less".to_owned()
        };
        [format!("{frequency_hz:.2}"), best.proposal.to_owned(), format!("{:.3}", best.at), effect]
    };
    ui.table(head, advice.iter().map(row));
    let modes = counted(modes, "mode");
    ui.say(format!("Each change by itself, to first order, for {modes}. Curves along x: --plot, --along."));
}
