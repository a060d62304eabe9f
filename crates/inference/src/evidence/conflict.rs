//! Do the data contradict what was known before them?

use super::laplace::Laplace;
use crate::error::InferenceError;
use crate::fit::{Fit, Posterior};
use crate::numbers::chi_squared_sds;
use crate::problem::{Parameter, Prior, gaussian};
use rijke_numerics::words::precise;
use rijke_numerics::{Cholesky, Matrix, symmetric_eigen};
use serde::{Deserialize, Serialize};

/// How far the posterior lies from the priors: those that were declared, and, where an earlier stage has
/// replaced them, those too.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Conflict {
    /// One row per parameter.
    pub offsets: Vec<Offset>,
    /// All parameters together against their declared priors.
    pub declared: Tension,
    /// All parameters together against the priors of this fit: what earlier stages left of the declared ones.
    pub carried: Tension,
}

/// How far one parameter has come from its prior.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Offset {
    /// Name.
    pub parameter: String,
    /// Unit.
    pub unit: String,
    /// Most probable physical value.
    pub value: f64,
    /// Distance from the centre of the declared prior, in its standard deviations: that of a normal number at
    /// the same quantile, for a prior that is not Gaussian. Zero for a flat prior.
    pub sds: f64,
    /// The same for the prior that an earlier stage has put in its place, if one has.
    pub carried_sds: Option<f64>,
}

/// How far the posterior mean of all parameters has come, against how far it could be expected to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tension {
    /// Square of the distance in units of what the prior foretells for the posterior mean: prior less
    /// posterior covariance.
    pub chi_squared: f64,
    /// Directions of which the data tell more than [`LEARNT`] of the prior variance.
    pub freedom: usize,
    /// The same surprise as standard deviations of one normal number.
    pub sds: f64,
    /// What ln of the prior density has lost against the centre of the prior, nats.
    pub penalty: f64,
}

/// A contradiction between data and prior.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ConflictWarning {
    /// One parameter is further from a prior than [`Conflict::LIMIT`].
    Parameter {
        /// Name.
        parameter: String,
        /// Its most probable value.
        value: f64,
        /// Unit.
        unit: String,
        /// Distance from the prior, in its standard deviations.
        sds: f64,
        /// True if that prior is what an earlier stage found, false if it is the declared one.
        carried: bool,
    },
    /// All parameters together are.
    Joint {
        /// The surprise in standard deviations.
        sds: f64,
        /// What the prior has lost, nats.
        penalty: f64,
        /// As above.
        carried: bool,
    },
}

/// Share of the prior variance that data must take away along a direction for it to count.
pub const LEARNT: f64 = 0.05;

impl Conflict {
    /// Standard deviations beyond which data and prior contradict each other.
    pub const LIMIT: f64 = 4.0;

    /// The contradictions beyond [`Conflict::LIMIT`]; empty if there are none.
    #[must_use]
    pub fn warnings(&self) -> Vec<ConflictWarning> {
        let one = |o: &Offset, sds: f64, carried: bool| {
            (sds.abs() > Self::LIMIT).then(|| ConflictWarning::Parameter {
                parameter: o.parameter.clone(),
                value: o.value,
                unit: o.unit.clone(),
                sds,
                carried,
            })
        };
        let rows = self.offsets.iter().flat_map(|o| {
            [one(o, o.sds, false), o.carried_sds.and_then(|sds| one(o, sds, true))].into_iter().flatten()
        });
        let tied = self.offsets.iter().any(|o| o.carried_sds.is_some());
        let joint = |t: &Tension, carried| {
            (t.sds > Self::LIMIT).then_some(ConflictWarning::Joint {
                sds: t.sds,
                penalty: t.penalty,
                carried,
            })
        };
        let carried = if tied { joint(&self.carried, true) } else { None };
        rows.chain(joint(&self.declared, false)).chain(carried).collect()
    }
}

impl std::fmt::Display for ConflictWarning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let prior = |carried: &bool| if *carried { "what was known before" } else { "its prior" };
        match self {
            Self::Parameter { parameter, value, unit, sds, carried } => {
                let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
                write!(f, "{parameter} = {}{unit} lies {sds:+.1} sd from {}", precise(*value), prior(carried))
            }
            Self::Joint { sds, penalty, carried } => {
                let prior = if *carried { prior(carried) } else { "their priors" };
                write!(
                    f,
                    "the data contradict {prior}: the parameters, taken together, lie {sds:.1} standard deviations from where the prior expects \
                     them; the prior density there is {penalty:.1} nats below its maximum"
                )
            }
        }
    }
}

