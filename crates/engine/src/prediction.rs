//! Predictions of a trained model with their uncertainty, at any operating point.

use crate::errors::{Changes, Common, LawErrors, changes, changes_by_factors};
use crate::noise::{LawError, Misfit};
use crate::point::parts;
use crate::{Assembly, Conditions, EngineError, NamedGaussian, PointModel, Trained};
use rijke_inference::NoiseEstimate;
use rijke_network::Workspace;
use rijke_numerics::{C64, Matrix, Order};
use rijke_study::{Cause, PointState};

/// What a trained model predicts at one operating point.
#[derive(Clone, Debug, PartialEq)]
pub struct PointPrediction {
    /// Growth rate, angular frequency, then the relative pressures, real and imaginary parts in turn.
    pub values: Vec<f64>,
    /// Covariance that the parameters cause, to first order; with it that of the errors of the base state of
    /// which the training knows.
    pub parameters: Matrix,
    /// Covariance that the other errors of the base state and of factors cause.
    pub base: Matrix,
    /// Covariance that an error of a law causes of which the training knows nothing.
    pub law: Matrix,
}

impl PointPrediction {
    /// Standard deviation of number `k` for a new measurement in a new installation. The default misfit is
    /// none: what is left is the uncertainty of the model.
    #[must_use]
    pub fn sd(&self, k: usize, misfit: &Misfit) -> f64 {
        let known = self.parameters[(k, k)] + self.base[(k, k)] + self.law[(k, k)];
        (known + misfit.measured[k.min(2)].powi(2)).sqrt()
    }
}

/// A prediction to first order in everything that it is uncertain by.
pub(crate) struct Linear {
    /// Growth rate, angular frequency, then the relative pressures, real and imaginary parts in turn.
    pub(crate) values: Vec<f64>,
    /// Places in what is known, of parameters and of errors that the training found, and the derivative in
    /// each.
    pub(crate) along: Vec<(usize, Vec<f64>)>,
    /// The change per standard deviation of every other error of the base state and of factors.
    pub(crate) base: Changes,
    /// Likewise of an error of a law of which the training knows nothing.
    pub(crate) law: Changes,
}

/// What training found, as far as predictions need it.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainedPosterior {
    /// The parameters: those of the model, then errors that points share.
    pub gaussian: NamedGaussian,
    /// What the errors of the base states among them are.
    pub(crate) common: Option<Common>,
    /// The misfit.
    pub noise: Vec<NoiseEstimate>,
}

impl Trained {
    /// The model's own parameters at the maximum.
    pub(crate) fn best(&self) -> &[f64] {
        &self.values[..self.own]
    }

    /// What predictions need.
    #[must_use]
    pub fn posterior(&self) -> TrainedPosterior {
        let (gaussian, common) = (self.of_predictions(), self.common.clone());
        TrainedPosterior { gaussian, common, noise: self.noise.clone() }
    }
}

impl TrainedPosterior {
    /// Predicts the numbers of `microphones` at `conditions`, in a new installation of the rig. Where the
    /// base state comes of the same inference as those that were trained on, what the training found of the
    /// errors of that inference is made use of. `near` is where the root is searched, if not near the first
    /// mode.
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
        let known = self.gaussian.in_a_new_installation(&self.noise);
        self.predict_from(&known, assembly, conditions, microphones, near, law)
    }

    /// The most probable error of a cause in its standard deviations, and the standard deviation of it; none
    /// if the training did not infer it.
    pub(crate) fn error_of(&self, cause: &Cause) -> Option<[f64; 2]> {
        self.common.as_ref()?.error(cause, &self.gaussian)
    }

    /// A base state with the errors that points share at their most probable values.
    pub(crate) fn as_inferred(&self, base: &PointState) -> PointState {
        let Some(common) = &self.common else { return base.clone() };
        let mean = |cause| common.error(cause, &self.gaussian).map_or(0.0, |[mean, _]| mean);
        let sds: Vec<f64> = base.errors.iter().map(|e| mean(&e.cause)).collect();
        base.displaced(&sds)
    }

    /// As [`TrainedPosterior::predict`], from what is `known` of the parameters.
    pub(crate) fn predict_from(
        &self,
        known: &NamedGaussian,
        assembly: &Assembly,
        conditions: &Conditions,
        microphones: &[usize],
        near: Option<C64>,
        law: Option<&LawError>,
    ) -> Result<PointPrediction, EngineError> {
        let linear = self.linear(known, assembly, conditions, microphones, near, law)?;
        let size = linear.values.len();
        let jacobian = Matrix::from_fn(size, linear.along.len(), |row, i| linear.along[i].1[row]);
        let places: Vec<usize> = linear.along.iter().map(|(place, _)| *place).collect();
        let parameters = jacobian.product(&known.covariance.select(&places)).product(&jacobian.transpose());
        let covariance = |changes: &Changes| {
            let mut sum = Matrix::zeros(size, size);
            changes.iter().for_each(|(_, change)| sum.add_outer(change));
            sum
        };
        let (base, law) = (covariance(&linear.base), covariance(&linear.law));
        Ok(PointPrediction { values: linear.values, parameters, base, law })
    }

    /// A prediction and its derivatives in everything that it is uncertain by.
    pub(crate) fn linear(
        &self,
        known: &NamedGaussian,
        assembly: &Assembly,
        conditions: &Conditions,
        microphones: &[usize],
        near: Option<C64>,
        law: Option<&LawError>,
    ) -> Result<Linear, EngineError> {
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
        let at: Vec<f64> = places.iter().map(|&k| known.mean[k]).collect();
        let model = PointModel::new(assembly, conditions, microphones)?;
        let model = match near {
            Some(guess) => model.starting_from(guess),
            None => model,
        };
        let response = model.respond(&at, Order::First, &mut Workspace::default())?;
        let mut values = parts(model.numbers(&response).map(|z| z.value()));
        let size = values.len();
        let s = response.s.value();
        let mut changes = changes(assembly, conditions, s, microphones, &at, Some(&values))?;
        changes.extend(changes_by_factors(assembly, conditions, s, microphones, &at)?);
        let mut unseen = Changes::new();
        if let Some(error) = law
            && let Some(errors) = LawErrors::of(assembly, error)?
        {
            for (cause, slope) in errors.changes_at(conditions, s, microphones, &at)? {
                let seen = self.common.as_ref().is_some_and(|common| common.has(&cause));
                if seen { &mut changes } else { &mut unseen }.push((cause, slope));
            }
        }
        let (shared, base) = match &self.common {
            Some(common) => common.along(known, &changes, size),
            None => (Vec::new(), changes),
        };
        for (place, slope) in &shared {
            values.iter_mut().zip(slope).for_each(|(v, d)| *v += known.mean[*place] * d);
        }
        let own = places.iter().enumerate().map(|(i, place)| (*place, model.slope(&response, i)));
        Ok(Linear { values, along: own.chain(shared).collect(), base, law: unseen })
    }
}
