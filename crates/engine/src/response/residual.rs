//! What a model leaves of the data, once the head's errors are taken at their most probable values.

use super::head::Rest;
use super::measured::Measured;
use rijke_numerics::C64;

/// What is left of a training.
pub(super) struct Left {
    /// What the head makes of the model's answers, load after load.
    pub(super) heard: Vec<Vec<C64>>,
    /// Root mean square of the residuals, both parts together.
    pub(super) size: f64,
    /// Root mean square of the data.
    pub(super) of_the_data: f64,
    /// Correlation between neighbouring frequencies.
    pub(super) neighbours: f64,
    /// How far that correlation is above the one of noise and misfit, over the standard deviation of
    /// independent residuals.
    pub(super) neighbours_sds: f64,
    /// The size over that which noise, misfit and measured standard deviations have.
    pub(super) ratio: f64,
    /// Standard deviation of that ratio for independent residuals.
    pub(super) ratio_sd: f64,
}

/// What is left of `measured` by what the head hears; `rest` is the covariance of what is not the head's.
pub(super) fn left(measured: &[Measured], heard: Vec<Vec<C64>>, rest: Rest<'_>) -> Left {
    let residuals: Vec<Vec<C64>> = measured
        .iter()
        .zip(&heard)
        .map(|(m, h)| m.values.iter().zip(h).map(|(m, h)| m - h).collect())
        .collect();
    let square: f64 = residuals.iter().flatten().map(|z| z.norm_sqr()).sum();
    let pairs: f64 = residuals.iter().flat_map(|r| r.windows(2)).map(|w| (w[1] * w[0].conj()).re).sum();
    let data: f64 = measured.iter().flat_map(|m| &m.values).map(|z| z.norm_sqr()).sum();
    let count: usize = measured.iter().map(|m| m.values.len()).sum();
    let (mut expected, mut shared) = (0.0, 0.0);
    for m in measured {
        let n = m.values.len();
        expected += 2.0 * (0..n).map(|i| rest.covariance_of(m, i, i)).sum::<f64>();
        shared += 2.0 * (1..n).map(|i| rest.covariance_of(m, i - 1, i)).sum::<f64>();
    }
    let neighbours = pairs / square.max(f64::MIN_POSITIVE);
    let known = shared / expected.max(f64::MIN_POSITIVE);
    Left {
        heard,
        size: (square / count.max(1) as f64).sqrt(),
        of_the_data: (data / count.max(1) as f64).sqrt().max(f64::MIN_POSITIVE),
        neighbours,
        neighbours_sds: (neighbours - known) * (2.0 * count as f64).sqrt(),
        ratio: (square / expected.max(f64::MIN_POSITIVE)).sqrt(),
        ratio_sd: 1.0 / (4.0 * count.max(1) as f64).sqrt(),
    }
}
