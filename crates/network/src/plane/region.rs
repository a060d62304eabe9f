//! A rectangle of the s-plane.

use crate::error::NetworkError;
use rijke_numerics::C64;

/// A rectangle of the s-plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Limits of the growth rate, 1/s.
    pub sigma: [f64; 2],
    /// Limits of the angular frequency, rad/s. Laws with square roots of s or open ends need both above zero.
    pub omega: [f64; 2],
}

impl Region {
    /// Refuses limits that do not increase or are not finite.
    pub(crate) fn check(&self) -> Result<(), NetworkError> {
        let Self { sigma: [left, right], omega: [low, high] } = *self;
        if left < right && low < high && [left, right, low, high].iter().all(|v| v.is_finite()) {
            Ok(())
        } else {
            Err(NetworkError::Region { sigma: self.sigma, omega: self.omega })
        }
    }

    /// Whether `s` lies inside or on the border.
    #[must_use]
    pub fn contains(&self, s: C64) -> bool {
        (self.sigma[0]..=self.sigma[1]).contains(&s.re) && (self.omega[0]..=self.omega[1]).contains(&s.im)
    }

    /// The region with a margin on all sides, 1/s.
    #[must_use]
    pub fn widened(&self, margin: f64) -> Self {
        let wide = |[low, high]: [f64; 2]| [low - margin, high + margin];
        Self { sigma: wide(self.sigma), omega: wide(self.omega) }
    }
}
