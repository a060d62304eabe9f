//! One unknown number: its name, its unit, and what is known of it before the data.

use crate::{InferenceError, Repeat, normal_cdf, normal_quantile};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// One real unknown.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// Name in files and tables, unique within a model.
    pub name: String,
    /// Symbol in print.
    pub symbol: String,
    /// Unit of the physical value; "1" if it has none.
    pub unit: String,
    /// What is known before the data.
    pub prior: Prior,
    /// The coordinate in which the posterior is taken to be Gaussian.
    pub coordinates: Coordinates,
    /// Where the model repeats itself if this value alone changes, so that a second maximum is looked for there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub repeats: Option<Repeat>,
}

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

/// The working coordinate z of a physical value a.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Coordinates {
    /// z = a. With bounds, a step across them is refused.
    Natural,
    /// a = e^z, for positive values.
    Log,
    /// a = low + (high - low) / (1 + e^-z), for values between two bounds.
    Logit,
}

impl Parameter {
    /// A parameter in the coordinate natural to its prior: ln for log-normal and half-normal, logit for bounded ones, the value itself otherwise.
    pub fn new(
        name: impl Into<String>,
        symbol: impl Into<String>,
        unit: impl Into<String>,
        prior: Prior,
    ) -> Self {
        let coordinates = match prior {
            Prior::Normal { .. } | Prior::Flat => Coordinates::Natural,
            Prior::LogNormal { .. } | Prior::HalfNormal { .. } => Coordinates::Log,
            Prior::Uniform { .. } | Prior::Truncated { .. } => Coordinates::Logit,
        };
        let (name, symbol, unit) = (name.into(), symbol.into(), unit.into());
        Self { name, symbol, unit, prior, coordinates, repeats: None }
    }

    /// A complex unknown as two reals, called `name.re` and `name.im`.
    #[must_use]
    pub fn complex(name: &str, symbol: &str, unit: &str, re: Prior, im: Prior) -> [Self; 2] {
        [
            Self::new(format!("{name}.re"), format!("Re {symbol}"), unit, re),
            Self::new(format!("{name}.im"), format!("Im {symbol}"), unit, im),
        ]
    }

    /// The same parameter in another working coordinate.
    #[must_use]
    pub fn in_coordinates(self, coordinates: Coordinates) -> Self {
        Self { coordinates, ..self }
    }

    /// The same parameter, of which the model repeats itself every `period`: a delay of a wave.
    #[must_use]
    pub fn repeating(self, period: f64) -> Self {
        Self { repeats: Some(Repeat::Period(period)), ..self }
    }

    /// The same parameter, of which the model is the same on the other side of `about`.
    #[must_use]
    pub fn mirrored(self, about: f64) -> Self {
        Self { repeats: Some(Repeat::Mirror(about)), ..self }
    }

    /// The physical value and its first two derivatives with respect to the working coordinate.
    #[must_use]
    pub fn physical(&self, z: f64) -> [f64; 3] {
        match self.coordinates {
            Coordinates::Natural => [z, 1.0, 0.0],
            Coordinates::Log => [z.exp(); 3],
            Coordinates::Logit => {
                let ((low, high), [s, slope, curvature]) = (self.prior.bounds(), logistic(z));
                [low + (high - low) * s, (high - low) * slope, (high - low) * curvature]
            }
        }
    }

    /// The working coordinate of a physical value; not finite at or beyond a bound.
    #[must_use]
    pub fn working(&self, value: f64) -> f64 {
        match self.coordinates {
            Coordinates::Natural => value,
            Coordinates::Log => value.ln(),
            Coordinates::Logit => {
                let (low, high) = self.prior.bounds();
                ((value - low) / (high - value)).ln()
            }
        }
    }

    /// ln of the prior density *in the working coordinate*, and its first two derivatives.
    ///
    /// # Errors
    /// [`InferenceError::OutsideBounds`], which is recoverable.
    pub fn ln_density(&self, z: f64) -> Result<[f64; 3], InferenceError> {
        let [a, t1, t2] = self.physical(z);
        let (low, high) = self.prior.bounds();
        if !(low..=high).contains(&a) {
            return Err(InferenceError::OutsideBounds { parameter: self.name.clone(), value: a, low, high });
        }
        if let (Prior::LogNormal { median, ln_sd }, Coordinates::Log) = (self.prior, self.coordinates) {
            // The Jacobian of the logarithm cancels; said directly, so that the Gaussian is exact.
            return Ok(gaussian(z, median.ln(), ln_sd));
        }
        let [p, p1, p2] = self.prior.ln_density(a);
        // ln |da/dz| and its derivatives.
        let [j, j1, j2] = match self.coordinates {
            Coordinates::Natural => [0.0; 3],
            Coordinates::Log => [z, 1.0, 0.0],
            Coordinates::Logit => {
                let [s, slope, _] = logistic(z);
                // ln(s (1 - s)) written so that neither factor underflows to zero.
                let ln_slope = -z.abs() - 2.0 * (-z.abs()).exp().ln_1p();
                [(high - low).ln() + ln_slope, 1.0 - 2.0 * s, -2.0 * slope]
            }
        };
        Ok([p + j, p1 * t1 + j1, p2 * t1 * t1 + p1 * t2 + j2])
    }

