//! What a model leaves of the data, once the head's errors are taken at their most probable values.

use super::data::Measured;
use rijke_numerics::C64;

/// What is left of a training.
pub(super) struct Left {
    /// What the head makes of the model's answers, load after load.
    pub(super) heard: Vec<Vec<C64>>,
    /// Root mean square of the residuals, both parts together.
    pub(super) size: f64,
    /// Correlation between neighbouring frequencies.
    pub(super) neighbours: f64,
    /// That correlation over its standard deviation for independent residuals.
    pub(super) neighbours_sds: f64,
}

/// What is left of `measured` by what the head hears.
pub(super) fn left(measured: &[Measured], heard: Vec<Vec<C64>>) -> Left {
    let residuals: Vec<Vec<C64>> = measured
        .iter()
        .zip(&heard)
        .map(|(m, h)| m.values.iter().zip(h).map(|(m, h)| m - h).collect())
        .collect();
    let square: f64 = residuals.iter().flatten().map(|z| z.norm_sqr()).sum();
    let pairs: f64 = residuals.iter().flat_map(|r| r.windows(2)).map(|w| (w[1] * w[0].conj()).re).sum();
    let count: usize = measured.iter().map(|m| m.values.len()).sum();
    let neighbours = pairs / square.max(f64::MIN_POSITIVE);
    Left {
        heard,
        size: (square / count.max(1) as f64).sqrt(),
        neighbours,
        neighbours_sds: neighbours * (2.0 * count as f64).sqrt(),
    }
}
