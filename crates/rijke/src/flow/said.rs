//! What inferred flows are said to be.

use crate::ui::Ui;
use rijke_flow::assimilate::{ClosureTension, FlowWarning, RunReport};
use rijke_flow::settled::SettlingReport;

/// What a run says of its place of the heater.
pub(super) fn summary(run: &RunReport, ui: &Ui) {
    ui.say(format!("heater at {} m", run.heater_m));
    // The six parameters of the paper come first; unknowns.csv has the rest.
    for u in run.unknowns.iter().take(6) {
        let note = if u.shrinkage > 0.7 { "   not identified: the prior" } else { "" };
        ui.say(format!("  {:<17} {:>9.4} [{:.4}, {:.4}] {}{note}", u.name, u.value, u.low, u.high, u.unit));
    }
    if let Some(p) = run.powers.last() {
        ui.say(format!(
            "  at {} W: {:.4} +- {:.4} m/s at the heater",
            p.power_w, p.heater_velocity, p.heater_velocity_sd
        ));
    }
    if let Some(chi) = run.innovation_chi_squared {
        ui.say(format!(
            "  chi-squared of the innovations {chi:.3}: no proof that the parameters are right; compare with --method batch"
        ));
    }
    if run.failed_members > 0 {
        ui.say(format!(
            "  {} runs of members failed and were replaced by draws from the other members",
            run.failed_members
        ));
    }
    for warning in &run.warnings {
        ui.say(format!("  do not trust this result: {}", words(warning)));
    }
}

/// What all places of the heater together say of closures.
pub(super) fn all_places(runs: &[RunReport], ui: &Ui) {
    let runs: Vec<&[ClosureTension]> =
        runs.iter().filter_map(|r| r.health.as_ref()).map(|h| h.tensions.as_slice()).collect();
    if runs.len() < 2 {
        return;
    }
    for t in ClosureTension::together(&runs).iter().filter(|t| t.is_wrong()) {
        ui.say(format!(
            "all places together prefer {} = {:.3} +- {:.3} to {:.3} ({:.1} sd): change it with --closures, or add 5 % to the sd of U_h",
            t.closure,
            t.preferred,
            t.sd,
            t.value,
            t.z.abs()
        ));
    }
}

fn words(warning: &FlowWarning) -> String {
    match warning {
        FlowWarning::PoorFit { chi_squared } => {
            format!("chi-squared per datum is {chi_squared:.2}, so the model misses more than the noise")
        }
        FlowWarning::Pattern { sensor, correlation } => {
            format!(
                "the residuals of sensor {sensor} follow a pattern in time (correlation {correlation:.2})"
            )
        }
        FlowWarning::Closure { name, value, preferred, z } => format!(
            "the readings prefer {name} = {preferred:.3} to {value:.3} ({:.1} sd): this closure, or what looks like it, is wrong",
            z.abs()
        ),
        FlowWarning::AtBound { name } => format!("{name} is held by the bound of its prior"),
        FlowWarning::NotConverged => "the search for the most probable unknowns gave up".into(),
    }
}

/// When the flow of a ramp is settled.
pub(super) fn settles(of: &SettlingReport) -> String {
    let SettlingReport { ramp, power_w, time_s, after_s } = of;
    let when = match after_s {
        Some(0.0) => "the flow is settled".to_owned(),
        Some(s) => format!("the flow settles in about {:.0} minutes", s / 60.0),
        None => "the flow does not settle within four hours".to_owned(),
    };
    format!("{ramp}: {when} after {time_s} s, the last row of its log, if the power stays at {power_w} W")
}
