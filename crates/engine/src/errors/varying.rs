//! Parameters that come out a little different each time the rig is put together.

use crate::noise::{BETWEEN, Varying};
use crate::observed::{Observed, Used};
use crate::{Assembly, EngineError, NamedGaussian, PointModel, Training};
use rayon::prelude::*;
use rijke_inference::{NoiseEstimate, NoiseGroup};
use rijke_network::Workspace;
use rijke_numerics::{InOrder, Matrix, Order};

/// A varying parameter as a group of noise, and where that noise points.
pub(crate) struct Scatter {
    pub(crate) group: NoiseGroup,
    /// For each point the derivative of its prediction, s and then pressures.
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
        used: &[Used],
        training: &Training,
        values: &[f64],
    ) -> Result<Vec<Self>, EngineError> {
        let places: Vec<(usize, &Varying)> =
            training.noise.varying.iter().filter_map(|v| Some((place(assembly, v)?, v))).collect();
        let at = |(o, u): (&Observed, &Used)| -> Result<Vec<Vec<f64>>, EngineError> {
            let point = PointModel::new(assembly, &o.conditions, &u.microphones)?.starting_from(o.near);
            let response = point.respond(values, Order::First, &mut Workspace::default())?;
            Ok(places.iter().map(|(k, _)| point.slope(&response, *k)).collect())
        };
        let by_point: Vec<_> = observed.par_iter().zip(used).map(at).in_order::<Result<_, _>>()?;
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

    /// Leaves out the points of whose draws an earlier stage tells: there they are no noise.
    pub(crate) fn leave_out(&mut self, is_told: impl Fn(usize) -> bool) {
        let told = self.slopes.iter_mut().enumerate().filter(|(p, _)| is_told(*p));
        told.for_each(|(_, slopes)| slopes.fill(0.0));
    }

    /// The structure of this noise over numbers, each a point and its row; points of one installation
    /// (`same`) share one draw.
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
    training.noise.varying.iter().any(|v| place(assembly, v).is_some())
}

fn place(assembly: &Assembly, varying: &Varying) -> Option<usize> {
    assembly.parameters().iter().position(|p| p.name == varying.parameter)
}

impl NamedGaussian {
    /// What is known of the parameters at one new installation of the rig: as `self`, with the scatter
    /// between installations that a training found or was given (`noise`).
    #[must_use]
    pub fn in_a_new_installation(&self, noise: &[NoiseEstimate]) -> Self {
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
