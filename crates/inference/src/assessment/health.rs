//! Can this evidence be trusted? What the checks of it found.

use crate::density::Calls;
use crate::evidence::{Conflict, Evidence};
use crate::maxima::{Explored, Open, OtherMaximum};
use crate::sample::{Importance, Verdict};
use serde::{Deserialize, Serialize};

/// How far the data lie from the best prediction, in the noise of the fit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChiSquared {
    /// r' C^-1 r of all data.
    pub value: f64,
    /// Degrees of freedom: the number of data, less the parameters that they determine if no noise is
    /// estimated. An estimated noise adjusts itself to the residuals, so that nothing but its floor can be
    /// exceeded, and all data count.
    pub freedom: usize,
    /// How many standard deviations of a normal number are as improbable; `value` far below `freedom` counts
    /// as none.
    pub sds: f64,
}

/// What the checks of one evidence found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Health {
    /// Evidence by importance sampling from all maxima, if it was asked for.
    pub importance: Option<Importance>,
    /// What the sampler said, if one was asked.
    #[serde(default)]
    pub sampler: Option<Verdict>,
    /// Other maxima of the posterior, most probable first.
    pub other_modes: Vec<OtherMaximum>,
    /// Share of the summed evidence that the best maximum holds, 0..1.
    #[serde(default)]
    pub share: f64,
    /// Starts that ended without converging, or at which the model failed.
    pub failed_starts: usize,
    /// All starts.
    pub starts: usize,
    /// Change of ln ML when the prior sd (or width) of one parameter is doubled; about -ln 2 = -0.69 for a
    /// parameter that the data fix, about zero for one that they do not see. Nothing if there is then no
    /// maximum.
    pub doubled_prior: Vec<(String, Option<f64>)>,
    /// Combinations of parameters of which the data tell less than the prior, each with the share of prior
    /// variance left.
    pub unidentified: Vec<(String, f64)>,
    /// Parameters that sit at a bound.
    pub at_bound: Vec<String>,
    /// How far the posterior lies from the priors; [`Conflict::warnings`] says where it is too far.
    #[serde(default)]
    pub conflict: Conflict,
    /// How far the data lie from the model, if it was asked for.
    #[serde(default)]
    pub chi_squared: Option<ChiSquared>,
    /// Reasons not to trust the evidence, the standard deviations or the model, in words with numbers; empty
    /// means trusted.
    pub warnings: Vec<String>,
    /// Calls of the model spent on fits (all starts) and on draws.
    pub calls: Calls,
}

/// Difference between Laplace's and the corrected evidence, nats, above which the row says so.
const GAP: f64 = 0.5;
/// The same above which there is no evidence, nats: a Bayes factor of 150 by nothing but the approximation.
const REFUSED: f64 = 5.0;

impl Health {
    /// The counts of a search.
    pub(crate) fn of_search(found: &Explored) -> Self {
        let mut health =
            Self { starts: found.starts, failed_starts: found.failed, calls: found.calls, ..Self::default() };
        if let Some(open) = found.open {
            let (starts, count) = (found.starts, found.peaks.len());
            let found = match open {
                Open::StillFound => format!("new maxima were still found after {starts} starts"),
                Open::FewStarts => {
                    format!("{starts} starts are too few to find all maxima, where {count} are known")
                }
                Open::ManyImages => {
                    format!("aliases lead to more maxima than the {count} that were looked at")
                }
            };
            let remedy = match open {
                Open::ManyImages => "Narrow the prior of the parameter that repeats itself",
                _ => {
                    "Narrow the priors, allow more starts, or declare the step by which a parameter repeats itself"
                }
            };
            health.warnings.push(format!("{found}: the evidence may be too low. {remedy}"));
        }
        health
    }

    /// Why an evidence by Laplace's method must not be used, if importance sampling says so.
    pub(crate) fn refused(&self, evidence: &Evidence) -> Option<String> {
        let gap = self.importance.as_ref().filter(|found| found.good())?.ln_marginal - evidence.ln_marginal;
        (gap.abs() > REFUSED).then(|| {
            format!(
                "Laplace's evidence is off by {gap:+.0} nats, by importance sampling: the posterior is no sum of Gaussians about its maxima. Give \
                 parameters that the data tell apart, or integrate by a sampler"
            )
        })
    }

    /// Takes up what importance sampling found, against the sum of Laplace's evidences.
    pub(crate) fn weigh(&mut self, found: Importance, ln_marginal: f64) {
        self.calls.value += found.draws;
        let gap = found.ln_marginal - ln_marginal;
        if !found.good() {
            self.warnings.push(format!(
                "importance sampling cannot confirm the evidence, because the posterior is not close to its Gaussian (Pareto k-hat {:.2}, limit {:.2})",
                found.k_hat,
                found.k_limit()
            ));
        } else if gap.abs() > GAP.max(4.0 * found.standard_error) {
            self.warnings.push(format!("importance sampling differs from Laplace by {gap:+.2} nats"));
        }
        self.importance = Some(found);
    }
}
