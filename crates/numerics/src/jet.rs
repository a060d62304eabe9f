//! Complex numbers that carry their first and second derivatives.

use crate::C64;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub};

/// A complex value with its gradient and Hessian with respect to the seeds of a [`JetSpace`].
///
/// A seed is either a real variable or a complex variable in which everything is analytic (the Laplace
/// variable s). Every function here except [`Jet::conj`], [`Jet::re`], [`Jet::im`] and [`Jet::abs`] is
/// analytic; those four hold only where the jet depends on real seeds alone, which is for the caller to know.
///
/// Cost of a product in n seeds: O(n) to first order, O(n^2) to second. Jets of different spaces must not be
/// mixed; doing so is a programming error.
#[derive(Clone, Debug, PartialEq)]
pub struct Jet {
    value: C64,
    gradient: Vec<C64>,
    /// Lower triangle, row by row: (0,0), (1,0), (1,1), (2,0), ...
    hessian: Vec<C64>,
}

/// How many derivatives to carry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Order {
    /// The value alone.
    Value,
    /// Value and gradient.
    First,
    /// Value, gradient and Hessian.
    Second,
}

/// The number of seeds and the order that a family of jets shares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JetSpace {
    seeds: usize,
    order: Order,
}

impl JetSpace {
    /// Jets in `seeds` variables up to `order`.
    #[must_use]
    pub fn new(seeds: usize, order: Order) -> Self {
        Self { seeds, order }
    }

    /// Number of variables.
    #[must_use]
    pub fn seeds(self) -> usize {
        self.seeds
    }

    /// Highest derivative carried.
    #[must_use]
    pub fn order(self) -> Order {
        self.order
    }

    /// A value that depends on no seed.
    #[must_use]
    pub fn constant(self, value: C64) -> Jet {
        let gradient = if self.order >= Order::First { self.seeds } else { 0 };
        let hessian = if self.order == Order::Second { self.seeds * (self.seeds + 1) / 2 } else { 0 };
        Jet { value, gradient: vec![C64::ZERO; gradient], hessian: vec![C64::ZERO; hessian] }
    }

    /// A real value that depends on no seed.
    #[must_use]
    pub fn real(self, value: f64) -> Jet {
        self.constant(C64::new(value, 0.0))
    }

    /// The variable number `index` itself. `index` must be below [`JetSpace::seeds`].
    #[must_use]
    pub fn seed(self, index: usize, value: C64) -> Jet {
        let mut jet = self.constant(value);
        if let Some(slope) = jet.gradient.get_mut(index) {
            *slope = C64::ONE;
        }
        jet
    }
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

    fn map_linear(&self, f: impl Fn(C64) -> C64) -> Self {
        Self {
            value: f(self.value),
            gradient: self.gradient.iter().map(|&z| f(z)).collect(),
            hessian: self.hessian.iter().map(|&z| f(z)).collect(),
        }
    }

    fn zip(&self, other: &Self, f: impl Fn(C64, C64) -> C64) -> Self {
        let pairs = |a: &[C64], b: &[C64]| a.iter().zip(b).map(|(&x, &y)| f(x, y)).collect();
        Self {
            value: f(self.value, other.value),
            gradient: pairs(&self.gradient, &other.gradient),
            hessian: pairs(&self.hessian, &other.hessian),
        }
    }
}

/// Place of (i, j) in a packed lower triangle.
fn packed(i: usize, j: usize) -> usize {
    let (row, column) = if i >= j { (i, j) } else { (j, i) };
    row * (row + 1) / 2 + column
}

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::{remainder_slopes, slopes_near};

    /// A function that uses every operation, of three real variables.
    fn everything(space: JetSpace, x: &[f64]) -> Jet {
        let v: Vec<Jet> = (0..3).map(|i| space.seed(i, C64::new(x[i], 0.0))).collect();
        let z = &v[0] + &v[1].scale(C64::new(0.3, 0.8));
        let w = &(&z.exp() / &z.sqrt()) - &(&v[2] * &z).sin();
        let y = &(&w.ln() * &z.cos()) + &(&v[2].tanh() * &z.powi(3));
        let k = &y.powf(1.7) + &(&z.abs() * &w.conj().re());
        let mut all = &k.shift(C64::new(0.1, 0.2)) + &(-&y.im());
        all.add_scaled(&w, C64::new(0.2, -0.4));
        all
    }

    #[test]
    fn order_remainders_fall_as_h2_and_h3() {
        let (x, direction) = ([0.7, 0.4, 1.1], [0.5, -0.3, 0.8]);
        let jet = everything(JetSpace::new(3, Order::Second), &x);
        let (mut first, mut second) = (C64::ZERO, C64::ZERO);
        for i in 0..3 {
            first += jet.gradient()[i] * direction[i];
            for j in 0..3 {
                second += 0.5 * jet.hessian(i, j) * direction[i] * direction[j];
            }
        }
        let at = |h: f64| {
            let moved: Vec<f64> = x.iter().zip(direction).map(|(x, d)| x + h * d).collect();
            everything(JetSpace::new(3, Order::Value), &moved).value() - jet.value()
        };
        slopes_near(&remainder_slopes(|h| (at(h) - first * h).norm()), 2.0, 0.05);
        slopes_near(&remainder_slopes(|h| (at(h) - first * h - second * h * h).norm()), 3.0, 0.05);
    }

    #[test]
    fn exact_tanh_far_out_is_one() {
        for x in [19.0, 21.0, 1e5, -1e5] {
            let jet = JetSpace::new(1, Order::Second).seed(0, C64::new(x, 0.3)).tanh();
            let [off, slope] = [jet.value() - x.signum(), jet.gradient()[0]];
            assert!(off.norm() < 1e-15 && slope.norm() < 1e-15, "{off} {slope}");
        }
    }

    #[test]
    fn exact_powers_at_zero_are_finite() {
        let jet = JetSpace::new(1, Order::Second).seed(0, C64::ZERO);
        assert_eq!(jet.powi(2).hessian(0, 0), C64::new(2.0, 0.0));
        assert_eq!(jet.powi(1).gradient()[0], C64::ONE);
        assert_eq!(jet.powi(0).gradient()[0], C64::ZERO);
    }
}
