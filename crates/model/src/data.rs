//! Observations as the data of an inference.

use crate::{Conditions, ModelError};
use rijke_inference::{Data, NoiseGroup, NoiseMode, Observation, relative_noise};
use rijke_numerics::Matrix;
use rijke_rig::Ping;

/// A measured ping and the conditions under which it was measured.
#[derive(Clone, Debug)]
pub struct Observed {
    /// The operating point and the state of its gas.
    pub conditions: Conditions,
    /// What was measured.
    pub ping: Ping,
}

/// What is assumed of the misfit between model and measurement, besides the measured covariance, which always counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation of the growth rate, 1/s.
    pub growth_rate: NoiseMode,
    /// Standard deviation of the angular frequency, rad/s.
    pub angular_frequency: NoiseMode,
    /// Standard deviation of each part of a microphone's pressure, relative to the reference microphone's pressure.
    pub pressure: NoiseMode,
}

impl Noise {
    /// All three are chosen by the data, as in sections 6.2 to 6.5 of the paper: what remains is model error.
    pub const FLOATED: Self = Self {
        growth_rate: NoiseMode::Floated,
        angular_frequency: NoiseMode::Floated,
        pressure: NoiseMode::Floated,
    };
}

/// The numbers that the microphones `chosen` (reference included) measured, with their covariance.
#[must_use]
pub fn selected(ping: &Ping, chosen: &[usize]) -> (Vec<f64>, Matrix) {
    let others: Vec<usize> = (0..ping.pressures.len()).filter(|m| *m != ping.reference).collect();
    let keep: Vec<usize> = [0, 1]
        .into_iter()
        .chain(
            chosen
                .iter()
                .filter_map(|m| others.iter().position(|o| o == m))
                .flat_map(|k| [2 + 2 * k, 3 + 2 * k]),
        )
        .collect();
    let all = ping.vector();
    (keep.iter().map(|&k| all[k]).collect(), ping.covariance.select(&keep))
}

/// One block per ping, with the measured covariance as a floor and up to three groups of further noise.
///
/// # Errors
/// [`ModelError::Inference`] for numbers that are not finite or covariances that are not positive definite.
pub fn data_of(observed: &[Observed], microphones: &[usize], noise: &Noise) -> Result<Data, ModelError> {
    let group = |name: &str, unit: &str, mode| NoiseGroup { name: name.into(), unit: unit.into(), mode };
    let mut groups = vec![
        group("growth rate", "1/s", noise.growth_rate),
        group("angular frequency", "rad/s", noise.angular_frequency),
    ];
    let others = |ping: &Ping| -> Vec<_> {
        microphones.iter().filter(|m| **m != ping.reference).map(|&m| ping.pressures[m]).collect()
    };
    if microphones.len() > 1 {
        groups.push(group("relative pressure", "1", noise.pressure));
    }
    let block = |observed: &Observed| {
        let (values, covariance) = selected(&observed.ping, microphones);
        let size = values.len();
        let block = Observation::new(observed.conditions.point.id.clone(), values)
            .with_floor(covariance)
            .with_independent_noise(0, &[0])
            .with_independent_noise(1, &[1]);
        if size == 2 {
            return block;
        }
        let shared = relative_noise(&others(&observed.ping));
        let padded =
            Matrix::from_fn(size, size, |i, j| if i > 1 && j > 1 { shared[(i - 2, j - 2)] } else { 0.0 });
        block.with_noise(2, padded)
    };
    Ok(Data::new(observed.iter().map(block).collect(), groups)?)
}
