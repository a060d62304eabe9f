//! How far the rig comes back to the same state when it is set anew.

use rijke_inference::{NoiseEstimate, NoiseMode};
use rijke_model::{Noise, Varying};

/// Re and Im `k_LS` of `ends.calibrated`, and their standard deviations between settings. Section 6.1: with eta = 1 and the same R at both
/// ends the two experiments with the empty tube give |R| = 0.9953 and 0.9952 with angles of 3.0597 and 3.0641 rad, and a difference of two is
/// 2^(1/2) standard deviations. Both move the mode shape, so that microphones which hear 3e-5 of it would take either for something else.
const ENDS: [(&str, f64); 2] = [("k_r", 7e-5), ("k_i", 0.0031)];

/// Where one setting is all there is.
pub(crate) fn ends_as_in_the_paper() -> Vec<Varying> {
    ends(|_, sd| NoiseMode::Fixed { sd })
}

/// Where the data, of many settings, say how far they scatter: within a factor of e of what the paper's one pair says.
pub(crate) fn ends_inferred() -> Vec<Varying> {
    ends(|_, sd| NoiseMode::Inferred { median: sd, ln_sd: 1.0 })
}

/// The noise of points whose ends may scatter: it floats, as in the paper, on top of what was measured: a noise that floats down to
/// nothing has no best value, and the ends may explain all of it.
pub(crate) const NOISE: Noise = Noise { measured: true, ..Noise::FLOATED };

/// As an earlier stage found.
pub(crate) fn ends_as_found(sds: [f64; 2]) -> Vec<Varying> {
    ends(|k, _| NoiseMode::Fixed { sd: sds[k] })
}

/// The standard deviations that a training found; the paper's if it had no ends that could vary.
pub(crate) fn ends_sd(noise: &[NoiseEstimate]) -> [f64; 2] {
    ENDS.map(|(name, sd)| noise.iter().find(|n| n.name.starts_with(name)).map_or(sd, |n| n.sd))
}

fn ends(mode: impl Fn(usize, f64) -> NoiseMode) -> Vec<Varying> {
    let varying =
        |(k, (name, sd)): (usize, (&str, f64))| Varying { parameter: name.to_owned(), sd: mode(k, sd) };
    ENDS.into_iter().enumerate().map(varying).collect()
}
