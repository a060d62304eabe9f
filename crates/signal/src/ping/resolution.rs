//! Records of a converter whose steps are larger than the noise. A signal of many steps, rounded, has an
//! error of step/sqrt(12) that is white; silence does not show it.

use crate::{Fault, Trace};

/// Noise of less than this share of a step hides in silence what quantisation does.
const HALF: f64 = 0.5;
/// Steps of a coarse converter down to which a decay is used, in the loudest channel: below them the samples
/// are no longer proportional to it.
const STEPS: f64 = 2.0;
/// The same as an amplitude over the noise of quantisation.
pub(crate) const LEAST: f64 = STEPS * 3.464_101_615;
/// Steps that the loudest channel must have: of eight steps without noise errors are twice what is stated.
const STEPS_NEEDED: f64 = 12.0;

/// The noise of each channel, of a converter with the given steps (0 where they are fine), where silence does
/// not show it, else none.
///
/// # Errors
/// [`Fault::Coarse`] if no channel spans the steps that are needed.
pub(crate) fn deviations(trace: &Trace<'_>, steps: &[f64], quiet: usize) -> Result<Option<Vec<f64>>, Fault> {
    let silent = || trace.channels.iter().map(|y| deviation(&y[..quiet])).zip(steps);
    if silent().all(|(d, step)| d >= HALF * *step) {
        return Ok(None);
    }
    enough_steps(trace, steps)?;
    Ok(Some(silent().map(|(d, step)| d.hypot(step / 12.0_f64.sqrt())).collect()))
}

/// Refuses a record of a coarse converter if no channel has the amplitude that is needed.
fn enough_steps(trace: &Trace<'_>, steps: &[f64]) -> Result<(), Fault> {
    let amplitude = |y: &Vec<f64>| {
        let (low, high) = y.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (v.min(a), v.max(b)));
        0.5 * (high - low)
    };
    let in_steps = trace
        .channels
        .iter()
        .zip(steps)
        .map(|(y, s)| if *s > 0.0 { amplitude(y) / s } else { f64::INFINITY });
    match in_steps.enumerate().max_by(|a, b| a.1.total_cmp(&b.1)) {
        Some((channel, most)) if most < STEPS_NEEDED => {
            let (step, amplitude) = (steps[channel], most * steps[channel]);
            Err(Fault::Coarse { channel: channel.into(), step, amplitude, need: STEPS_NEEDED })
        }
        _ => Ok(()),
    }
}

/// Standard deviation of samples.
pub(crate) fn deviation(y: &[f64]) -> f64 {
    let mean = y.iter().sum::<f64>() / y.len() as f64;
    (y.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / y.len() as f64).sqrt()
}
