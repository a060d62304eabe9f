//! What calibration clicks leave beyond noise, and what noise and it do to gains and times.

use super::error::CalibrationError;
use crate::click::ClickFit;
use rijke_numerics::{C64, Matrix};

/// Energy that calibration clicks may leave, over their own: a twentieth of the amplitude. Clicks in warm gas
/// may leave more, but gains of the channels come from these.
const MISFIT: f64 = 2.5e-3;
/// Standard deviations of the mean from which clicks leave more than noise.
const SEEN: f64 = 3.0;

/// Mean of the shares of their energy that clicks leave beyond noise; zero where it is not seen.
///
/// # Errors
/// More than is allowed.
pub(super) fn misfit(shares: &[f64]) -> Result<f64, CalibrationError> {
    let count = shares.len() as f64;
    let mean = shares.iter().sum::<f64>() / count;
    if mean > MISFIT {
        return Err(CalibrationError::Misfit { share: mean, limit: MISFIT });
    }
    let squares: f64 = shares.iter().map(|share| (share - mean).powi(2)).sum();
    Ok(if mean > SEEN * (squares / (count * (count - 1.0))).sqrt() { mean } else { 0.0 })
}

/// Relative variance of each gain, and variance of each time, s^2, where clicks leave this share of their
/// energy. A channel leaves the same in all clicks, so that its mean does not average it out. Of the
/// independent numbers of the waveform one looks like another gain, and one like another time: what is left
/// has as much of these as of any other.
pub(super) fn systematic(share: f64, template: &[C64], frequencies: &[f64]) -> [f64; 2] {
    let energy = |power: i32| -> f64 {
        template.iter().zip(frequencies).map(|(w, omega)| w.norm_sqr() * omega.powi(power)).sum()
    };
    let each = share / (2 * template.len()).max(1) as f64;
    [each, each * energy(0) / energy(2)]
}

/// Relative covariance of the gains of one click that are counted from their mean square.
pub(super) fn relative(fit: &ClickFit) -> Matrix {
    let channels = fit.gains.len();
    let power: f64 = fit.gains.iter().map(|g| g * g).sum();
    let share = |m: usize| fit.gains[m].powi(2) / power;
    let less_mean = Matrix::from_fn(channels, channels, |i, j| f64::from(u8::from(i == j)) - share(j));
    let own = Matrix::from_fn(channels, channels, |i, j| {
        fit.gain_covariance[(i, j)] / (fit.gains[i] * fit.gains[j])
    });
    less_mean.product(&own).product(&less_mean.transpose())
}
