//! Sums, products and quotients of jets.

use super::values::Jet;
use crate::C64;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub};

impl Add for &Jet {
    type Output = Jet;
    fn add(self, other: &Jet) -> Jet {
        self.zip(other, |a, b| a + b)
    }
}

impl Sub for &Jet {
    type Output = Jet;
    fn sub(self, other: &Jet) -> Jet {
        self.zip(other, |a, b| a - b)
    }
}

impl AddAssign<&Jet> for Jet {
    fn add_assign(&mut self, other: &Jet) {
        self.value += other.value;
        let both = self.gradient.iter_mut().zip(&other.gradient);
        both.chain(self.hessian.iter_mut().zip(&other.hessian)).for_each(|(a, b)| *a += b);
    }
}

impl AddAssign<C64> for Jet {
    fn add_assign(&mut self, constant: C64) {
        self.value += constant;
    }
}

impl MulAssign<C64> for Jet {
    fn mul_assign(&mut self, factor: C64) {
        self.value *= factor;
        self.gradient.iter_mut().chain(&mut self.hessian).for_each(|d| *d *= factor);
    }
}

impl MulAssign<&Jet> for Jet {
    fn mul_assign(&mut self, other: &Jet) {
        let (a, b) = (self.value, other.value);
        let mut entries = self.hessian.iter_mut().zip(&other.hessian);
        for (i, (x, y)) in self.gradient.iter().zip(&other.gradient).enumerate() {
            let row = self.gradient.iter().zip(&other.gradient).take(i + 1);
            for ((u, v), (h, k)) in row.zip(entries.by_ref()) {
                *h = b * *h + a * k + (x * v + u * y);
            }
        }
        self.gradient.iter_mut().zip(&other.gradient).for_each(|(x, y)| *x = b * *x + a * y);
        self.value = a * b;
    }
}

impl Mul for &Jet {
    type Output = Jet;
    fn mul(self, other: &Jet) -> Jet {
        let mut product = self.clone();
        product *= other;
        product
    }
}

impl Div for &Jet {
    type Output = Jet;
    #[allow(clippy::suspicious_arithmetic_impl, reason = "a/b is a times 1/b, with the derivatives of both")]
    fn div(self, other: &Jet) -> Jet {
        self * &other.recip()
    }
}

impl Neg for &Jet {
    type Output = Jet;
    fn neg(self) -> Jet {
        self.map_linear(|z| -z)
    }
}