    /// The working coordinate at which a fit starts (the prior median) and the scale over which the prior changes,
    /// infinite for [`Prior::Flat`].
    #[must_use]
    pub fn start(&self) -> (f64, f64) {
        let centre = self.working(self.prior.quantile(0.5));
        let scale = match (self.prior, self.coordinates) {
            (Prior::Flat, _) => f64::INFINITY,
            (Prior::Normal { sd, .. }, Coordinates::Natural) => sd,
            (Prior::LogNormal { ln_sd, .. }, Coordinates::Log) => ln_sd,
            // Half the distance between the central 68 % quantiles, as for a Gaussian.
            (prior, _) => {
                0.5 * (self.working(prior.quantile(0.841_345)) - self.working(prior.quantile(0.158_655)))
            }
        };
        (centre, scale)
    }

    /// Fails if the numbers of the prior contradict each other or the coordinate.
    ///
    /// # Errors
    /// [`InferenceError::BadPrior`], [`InferenceError::PriorScale`] for a number whose square or inverse leaves double precision,
    /// [`InferenceError::BadAlias`] for a period that is no number or zero.
    pub fn validate(&self) -> Result<(), InferenceError> {
        if let Some(Repeat::Period(value) | Repeat::Mirror(value)) = self.repeats
            && !(value.is_finite() && (value != 0.0 || matches!(self.repeats, Some(Repeat::Mirror(_)))))
        {
            return Err(InferenceError::BadAlias { parameter: self.name.clone(), value });
        }
        let problem = self.prior.problem().or_else(|| {
            let (low, high) = self.prior.bounds();
            match self.coordinates {
                Coordinates::Log if low != 0.0 || high.is_finite() => {
                    Some("the coordinate ln needs the bounds 0 and infinity".to_owned())
                }
                Coordinates::Logit if !(low.is_finite() && high.is_finite()) => {
                    Some("the coordinate logit needs two finite bounds".to_owned())
                }
                _ => None,
            }
        });
        problem.map_or(Ok(()), |problem| {
            Err(InferenceError::BadPrior { parameter: self.name.clone(), problem })
        })?;
        self.prior.in_range(&self.name)
    }
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

    /// ln of the density of the physical value, with its first two derivatives; the value must lie within the bounds.
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

    /// The physical value below which the prior holds the probability `p`; NaN for [`Prior::Flat`] except at the
    /// median, which is taken as zero so that a fit has a start.
    #[must_use]
    pub fn quantile(&self, p: f64) -> f64 {
        match *self {
            Self::Normal { mean, sd } => mean + sd * normal_quantile(p),
            Self::LogNormal { median, ln_sd } => median * (ln_sd * normal_quantile(p)).exp(),
            Self::Uniform { low, high } => low + p * (high - low),
            Self::HalfNormal { sd } => -sd * normal_quantile(0.5 * (1.0 - p)),
            Self::Truncated { mean, sd, low, high } => {
                // Work in the tail that is further from one, where the distribution function keeps its digits.
                let (a, b) = ((low - mean) / sd, (high - mean) / sd);
                let standard = if a > 0.0 {
                    -normal_quantile((1.0 - p) * normal_cdf(-a) + p * normal_cdf(-b))
                } else {
                    normal_quantile((1.0 - p) * normal_cdf(a) + p * normal_cdf(b))
                };
                (mean + sd * standard).clamp(low, high)
            }
            Self::Flat => {
                if p == 0.5 {
                    0.0
                } else {
                    f64::NAN
                }
            }
        }
    }

    /// The same prior with its width multiplied by `factor` about the same centre: the standard deviation, that of the logarithm,
    /// or the distance between the bounds.
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

    fn problem(&self) -> Option<String> {
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

fn gaussian(x: f64, mean: f64, sd: f64) -> [f64; 3] {
    let t = (x - mean) / sd;
    [-0.5 * t * t - sd.ln() - 0.5 * (2.0 * PI).ln(), -t / sd, -1.0 / (sd * sd)]
}

fn logistic(z: f64) -> [f64; 3] {
    let s = if z >= 0.0 { 1.0 / (1.0 + (-z).exp()) } else { z.exp() / (1.0 + z.exp()) };
    let slope = s * (1.0 - s);
    [s, slope, slope * (1.0 - 2.0 * s)]
}

fn truncated_mass(mean: f64, sd: f64, low: f64, high: f64) -> f64 {
    let (a, b) = ((low - mean) / sd, (high - mean) / sd);
    if a > 0.0 { normal_cdf(-a) - normal_cdf(-b) } else { normal_cdf(b) - normal_cdf(a) }
}
