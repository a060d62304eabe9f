//! Numbers the kernels are written for: plain, or carrying first derivatives.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A real number of the flow's equations: `f64`, or a [`Dual`] that carries derivatives.
///
/// An implicit equation (the mass flow) is solved in plain numbers; its root then enters once more as
/// [`Number::unknown`], and [`Number::settle`] replaces the derivative with respect to it by what the implicit function
/// theorem says.
pub trait Number:
    Copy
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    /// Derivative of the root of an implicit equation.
    type Slope: Copy;

    /// Whether the number carries derivatives at all.
    const DERIVATIVES: bool;

    /// A number without derivatives.
    fn constant(value: f64) -> Self;

    /// The number itself.
    fn value(self) -> f64;

    /// f(self), from f and f' at the value.
    #[must_use]
    fn compose(self, value: f64, slope: f64) -> Self;

    /// The root of an implicit equation, as a variable of its own.
    fn unknown(value: f64) -> Self;

    /// How the root moves, from the residual at the root.
    fn slope(residual: Self) -> Self::Slope;

    /// A quantity that depends on the root, once the root's movement is known.
    #[must_use]
    fn settle(self, slope: &Self::Slope) -> Self;

    /// Square root.
    #[must_use]
    fn sqrt(self) -> Self {
        let root = self.value().sqrt();
        self.compose(root, 0.5 / root)
    }

    /// 1/self.
    #[must_use]
    fn recip(self) -> Self {
        let inverse = self.value().recip();
        self.compose(inverse, -inverse * inverse)
    }

    /// Exponential.
    #[must_use]
    fn exp(self) -> Self {
        let e = self.value().exp();
        self.compose(e, e)
    }

    /// Natural logarithm.
    #[must_use]
    fn ln(self) -> Self {
        self.compose(self.value().ln(), self.value().recip())
    }

    /// self^{2/3} of a positive number.
    #[must_use]
    fn two_thirds(self) -> Self {
        let root = self.value().cbrt();
        self.compose(root * root, 2.0 / (3.0 * root))
    }
}

impl Number for f64 {
    type Slope = ();
    const DERIVATIVES: bool = false;
    #[inline]
    fn constant(value: f64) -> Self {
        value
    }
    fn value(self) -> f64 {
        self
    }
    #[inline]
    fn compose(self, value: f64, _: f64) -> Self {
        value
    }
    fn unknown(value: f64) -> Self {
        value
    }
    fn slope(_: Self) {}
    #[inline]
    fn settle(self, (): &()) -> Self {
        self
    }
}

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
    fn zip(self, other: Self, value: f64, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut slopes = self.slopes;
        for (s, o) in slopes.iter_mut().zip(other.slopes) {
            *s = f(*s, o);
        }
        Self { value, slopes }
    }
}

impl<const P: usize> Number for Dual<P> {
    type Slope = [f64; P];
    const DERIVATIVES: bool = true;
    #[inline]
    fn constant(value: f64) -> Self {
        Self { value, slopes: [0.0; P] }
    }
    fn value(self) -> f64 {
        self.value
    }
    #[inline]
    fn compose(self, value: f64, slope: f64) -> Self {
        Self { value, slopes: self.slopes.map(|s| slope * s) }
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
