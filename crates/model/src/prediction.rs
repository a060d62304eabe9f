//! Predictions of a trained model with their uncertainty, at any operating point.

use crate::common::Common;
use crate::law_error::LawError;
use crate::numbers::parts;
use crate::systematic::changes;
use crate::{Assembly, Conditions, Knowledge, Misfit, ModelError, PointModel, Trained, Workspace};
use rijke_numerics::{C64, Matrix, Order};

/// What a trained model predicts at one operating point.
#[derive(Clone, Debug, PartialEq)]
pub struct PointPrediction {
    /// Growth rate, angular frequency, then the relative pressures: the order of `rijke_rig::Ping::vector`.
    pub values: Vec<f64>,
    /// Covariance that the parameters cause, to first order; with it that of the errors of the base state of which the training knows.
    pub parameters: Matrix,
    /// Covariance that the other errors of the base state cause.
    pub base: Matrix,
    /// Covariance that an error of the law of the heat release causes of which the training knows nothing, per unit variance of its
    /// relative error ([`Misfit::heat_release`]).
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
        predict(self, None, assembly, conditions, microphones, near)
    }

    /// Mean and covariance of the free parameters of `assembly`, in its order.
    ///
    /// # Errors
    /// [`ModelError::UnknownParameter`] for a free parameter of which nothing is known.
    pub fn of(&self, assembly: &Assembly) -> Result<(Vec<f64>, Matrix), ModelError> {
        let keep = self.places(assembly)?;
        Ok((keep.iter().map(|&k| self.mean[k]).collect(), self.covariance.select(&keep)))
    }

    /// Where the free parameters of `assembly` stand, in its order.
    fn places(&self, assembly: &Assembly) -> Result<Vec<usize>, ModelError> {
        let place = |name: &str| {
            self.names.iter().position(|n| n == name).ok_or_else(|| ModelError::UnknownParameter {
                name: name.to_owned(),
                known: self.names.join(", "),
            })
        };
        assembly.parameters().iter().map(|p| place(&p.name)).collect()
    }
}

impl Trained {
    /// As [`Knowledge::predict`], at a new setting of the rig whose base state comes of the same inference of the flow as those that were
    /// trained on: what the training found of the errors of that inference is made use of.
    ///
    /// # Errors
    /// As [`Knowledge::predict`].
    pub fn predict(
        &self,
        assembly: &Assembly,
        conditions: &Conditions,
        microphones: &[usize],
        near: Option<C64>,
    ) -> Result<PointPrediction, ModelError> {
        let known = self.knowledge().at_a_new_setting(&self.noise);
        let law = Misfit::of(&self.noise).heat_release;
        let common = self.common.as_ref().map(|common| (common, law));
        predict(&known, common, assembly, conditions, microphones, near)
    }
}

/// `common`: the errors that a training knows of, and the standard deviation of the error of the law among them.
fn predict(
    known: &Knowledge,
    common: Option<(&Common, f64)>,
    assembly: &Assembly,
    conditions: &Conditions,
    microphones: &[usize],
    near: Option<C64>,
) -> Result<PointPrediction, ModelError> {
    let places = known.places(assembly)?;
    let values: Vec<f64> = places.iter().map(|&k| known.mean[k]).collect();
    let model = PointModel::new(assembly, conditions, microphones)?;
    let model = match near {
        Some(guess) => model.starting_from(guess),
        None => model,
    };
    let response = model.respond(&values, Order::First, &mut Workspace::default())?;
    let complex: Vec<_> = model.numbers(&response).collect();
    let mut values_here = parts(complex.iter().map(|z| z.value()));
    let size = values_here.len();
    let s = response.s.value();
    let mut changes = changes(assembly, conditions, s, microphones, &values)?;
    let mut heat_release = Matrix::zeros(size, size);
    if let Some(law) = LawError::of(assembly, 1.0)? {
        for (cause, slope) in law.changes_at(conditions, s, microphones, &values)? {
            match common.filter(|(common, _)| common.has(&cause)) {
                Some((_, sd)) => changes.push((cause, slope.iter().map(|d| d * sd).collect())),
                None => heat_release.add_outer(&slope),
            }
        }
    }
    let (along, left) = match common {
        Some((common, _)) => common.along(known, &changes, size),
        None => (Vec::new(), changes.into_iter().map(|(_, change)| change).collect()),
    };
    let mut base = Matrix::zeros(size, size);
    left.iter().for_each(|change| base.add_outer(change));
    for (place, slope) in &along {
        values_here.iter_mut().zip(slope).for_each(|(v, d)| *v += known.mean[*place] * d);
    }
    let all: Vec<usize> = places.iter().copied().chain(along.iter().map(|(place, _)| *place)).collect();
    let jacobian = Matrix::from_fn(size, all.len(), |row, i| match i.checked_sub(places.len()) {
        Some(k) => along[k].1[row],
        None => {
            let z = complex[row / 2].gradient()[i];
            if row.is_multiple_of(2) { z.re } else { z.im }
        }
    });
    let parameters = jacobian.product(&known.covariance.select(&all)).product(&jacobian.transpose());
    Ok(PointPrediction { values: values_here, parameters, base, heat_release })
}
