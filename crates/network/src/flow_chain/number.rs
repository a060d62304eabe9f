//! The two numbers that a flow chain is computed in: value and slope in s for searches, jets for parameters.

use crate::laws::Law;
use rijke_numerics::ComplexDual;
use rijke_numerics::{C64, Jet};
use std::ops::{Add, Mul, Neg, Sub};

/// A complex number that carries derivatives.
pub(crate) trait Number:
    Clone + PartialEq + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
    /// A constant with the same seeds.
    fn like(&self, value: C64) -> Self;
    fn value(&self) -> C64;
    /// f(self) from f, f' and f'' at the value.
    fn compose(&self, f: [C64; 3]) -> Self;

    fn real(&self, value: f64) -> Self {
        self.like(C64::new(value, 0.0))
    }
    fn times(&self, factor: f64) -> Self {
        self.clone() * self.real(factor)
    }
    fn recip(&self) -> Self {
        let r = self.value().inv();
        self.compose([r, -r * r, 2.0 * r * r * r])
    }
    fn over(&self, other: &Self) -> Self {
        self.clone() * other.recip()
    }
    fn exp(&self) -> Self {
        let e = self.value().exp();
        self.compose([e, e, e])
    }
    fn ln(&self) -> Self {
        let r = self.value().inv();
        self.compose([self.value().ln(), r, -r * r])
    }
    fn sqrt(&self) -> Self {
        let root = self.value().sqrt();
        let slope = 0.5 * root.inv();
        self.compose([root, slope, -0.5 * slope / self.value()])
    }
    /// A law of s; `self` is s.
    fn law(&self, law: &Law) -> Self {
        self.compose(law.analytic(self.value()))
    }
}

impl Number for ComplexDual {
    fn like(&self, value: C64) -> Self {
        Self::constant(value)
    }
    fn value(&self) -> C64 {
        self.value
    }
    fn compose(&self, [f, slope, _]: [C64; 3]) -> Self {
        Self { value: f, slope: slope * self.slope }
    }
}

/// A jet, or a constant: most numbers of a chain depend on no parameter, and what they multiply need only be
/// scaled.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Seeded {
    Fixed(C64),
    Varying(Jet),
}

impl Seeded {
    /// Of a jet, whose derivatives may all be zero.
    pub(crate) fn new(jet: Jet) -> Self {
        let fixed = jet.gradient().iter().chain(jet.hessian_packed()).all(|d| *d == C64::ZERO);
        if fixed { Self::Fixed(jet.value()) } else { Self::Varying(jet) }
    }

    /// As a jet in the seeds that `s` has.
    pub(crate) fn jet(self, s: &Jet) -> Jet {
        match self {
            Self::Fixed(value) => s.compose(value, C64::ZERO, C64::ZERO),
            Self::Varying(jet) => jet,
        }
    }
}

impl Add for Seeded {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        match (self, o) {
            (Self::Fixed(a), Self::Fixed(b)) => Self::Fixed(a + b),
            (Self::Fixed(a), Self::Varying(mut b)) | (Self::Varying(mut b), Self::Fixed(a)) => {
                b += a;
                Self::Varying(b)
            }
            (Self::Varying(mut a), Self::Varying(b)) => {
                a += &b;
                Self::Varying(a)
            }
        }
    }
}

impl Sub for Seeded {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self + -o
    }
}

impl Mul for Seeded {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        match (self, o) {
            (Self::Fixed(a), Self::Fixed(b)) => Self::Fixed(a * b),
            (Self::Fixed(a), Self::Varying(mut b)) | (Self::Varying(mut b), Self::Fixed(a)) => {
                b *= a;
                Self::Varying(b)
            }
            (Self::Varying(mut a), Self::Varying(b)) => {
                a *= &b;
                Self::Varying(a)
            }
        }
    }
}

impl Neg for Seeded {
    type Output = Self;
    fn neg(self) -> Self {
        match self {
            Self::Fixed(a) => Self::Fixed(-a),
            Self::Varying(a) => Self::Varying(-&a),
        }
    }
}

impl Number for Seeded {
    fn like(&self, value: C64) -> Self {
        Self::Fixed(value)
    }
    fn value(&self) -> C64 {
        match self {
            Self::Fixed(value) => *value,
            Self::Varying(jet) => jet.value(),
        }
    }
    fn compose(&self, [f, slope, curvature]: [C64; 3]) -> Self {
        match self {
            Self::Fixed(_) => Self::Fixed(f),
            Self::Varying(jet) => Self::Varying(jet.compose(f, slope, curvature)),
        }
    }
}
