//! The standard normal number at the quantile of a value: the coordinate in which any prior is standard
//! normal.

use super::prior::{Prior, gaussian, truncated_mass};
use crate::numbers::{normal_cdf, normal_quantile};
use std::f64::consts::{FRAC_PI_2, SQRT_2};

/// Probability below which a quantile of a half-normal is a straight line, to rounding.
const STRAIGHT: f64 = 1e-6;

impl Prior {
    /// The value whose standard normal number is `z`, with its first two derivatives in z: with F the
    /// distribution and p its density, a = F^-1(Phi(z)), a' = phi(z)/p(a), a'' = -a' (z + a' (ln p)'(a)).
    /// NaN for [`Prior::Flat`].
    #[must_use]
    pub fn of_score(&self, z: f64) -> [f64; 3] {
        let (below, above) = (normal_cdf(z), normal_cdf(-z));
        let a = match *self {
            Self::Normal { mean, sd } => mean + sd * z,
            Self::LogNormal { median, ln_sd } => median * (ln_sd * z).exp(),
            // Written from the nearer bound, so that the distance to it keeps its digits.
            Self::Uniform { low, high } if z < 0.0 => low + (high - low) * below,
            Self::Uniform { low, high } => high - (high - low) * above,
            Self::HalfNormal { sd } if below < STRAIGHT => sd * FRAC_PI_2.sqrt() * below,
            Self::HalfNormal { sd } => -sd * normal_quantile(0.5 * above),
            Self::Truncated { mean, sd, low, high } => {
                let (l, h) = ((low - mean) / sd, (high - mean) / sd);
                // From the smaller of both tails, which keeps its digits.
                let less = above * normal_cdf(l) + below * normal_cdf(h);
                let more = above * normal_cdf(-l) + below * normal_cdf(-h);
                let standard = if more < less { -normal_quantile(more) } else { normal_quantile(less) };
                (mean + sd * standard).max(low).min(high)
            }
            Self::Flat => f64::NAN,
        };
        let [ln_p, ln_slope, _] = self.ln_density(a);
        let slope = (gaussian(z, 0.0, 1.0)[0] - ln_p).exp();
        [a, slope, -slope * (z + slope * ln_slope)]
    }

    /// The standard normal number at the quantile of a value; not finite at or beyond a bound, NaN for
    /// [`Prior::Flat`].
    #[must_use]
    pub fn score(&self, a: f64) -> f64 {
        let between = |below: f64, above: f64| {
            if below < above { normal_quantile(below) } else { -normal_quantile(above) }
        };
        match *self {
            Self::Normal { mean, sd } => (a - mean) / sd,
            Self::LogNormal { median, ln_sd } => (a / median).ln() / ln_sd,
            Self::Uniform { low, high } => between((a - low) / (high - low), (high - a) / (high - low)),
            Self::HalfNormal { sd } => between(libm::erf(a / sd / SQRT_2), 2.0 * normal_cdf(-a / sd)),
            Self::Truncated { mean, sd, low, high } => {
                let [l, x, h] = [low, a, high].map(|v| (v - mean) / sd);
                let mass = |from: f64, to: f64| truncated_mass(0.0, 1.0, from, to);
                let whole = mass(l, h);
                between(mass(l, x) / whole, mass(x, h) / whole)
            }
            Self::Flat => f64::NAN,
        }
    }
}
