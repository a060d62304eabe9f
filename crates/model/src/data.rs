//! Observations as the data of an inference.

use crate::noise::Groups;
use crate::varying::Scatter;
use crate::{BaseErrors, Conditions, ModelError, Noise};
use rijke_inference::{Data, Observation, relative_noise};
use rijke_numerics::{C64, Matrix};
use rijke_rig::{OperatingPoint, Ping, Rig};

/// A measured ping and the conditions under which it was measured.
#[derive(Clone, Debug)]
pub struct Observed {
    /// The operating point and the state of its gas.
    pub conditions: Conditions,
    /// What was measured.
    pub ping: Ping,
}

/// The numbers that the microphones `chosen` (reference included) measured, with their covariance.
#[must_use]
pub fn selected(ping: &Ping, chosen: &[usize]) -> (Vec<f64>, Matrix) {
    let pressures = places(ping, chosen).into_iter().flat_map(|k| [2 + 2 * k, 3 + 2 * k]);
    let keep: Vec<usize> = [0, 1].into_iter().chain(pressures).collect();
    let all = ping.vector();
    (keep.iter().map(|&k| all[k]).collect(), ping.covariance.select(&keep))
}

/// For each of the microphones `chosen` but the reference its place among all but the reference.
pub(crate) fn places(ping: &Ping, chosen: &[usize]) -> Vec<usize> {
    let others: Vec<usize> = (0..ping.pressures.len()).filter(|m| *m != ping.reference).collect();
    chosen.iter().filter_map(|m| others.iter().position(|o| o == m)).collect()
}

/// One block per ping, with up to three groups of noise and, if asked for, the measured covariance.
///
/// # Errors
/// [`ModelError::Inference`] for numbers that are not finite or covariances that are not positive definite.
pub fn data_of(observed: &[Observed], microphones: &[usize], noise: &Noise) -> Result<Data, ModelError> {
    data_apart_from(observed, microphones, noise, &vec![None; observed.len()], &[])
}

/// As [`data_of`], with the noise of the near field where a structure is given, and that of parameters that vary between settings;
/// every point is a setting of its own.
pub(crate) fn data_apart_from(
    observed: &[Observed],
    microphones: &[usize],
    noise: &Noise,
    doubtful: &[Option<Matrix>],
    scatter: &[Scatter],
) -> Result<Data, ModelError> {
    let groups = Groups::new(microphones, noise).near_field(doubtful).varying(scatter);
    let block = |(p, (observed, doubtful)): (usize, (&Observed, &Option<Matrix>))| {
        let (values, covariance) = selected(&observed.ping, microphones);
        let size = values.len();
        let padded = |m: &Matrix| {
            Matrix::from_fn(size, size, |i, j| if i > 1 && j > 1 { m[(i - 2, j - 2)] } else { 0.0 })
        };
        let block = Observation::new(observed.conditions.point.id.clone(), values)
            .with_independent_noise(0, &[0])
            .with_independent_noise(1, &[1]);
        let block = if noise.measured { block.with_floor(covariance) } else { block };
        let numbers: Vec<(usize, usize)> = (0..size).map(|row| (p, row)).collect();
        let varying = scatter.iter().map(|s| s.structure(&numbers, |_, _| false));
        let block = with(block, (groups.varying..).zip(varying));
        if size == 2 {
            return block;
        }
        let near = groups.near_field.zip(doubtful.as_ref()).map(|(group, near)| (group, padded(near)));
        let own = (2, padded(&relative_noise(&others(&observed.ping, microphones))));
        with(block, near.into_iter().chain([own]))
    };
    Ok(Data::new(observed.iter().zip(doubtful).enumerate().map(block).collect(), groups.list)?)
}

/// Whether a microphone stands in the near field of the heater: closer to it than the radius of the tube.
#[must_use]
pub fn hears_near_field(rig: &Rig, point: &OperatingPoint, microphone: usize) -> bool {
    let heater = point.position.filter(|_| point.heater);
    heater.is_some_and(|x| (rig.microphones.positions[microphone] - x).abs() < rig.tube.radius())
}

/// Structure of the noise of the relative pressures where microphones stand in the near field of the heater, closer to it
/// than the radius of the tube; nothing where none does.
///
/// There the pressure is that of the flow through and round the plates, and no plane wave's. Such a microphone gets a standard
/// deviation of a tenth, which is as good as leaving it out; the reference microphone's is one that all others share. It is no
/// part of the floor, from which the inference judges whether a floating noise is needed at all.
pub(crate) fn near_field(rig: &Rig, observed: &Observed, microphones: &[usize]) -> Option<Matrix> {
    let point = &observed.conditions.point;
    let near = |m: usize| hears_near_field(rig, point, m);
    let ping = &observed.ping;
    let kept: Vec<usize> = microphones.iter().copied().filter(|m| *m != ping.reference).collect();
    if !microphones.iter().any(|&m| near(m)) {
        return None;
    }
    let size = 2 * kept.len();
    let shared = relative_noise(&others(ping, microphones));
    let common = if near(ping.reference) { 1.0 } else { 0.0 };
    Some(Matrix::from_fn(size, size, |i, j| {
        let diagonal = f64::from(u8::from(i == j));
        // `relative_noise` is the identity, each microphone's own noise, and the reference's, which they share.
        common * (shared[(i, j)] - diagonal) + if near(kept[i / 2]) { diagonal } else { 0.0 }
    }))
}

