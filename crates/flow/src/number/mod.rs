//! Numbers the kernels are written for: plain, carrying first derivatives, or several side by side.
//!
//! Knows no equation: a kernel is written once for any [`Number`], and the caller chooses what it carries.

mod dual;
mod lanes;

pub use dual::Dual;
pub use lanes::Lanes;

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A real number of the flow's equations: `f64`, a [`Dual`] that carries derivatives, or [`Lanes`] of several
/// states that are computed side by side.
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
    /// The same number everywhere, without derivatives.
    fn constant(value: f64) -> Self;

    /// f(self), from f and f' at the value.
    #[must_use]
    fn map(self, f: impl Fn(f64) -> (f64, f64)) -> Self;

    /// Two functions at once, each with its slope.
    #[must_use]
    fn map2(self, f: impl Fn(f64) -> [(f64, f64); 2]) -> (Self, Self);

    /// The number itself, or the sum of all lanes: what books of energy add up.
    fn total(self) -> f64;

    /// Square root.
    #[must_use]
    #[inline]
    fn sqrt(self) -> Self {
        self.map(|v| {
            let root = v.sqrt();
            (root, 0.5 / root)
        })
    }

    /// 1/self.
    #[must_use]
    #[inline]
    fn recip(self) -> Self {
        self.map(|v| {
            let inverse = v.recip();
            (inverse, -inverse * inverse)
        })
    }

    /// Exponential.
    #[must_use]
    #[inline]
    fn exp(self) -> Self {
        self.map(|v| {
            let e = v.exp();
            (e, e)
        })
    }

    /// Natural logarithm.
    #[must_use]
    #[inline]
    fn ln(self) -> Self {
        self.map(|v| (v.ln(), v.recip()))
    }

    /// self^{2/3} of a positive number.
    #[must_use]
    #[inline]
    fn two_thirds(self) -> Self {
        self.map(|v| {
            let root = v.cbrt();
            (root * root, 2.0 / (3.0 * root))
        })
    }
}

/// One number, alone or with its derivatives.
///
/// An implicit equation (the mass flow) is solved in plain numbers; its root then enters once more as
/// [`Single::unknown`], and [`Single::settle`] replaces the derivative with respect to it by what the
/// implicit function theorem says.
pub trait Single: Number {
    /// Derivative of the root of an implicit equation.
    type Slope: Copy;

    /// Whether the number carries derivatives at all.
    const DERIVATIVES: bool;

    /// The number itself.
    fn value(self) -> f64;

    /// The root of an implicit equation, as a variable of its own.
    fn unknown(value: f64) -> Self;

    /// How the root moves, from the residual at the root.
    fn slope(residual: Self) -> Self::Slope;

    /// A quantity that depends on the root, once the root's movement is known.
    #[must_use]
    fn settle(self, slope: &Self::Slope) -> Self;
}

impl Number for f64 {
    #[inline]
    fn constant(value: f64) -> Self {
        value
    }
    #[inline]
    fn map(self, f: impl Fn(f64) -> (f64, f64)) -> Self {
        f(self).0
    }
    #[inline]
    fn map2(self, f: impl Fn(f64) -> [(f64, f64); 2]) -> (Self, Self) {
        let [a, b] = f(self);
        (a.0, b.0)
    }
    #[inline]
    fn total(self) -> f64 {
        self
    }
}

impl Single for f64 {
    type Slope = ();
    const DERIVATIVES: bool = false;
    #[inline]
    fn value(self) -> f64 {
        self
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
