//! Predictions of a trained model with their uncertainty, at any operating point.

use crate::law_error::slopes_at;
use crate::{
    Assembly, Conditions, Knowledge, Misfit, ModelError, PointModel, Workspace, systematic::changes,
};
use rijke_network::Response;
use rijke_numerics::{C64, Matrix, Order};

/// What a trained model predicts at one operating point.
#[derive(Clone, Debug, PartialEq)]
pub struct PointPrediction {
    /// Growth rate, angular frequency, then the relative pressures: the order of `rijke_rig::Ping::vector`.
    pub values: Vec<f64>,
    /// Covariance that the parameters cause, to first order.
    pub parameters: Matrix,
    /// Covariance that the errors of the base state cause.
    pub base: Matrix,
    /// Covariance that an error of the law of the heat release causes, per unit variance of its relative error
    /// ([`Misfit::heat_release`]).
    pub heat_release: Matrix,
}

impl PointPrediction {
    /// Standard deviation of number `k` for a new measurement in a new setting. The default misfit is none: what is left is
    /// the uncertainty of the model.
    #[must_use]
    pub fn sd(&self, k: usize, misfit: &Misfit) -> f64 {
        let known = self.parameters[(k, k)] + self.base[(k, k)];
        let law = self.heat_release[(k, k)] * misfit.heat_release.powi(2);
        (known + law + misfit.measured[k.min(2)].powi(2)).sqrt()
    }
}

impl Knowledge {
    /// Predicts the numbers of `microphones` at `conditions` with the model `assembly`, whose free parameters are known as
    /// `self` says. `near` is where the root is searched, if not near that of an open tube.
    ///
    /// # Errors
    /// [`ModelError::UnknownParameter`] for a free parameter of which nothing is known; those of the model.
    pub fn predict(
        &self,
        assembly: &Assembly,
        conditions: &Conditions,
        microphones: &[usize],
        near: Option<C64>,
    ) -> Result<PointPrediction, ModelError> {
        let place = |name: &str| {
            self.names.iter().position(|n| n == name).ok_or_else(|| ModelError::UnknownParameter {
                name: name.to_owned(),
                known: self.names.join(", "),
            })
        };
        let keep: Vec<usize> =
            assembly.parameters().iter().map(|p| place(&p.name)).collect::<Result<_, _>>()?;
        let values: Vec<f64> = keep.iter().map(|&k| self.mean[k]).collect();
        let model = PointModel::new(assembly, conditions, microphones)?;
        let model = match near {
            Some(guess) => model.starting_from(guess),
            None => model,
        };
        let Response { s, pressures, .. } =
            model.respond(&values, Order::First, &mut Workspace::default())?;
        let reference = assembly.rig.microphones.reference;
        let others = microphones.iter().zip(&pressures).filter(|(m, _)| **m != reference);
        let complex: Vec<_> = std::iter::once(&s).chain(others.map(|(_, p)| p)).collect();
        let part = |row: usize, z: C64| if row.is_multiple_of(2) { z.re } else { z.im };
        let jacobian = Matrix::from_fn(2 * complex.len(), values.len(), |row, i| {
            part(row, complex[row / 2].gradient()[i])
        });
        let size = jacobian.rows();
        let causes = changes(assembly, conditions, s.value(), microphones, &values)?;
        let laws = slopes_at(assembly, conditions, s.value(), microphones, &values)?;
        let base = causes.iter().fold(Matrix::zeros(size, size), |sum, (_, j)| {
            sum.plus(1.0, &Matrix::from_fn(size, size, |r, c| j[r] * j[c]))
        });
        Ok(PointPrediction {
            values: (0..size).map(|row| part(row, complex[row / 2].value())).collect(),
            parameters: jacobian.product(&self.covariance.select(&keep)).product(&jacobian.transpose()),
            base,
            heat_release: laws.iter().flatten().fold(Matrix::zeros(size, size), |sum, j| {
                sum.plus(1.0, &Matrix::from_fn(size, size, |r, c| j[r] * j[c]))
            }),
        })
    }
}
