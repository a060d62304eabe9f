//! The ambient temperature from a noisy thermometer.

use super::Record;

/// Smoothed ambient temperature at every sample, K, and the variance of its error, K^2.
///
/// A random walk (drift) under white noise: Kalman filter forward, Rauch-Tung-Striebel smoother backward. The constant
/// error of the thermometer is one of the unknowns and not part of this.
#[must_use]
pub fn smooth_ambient(record: &Record) -> (Vec<f64>, Vec<f64>) {
    let noise = record.ambient_sd.powi(2).max(1e-12);
    let walk = record.ambient_drift.powi(2) * record.interval;
    let (mut mean, mut variance) = (Vec::new(), Vec::new());
    let (mut m, mut v) = (record.samples.first().map_or(0.0, |s| s.ambient), f64::INFINITY);
    for sample in &record.samples {
        let gain = if v.is_infinite() { 1.0 } else { (v + walk) / (v + walk + noise) };
        m += gain * (sample.ambient - m);
        v = gain * noise;
        mean.push(m);
        variance.push(v);
    }
    for i in (0..mean.len().saturating_sub(1)).rev() {
        let back = variance[i] / (variance[i] + walk);
        mean[i] += back * (mean[i + 1] - mean[i]);
        variance[i] += back * back * (variance[i + 1] - variance[i] - walk);
    }
    (mean, variance)
}
