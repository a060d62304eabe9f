//! One model trained on responses: the most probable parameters, and the head's errors about what the rig
//! then answers.

use super::data::Blocks;
use super::ground::GroundMaximum;
use super::head::{HeardResponses, Rest};
use super::measured::Measured;
use super::predict::{Responses, Told};
use crate::EngineError;
use rijke_inference::{
    AssessOptions, Energy, Evidence, Fit, ForwardError, InferenceError, Laplace, MapOptions, Objective,
    OtherMaximum, Parameters, Posterior, Stop, further_maxima, minimise,
};
use rijke_numerics::{C64, Cholesky, Jet, Matrix, Order, Streams};
use rijke_study::ErrorTerm;
use rijke_study::plan::SdSpec;
use rijke_study::responses::ResponseStage;

/// Movement of the parameters from fit to fit, in their standard deviations, at which the head's errors have
/// settled.
const SETTLED: f64 = 0.01;
/// Most fits until they settle.
const FITS: usize = 25;
/// Searches for all maxima, each about the best of the one before.
const SEARCHES: usize = 3;
/// Nats that a search may leave to gain in a row that takes part.
const TO_GAIN: f64 = 0.05;

/// What one model is trained with.
pub(super) struct ResponseTraining<'a> {
    pub(super) responses: &'a Responses<'a>,
    pub(super) measured: &'a [Measured],
    pub(super) errors: &'a [ErrorTerm],
    pub(super) parameters: &'a Parameters,
    pub(super) stage: &'a ResponseStage,
    /// Where to search too, if a parameter is known to repeat itself within its prior.
    pub(super) starts: &'a [Vec<f64>],
}

/// What training found.
pub(super) struct Found {
    pub(super) fit: Fit,
    pub(super) laplace: Laplace,
    pub(super) evidence: Evidence,
    /// Its share of the evidence that all maxima have together, 0..1.
    pub(super) share: f64,
    /// The other maxima that are not improbable.
    pub(super) beside: Vec<GroundMaximum>,
    /// All others, in words and numbers.
    pub(super) maxima: Vec<OtherMaximum>,
    /// What the rig answers with these parameters, load after load.
    pub(super) answers: Vec<Vec<C64>>,
    /// What the head most probably makes of it.
    pub(super) heard: Vec<Vec<C64>>,
    pub(super) warnings: Vec<String>,
}

