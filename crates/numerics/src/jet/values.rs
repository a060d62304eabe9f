//! Complex numbers that carry their first and second derivatives.

use super::order::{Order, packed};
use crate::C64;

/// A complex value with its gradient and Hessian with respect to the seeds of a [`crate::JetSpace`].
///
/// A seed is either a real variable or a complex variable in which everything is analytic (the Laplace
/// variable s). Every function here except [`Jet::conj`], [`Jet::re`], [`Jet::im`] and [`Jet::abs`] is
/// analytic; those four hold only where the jet depends on real seeds alone, which is for the caller to know.
///
/// Cost of a product in n seeds: O(n) to first order, O(n^2) to second. Jets of different spaces must not be
/// mixed; doing so is a programming error.
#[derive(Clone, Debug, PartialEq)]
pub struct Jet {
    pub(super) value: C64,
    pub(super) gradient: Vec<C64>,
    /// Lower triangle, row by row: (0,0), (1,0), (1,1), (2,0), ...
    pub(super) hessian: Vec<C64>,
}

impl Jet {
    /// The value.
    #[must_use]
    pub fn value(&self) -> C64 {
        self.value
    }

    /// First derivatives, one per seed; empty when the order is [`Order::Value`].
    #[must_use]
    pub fn gradient(&self) -> &[C64] {
        &self.gradient
    }

    /// Second derivative with respect to seeds `i` and `j`; zero when second derivatives are not carried.
    #[must_use]
    pub fn hessian(&self, i: usize, j: usize) -> C64 {
        self.hessian.get(packed(i, j)).copied().unwrap_or(C64::ZERO)
    }

    /// The lower triangle of the Hessian, row by row; empty below [`Order::Second`].
    #[must_use]
    pub fn hessian_packed(&self) -> &[C64] {
        &self.hessian
    }

    /// The highest derivative that it carries in its seeds.
    #[must_use]
    pub fn order(&self) -> Order {
        match (self.gradient.is_empty(), self.hessian.is_empty()) {
            (true, _) => Order::Value,
            (false, true) => Order::First,
            (false, false) => Order::Second,
        }
    }

    /// The same jet from its parts; `hessian` is the lower triangle, row by row.
    #[must_use]
    pub fn from_parts(value: C64, gradient: Vec<C64>, hessian: Vec<C64>) -> Self {
        Self { value, gradient, hessian }
    }

    /// f(self), given f and its first and second derivative at the value (Faa di Bruno to second order).
    #[must_use]
    pub fn compose(&self, f: C64, slope: C64, curvature: C64) -> Self {
        let gradient: Vec<C64> = self.gradient.iter().map(|g| slope * g).collect();
        let mut hessian: Vec<C64> = self.hessian.iter().map(|h| slope * h).collect();
        if !hessian.is_empty() {
            let mut k = 0;
            for i in 0..self.gradient.len() {
                for j in 0..=i {
                    hessian[k] += curvature * self.gradient[i] * self.gradient[j];
                    k += 1;
                }
            }
        }
        Self { value: f, gradient, hessian }
    }

    /// Product with a constant.
    #[must_use]
    pub fn scale(&self, factor: C64) -> Self {
        self.map_linear(|z| factor * z)
    }

    /// Sum with a constant.
    #[must_use]
    pub fn shift(&self, constant: C64) -> Self {
        Self { value: self.value + constant, ..self.clone() }
    }

    /// 1/self.
    #[must_use]
    pub fn recip(&self) -> Self {
        let r = self.value.inv();
        self.compose(r, -r * r, 2.0 * r * r * r)
    }

    /// e^self.
    #[must_use]
    pub fn exp(&self) -> Self {
        let e = self.value.exp();
        self.compose(e, e, e)
    }

    /// Natural logarithm, principal branch.
    #[must_use]
    pub fn ln(&self) -> Self {
        let r = self.value.inv();
        self.compose(self.value.ln(), r, -r * r)
    }

    /// Square root, principal branch.
    #[must_use]
    pub fn sqrt(&self) -> Self {
        let root = self.value.sqrt();
        let slope = 0.5 * root.inv();
        self.compose(root, slope, -0.5 * slope / self.value)
    }

    /// Sine.
    #[must_use]
    pub fn sin(&self) -> Self {
        let (s, c) = (self.value.sin(), self.value.cos());
        self.compose(s, c, -s)
    }

    /// Cosine.
    #[must_use]
    pub fn cos(&self) -> Self {
        let (s, c) = (self.value.sin(), self.value.cos());
        self.compose(c, -s, -c)
    }

    /// Hyperbolic tangent.
    #[must_use]
    pub fn tanh(&self) -> Self {
        const FAR: f64 = 20.0; // from overflow of the one, and from rounding of the other
        let (t, slope) = if self.value.re.abs() < FAR {
            let t = self.value.tanh();
            (t, 1.0 - t * t)
        } else {
            let sign = self.value.re.signum();
            let small = (-2.0 * sign * self.value).exp();
            let over = (1.0 + small).inv();
            (sign * (1.0 - small) * over, 4.0 * small * over * over)
        };
        self.compose(t, slope, -2.0 * t * slope)
    }

    /// Integer power.
    #[must_use]
    pub fn powi(&self, n: i32) -> Self {
        let (k, z) = (f64::from(n), self.value);
        let slope = if n == 0 { C64::ZERO } else { k * z.powi(n - 1) };
        let curvature = if n == 0 || n == 1 { C64::ZERO } else { k * (k - 1.0) * z.powi(n - 2) };
        self.compose(z.powi(n), slope, curvature)
    }

    /// Constant real power, principal branch.
    #[must_use]
    pub fn powf(&self, p: f64) -> Self {
        let z = self.value;
        self.compose(z.powf(p), p * z.powf(p - 1.0), p * (p - 1.0) * z.powf(p - 2.0))
    }

    /// Complex conjugate; valid only in real seeds.
    #[must_use]
    pub fn conj(&self) -> Self {
        self.map_linear(|z| z.conj())
    }

    /// Real part; valid only in real seeds.
    #[must_use]
    pub fn re(&self) -> Self {
        self.map_linear(|z| C64::new(z.re, 0.0))
    }

    /// Imaginary part (a real number); valid only in real seeds.
    #[must_use]
    pub fn im(&self) -> Self {
        self.map_linear(|z| C64::new(z.im, 0.0))
    }

    /// Modulus; valid only in real seeds, and not differentiable at zero.
    #[must_use]
    pub fn abs(&self) -> Self {
        (self * &self.conj()).re().sqrt()
    }

    /// Adds `factor` times `other`.
    pub fn add_scaled(&mut self, other: &Self, factor: C64) {
        self.value += factor * other.value;
        let both = self.gradient.iter_mut().zip(&other.gradient);
        both.chain(self.hessian.iter_mut().zip(&other.hessian)).for_each(|(a, b)| *a += factor * b);
    }

    pub(super) fn map_linear(&self, f: impl Fn(C64) -> C64) -> Self {
        Self {
            value: f(self.value),
            gradient: self.gradient.iter().map(|&z| f(z)).collect(),
            hessian: self.hessian.iter().map(|&z| f(z)).collect(),
        }
    }

    pub(super) fn zip(&self, other: &Self, f: impl Fn(C64, C64) -> C64) -> Self {
        let pairs = |a: &[C64], b: &[C64]| a.iter().zip(b).map(|(&x, &y)| f(x, y)).collect();
        Self {
            value: f(self.value, other.value),
            gradient: pairs(&self.gradient, &other.gradient),
            hessian: pairs(&self.hessian, &other.hessian),
        }
    }
}
