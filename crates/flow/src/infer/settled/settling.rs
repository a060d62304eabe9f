//! How long the flow of a ramp takes to settle after the last change that its log has.

use super::of_run::Settled;
use super::prediction::Predicted;
use super::run::State;
use crate::apparatus::ramp::Ramp;
use crate::error::FlowError;
use crate::infer::report::SettlingReport;
use rijke_numerics::Matrix;

/// How far ahead is looked, s, and in what steps.
const AHEAD: f64 = 4.0 * 3600.0;
const STEP: f64 = 60.0;
/// Settled: mass flux and velocity within this share of where they end, and temperatures within so many
/// kelvin.
const SHARE: f64 = 0.01;
const KELVIN: f64 = 1.0;

impl Settled<'_> {
    /// The ramps of the run, each continued with its last power at the most probable unknowns.
    pub(super) fn settling(&self) -> Result<Vec<SettlingReport>, FlowError> {
        let all = self.run.ramps.iter().enumerate();
        all.filter_map(|(r, ramp)| self.settling_of(r, ramp).transpose()).collect()
    }

    fn settling_of(&self, r: usize, ramp: &Ramp) -> Result<Option<SettlingReport>, FlowError> {
        let (Some(last), Some(like)) =
            (ramp.log.last(), self.run.states.iter().find(|s| s.moment.is_some_and(|m| m.0 == r)))
        else {
            return Ok(None);
        };
        let later = |k: u32| State {
            power: last.power,
            sensors: Vec::new(),
            readings: Vec::new(),
            noise: Matrix::zeros(0, 0),
            moment: Some((r, last.time + STEP * f64::from(k))),
            ..like.clone()
        };
        // The states of the run stay, for the unknowns are those of its days.
        let mut run = self.run.clone();
        let known = run.states.len();
        run.states.extend((0..=(AHEAD / STEP) as u32).map(later));
        let found = run.predict(self.pipe, &self.priors, &self.mean, Some(&self.predicted))?;
        let moments = &found[known..];
        let from = moments.last().and_then(|end| moments.iter().rposition(|now| !is_near(now, end)));
        let after_s = match from {
            None => Some(0.0),
            Some(k) if k + 2 < moments.len() => Some(STEP * (k + 1) as f64),
            Some(_) => None,
        };
        Ok(Some(SettlingReport { ramp: ramp.id.clone(), power_w: last.power, time_s: last.time, after_s }))
    }
}

/// Whether a moment is settled, by where the ramp ends.
fn is_near(now: &Predicted, end: &Predicted) -> bool {
    let (flow, gas) = now.base.split_at(FLOW);
    let shares = flow.iter().zip(&end.base).all(|(a, b)| (a - b).abs() <= SHARE * a.abs().max(b.abs()));
    shares && gas.iter().zip(&end.base[FLOW..]).all(|(a, b)| (a - b).abs() <= KELVIN)
}

/// Numbers of a base state that are of the flow, before the temperatures: mass flux and velocity at the
/// heater.
const FLOW: usize = 2;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::infer::settled::JointFit;
    use crate::infer::settled::tests::{SD, pipe, ramped, read};
    use rijke_numerics::Streams;

    /// Where a ramp ends is another solver's: the settled state.
    #[test]
    fn oracle_a_ramp_is_settled_when_it_is_near_the_steady_state() {
        let pipe = pipe(0.35);
        let mut run = ramped();
        read(&pipe, &mut run, SD, &mut Streams::new(1).stream("ramp settles"));
        let runs = [(pipe.clone(), run.clone().checked(&pipe).unwrap())];
        let fit = JointFit::new(&runs).unwrap();
        let (reports, _) = fit.report().unwrap();
        let [said] = &reports[0].settling[..] else { panic!("one ramp") };
        assert_eq!((said.ramp.as_str(), said.power_w, said.time_s), ("a", 180.0, 600.0));
        let after = said.after_s.unwrap();
        assert!(after > 300.0, "{after}");
        let hot = run.states[4].clone();
        let at = |moment| State { moment, ..hot.clone() };
        run.states.extend([at(None), at(Some((0, 600.0 + after))), at(Some((0, 540.0 + after)))]);
        let found = Settled::at_prior(&pipe, &run).states(&fit.runs[0].mean, None).unwrap();
        let off = |k: usize| {
            let all = found[k].base.iter().zip(&found[5].base).enumerate();
            all.map(|(j, (a, b))| if j < 2 { (a / b - 1.0).abs() / 0.01 } else { (a - b).abs() })
                .fold(0.0, f64::max)
        };
        assert!(off(6) < 1.1 && off(7) > 0.95 && off(7) > off(6), "{} {}", off(6), off(7));
    }
}