impl ResponseTraining<'_> {
    /// The maximum of the posterior, Laplace's method there and the evidence, of all maxima if they are
    /// looked for.
    ///
    /// # Errors
    /// [`EngineError::Unsettled`] if the head's errors do not settle or the search ended early, and errors of
    /// the inference.
    pub(super) fn found(&self) -> Result<Found, EngineError> {
        self.found_from(None)
    }

    /// The medians of the priors.
    pub(super) fn middle(&self) -> Vec<f64> {
        self.parameters.physical(&self.parameters.from_standard_normal(&vec![0.0; self.parameters.len()]))
    }

    /// As [`ResponseTraining::found`], with a search from `start`.
    pub(super) fn found_from(&self, mut start: Option<Fit>) -> Result<Found, EngineError> {
        let mut heard = match &start {
            Some(fit) => self.about(fit)?,
            None => HeardResponses::about_data(self.measured, self.errors, self.answered(&self.middle())?)?,
        };
        for _ in 0..if self.stage.checked { SEARCHES } else { 1 } {
            if !heard.is_exact() {
                let fit;
                (heard, fit) = self.settled(heard, start)?;
                start = Some(fit);
            }
            let mut found = self.fitted(&heard, start.as_ref())?;
            found.evidence.ln_best_fit += heard.tilt_cost();
            found.evidence.ln_marginal += heard.tilt_cost();
            let fit = &found.fit;
            let moved =
                start.as_ref().map_or(0.0, |start| moved(&found.laplace, &fit.parameters, &start.parameters));
            let after = self.about(fit)?;
            if heard.is_exact() || moved < SETTLED {
                let answers = after.answered();
                return Ok(Found { answers, heard: after.heard(), ..found });
            }
            // The search found a better maximum, where the head's errors are others.
            (heard, start) = (after, Some(found.fit));
        }
        Err(EngineError::Unsettled {
            what: "the errors of the head differ between maxima of the posterior, and the searches do not end at one".to_owned(),
        })
    }

    /// Fits, with the head's errors taken about the fit before, until the parameters stay.
    fn settled(
        &self,
        mut heard: HeardResponses,
        start: Option<Fit>,
    ) -> Result<(HeardResponses, Fit), EngineError> {
        let mut before = start;
        if before.is_none() && self.errors.is_empty() && heard.has_fields() {
            let fit = self.projected(&heard)?;
            heard = self.about(&fit)?;
            before = Some(fit);
        }
        let mut last = f64::INFINITY;
        for _ in 0..FITS {
            let fit = self.fit(&heard, before.as_ref())?;
            capped(&fit.stop)?;
            if let Some(before) = &before {
                last = self.distance(&fit, &before.parameters);
            }
            heard = self.about(&fit)?;
            if last < SETTLED {
                return Ok((heard, fit));
            }
            before = Some(fit);
        }
        Err(EngineError::Unsettled {
            what: format!(
                "the errors of the head, or the fields of unknown sources, do not settle: after {FITS} fits the parameters still move by {last:.2} \
                 standard deviations; give the head fewer functions or a smaller sd, and look for what the model lacks"
            ),
        })
    }

    /// The fit that a search finds from the centre of the prior if the fields of unknown sources are those
    /// about every point of its path. With the fields of the last fit alone it may run far beyond.
    fn projected(&self, heard: &HeardResponses) -> Result<Fit, EngineError> {
        let rough = self.fit(heard, None)?;
        capped(&rough.stop)?;
        let mut start = self.parameters.centre();
        start.extend(&rough.working[start.len()..]);
        let found = minimise(&AboutItself(self), &start, &MapOptions::default().search)?;
        capped(&found.stop)?;
        let end = found.z;
        let answers = self.answered(&self.parameters.physical(&end[..self.parameters.len()]))?;
        let heard = HeardResponses::about_data(self.measured, self.errors, answers)?;
        self.fit(&heard, Some(&Fit { working: end, ..rough }))
    }

    /// The maximum next to that of the fit before, with its noise, if there is one.
    fn fit(&self, heard: &HeardResponses, before: Option<&Fit>) -> Result<Fit, EngineError> {
        let data = self.blocks(heard).data()?;
        let quick = self.told(heard, Order::First);
        let posterior = Posterior::new(&quick, &data, self.parameters)?;
        let options = MapOptions::default();
        let Some(before) = before else { return Ok(posterior.map(&options)?) };
        match posterior.map_from(&before.working, &options.search) {
            Ok(fit) if fit.stop.converged() => Ok(fit),
            _ => Ok(posterior.map(&options.from(&before.parameters))?),
        }
    }

    /// The head's errors about the answers of the rig with the parameters of a fit.
    pub(super) fn about(&self, fit: &Fit) -> Result<HeardResponses, EngineError> {
        let answers = self.answered(&fit.parameters)?;
        let rest = Rest { noise: &fit.noise, kernel: self.stage.misfit.as_ref().map(|m| m.kernel) };
        HeardResponses::about_answers(self.measured, self.errors, answers, rest)
    }

    /// The answers of the rig.
    fn answered(&self, parameters: &[f64]) -> Result<Vec<Vec<C64>>, EngineError> {
        let answers = self.responses.answers(parameters, Order::Value)?;
        Ok(answers.iter().map(|a| a.iter().map(Jet::value).collect()).collect())
    }

    fn told<'b>(&'b self, heard: &'b HeardResponses, highest: Order) -> Told<'b, 'b> {
        Told { responses: self.responses, measured: self.measured, heard, highest }
    }

    fn blocks<'b>(&'b self, heard: &'b HeardResponses) -> Blocks<'b> {
        Blocks {
            measured: self.measured,
            errors: self.errors,
            heard,
            noise: &self.stage.noise,
            misfit: self.stage.misfit.as_ref(),
        }
    }

    /// How far the parameters of a fit are from others, in standard deviations of the fit.
    fn distance(&self, fit: &Fit, others: &[f64]) -> f64 {
        let p = self.parameters.len();
        let block = Matrix::from_fn(p, p, |i, j| fit.search_hessian[(i, j)]);
        let scales = self.parameters.scales();
        let sds: Vec<f64> = match Cholesky::new(&block) {
            Ok(factor) => {
                let inverse = factor.inverse();
                (0..p).map(|i| inverse[(i, i)].sqrt()).collect()
            }
            Err(_) => scales,
        };
        let working = self.parameters.working(others);
        (0..p).map(|i| (fit.working[i] - working[i]).abs() / sds[i]).fold(0.0, f64::max)
    }

    /// The maximum of a posterior, searched without second derivatives of the model, Laplace's method there,
    /// the evidence of all maxima that were looked for, and warnings.
    fn fitted(&self, heard: &HeardResponses, start: Option<&Fit>) -> Result<Found, EngineError> {
        let data = self.blocks(heard).data()?;
        // With unknown sources, second derivatives at fixed fields are not those of the cost: what the fields
        // do when the parameters move is as large. Gauss and Newton leave out both.
        let highest = if heard.has_fields() { Order::First } else { Order::Second };
        let whole = self.told(heard, highest);
        let posterior = Posterior::new(&whole, &data, self.parameters)?;
        let (answers, heard_so) = (Vec::new(), Vec::new());
        if !self.stage.checked && self.starts.is_empty() {
            let fit = self.fit(heard, start)?;
            let laplace = posterior.laplace(&fit)?;
            ended(&fit.stop, laplace.decrement)?;
            let evidence = laplace.evidence;
            let early = (!fit.stop.converged()).then(|| format!("the search stopped early: {}", fit.stop));
            let warnings = early.into_iter().collect();
            let (beside, maxima) = (Vec::new(), Vec::new());
            return Ok(Found {
                fit,
                laplace,
                evidence,
                share: 1.0,
                beside,
                maxima,
                answers,
                heard: heard_so,
                warnings,
            });
        }
        // One stream for every model: a further row must not change the others.
        let mut options = AssessOptions {
            streams: Streams::new(u64::from_le_bytes(*b"response")),
            starts: start
                .iter()
                .map(|fit| fit.parameters.clone())
                .chain(self.starts.iter().cloned())
                .collect(),
            // A stage judges the residuals itself.
            goodness_of_fit: false,
            few_data: false,
            ..AssessOptions::default()
        };
        options.most_starts += 2 * self.starts.len();
        if !self.stage.checked {
            // The starts, and the images of the best maximum.
            (options.random_starts, options.screened, options.draws) = (0, 0, 0);
        }
        let assessed = posterior.assess(&options)?;
        let laplace = assessed.laplace.or_else(|_| posterior.laplace(&assessed.fit))?;
        ended(&assessed.fit.stop, laplace.decrement)?;
        let evidence = assessed.evidence.unwrap_or(laplace.evidence);
        let names: Vec<String> = self.parameters.list().iter().map(|p| p.name.clone()).collect();
        let beside = assessed.maxima[1..].iter().filter_map(|m| GroundMaximum::of(&names, m)).collect();
        let health = assessed.health;
        let warnings = match self.stage.checked {
            true => health.warnings,
            false => further_maxima(&health.other_modes).into_iter().collect(),
        };
        let (share, maxima, fit) = (health.share, health.other_modes, assessed.fit);
        Ok(Found { fit, laplace, evidence, share, beside, maxima, answers, heard: heard_so, warnings })
    }
}