impl Posterior<'_> {
    /// How far the posterior of `fit` lies from the priors.
    ///
    /// # Errors
    /// [`InferenceError::Dense`] if a covariance cannot be decomposed.
    pub fn conflict(&self, fit: &Fit, laplace: &Laplace) -> Result<Conflict, InferenceError> {
        let parameters = self.parameters();
        let p = parameters.len();
        let covariance = Matrix::from_fn(p, p, |i, j| laplace.covariance[(i, j)]);
        let z = &fit.working[..p];
        let scores: Vec<[f64; 2]> = parameters.list().iter().zip(z).map(|(q, &z)| q.score(z)).collect();
        let (centre, scales) = (parameters.centre(), parameters.scales());
        let offsets = parameters.list().iter().enumerate().map(|(i, q)| Offset {
            parameter: q.name.clone(),
            unit: q.unit.clone(),
            value: fit.parameters[i],
            sds: scores[i][0],
            carried_sds: parameters.is_tied(i).then(|| (z[i] - centre[i]) / scales[i]),
        });
        let offsets = offsets.collect();
        // Declared priors are independent: standard normal in xi, with slopes dxi/dz.
        let xi: Vec<f64> = scores.iter().map(|s| s[0]).collect();
        let to_xi = Matrix::diagonal(&scores.iter().map(|s| s[1]).collect::<Vec<_>>());
        let declared = tension(&xi, &to_xi, &covariance)?;
        let (mut xi, mut to_xi) = (xi, to_xi);
        for (members, offset, factor) in parameters.joints(z) {
            let white = factor.whiten(&offset);
            let inverse = inverse_of(factor);
            for (k, &i) in members.iter().enumerate() {
                xi[i] = white[k];
                to_xi[(i, i)] = 0.0;
                for (l, &j) in members.iter().enumerate() {
                    to_xi[(i, j)] = inverse[(k, l)];
                }
            }
        }
        let carried = tension(&xi, &to_xi, &covariance)?;
        Ok(Conflict { offsets, declared, carried })
    }
}

/// L^-1.
fn inverse_of(factor: &Cholesky) -> Matrix {
    let n = factor.lower().rows();
    let columns: Vec<Vec<f64>> = (0..n)
        .map(|j| factor.whiten(&(0..n).map(|i| f64::from(u8::from(i == j))).collect::<Vec<_>>()))
        .collect();
    Matrix::from_fn(n, n, |i, j| columns[j][i])
}

/// The posterior mean `xi`, in coordinates in which the prior is standard normal. Before the data it has the
/// covariance I - K, where K is the posterior's: T = sum of c_k^2/(1 - k), over the eigenvectors of K with
/// eigenvalues k below 1 - [`LEARNT`].
fn tension(xi: &[f64], to_xi: &Matrix, covariance: &Matrix) -> Result<Tension, InferenceError> {
    let n = xi.len();
    if n == 0 {
        return Ok(Tension::default());
    }
    let after = to_xi.product(covariance).product(&to_xi.transpose());
    let (values, vectors) = symmetric_eigen(&after)?;
    let (mut chi_squared, mut freedom) = (0.0, 0);
    // A flat prior has no slope: nothing is known of that direction, and nothing contradicted.
    for k in (0..n).filter(|&k| values[k] < 1.0 - LEARNT && values[k] > 0.0) {
        let along: f64 = (0..n).map(|i| vectors[(i, k)] * xi[i]).sum();
        chi_squared += along * along / (1.0 - values[k]);
        freedom += 1;
    }
    let penalty = 0.5 * xi.iter().map(|x| x * x).sum::<f64>();
    Ok(Tension { chi_squared, freedom, sds: chi_squared_sds(chi_squared, freedom), penalty })
}

impl Parameter {
    /// The standard normal number at the same quantile of the declared prior, and its derivative with respect
    /// to the working coordinate.
    ///
    /// Gaussian priors by their formula at any distance. A half-normal says that small is possible: its
    /// number is the distance from zero.
    pub(crate) fn score(&self, z: f64) -> [f64; 2] {
        let [a, slope, _] = self.physical(z);
        match self.prior {
            Prior::Flat => [0.0, 0.0],
            Prior::HalfNormal { sd } => [a / sd, slope / sd],
            prior => {
                let xi = prior.score(a);
                let ln_ratio = prior.ln_density(a)[0] - gaussian(xi, 0.0, 1.0)[0];
                if xi.is_finite() { [xi, slope * ln_ratio.exp()] } else { [xi.signum() * FARTHEST, 0.0] }
            }
        }
    }
}

/// What a value on a bound counts as: the normal number whose tail is the smallest number.
const FARTHEST: f64 = 38.0;
