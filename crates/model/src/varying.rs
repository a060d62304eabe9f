//! Parameters that come out a little different each time the rig is set.

use crate::noise::BETWEEN;
use crate::{Assembly, Knowledge, ModelError, Observed, PointModel, Training, Workspace};
use rayon::prelude::*;
use rijke_inference::{NoiseEstimate, NoiseGroup, NoiseMode};
use rijke_numerics::{Matrix, Order};

/// A parameter whose value scatters from setting to setting of the rig about the one that is inferred: the ends, say, whose
/// effective place moves with what stands near them.
///
/// Enters to first order, as noise along the slope of the prediction: it moves frequency and mode shape together, so that what the
/// microphones say of it at one setting is not taken for knowledge of its mean over settings.
#[derive(Clone, Debug, PartialEq)]
pub struct Varying {
    /// Name of the parameter; one that a model does not have is ignored.
    pub parameter: String,
    /// Standard deviation between settings, in the parameter's unit.
    pub sd: NoiseMode,
}

/// A varying parameter as a group of noise, and where that noise points.
pub(crate) struct Scatter {
    pub(crate) group: NoiseGroup,
    /// For each point the derivative of its prediction, in the order of `rijke_rig::Ping::vector`.
    pub(crate) slopes: Vec<Vec<f64>>,
}

impl Scatter {
    /// Those that the assembly has free, at the parameter values `values`.
    ///
    /// # Errors
    /// Those of the model.
    pub(crate) fn of(
        assembly: &Assembly,
        observed: &[Observed],
        training: &Training,
        values: &[f64],
    ) -> Result<Vec<Self>, ModelError> {
        let places: Vec<(usize, &Varying)> =
            training.varying.iter().filter_map(|v| Some((place(assembly, v)?, v))).collect();
        let at = |o: &Observed| -> Result<Vec<Vec<f64>>, ModelError> {
            let point =
                PointModel::new(assembly, &o.conditions, &training.microphones)?.starting_from(o.ping.s);
            let response = point.respond(values, Order::First, &mut Workspace::default())?;
            Ok(places.iter().map(|(k, _)| point.slope(&response, *k)).collect())
        };
        let by_point: Vec<_> = observed.par_iter().map(at).collect::<Result<_, _>>()?;
        let scatter = |(index, (k, varying)): (usize, &(usize, &Varying))| Self {
            group: NoiseGroup {
                name: format!("{}{BETWEEN}", varying.parameter),
                unit: assembly.parameters()[*k].unit.clone(),
                mode: varying.sd,
            },
            slopes: by_point.iter().map(|slopes| slopes[index].clone()).collect(),
        };
        Ok(places.iter().enumerate().map(scatter).collect())
    }

    /// The structure of this noise over numbers, each a point and its row; points of one setting (`same`) share one draw.
    pub(crate) fn structure(
        &self,
        numbers: &[(usize, usize)],
        same: impl Fn(usize, usize) -> bool,
    ) -> Matrix {
        Matrix::from_fn(numbers.len(), numbers.len(), |i, j| {
            let ((a, row), (b, column)) = (numbers[i], numbers[j]);
            if a == b || same(a, b) { self.slopes[a][row] * self.slopes[b][column] } else { 0.0 }
        })
    }
}

/// Whether any parameter of the assembly varies.
pub(crate) fn any_varies(assembly: &Assembly, training: &Training) -> bool {
    training.varying.iter().any(|v| place(assembly, v).is_some())
}

fn place(assembly: &Assembly, varying: &Varying) -> Option<usize> {
    assembly.parameters().iter().position(|p| p.name == varying.parameter)
}

impl Knowledge {
    /// What is known of the parameters at one new setting of the rig: as `self`, with the scatter between settings that a training
    /// found or was given (`noise`).
    #[must_use]
    pub fn at_a_new_setting(&self, noise: &[NoiseEstimate]) -> Self {
        let mut new = self.clone();
        for estimate in noise {
            let name = estimate.name.strip_suffix(BETWEEN);
            if let Some(k) = name.and_then(|name| self.names.iter().position(|n| n == name)) {
                new.covariance[(k, k)] += estimate.sd * estimate.sd;
            }
        }
        new
    }
}