/// The cost of a training with unknown sources, with their fields about every point itself.
struct AboutItself<'a, 'b>(&'b ResponseTraining<'a>);

impl Objective for AboutItself<'_, '_> {
    fn size(&self) -> usize {
        self.scales().len()
    }

    fn evaluate(&self, z: &[f64], order: Order) -> Result<Energy, InferenceError> {
        let Self(training) = self;
        let values = training.parameters.physical(&z[..training.parameters.len()]);
        let about = |answers| HeardResponses::about_data(training.measured, training.errors, answers);
        let heard = training.answered(&values).and_then(about).map_err(ForwardError::from)?;
        let data = training.blocks(&heard).data().map_err(ForwardError::from)?;
        let told = training.told(&heard, Order::First);
        Posterior::new(&told, &data, training.parameters)?.evaluate(z, order)
    }

    fn scales(&self) -> Vec<f64> {
        let mut scales = self.0.parameters.scales();
        scales.extend((!matches!(self.0.stage.noise, SdSpec::Fixed(_))).then_some(1.0));
        scales
    }
}

/// Refuses a search that ended where there is still something to gain: its evidence is no number to rank by.
fn ended(stop: &Stop, decrement: f64) -> Result<(), EngineError> {
    if left_to_gain(stop, decrement) {
        return Err(EngineError::Unsettled { what: format!("the search stopped early: {stop}") });
    }
    Ok(())
}

/// Refuses a search whose evaluations were used up before its end: one that begins there goes no further.
fn capped(stop: &Stop) -> Result<(), EngineError> {
    match stop {
        Stop::EvaluationCap { decrement } => ended(stop, *decrement),
        _ => Ok(()),
    }
}

/// Whether a search left nats to gain; `decrement` is half of g' H^-1 g at its end.
fn left_to_gain(stop: &Stop, decrement: f64) -> bool {
    let to_gain = match stop {
        Stop::Converged { .. } => 0.0,
        Stop::EvaluationCap { decrement } => *decrement,
        _ => decrement,
    };
    // NaN: nobody knows.
    !matches!(to_gain.partial_cmp(&TO_GAIN), Some(std::cmp::Ordering::Less))
}

/// How far parameters are from others, in standard deviations.
pub(super) fn moved(laplace: &Laplace, here: &[f64], there: &[f64]) -> f64 {
    let sd = |i: usize| laplace.physical_covariance[(i, i)].sqrt();
    here.iter().zip(there).enumerate().map(|(i, (a, b))| (a - b).abs() / sd(i)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::left_to_gain;
    use rijke_inference::Stop;

    #[test]
    fn exact_a_search_with_nats_to_gain_takes_no_part() {
        assert!(!left_to_gain(&Stop::Converged { decrement: 1e-9 }, f64::NAN));
        assert!(!left_to_gain(&Stop::EvaluationCap { decrement: 3e-3 }, 190.0));
        assert!(left_to_gain(&Stop::EvaluationCap { decrement: 190.0 }, 0.0));
        assert!(left_to_gain(&Stop::EvaluationCap { decrement: f64::INFINITY }, 0.0));
        assert!(left_to_gain(&Stop::Blocked { reason: "a bound".into() }, 0.5));
        assert!(!left_to_gain(&Stop::Blocked { reason: "rounding".into() }, 1e-6));
        assert!(left_to_gain(&Stop::Flat { eigenvalue_ratio: 1e-12 }, f64::NAN));
    }
}
