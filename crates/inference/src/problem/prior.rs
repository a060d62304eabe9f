//! What is known of one number before the data: a probability density.

use crate::numbers::{normal_cdf, normal_quantile};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A probability density of a physical value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Prior {
    /// Gaussian.
    Normal {
        /// Mean.
        mean: f64,
        /// Standard deviation.
        sd: f64,
    },
    /// ln of the value is Gaussian.
    LogNormal {
        /// Median of the value.
        median: f64,
        /// Standard deviation of its natural logarithm.
        ln_sd: f64,
    },
    /// Constant between two bounds.
    Uniform {
        /// Lower bound.
        low: f64,
        /// Upper bound.
        high: f64,
    },
    /// The modulus of a Gaussian number of mean zero: a scale that may be small.
    HalfNormal {
        /// Standard deviation of that Gaussian.
        sd: f64,
    },
    /// Gaussian within two bounds.
    Truncated {
        /// Mean before truncation.
        mean: f64,
        /// Standard deviation before truncation.
        sd: f64,
        /// Lower bound.
        low: f64,
        /// Upper bound.
        high: f64,
    },
    /// Constant everywhere: improper, so that parameters can be fitted but no evidence exists.
    Flat,
}

impl Prior {
    /// Where the density is not zero.
    #[must_use]
    pub fn bounds(&self) -> (f64, f64) {
        match *self {
            Self::Normal { .. } | Self::Flat => (f64::NEG_INFINITY, f64::INFINITY),
            Self::LogNormal { .. } | Self::HalfNormal { .. } => (0.0, f64::INFINITY),
            Self::Uniform { low, high } | Self::Truncated { low, high, .. } => (low, high),
        }
    }

    /// ln of the density of the physical value, with its first two derivatives; the value must lie within the
    /// bounds.
    #[must_use]
    pub fn ln_density(&self, a: f64) -> [f64; 3] {
        match *self {
            Self::Normal { mean, sd } => gaussian(a, mean, sd),
            Self::LogNormal { median, ln_sd } => {
                let [p, p1, p2] = gaussian(a.ln(), median.ln(), ln_sd);
                [p - a.ln(), (p1 - 1.0) / a, (p2 - p1 + 1.0) / (a * a)]
            }
            Self::Uniform { low, high } => [-(high - low).ln(), 0.0, 0.0],
            Self::HalfNormal { sd } => {
                let [p, p1, p2] = gaussian(a, 0.0, sd);
                [p + 2_f64.ln(), p1, p2]
            }
            Self::Truncated { mean, sd, low, high } => {
                let [p, p1, p2] = gaussian(a, mean, sd);
                [p - truncated_mass(mean, sd, low, high).ln(), p1, p2]
            }
            Self::Flat => [0.0; 3],
        }
    }

    /// The physical value below which the prior holds the probability `p`; NaN for [`Prior::Flat`] except at
    /// the median, which is taken as zero so that a fit has a start.
    #[must_use]
    pub fn quantile(&self, p: f64) -> f64 {
        match *self {
            Self::Normal { mean, sd } => mean + sd * normal_quantile(p),
            Self::LogNormal { median, ln_sd } => median * (ln_sd * normal_quantile(p)).exp(),
            Self::Uniform { low, high } => low + p * (high - low),
            Self::HalfNormal { .. } | Self::Truncated { .. } => self.of_score(normal_quantile(p))[0],
            Self::Flat => {
                if p == 0.5 {
                    0.0
                } else {
                    f64::NAN
                }
            }
        }
    }

    /// The same prior with its width multiplied by `factor` about the same centre: the standard deviation,
    /// that of the logarithm, or the distance between the bounds.
    #[must_use]
    pub fn widened(&self, factor: f64) -> Self {
        match *self {
            Self::Normal { mean, sd } => Self::Normal { mean, sd: factor * sd },
            Self::LogNormal { median, ln_sd } => Self::LogNormal { median, ln_sd: factor * ln_sd },
            Self::Uniform { low, high } => {
                let (centre, half) = (0.5 * (low + high), 0.5 * factor * (high - low));
                Self::Uniform { low: centre - half, high: centre + half }
            }
            Self::HalfNormal { sd } => Self::HalfNormal { sd: factor * sd },
            Self::Truncated { mean, sd, low, high } => Self::Truncated { mean, sd: factor * sd, low, high },
            Self::Flat => Self::Flat,
        }
    }

    /// What is wrong with its numbers, if anything.
    pub(super) fn problem(&self) -> Option<String> {
        let positive = |name: &str, v: f64| {
            (!(v > 0.0 && v.is_finite())).then(|| format!("{name} = {v}, but it must be positive and finite"))
        };
        let finite = |name: &str, v: f64| (!v.is_finite()).then(|| format!("{name} = {v} is not finite"));
        let ordered = |low: f64, high: f64| {
            (low.partial_cmp(&high) != Some(std::cmp::Ordering::Less))
                .then(|| format!("the lower bound {low} is not below the upper bound {high}"))
        };
        match *self {
            Self::Normal { mean, sd } => finite("mean", mean).or_else(|| positive("sd", sd)),
            Self::LogNormal { median, ln_sd } => {
                positive("median", median).or_else(|| positive("ln_sd", ln_sd))
            }
            Self::Uniform { low, high } => {
                finite("low", low).or_else(|| finite("high", high)).or_else(|| ordered(low, high))
            }
            Self::HalfNormal { sd } => positive("sd", sd),
            Self::Truncated { mean, sd, low, high } => {
                finite("mean", mean).or_else(|| positive("sd", sd)).or_else(|| ordered(low, high)).or_else(
                    || positive("the prior mass between the bounds", truncated_mass(mean, sd, low, high)),
                )
            }
            Self::Flat => None,
        }
    }
}

/// ln of a normal density, with its first two derivatives.
pub(crate) fn gaussian(x: f64, mean: f64, sd: f64) -> [f64; 3] {
    let t = (x - mean) / sd;
    [-0.5 * t * t - sd.ln() - 0.5 * (2.0 * PI).ln(), -t / sd, -1.0 / (sd * sd)]
}

pub(super) fn truncated_mass(mean: f64, sd: f64, low: f64, high: f64) -> f64 {
    let (a, b) = ((low - mean) / sd, (high - mean) / sd);
    if a > 0.0 { normal_cdf(-a) - normal_cdf(-b) } else { normal_cdf(b) - normal_cdf(a) }
}
