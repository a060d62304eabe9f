//! Numbers that carry first derivatives.

use super::{Number, Single};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number with P derivatives; the last belongs to the unknown of an implicit equation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<const P: usize> {
    /// The number.
    pub value: f64,
    /// Its derivatives.
    pub slopes: [f64; P],
}

impl<const P: usize> Dual<P> {
    /// The variable number `index`, which must be below P - 1 unless no implicit equation follows.
    #[must_use]
    pub fn variable(value: f64, index: usize) -> Self {
        let mut slopes = [0.0; P];
        slopes[index] = 1.0;
        Self { value, slopes }
    }

    #[inline]
    fn compose(self, (value, slope): (f64, f64)) -> Self {
        Self { value, slopes: self.slopes.map(|s| slope * s) }
    }

    #[inline]
    fn zip(self, other: Self, value: f64, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut slopes = self.slopes;
        for (s, o) in slopes.iter_mut().zip(other.slopes) {
            *s = f(*s, o);
        }
        Self { value, slopes }
    }
}

impl<const P: usize> Number for Dual<P> {
    #[inline]
    fn constant(value: f64) -> Self {
        Self { value, slopes: [0.0; P] }
    }
    #[inline]
    fn map(self, f: impl Fn(f64) -> (f64, f64)) -> Self {
        self.compose(f(self.value))
    }
    #[inline]
    fn map2(self, f: impl Fn(f64) -> [(f64, f64); 2]) -> (Self, Self) {
        let [a, b] = f(self.value);
        (self.compose(a), self.compose(b))
    }
    #[inline]
    fn total(self) -> f64 {
        self.value
    }
}

impl<const P: usize> Single for Dual<P> {
    type Slope = [f64; P];
    const DERIVATIVES: bool = true;
    #[inline]
    fn value(self) -> f64 {
        self.value
    }
    fn unknown(value: f64) -> Self {
        Self::variable(value, P - 1)
    }
    fn slope(residual: Self) -> [f64; P] {
        let mut slope = residual.slopes.map(|r| -r / residual.slopes[P - 1]);
        slope[P - 1] = 0.0;
        slope
    }
    #[inline]
    fn settle(self, slope: &[f64; P]) -> Self {
        let along = self.slopes[P - 1];
        let mut slopes = self.slopes;
        slopes[P - 1] = 0.0;
        for (s, d) in slopes.iter_mut().zip(slope) {
            *s += along * d;
        }
        Self { value: self.value, slopes }
    }
}

impl<const P: usize> Add for Dual<P> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        self.zip(other, self.value + other.value, |a, b| a + b)
    }
}

impl<const P: usize> Sub for Dual<P> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        self.zip(other, self.value - other.value, |a, b| a - b)
    }
}

impl<const P: usize> Mul for Dual<P> {
    type Output = Self;
    #[allow(clippy::suspicious_arithmetic_impl, reason = "the product rule is a sum")]
    #[inline]
    fn mul(self, other: Self) -> Self {
        self.zip(other, self.value * other.value, |a, b| a * other.value + b * self.value)
    }
}

impl<const P: usize> Div for Dual<P> {
    type Output = Self;
    #[inline]
    fn div(self, other: Self) -> Self {
        let (inverse, ratio) = (1.0 / other.value, self.value / other.value);
        self.zip(other, ratio, |a, b| (a - ratio * b) * inverse)
    }
}

impl<const P: usize> Neg for Dual<P> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        self * -1.0
    }
}

impl<const P: usize> Add<f64> for Dual<P> {
    type Output = Self;
    #[inline]
    fn add(self, other: f64) -> Self {
        Self { value: self.value + other, ..self }
    }
}

impl<const P: usize> Sub<f64> for Dual<P> {
    type Output = Self;
    #[inline]
    fn sub(self, other: f64) -> Self {
        Self { value: self.value - other, ..self }
    }
}

impl<const P: usize> Mul<f64> for Dual<P> {
    type Output = Self;
    #[inline]
    fn mul(self, other: f64) -> Self {
        Self { value: self.value * other, slopes: self.slopes.map(|s| s * other) }
    }
}
