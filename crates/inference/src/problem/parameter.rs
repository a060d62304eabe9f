//! One unknown number: its name, its unit, its prior, and the coordinate in which it is sought.

use super::prior::{Prior, gaussian};
use crate::error::InferenceError;
use serde::{Deserialize, Serialize};

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
}

/// The working coordinate z of a physical value a.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Coordinates {
    /// z = a. With bounds, a step across them is refused.
    Natural,
    /// a = e^z, for positive values.
    Log,
    /// z is the standard normal number at the quantile of a, so that the prior is a standard normal
    /// density: for values with bounds. Where the data say nothing, the posterior is Gaussian exactly.
    Score,
}

/// Deviations over which a Gaussian is summed, and nodes on either side.
const REACH: f64 = 6.0;
const NODES: i32 = 40;

impl Parameter {
    /// A parameter in the coordinate natural to its prior: ln for log-normal ones, the standard normal
    /// number for other bounded ones, the value itself otherwise.
    pub fn new(
        name: impl Into<String>,
        symbol: impl Into<String>,
        unit: impl Into<String>,
        prior: Prior,
    ) -> Self {
        let coordinates = match prior {
            Prior::Normal { .. } | Prior::Flat => Coordinates::Natural,
            Prior::LogNormal { .. } => Coordinates::Log,
            Prior::HalfNormal { .. } | Prior::Uniform { .. } | Prior::Truncated { .. } => Coordinates::Score,
        };
        let (name, symbol, unit) = (name.into(), symbol.into(), unit.into());
        Self { name, symbol, unit, prior, coordinates }
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

    /// The physical value and its first two derivatives with respect to the working coordinate.
    #[must_use]
    pub fn physical(&self, z: f64) -> [f64; 3] {
        match self.coordinates {
            Coordinates::Natural => [z, 1.0, 0.0],
            Coordinates::Log => [z.exp(); 3],
            Coordinates::Score => self.prior.of_score(z),
        }
    }

    /// The standard deviation of the physical value, from that which its posterior has `to_first_order`
    /// about the most probable `value`.
    ///
    /// Where values have bounds, the first order overstates the width, and so does the width of a Gaussian
    /// in the working coordinate: the former where the data say little, the latter beside a bound. The
    /// smaller of the two is taken. Of a truncated Gaussian it is within a sixth of the exact one.
    #[must_use]
    pub fn sd_about(&self, value: f64, to_first_order: f64) -> f64 {
        if self.coordinates != Coordinates::Score {
            return to_first_order;
        }
        let z = self.working(value);
        let width = to_first_order / self.physical(z)[1];
        // Trapezoids converge as fast as for any function that is smooth and falls off.
        let mut sums = [0.0; 3];
        for k in -NODES..=NODES {
            let x = REACH * f64::from(k) / f64::from(NODES);
            let (weight, a) = ((-0.5 * x * x).exp(), self.physical(z + width * x)[0] - value);
            sums = [sums[0] + weight, sums[1] + weight * a, sums[2] + weight * a * a];
        }
        let [sum, first, second] = sums;
        let sd = (second / sum - (first / sum).powi(2)).sqrt();
        if sd.is_finite() { sd.min(to_first_order) } else { to_first_order }
    }

    /// The values between which the physical one lies with a probability of 68 %, for a posterior that is
    /// Gaussian in the working coordinate with the standard deviation `to_first_order` about `value`: never
    /// beyond a bound.
    #[must_use]
    pub fn interval_about(&self, value: f64, to_first_order: f64) -> [f64; 2] {
        let z = self.working(value);
        let width = to_first_order / self.physical(z)[1];
        [z - width, z + width].map(|z| self.physical(z)[0])
    }

    /// The working coordinate of a physical value; not finite at or beyond a bound.
    #[must_use]
    pub fn working(&self, value: f64) -> f64 {
        match self.coordinates {
            Coordinates::Natural => value,
            Coordinates::Log => value.ln(),
            Coordinates::Score => self.prior.score(value),
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
            Coordinates::Score => return Ok(gaussian(z, 0.0, 1.0)),
        };
        Ok([p + j, p1 * t1 + j1, p2 * t1 * t1 + p1 * t2 + j2])
    }

    /// The working coordinate at which a fit starts (the prior median) and the scale over which the prior
    /// changes, infinite for [`Prior::Flat`].
    #[must_use]
    pub fn start(&self) -> (f64, f64) {
        let centre = self.working(self.prior.quantile(0.5));
        let scale = match (self.prior, self.coordinates) {
            (Prior::Flat, _) => f64::INFINITY,
            (Prior::Normal { sd, .. }, Coordinates::Natural) => sd,
            (Prior::LogNormal { ln_sd, .. }, Coordinates::Log) => ln_sd,
            (_, Coordinates::Score) => 1.0,
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
    /// [`InferenceError::BadPrior`], [`InferenceError::PriorScale`] for a number whose square or inverse
    /// leaves double precision.
    pub fn validate(&self) -> Result<(), InferenceError> {
        let problem = self.prior.problem().or_else(|| {
            let (low, high) = self.prior.bounds();
            match self.coordinates {
                Coordinates::Log if low != 0.0 || high.is_finite() => {
                    Some("the coordinate ln needs the bounds 0 and infinity".to_owned())
                }
                Coordinates::Score if self.prior == Prior::Flat => {
                    Some("a flat prior has no quantiles".to_owned())
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
