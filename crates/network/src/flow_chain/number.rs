//! The two numbers that a flow chain is computed in: value and slope in s for searches, jets for parameters.

use crate::laws::Law;
use crate::plane::dual::Dual;
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

impl Neg for Dual {
    type Output = Self;
    fn neg(self) -> Self {
        Self { v: -self.v, d: -self.d }
    }
}

impl Number for Dual {
    fn like(&self, value: C64) -> Self {
        Self::constant(value)
    }
    fn value(&self) -> C64 {
        self.v
    }
    fn compose(&self, [f, slope, _]: [C64; 3]) -> Self {
        Self { v: f, d: slope * self.d }
    }
}

/// A jet with the operators of a number.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Seeded(pub(crate) Jet);

impl Add for Seeded {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self(&self.0 + &o.0)
    }
}

impl Sub for Seeded {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self(&self.0 - &o.0)
    }
}

impl Mul for Seeded {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Self(&self.0 * &o.0)
    }
}

impl Neg for Seeded {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-&self.0)
    }
}

impl Number for Seeded {
    fn like(&self, value: C64) -> Self {
        let zeros = |n: usize| vec![C64::ZERO; n];
        let (first, second) = (self.0.gradient().len(), self.0.hessian_packed().len());
        Self(Jet::from_parts(value, zeros(first), zeros(second)))
    }
    fn value(&self) -> C64 {
        self.0.value()
    }
    fn compose(&self, [f, slope, curvature]: [C64; 3]) -> Self {
        Self(self.0.compose(f, slope, curvature))
    }
}
