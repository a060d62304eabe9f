//! All that can be said of a model with its data: every maximum, the evidence summed over them, and the
//! checks of it.

use super::health::Health;
use crate::density::{Gaussian, TrustRegion};
use crate::error::InferenceError;
use crate::evidence::{Evidence, Laplace};
use crate::fit::{Fit, Posterior};
use crate::linearised::Few;
use crate::maxima::{Breadth, Maximum, Scan, Sorted, Terrain, explore, further_maxima, sorted};
use crate::problem::{Data, Forward, Parameters};
use crate::sample::{LikelihoodTarget, SamplerKind, Target, Verdict, weighed};
use rijke_numerics::Streams;

/// Settings of [`Posterior::assess`].
#[derive(Clone, Debug)]
pub struct AssessOptions {
    /// The minimiser of every start.
    pub search: TrustRegion,
    /// Physical parameters to start from, beside the centre of the prior.
    pub starts: Vec<Vec<f64>>,
    /// Delays, of which a search knows one period alone: each is moved over eight standard deviations of
    /// its prior (several over four), with the others fitted, and the best of these points are starts, too.
    pub scans: Vec<Scan>,
    /// Searches from the best of a sample of the prior, in one batch; there are further batches as long as
    /// one finds a new maximum. Zero: from given starts and known aliases alone.
    pub random_starts: usize,
    /// Size of that sample, an evaluation of the model each.
    pub screened: usize,
    /// Most searches. Not counted are those from the images to which an alias leads, and some forty more
    /// where the best maximum contradicts its priors or misses the data.
    pub most_starts: usize,
    /// Model calls spent on the importance-sampled evidence; zero leaves it out, and says so in the row.
    pub draws: usize,
    /// A slow method to compare the evidence with, and its statistical error, nats.
    pub sampler: Option<(SamplerKind, f64)>,
    /// Whether to warn of a model that misses the data ([`Health::chi_squared`]). False for a caller who
    /// judges the residuals.
    pub goodness_of_fit: bool,
    /// Whether to find what few data leave unknown of a noise that floats ([`Assessment::few`]), and to warn
    /// where Laplace's standard deviations are too small by a tenth. False for a caller who widens them
    /// ([`crate::Linearised::few`]).
    pub few_data: bool,
    /// Random streams of starts and draws.
    pub streams: Streams,
}

/// All maxima of a posterior, the evidence summed over them, and what the checks found.
#[derive(Clone, Debug)]
pub struct Assessment {
    /// The best maximum found: the one with the most evidence.
    pub fit: Fit,
    /// Laplace's method there, or why it does not apply. Its standard deviations take a noise that floats for
    /// known: those of [`Assessment::sd`] do not.
    pub laplace: Result<Laplace, String>,
    /// What few data leave unknown of noises that float; nothing if none floats, if it was not asked for, or
    /// if there are more than 2000 data.
    pub few: Option<Few>,
    /// The evidence summed over all maxima: the number to rank by. Its best-fit likelihood is that of the
    /// best maximum; what the others add is in the Occam factor, as prior volume that survives the data.
    /// Equal to that of `laplace` if there is one maximum.
    pub evidence: Result<Evidence, String>,
    /// All maxima, best first, the first of them that of `fit`.
    pub maxima: Vec<Maximum>,
    /// The checks.
    pub health: Health,
}

impl Default for AssessOptions {
    /// Newton, the centre of the prior, the best four of 32 draws from it, and 256 calls for the corrected
    /// evidence.
    fn default() -> Self {
        Self {
            search: TrustRegion::default(),
            starts: Vec::new(),
            scans: Vec::new(),
            random_starts: 4,
            screened: 32,
            most_starts: 32,
            draws: 256,
            sampler: None,
            goodness_of_fit: true,
            few_data: true,
            streams: Streams::new(1),
        }
    }
}

impl Assessment {
    /// Posterior standard deviation of each physical parameter at the best maximum: that of
    /// [`Laplace::sd`], wider by what few data leave unknown of noises that float, so that two of them hold
    /// the truth with 95 %. Nothing where Laplace's method does not apply.
    #[must_use]
    pub fn sd(&self) -> Option<Vec<f64>> {
        let mut sds = self.laplace.as_ref().ok()?.sd();
        if let Some(few) = &self.few {
            sds.iter_mut().zip(&few.parameters).for_each(|(sd, factor)| *sd *= factor);
        }
        Some(sds)
    }
}

impl AssessOptions {
    /// How widely they let a search go.
    pub(super) fn breadth(&self) -> Breadth {
        let &Self { screened, random_starts, most_starts, .. } = self;
        Breadth { screened, random_starts, most_starts }
    }
}

/// All that can be said of a model with its data: every maximum of the posterior, the evidence summed over
/// them, the checks of it, and whether the data contradict the priors.
///
/// # Errors
/// Those of [`Posterior::new`] and [`Posterior::assess`].
pub fn assess(
    forward: &dyn Forward,
    data: &Data,
    parameters: &Parameters,
    options: &AssessOptions,
) -> Result<Assessment, InferenceError> {
    Posterior::new(forward, data, parameters)?.assess(options)
}

