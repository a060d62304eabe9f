//! The numbers that formulas run on: jets, and values with their slope in s.

use rijke_numerics::{C64, ComplexDual, Jet};

/// A number that a formula can be run on: a jet, or a value with its derivative in s.
pub(crate) trait Analytic: Clone {
    /// The value alone.
    fn value(&self) -> C64;
    /// f(self), given f and its first two derivatives at the value.
    fn compose(&self, derivatives: [C64; 3]) -> Self;
    fn plus(&self, other: &Self) -> Self;
    fn minus(&self, other: &Self) -> Self;
    fn times(&self, other: &Self) -> Self;
    fn scale(&self, factor: C64) -> Self;
    fn shift(&self, constant: C64) -> Self;
    /// Real part, imaginary part and conjugate: for what depends on real seeds alone.
    fn re(&self) -> Self;
    fn im(&self) -> Self;
    fn conj(&self) -> Self;
}

/// An operand: most of them carry no derivative, and are cheaper as plain numbers.
pub(crate) enum Operand<T> {
    Number(C64),
    Full(T),
}

impl Analytic for Jet {
    fn value(&self) -> C64 {
        Jet::value(self)
    }
    fn compose(&self, [f, slope, curvature]: [C64; 3]) -> Self {
        Jet::compose(self, f, slope, curvature)
    }
    fn plus(&self, other: &Self) -> Self {
        self + other
    }
    fn minus(&self, other: &Self) -> Self {
        self - other
    }
    fn times(&self, other: &Self) -> Self {
        self * other
    }
    fn scale(&self, factor: C64) -> Self {
        Jet::scale(self, factor)
    }
    fn shift(&self, constant: C64) -> Self {
        Jet::shift(self, constant)
    }
    fn re(&self) -> Self {
        Jet::re(self)
    }
    fn im(&self) -> Self {
        Jet::im(self)
    }
    fn conj(&self) -> Self {
        Jet::conj(self)
    }
}

/// A linear map of the value, and so of the slope.
#[inline]
fn each(number: &ComplexDual, f: impl Fn(C64) -> C64) -> ComplexDual {
    ComplexDual { value: f(number.value), slope: f(number.slope) }
}

impl Analytic for ComplexDual {
    #[inline]
    fn value(&self) -> C64 {
        self.value
    }
    #[inline]
    fn compose(&self, [f, slope, _]: [C64; 3]) -> Self {
        Self { value: f, slope: slope * self.slope }
    }
    #[inline]
    fn plus(&self, other: &Self) -> Self {
        *self + *other
    }
    #[inline]
    fn minus(&self, other: &Self) -> Self {
        *self - *other
    }
    #[inline]
    fn times(&self, other: &Self) -> Self {
        *self * *other
    }
    #[inline]
    fn scale(&self, factor: C64) -> Self {
        each(self, |z| factor * z)
    }
    #[inline]
    fn shift(&self, constant: C64) -> Self {
        Self { value: self.value + constant, ..*self }
    }
    #[inline]
    fn re(&self) -> Self {
        each(self, |z| C64::new(z.re, 0.0))
    }
    #[inline]
    fn im(&self) -> Self {
        each(self, |z| C64::new(z.im, 0.0))
    }
    #[inline]
    fn conj(&self) -> Self {
        each(self, |z| z.conj())
    }
}
