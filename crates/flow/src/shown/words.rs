//! What inferred flows are said to be, a sentence a line.

use crate::infer::health::FlowWarning;
use crate::infer::report::{RunReport, SettlingReport};
use crate::infer::tension::ClosureTension;

/// Unknowns that the paper has: they come first.
const OF_THE_PAPER: usize = 6;
/// Posterior over prior standard deviation from which on an unknown is not identified.
const NOT_TOLD: f64 = 0.7;

/// What a run says of its place of the heater.
#[must_use]
pub fn words(run: &RunReport) -> Vec<String> {
    let mut all = vec![format!("heater at {} m", run.heater_m)];
    for u in run.unknowns.iter().take(OF_THE_PAPER) {
        let note = if u.shrinkage > NOT_TOLD { "   not identified: the prior" } else { "" };
        all.push(format!("  {:<17} {:>9.4} [{:.4}, {:.4}] {}{note}", u.name, u.value, u.low, u.high, u.unit));
    }
    if let Some(p) = run.powers.last() {
        all.push(format!(
            "  at {} W: {:.4} +- {:.4} m/s at the heater",
            p.power_w, p.heater_velocity, p.heater_velocity_sd
        ));
    }
    if let Some(chi) = run.innovation_chi_squared {
        all.push(format!(
            "  chi-squared of the innovations {chi:.3}: no proof that the parameters are right; compare with --method batch"
        ));
    }
    if run.failed_members > 0 {
        all.push(format!(
            "  {} runs of members failed and were replaced by draws from the other members",
            run.failed_members
        ));
    }
    all.extend(run.warnings.iter().map(|w| format!("  do not trust this result: {}", of_warning(w))));
    all
}

/// What all places of the heater together say of closures.
#[must_use]
pub fn together(runs: &[RunReport]) -> Vec<String> {
    let runs: Vec<&[ClosureTension]> =
        runs.iter().filter_map(|r| r.health.as_ref()).map(|h| h.tensions.as_slice()).collect();
    if runs.len() < 2 {
        return Vec::new();
    }
    let said = |t: &ClosureTension| {
        format!(
            "all places together prefer {} = {:.3} +- {:.3} to {:.3} ({:.1} sd): change it with --closures, or add 5 % to the sd of U_h",
            t.closure,
            t.preferred,
            t.sd,
            t.value,
            t.z.abs()
        )
    };
    ClosureTension::together(&runs).iter().filter(|t| t.is_wrong()).map(said).collect()
}

fn of_warning(warning: &FlowWarning) -> String {
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
        FlowWarning::AtBound { name } => format!(
            "{name} lies in the outermost 1 % of its prior, or at its bound: the readings contradict that prior"
        ),
        FlowWarning::NotConverged => "the search for the most probable unknowns gave up".into(),
    }
}

/// When the flow of a ramp is settled.
#[must_use]
pub fn settles(of: &SettlingReport) -> String {
    let SettlingReport { ramp, power_w, time_s, after_s } = of;
    let when = match after_s {
        Some(0.0) => "the flow is settled".to_owned(),
        Some(s) => format!("the flow settles in about {:.0} minutes", s / 60.0),
        None => "the flow does not settle within four hours".to_owned(),
    };
    format!("{ramp}: {when} after {time_s} s, the last row of its log, if the power stays at {power_w} W")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_reasons_not_to_trust_a_run_are_said_last() {
        let warnings = vec![FlowWarning::NotConverged, FlowWarning::AtBound { name: "h_o".into() }];
        let run = RunReport { heater_m: 0.25, warnings, failed_members: 2, ..RunReport::empty() };
        let said = words(&run);
        assert_eq!((said.len(), said[0].as_str()), (4, "heater at 0.25 m"));
        assert!(said[1].starts_with("  2 runs of members failed"), "{said:?}");
        assert!(said[3].ends_with("h_o lies in the outermost 1 % of its prior, or at its bound: the readings contradict that prior"), "{said:?}");
        assert!(together(&[run.clone(), run]).is_empty());
        let ramp = SettlingReport { ramp: "up".into(), power_w: 60.0, time_s: 900.0, after_s: Some(600.0) };
        assert!(settles(&ramp).contains("settles in about 10 minutes after 900 s"));
    }
}
