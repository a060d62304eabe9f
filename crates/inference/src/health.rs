//! Can this evidence be trusted? Laplace's method with the checks that say so.

use crate::held::Held;
use crate::{
    Calls, Coordinates, Fit, Gaussian, Importance, InferenceError, Laplace, LikelihoodTarget, Objective,
    Posterior, Prior, RefereeKind, Target, TrustRegion, Verdict, importance,
};
use rijke_numerics::{Matrix, Order, Streams, symmetric_eigen};
use serde::{Deserialize, Serialize};

/// Settings of [`Posterior::assess`].
#[derive(Clone, Debug)]
pub struct AssessOptions {
    /// The minimiser of every start.
    pub search: TrustRegion,
    /// Physical parameters to start from, beside the centre of the prior.
    pub starts: Vec<Vec<f64>>,
    /// Further starts drawn from the prior.
    pub random_starts: usize,
    /// Model calls spent on the importance-sampled evidence; zero leaves it out, and says so in the row.
    pub draws: usize,
    /// A slow method to compare the evidence with, and its statistical error, nats.
    pub referee: Option<(RefereeKind, f64)>,
    /// Random streams of starts and draws.
    pub streams: Streams,
}

/// A fit, its Laplace approximation, and what the checks found.
#[derive(Clone, Debug)]
pub struct Assessment {
    /// The best maximum found.
    pub fit: Fit,
    /// Laplace's method there, or why it does not apply.
    pub laplace: Result<Laplace, String>,
    /// The checks.
    pub health: Health,
}

/// What the checks of one evidence found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Health {
    /// Evidence by importance sampling, if it was asked for.
    pub importance: Option<Importance>,
    /// What the referee said, if one was asked.
    #[serde(default)]
    pub referee: Option<Verdict>,
    /// Other maxima of the posterior, most probable first.
    pub other_modes: Vec<Mode>,
    /// Starts that ended without converging, or at which the model failed.
    pub failed_starts: usize,
    /// All starts.
    pub starts: usize,
    /// Change of ln ML when the prior sd (or width) of one parameter is doubled; about -ln 2 = -0.69 for a parameter
    /// that the data fix, about zero for one that they do not see. Nothing if there is then no maximum.
    pub doubled_prior: Vec<(String, Option<f64>)>,
    /// Combinations of parameters of which the data tell less than the prior, each with the share of prior variance left.
    pub unidentified: Vec<(String, f64)>,
    /// Parameters that sit at a bound.
    pub at_bound: Vec<String>,
    /// Reasons not to trust the evidence, in words with numbers; empty means trusted.
    pub warnings: Vec<String>,
    /// Calls of the model spent on fits (all starts) and on draws.
    pub calls: Calls,
}

/// A maximum of the posterior.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mode {
    /// Physical parameters.
    pub parameters: Vec<f64>,
    /// Its Laplace evidence, nats; nothing if its Hessian is not positive definite, or if its likelihood is too low for
    /// its evidence to matter.
    pub ln_marginal: Option<f64>,
}

/// A second maximum counts if it holds more than this fraction of the evidence of the first, as a logarithm: 5 %.
pub(crate) const MODE_LIMIT: f64 = -3.0;
/// Two ends of a search are the same maximum if they are closer than this many posterior standard deviations.
pub(crate) const SAME_MODE: f64 = 0.5;
/// Difference between Laplace's and the corrected evidence, nats, above which the row says so.
const GAP: f64 = 0.5;

impl Default for AssessOptions {
    /// Newton, the centre of the prior and four draws from it, and 256 calls for the corrected evidence.
    fn default() -> Self {
        Self {
            search: TrustRegion::default(),
            starts: Vec::new(),
            random_starts: 4,
            draws: 256,
            referee: None,
            streams: Streams::new(1),
        }
    }
}

