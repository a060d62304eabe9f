//! Predictions of a trained model with their uncertainty, at any operating point.

use crate::errors::{Common, LawErrors, changes};
use crate::noise::{LawError, Misfit};
use crate::point::parts;
use crate::{Assembly, Conditions, EngineError, Knowledge, PointModel, Trained};
use rijke_inference::NoiseEstimate;
use rijke_network::Workspace;
use rijke_numerics::{C64, Matrix, Order};

/// What a trained model predicts at one operating point.
#[derive(Clone, Debug, PartialEq)]
pub struct PointPrediction {
    /// Growth rate, angular frequency, then the relative pressures, real and imaginary parts in turn.
    pub values: Vec<f64>,
    /// Covariance that the parameters cause, to first order; with it that of the errors of the base state of which the training knows.
    pub parameters: Matrix,
    /// Covariance that the other errors of the base state cause.
    pub base: Matrix,
    /// Covariance that an error of a law causes of which the training knows nothing.
    pub law: Matrix,
}

impl PointPrediction {
    /// Standard deviation of number `k` for a new measurement in a new installation. The default misfit is none: what is left is
    /// the uncertainty of the model.
    #[must_use]
    pub fn sd(&self, k: usize, misfit: &Misfit) -> f64 {
        let known = self.parameters[(k, k)] + self.base[(k, k)] + self.law[(k, k)];
        (known + misfit.measured[k.min(2)].powi(2)).sqrt()
    }
}

/// What training found, as far as predictions need it.
#[derive(Clone, Debug, PartialEq)]
pub struct Posterior {
    /// The parameters: those of the model, then errors that all installations share.
    pub knowledge: Knowledge,
    /// What the errors of the base states among them are.
    pub(crate) common: Option<Common>,
    /// The misfit.
    pub noise: Vec<NoiseEstimate>,
}

impl Trained {
    /// What predictions need.
    #[must_use]
    pub fn posterior(&self) -> Posterior {
        Posterior { knowledge: self.knowledge(), common: self.common.clone(), noise: self.noise.clone() }
    }
}

impl Posterior {
    /// Predicts the numbers of `microphones` at `conditions`, in a new installation of the rig. Where the base state comes of the same
    /// inference as those that were trained on, what the training found of the errors of that inference is made use of. `near` is where
    /// the root is searched, if not near the first mode.
    ///
    /// # Errors
    /// Those of the model.
    pub fn predict(
        &self,
        assembly: &Assembly,
        conditions: &Conditions,
        microphones: &[usize],
        near: Option<C64>,
        law: Option<&LawError>,
    ) -> Result<PointPrediction, EngineError> {
        let known = self.knowledge.in_a_new_installation(&self.noise);
        self.predict_from(&known, assembly, conditions, microphones, near, law)
    }

    /// As [`Posterior::predict`], from what is `known` of the parameters.
    pub(crate) fn predict_from(
        &self,
        known: &Knowledge,
        assembly: &Assembly,
        conditions: &Conditions,
        microphones: &[usize],
        near: Option<C64>,
        law: Option<&LawError>,
    ) -> Result<PointPrediction, EngineError> {
        let place = |name: &str| known.names.iter().position(|n| n == name);
        let places: Vec<usize> = assembly
            .parameters()
            .iter()
            .map(|p| {
                place(&p.name).ok_or_else(|| EngineError::UnknownParameter {
                    name: p.name.clone(),
                    known: known.names.join(", "),
                })
            })
            .collect::<Result<_, _>>()?;
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
        let mut of_the_law = Matrix::zeros(size, size);
        if let Some(error) = law
            && let Some(errors) = LawErrors::of(assembly, error)?
        {
            for (cause, slope) in errors.changes_at(conditions, s, microphones, &values)? {
                match self.common.as_ref().filter(|common| common.has(&cause)) {
                    Some(_) => changes.push((cause, slope)),
                    None => of_the_law.add_outer(&slope),
                }
            }
        }
        let (along, left) = match &self.common {
            Some(common) => common.along(known, &changes, size),
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
        Ok(PointPrediction { values: values_here, parameters, base, law: of_the_law })
    }
}
