//! Observations as the data of an inference.

use crate::{BaseErrors, Conditions, ModelError};
use rijke_inference::{Data, NoiseGroup, NoiseMode, Observation, relative_noise};
use rijke_numerics::{C64, Matrix};
use rijke_rig::Ping;

/// A measured ping and the conditions under which it was measured.
#[derive(Clone, Debug)]
pub struct Observed {
    /// The operating point and the state of its gas.
    pub conditions: Conditions,
    /// What was measured.
    pub ping: Ping,
}

/// What is assumed of the difference between model and measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation of the growth rate, 1/s.
    pub growth_rate: NoiseMode,
    /// Standard deviation of the angular frequency, rad/s.
    pub angular_frequency: NoiseMode,
    /// Standard deviation of each part of a microphone's pressure, relative to the reference microphone's pressure.
    pub pressure: NoiseMode,
    /// Whether the measured covariance is added to these. Not where they float: noise that is below the measured one
    /// would then have no best value.
    pub measured: bool,
}

impl Noise {
    /// All three are chosen by the data, as in sections 6.2 to 6.5 of the paper: measurement and model error together.
    pub const FLOATED: Self = Self {
        growth_rate: NoiseMode::Floated,
        angular_frequency: NoiseMode::Floated,
        pressure: NoiseMode::Floated,
        measured: false,
    };

    /// The measured covariance and nothing else: for a model that is exact.
    pub const MEASURED: Self = Self {
        growth_rate: NoiseMode::Fixed { sd: 0.0 },
        angular_frequency: NoiseMode::Fixed { sd: 0.0 },
        pressure: NoiseMode::Fixed { sd: 0.0 },
        measured: true,
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

/// One block per ping, with up to three groups of noise and, if asked for, the measured covariance.
///
/// # Errors
/// [`ModelError::Inference`] for numbers that are not finite or covariances that are not positive definite.
pub fn data_of(observed: &[Observed], microphones: &[usize], noise: &Noise) -> Result<Data, ModelError> {
    let block = |observed: &Observed| {
        let (values, covariance) = selected(&observed.ping, microphones);
        let size = values.len();
        let block = Observation::new(observed.conditions.point.id.clone(), values)
            .with_independent_noise(0, &[0])
            .with_independent_noise(1, &[1]);
        let block = if noise.measured { block.with_floor(covariance) } else { block };
        if size == 2 {
            return block;
        }
        let shared = relative_noise(&others(&observed.ping, microphones));
        let padded =
            Matrix::from_fn(size, size, |i, j| if i > 1 && j > 1 { shared[(i - 2, j - 2)] } else { 0.0 });
        block.with_noise(2, padded)
    };
    Ok(Data::new(observed.iter().map(block).collect(), groups(microphones, noise))?)
}

/// As [`data_of`], with the errors of the base states as a covariance that does not float; and for each number of the data
/// its place in the prediction.
///
/// Growth rates and frequencies of all points that share a cause of error are one block, so that what moves them together
/// is known to. The pressures of each point are a block of their own: what the errors do to pressures and eigenvalue
/// together is left out, because blocks of a hundred numbers would make the inference a hundred times slower.
///
/// # Errors
/// As [`data_of`].
pub fn data_with_base_errors(
    observed: &[Observed],
    microphones: &[usize],
    noise: &Noise,
    errors: &BaseErrors,
) -> Result<(Data, Vec<usize>), ModelError> {
    let measured: Vec<(Vec<f64>, Matrix)> = observed.iter().map(|o| selected(&o.ping, microphones)).collect();
    let size = 2 * microphones.len();
    let (mut blocks, mut order) = (Vec::new(), Vec::new());
    for group in errors.together() {
        let values = group.iter().flat_map(|&p| measured[p].0[..2].iter().copied()).collect();
        let own = Matrix::from_fn(2 * group.len(), 2 * group.len(), |i, j| {
            if i / 2 == j / 2 { measured[group[i / 2]].1[(i % 2, j % 2)] } else { 0.0 }
        });
        let names: Vec<&str> = group.iter().map(|&p| observed[p].conditions.point.id.as_str()).collect();
        let even: Vec<usize> = (0..group.len()).map(|k| 2 * k).collect();
        let odd: Vec<usize> = (0..group.len()).map(|k| 2 * k + 1).collect();
        let floor = errors.covariance(&group, &[0, 1]).plus(if noise.measured { 1.0 } else { 0.0 }, &own);
        blocks.push(
            Observation::new(names.join(" "), values)
                .with_floor(floor)
                .with_independent_noise(0, &even)
                .with_independent_noise(1, &odd),
        );
        order.extend(group.iter().flat_map(|&p| [p * size, p * size + 1]));
    }
    let rows: Vec<usize> = (2..size).collect();
    for (p, observed) in observed.iter().enumerate().filter(|_| size > 2) {
        let floor = errors.covariance(&[p], &rows);
        let own = measured[p].1.select(&rows);
        blocks.push(
            Observation::new(observed.conditions.point.id.clone(), measured[p].0[2..].to_vec())
                .with_floor(floor.plus(if noise.measured { 1.0 } else { 0.0 }, &own))
                .with_noise(2, relative_noise(&others(&observed.ping, microphones))),
        );
        order.extend(rows.iter().map(|r| p * size + r));
    }
    Ok((Data::new(blocks, groups(microphones, noise))?, order))
}

/// The relative pressures of `microphones` but the reference.
fn others(ping: &Ping, microphones: &[usize]) -> Vec<C64> {
    microphones.iter().filter(|m| **m != ping.reference).map(|&m| ping.pressures[m]).collect()
}

fn groups(microphones: &[usize], noise: &Noise) -> Vec<NoiseGroup> {
    let group = |name: &str, unit: &str, mode| NoiseGroup { name: name.into(), unit: unit.into(), mode };
    let mut groups = vec![
        group("growth rate", "1/s", noise.growth_rate),
        group("angular frequency", "rad/s", noise.angular_frequency),
    ];
    if microphones.len() > 1 {
        groups.push(group("relative pressure", "1", noise.pressure));
    }
    groups
}