impl Posterior<'_> {
    /// MAP from several starts, Laplace's method at the best, and every check of the evidence.
    ///
    /// Cost: a fit per start and `options.draws` values of the model, in parallel; the doubled priors cost no call.
    ///
    /// # Errors
    /// Errors that are not recoverable, and the failure of the first start if the model fails at all of them. A model
    /// that was fitted but cannot be trusted is an [`Assessment`] with warnings.
    pub fn assess(&self, options: &AssessOptions) -> Result<Assessment, InferenceError> {
        let mut health = Health::default();
        let mut fits = self.maxima(options, &mut health)?;
        let fit = fits.remove(0);
        let laplace = self.laplace(&fit);
        if let Ok(laplace) = &laplace {
            self.examine(&fit, laplace, &fits, options, &mut health)?;
        }
        self.warn_of_fit(&fit, &mut health);
        Ok(Assessment { fit, laplace: laplace.map_err(|e| e.to_string()), health })
    }

    fn examine(
        &self,
        fit: &Fit,
        laplace: &Laplace,
        others: &[Fit],
        options: &AssessOptions,
        health: &mut Health,
    ) -> Result<(), InferenceError> {
        let target = self.target(fit);
        let gaussian = Gaussian::from_hessian(&laplace.mean, fit.cost, &laplace.hessian)?;
        self.find_modes(&target, &gaussian, laplace, others, health);
        if options.draws > 0 && !laplace.mean.is_empty() {
            let found = importance(&target, &gaussian, options.draws, options.streams)?;
            health.calls.value += found.draws;
            let gap = found.ln_marginal - laplace.evidence.ln_marginal;
            if !found.good() {
                health.warnings.push(format!(
                    "the posterior is not near its Gaussian: Pareto k-hat {:.2} above {:.2}",
                    found.k_hat,
                    found.k_limit()
                ));
            } else if gap.abs() > GAP.max(4.0 * found.standard_error) {
                health.warnings.push(format!("Laplace is off by {gap:+.2} nats"));
            }
            health.importance = Some(found);
        } else if !laplace.mean.is_empty() {
            health.warnings.push("the evidence was not checked by importance sampling".to_owned());
        }
        if let (Some((kind, error)), false) = (options.referee, laplace.mean.is_empty()) {
            health.referee = Some(self.ask(kind, error, fit, laplace, options, &mut health.warnings)?);
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
            health.warnings.push(format!("at a bound: {}", health.at_bound.join(", ")));
        }
        Ok(())
    }

    /// The referee's verdict, and a warning if it contradicts Laplace's by more than three of its errors.
    fn ask(
        &self,
        kind: RefereeKind,
        error: f64,
        fit: &Fit,
        laplace: &Laplace,
        options: &AssessOptions,
        warnings: &mut Vec<String>,
    ) -> Result<Verdict, InferenceError> {
        let target = LikelihoodTarget::new(self, fit)?;
        let evidence = laplace.evidence;
        let referee = kind.build(error, evidence.ln_occam, target.size(), options.streams)?;
        let judged = referee.judge(&target)?;
        let gap = judged.ln_marginal - evidence.ln_marginal;
        if !judged.finished {
            warnings.push(format!("{} reached its cap on evaluations", referee.name()));
        } else if gap.abs() > 3.0 * judged.standard_error {
            warnings.push(format!(
                "{} differs by {gap:+.2} nats, of an error of {:.2}",
                referee.name(),
                judged.standard_error
            ));
        }
        Ok(Verdict {
            referee: referee.name().to_owned(),
            ln_marginal: judged.ln_marginal,
            standard_error: judged.standard_error,
            calls: judged.calls.total(),
            finished: judged.finished,
        })
    }

    fn find_modes(
        &self,
        target: &Held<'_>,
        gaussian: &Gaussian,
        laplace: &Laplace,
        others: &[Fit],
        health: &mut Health,
    ) {
        let mut seen = vec![laplace.mean.clone()];
        for other in others.iter().filter(|f| f.stop.converged()) {
            let z: Vec<f64> = target.free.iter().map(|&i| other.working[i]).collect();
            let near = |mode: &Vec<f64>| {
                let offset: Vec<f64> =
                    z.iter().zip(mode).zip(&gaussian.mean).map(|((z, m), g)| z - m + g).collect();
                gaussian.distance(&offset) < SAME_MODE
            };
            if seen.iter().any(near) {
                continue;
            }
            seen.push(z);
            let ln_marginal = self.laplace(other).ok().map(|l| l.evidence.ln_marginal);
            health.other_modes.push(Mode { parameters: other.parameters.clone(), ln_marginal });
        }
        health.other_modes.sort_by(|a, b| {
            let key = |m: &Mode| m.ln_marginal.unwrap_or(f64::NEG_INFINITY);
            key(b).total_cmp(&key(a))
        });
        if let Some(ln) = health.other_modes.first().and_then(|m| m.ln_marginal) {
            let relative = ln - laplace.evidence.ln_marginal;
            if relative > MODE_LIMIT {
                health.warnings.push(format!(
                    "the posterior has {} further maxima, one with {relative:+.2} nats of evidence relative to the best fit",
                    health.other_modes.len()
                ));
            }
        }
    }

    fn warn_of_fit(&self, fit: &Fit, health: &mut Health) {
        if !fit.stop.converged() {
            health.warnings.push(format!("the search did not converge: {}", fit.stop));
        }
        let data = self.data().observations();
        for (g, noise) in fit.noise.iter().enumerate().filter(|(_, n)| n.floats) {
            let (mut size, mut count, mut bare) = (0.0_f64, 0, false);
            for observation in data {
                for (_, s) in observation.noise.iter().filter(|(h, _)| *h == g) {
                    for i in (0..observation.values.len()).filter(|&i| s[(i, i)] > 0.0) {
                        size = size.max(observation.values[i].abs());
                        count += 1;
                        bare |= observation.floor.as_ref().is_none_or(|f| f[(i, i)] == 0.0);
                    }
                }
            }
            if count <= self.parameters().len() {
                health.warnings.push(format!(
                    "the noise '{}' floats with {count} data against {} parameters",
                    noise.name,
                    self.parameters().len()
                ));
            }
            if bare && noise.sd < 1e-12 * size {
                health.warnings.push(format!("the noise '{}' has collapsed to {:.1e}", noise.name, noise.sd));
            }
        }
    }

    /// The evidence with one prior widened at a time, on the quadratic model of the likelihood at the maximum.
    fn doubled_priors(
        &self,
        fit: &Fit,
        laplace: &Laplace,
    ) -> Result<Vec<(String, Option<f64>)>, InferenceError> {
        let p = self.parameters().len();
        let density = self.parameters().ln_density(&fit.working[..p])?;
        let n = laplace.mean.len();
        let mut surrogate = Surrogate {
            centre: laplace.mean.clone(),
            // At the maximum the slopes of likelihood and prior cancel.
            slope: (0..n).map(|i| density.gradient.get(i).copied().unwrap_or(0.0)).collect(),
            hessian: Matrix::from_fn(n, n, |i, j| {
                laplace.hessian[(i, j)] + if i < p && j < p { density.hessian[(i, j)] } else { 0.0 }
            }),
            parameters: self.parameters().clone(),
        };
        let base = Gaussian::at(&surrogate, &laplace.mean)?.ln_integral;
        let mut changes = Vec::with_capacity(p);
        for i in 0..p {
            let name = self.parameters().list()[i].name.clone();
            if let Prior::Uniform { .. } = self.parameters().list()[i].prior {
                // Twice the width halves the density; what lies beyond the old bounds was never looked at.
                changes.push((name, Some(-std::f64::consts::LN_2)));
                continue;
            }
            surrogate.parameters = self.parameters().widened(i, 2.0);
            let found = crate::minimise(&surrogate, &laplace.mean, &TrustRegion::default())
                .and_then(|minimum| Gaussian::at(&surrogate, &minimum.z));
            changes.push((name, found.ok().map(|g| g.ln_integral - base)));
        }
        Ok(changes)
    }

    /// Directions in which the posterior keeps more than half of the prior variance.
    fn unidentified(&self, laplace: &Laplace) -> Result<Vec<(String, f64)>, InferenceError> {
        let keep = self.integrated();
        let scales = self.scales();
        let n = keep.len();
        let likelihood = laplace.gauss_newton.plus(1.0, &laplace.curvature);
        let scaled = Matrix::from_fn(n, n, |i, j| likelihood[(i, j)] * scales[keep[i]] * scales[keep[j]]);
        let (values, vectors) = symmetric_eigen(&scaled)?;
        Ok((0..n)
            .filter(|&k| values[k] < 1.0)
            .map(|k| {
                let direction: Vec<f64> = (0..n).map(|i| vectors[(i, k)]).collect();
                (self.in_words(&direction, &keep), 1.0 / (1.0 + values[k].max(0.0)))
            })
            .collect())
    }

    fn at_bound(&self, fit: &Fit, laplace: &Laplace) -> Vec<String> {
        let sds = laplace.sd();
        let mut found = Vec::new();
        for (i, parameter) in self.parameters().list().iter().enumerate() {
            let ((low, high), a, z) = (parameter.prior.bounds(), fit.parameters[i], fit.working[i]);
            let near = match parameter.coordinates {
                // A Gaussian that is cut by a bound is none.
                Coordinates::Natural => a - low < sds[i] || high - a < sds[i],
                // 0.1 % of the width.
                Coordinates::Logit => z.abs() > 7.0,
                Coordinates::Log => false,
            };
            if near {
                found.push(format!("{} = {a:.4e} {}", parameter.name, parameter.unit));
            }
        }
        found
    }
}

/// A quadratic likelihood with the exact prior of `parameters`.
struct Surrogate {
    centre: Vec<f64>,
    slope: Vec<f64>,
    hessian: Matrix,
    parameters: crate::Parameters,
}

impl Objective for Surrogate {
    fn size(&self) -> usize {
        self.centre.len()
    }

    fn evaluate(&self, z: &[f64], _: Order) -> Result<crate::Energy, InferenceError> {
        let (n, p) = (self.size(), self.parameters.len());
        let offset: Vec<f64> = z.iter().zip(&self.centre).map(|(z, c)| z - c).collect();
        let pull = self.hessian.times(&offset);
        let prior = self.parameters.ln_density(&z[..p])?;
        let linear: f64 = (0..n).map(|i| (self.slope[i] + 0.5 * pull[i]) * offset[i]).sum();
        let mut hessian = self.hessian.clone();
        let mut gradient: Vec<f64> = (0..n).map(|i| self.slope[i] + pull[i]).collect();
        for i in 0..p {
            gradient[i] -= prior.gradient[i];
            for j in 0..p {
                hessian[(i, j)] -= prior.hessian[(i, j)];
            }
        }
        Ok(crate::Energy { value: linear - prior.value, gradient, hessian, gauss_newton: None })
    }
}
