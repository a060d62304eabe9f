//! Several plain numbers side by side.

use super::Number;
use std::array::from_fn;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// L plain numbers side by side: the same place of L states of one tube. A march through the cells is a chain
/// of dependent operations, and L chains at once keep the processor busy; every lane has the numbers that it
/// would have alone, to the last bit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lanes<const L: usize>(pub [f64; L]);

impl<const L: usize> Number for Lanes<L> {
    #[inline]
    fn constant(value: f64) -> Self {
        Self([value; L])
    }
    #[inline]
    fn map(self, f: impl Fn(f64) -> (f64, f64)) -> Self {
        Self(self.0.map(|v| f(v).0))
    }
    #[inline]
    fn map2(self, f: impl Fn(f64) -> [(f64, f64); 2]) -> (Self, Self) {
        let both: [[f64; 2]; L] = from_fn(|k| f(self.0[k]).map(|(value, _)| value));
        (Self(both.map(|b| b[0])), Self(both.map(|b| b[1])))
    }
    #[inline]
    fn total(self) -> f64 {
        self.0.iter().sum()
    }
}

impl<const L: usize> Add for Lanes<L> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self(from_fn(|k| self.0[k] + other.0[k]))
    }
}

impl<const L: usize> Sub for Lanes<L> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self(from_fn(|k| self.0[k] - other.0[k]))
    }
}

impl<const L: usize> Mul for Lanes<L> {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        Self(from_fn(|k| self.0[k] * other.0[k]))
    }
}

impl<const L: usize> Div for Lanes<L> {
    type Output = Self;
    #[inline]
    fn div(self, other: Self) -> Self {
        Self(from_fn(|k| self.0[k] / other.0[k]))
    }
}

impl<const L: usize> Neg for Lanes<L> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self(self.0.map(|v| -v))
    }
}

impl<const L: usize> Add<f64> for Lanes<L> {
    type Output = Self;
    #[inline]
    fn add(self, other: f64) -> Self {
        Self(self.0.map(|v| v + other))
    }
}

impl<const L: usize> Sub<f64> for Lanes<L> {
    type Output = Self;
    #[inline]
    fn sub(self, other: f64) -> Self {
        Self(self.0.map(|v| v - other))
    }
}

impl<const L: usize> Mul<f64> for Lanes<L> {
    type Output = Self;
    #[inline]
    fn mul(self, other: f64) -> Self {
        Self(self.0.map(|v| v * other))
    }
}
