//! A complex number with its derivative in s.

use crate::C64;
use std::ops::{Add, Mul, Neg, Sub};

/// A value and its derivative with respect to s, where only the first derivative in one variable is wanted:
/// the search for a root. A [`crate::Jet`] carries more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComplexDual {
    /// The value.
    pub value: C64,
    /// d/ds.
    pub slope: C64,
}

impl ComplexDual {
    /// A number that does not depend on s.
    #[must_use]
    pub fn constant(value: C64) -> Self {
        Self { value, slope: C64::ZERO }
    }
    /// A real number that does not depend on s.
    #[must_use]
    pub fn real(value: f64) -> Self {
        Self::constant(C64::new(value, 0.0))
    }
    /// 1/self.
    #[must_use]
    pub fn recip(self) -> Self {
        let value = self.value.inv();
        Self { value, slope: -self.slope * value * value }
    }
}

impl Add for ComplexDual {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { value: self.value + o.value, slope: self.slope + o.slope }
    }
}

impl Sub for ComplexDual {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { value: self.value - o.value, slope: self.slope - o.slope }
    }
}

impl Mul for ComplexDual {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self { value: self.value * o.value, slope: self.value * o.slope + self.slope * o.value }
    }
}

impl Neg for ComplexDual {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self { value: -self.value, slope: -self.slope }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_the_slope_is_that_of_the_value() {
        let f = |s: ComplexDual| {
            let two = ComplexDual::real(2.0);
            -(s * s - two).recip() + s * ComplexDual::constant(C64::new(0.3, 0.1))
        };
        let (s, step) = (C64::new(0.4, 1.3), 1e-5);
        let at = |s: C64, slope: f64| f(ComplexDual { value: s, slope: C64::new(slope, 0.0) });
        let difference = (at(s + step, 0.0).value - at(s - step, 0.0).value) / (2.0 * step);
        assert!((at(s, 1.0).slope - difference).norm() < 1e-9);
        assert_eq!(at(s, 0.0).slope, C64::ZERO);
    }
}
