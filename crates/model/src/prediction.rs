//! Predictions of a trained model with their uncertainty, at any operating point.

use crate::law_error::LawError;
use crate::numbers::parts;
use crate::systematic::changes;
use crate::{Assembly, Conditions, Knowledge, Misfit, ModelError, PointModel, Workspace};
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
        let (values, covariance) = self.of(assembly)?;
        let model = PointModel::new(assembly, conditions, microphones)?;
        let model = match near {
            Some(guess) => model.starting_from(guess),
            None => model,
        };
        let response = model.respond(&values, Order::First, &mut Workspace::default())?;
        let complex: Vec<_> = model.numbers(&response).collect();
        let jacobian = Matrix::from_fn(2 * complex.len(), values.len(), |row, i| {
            let z = complex[row / 2].gradient()[i];
            if row.is_multiple_of(2) { z.re } else { z.im }
        });
        let s = response.s.value();
        let size = jacobian.rows();
        let mut base = Matrix::zeros(size, size);
        for (_, change) in changes(assembly, conditions, s, microphones, &values)? {
            base.add_outer(&change);
        }
        let mut heat_release = Matrix::zeros(size, size);
        if let Some(law) = LawError::of(assembly)? {
            for slope in law.slopes_at(conditions, s, microphones, &values)? {
                heat_release.add_outer(&slope);
            }
        }
        Ok(PointPrediction {
            values: parts(complex.iter().map(|z| z.value())),
            parameters: jacobian.product(&covariance).product(&jacobian.transpose()),
            base,
            heat_release,
        })
    }

    /// Mean and covariance of the free parameters of `assembly`, in its order.
    ///
    /// # Errors
    /// [`ModelError::UnknownParameter`] for a free parameter of which nothing is known.
    pub fn of(&self, assembly: &Assembly) -> Result<(Vec<f64>, Matrix), ModelError> {
        let place = |name: &str| {
            self.names.iter().position(|n| n == name).ok_or_else(|| ModelError::UnknownParameter {
                name: name.to_owned(),
                known: self.names.join(", "),
            })
        };
        let keep: Vec<usize> =
            assembly.parameters().iter().map(|p| place(&p.name)).collect::<Result<_, _>>()?;
        Ok((keep.iter().map(|&k| self.mean[k]).collect(), self.covariance.select(&keep)))
    }
}