impl Posterior<'_> {
    /// All maxima that several starts lead to, Laplace's method at each, the evidence summed over them, and
    /// every check of it.
    ///
    /// Cost: a fit per start, `options.screened + options.draws` values of the model, in parallel; the
    /// doubled priors cost no call.
    ///
    /// # Errors
    /// [`InferenceError::StartSize`] and [`InferenceError::BadName`] for starts and scans of other
    /// parameters, [`InferenceError::Setting`] for a scan without a step; errors that are not recoverable,
    /// and the failure of the first start if the model fails at all of them. A model that was fitted but
    /// cannot be trusted is an [`Assessment`] with warnings.
    pub fn assess(&self, options: &AssessOptions) -> Result<Assessment, InferenceError> {
        let expected = self.parameters().len();
        if let Some(start) = options.starts.iter().find(|start| start.len() != expected) {
            return Err(InferenceError::StartSize { found: start.len(), expected });
        }
        for scan in &options.scans {
            self.parameters().place(&scan.parameter)?;
            if !(scan.step > 0.0 && scan.step.is_finite()) {
                let (value, need) = (scan.step, "a number above zero, in the unit of the parameter");
                return Err(InferenceError::Setting { name: "the step of a scan", value, need });
            }
        }
        let terrain = Terrain { posterior: self, search: options.search, streams: options.streams };
        let (scanned, calls) = self.scanned(&options.scans, options.streams);
        let mut breadth = options.breadth();
        breadth.most_starts += scanned.len();
        let starts: Vec<Vec<f64>> = options.starts.iter().cloned().chain(scanned).collect();
        let mut found = explore(&terrain, &starts, breadth)?;
        found.calls = found.calls.plus(calls);
        let mut health = Health::of_search(&found);
        let Sorted { maxima, proposal, modes, evidence } = sorted(self.parameters(), found);
        (health.other_modes, health.share) = (modes, maxima[0].share);
        let (mut fit, laplace) = (maxima[0].fit.clone(), maxima[0].laplace.clone());
        if let (Ok(laplace), Some(evidence)) = (&laplace, &evidence) {
            health.warnings.extend(further_maxima(&health.other_modes));
            self.examine(&fit, laplace, evidence, &proposal, options, &mut health)?;
        }
        self.warn_of_fit(&fit, &mut health);
        if options.goodness_of_fit {
            self.warn_of_misfit(&fit, &mut health)?;
        }
        let few = laplace.as_ref().ok().filter(|_| options.few_data);
        let few = few.and_then(|laplace| self.few(&mut fit, laplace, &mut health));
        let evidence = match (&laplace, evidence) {
            (Ok(_), Some(evidence)) => health.refused(&evidence).map_or(Ok(evidence), Err),
            (Err(reason), _) => Err(reason.clone()),
            (Ok(laplace), None) => Ok(laplace.evidence),
        };
        Ok(Assessment { fit, laplace, few, evidence, maxima, health })
    }

    fn examine(
        &self,
        fit: &Fit,
        laplace: &Laplace,
        evidence: &Evidence,
        proposal: &[(f64, Gaussian)],
        options: &AssessOptions,
        health: &mut Health,
    ) -> Result<(), InferenceError> {
        let target = self.target(fit);
        if options.draws > 0 && !laplace.mean.is_empty() {
            let found = weighed(&target, proposal, options.draws, options.streams)?;
            health.weigh(found, evidence.ln_marginal);
        } else if !laplace.mean.is_empty() {
            health.warnings.push("the evidence was not checked by importance sampling".to_owned());
        }
        if let (Some((kind, error)), false) = (options.sampler, laplace.mean.is_empty()) {
            health.sampler = Some(self.ask(kind, error, fit, evidence, options, &mut health.warnings)?);
        }
        if laplace.gauss_newton_only {
            health.warnings.push("the model has no second derivatives: Gauss-Newton Hessian".to_owned());
        }
        health.doubled_prior = self.doubled_priors(fit, laplace)?;
        for (name, _) in health.doubled_prior.iter().filter(|(_, change)| change.is_none()) {
            health.warnings.push(format!("no maximum if the prior sd of {name} is doubled"));
        }
        health.unidentified = self.unidentified(laplace)?;
        health.at_bound = self.at_bound(fit, laplace);
        if !health.at_bound.is_empty() {
            let all = health.at_bound.join(", ");
            health
                .warnings
                .push(format!("at a bound: {all}; if values beyond it are possible, widen the prior"));
        }
        health.conflict = self.conflict(fit, laplace)?;
        health.warnings.extend(health.conflict.warnings().iter().map(ToString::to_string));
        Ok(())
    }

    /// The sampler's verdict, and a warning if it contradicts Laplace's by more than three of its errors.
    fn ask(
        &self,
        kind: SamplerKind,
        error: f64,
        fit: &Fit,
        evidence: &Evidence,
        options: &AssessOptions,
        warnings: &mut Vec<String>,
    ) -> Result<Verdict, InferenceError> {
        let target = LikelihoodTarget::new(self, fit)?;
        let sampler = kind.build(error, evidence.ln_occam, target.size(), options.streams)?;
        let found = sampler.integrate(&target)?;
        let gap = found.ln_marginal - evidence.ln_marginal;
        if !found.finished {
            warnings.push(format!("{} reached its cap on evaluations", sampler.name()));
        } else if gap.abs() > 3.0 * found.standard_error {
            warnings.push(format!(
                "{} differs by {gap:+.2} nats, of an error of {:.2}",
                sampler.name(),
                found.standard_error
            ));
        }
        Ok(Verdict {
            sampler: sampler.name().to_owned(),
            ln_marginal: found.ln_marginal,
            standard_error: found.standard_error,
            calls: found.calls.total(),
            finished: found.finished,
        })
    }
}
