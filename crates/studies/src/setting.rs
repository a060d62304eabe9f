//! How far the rig comes back to the same state when it is set anew.

use rijke_inference::{NoiseEstimate, NoiseMode};
use rijke_model::Varying;

/// Standard deviation between settings of the angle of R, rad, so of Im `k_LS`. Section 6.1: with eta = 1 and the same R at both ends the
/// two experiments with the empty tube give angles of 3.0597 and 3.0641, and a difference of two is 2^(1/2) standard deviations.
const ANGLE_SD: f64 = 0.0031;

/// Where one setting is all there is.
pub(crate) fn ends_as_in_the_paper() -> Vec<Varying> {
    ends(NoiseMode::Fixed { sd: ANGLE_SD })
}

/// Where the data, of many settings, say how far they scatter: within a factor of e of what the paper's one pair says.
pub(crate) fn ends_inferred() -> Vec<Varying> {
    ends(NoiseMode::Inferred { median: ANGLE_SD, ln_sd: 1.0 })
}

/// As an earlier stage found.
pub(crate) fn ends_as_found(sd: f64) -> Vec<Varying> {
    ends(NoiseMode::Fixed { sd })
}

/// The standard deviation that a training found; the paper's if it had no ends that could vary.
pub(crate) fn ends_sd(noise: &[NoiseEstimate]) -> f64 {
    noise.iter().find(|n| n.name.starts_with(ENDS)).map_or(ANGLE_SD, |n| n.sd)
}

fn ends(sd: NoiseMode) -> Vec<Varying> {
    vec![Varying { parameter: ENDS.to_owned(), sd }]
}

/// Im `k_LS` of `ends.calibrated`. Its real part scatters too, by some 1e-4, which moves the growth rate alone: that is in the misfit of
/// the growth rate.
const ENDS: &str = "k_i";
