//! A value with its derivative in s.

use rijke_numerics::C64;
use std::ops::{Add, Mul, Sub};

/// A value and its derivative with respect to s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Dual {
    pub(crate) v: C64,
    pub(crate) d: C64,
}

impl Dual {
    pub(crate) fn constant(v: C64) -> Self {
        Self { v, d: C64::ZERO }
    }
    pub(crate) fn real(v: f64) -> Self {
        Self::constant(C64::new(v, 0.0))
    }
    pub(crate) fn recip(self) -> Self {
        let r = self.v.inv();
        Self { v: r, d: -self.d * r * r }
    }
}

impl Add for Dual {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { v: self.v + o.v, d: self.d + o.d }
    }
}

impl Sub for Dual {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { v: self.v - o.v, d: self.d - o.d }
    }
}

impl Mul for Dual {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self { v: self.v * o.v, d: self.v * o.d + self.d * o.v }
    }
}