/// As [`data_of`], with the errors of the base states as a covariance that does not float, parameters that vary between settings, and
/// what points of one setting share; and for each number of the data its place in the prediction.
///
/// Growth rates and frequencies of all points that share a cause of error are one block, so that what moves them together
/// is known to. The pressures of each point are a block of their own: the errors and the scatter of the ends do to
/// pressures and eigenvalue together is left out, because larger blocks would make the inference many times slower.
///
/// # Errors
/// As [`data_of`].
pub(crate) fn data_with_base_errors(
    observed: &[Observed],
    microphones: &[usize],
    noise: &Noise,
    errors: &BaseErrors,
    doubtful: &[Option<Matrix>],
    scatter: &[Scatter],
) -> Result<(Data, Vec<usize>), ModelError> {
    let measured: Vec<(Vec<f64>, Matrix)> = observed.iter().map(|o| selected(&o.ping, microphones)).collect();
    let size = 2 * microphones.len();
    let (mut blocks, mut order) = (Vec::new(), Vec::new());
    let same = |a: usize, b: usize| same_setting(&observed[a].conditions, &observed[b].conditions);
    let groups = Groups::new(microphones, noise).near_field(doubtful).shared(noise).varying(scatter);
    let varying = |numbers: &[(usize, usize)]| -> Vec<(usize, Matrix)> {
        (groups.varying..).zip(scatter.iter().map(|s| s.structure(numbers, same))).collect()
    };
    for group in errors.together(same) {
        let values = group.iter().flat_map(|&p| measured[p].0[..2].iter().copied()).collect();
        let own = Matrix::from_fn(2 * group.len(), 2 * group.len(), |i, j| {
            if i / 2 == j / 2 { measured[group[i / 2]].1[(i % 2, j % 2)] } else { 0.0 }
        });
        let names: Vec<&str> = group.iter().map(|&p| observed[p].conditions.point.id.as_str()).collect();
        let even: Vec<usize> = (0..group.len()).map(|k| 2 * k).collect();
        let odd: Vec<usize> = (0..group.len()).map(|k| 2 * k + 1).collect();
        let floor = errors.covariance(&group, &[0, 1]).plus(if noise.measured { 1.0 } else { 0.0 }, &own);
        let shared = |part: usize| {
            Matrix::from_fn(2 * group.len(), 2 * group.len(), |i, j| {
                let (a, b) = (group[i / 2], group[j / 2]);
                f64::from(u8::from(i % 2 == part && j % 2 == part && (a == b || same(a, b))))
            })
        };
        let block = Observation::new(names.join(" "), values)
            .with_floor(floor)
            .with_independent_noise(0, &even)
            .with_independent_noise(1, &odd);
        let settings = groups.setting.into_iter().flatten().zip([shared(0), shared(1)]);
        let numbers: Vec<_> = group.iter().flat_map(|&p| [(p, 0), (p, 1)]).collect();
        blocks.push(with(block, settings.chain(varying(&numbers))));
        order.extend(group.iter().flat_map(|&p| [p * size, p * size + 1]));
    }
    let rows: Vec<usize> = (2..size).collect();
    for (p, observed) in observed.iter().enumerate().filter(|_| size > 2) {
        let floor = errors.covariance(&[p], &rows);
        let own = measured[p].1.select(&rows);
        let block = Observation::new(observed.conditions.point.id.clone(), measured[p].0[2..].to_vec())
            .with_floor(floor.plus(if noise.measured { 1.0 } else { 0.0 }, &own))
            .with_noise(2, relative_noise(&others(&observed.ping, microphones)));
        let near = groups.near_field.zip(doubtful[p].clone());
        let numbers: Vec<_> = rows.iter().map(|&row| (p, row)).collect();
        blocks.push(with(block, near.into_iter().chain(varying(&numbers))));
        order.extend(rows.iter().map(|r| p * size + r));
    }
    Ok((Data::new(blocks, groups.list)?, order))
}

/// A block with the noises that act on it: the group of each, and its structure.
fn with(block: Observation, noises: impl IntoIterator<Item = (usize, Matrix)>) -> Observation {
    noises.into_iter().fold(block, |block, (group, structure)| block.with_noise(group, structure))
}

/// The relative pressures of `microphones` but the reference.
fn others(ping: &Ping, microphones: &[usize]) -> Vec<C64> {
    microphones.iter().filter(|m| **m != ping.reference).map(|&m| ping.pressures[m]).collect()
}

/// Whether the rig was not touched between two hot points: the heater stood at the same position, at any power.
pub(crate) fn same_setting(a: &Conditions, b: &Conditions) -> bool {
    let hot = |c: &Conditions| c.point.position.filter(|_| c.point.power > 0.0);
    matches!((hot(a), hot(b)), (Some(x), Some(y)) if (x - y).abs() < 1e-9)
}
