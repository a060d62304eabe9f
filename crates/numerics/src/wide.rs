//! Complex numbers side by side in the registers of the machine.

use crate::C64;
use pulp::Simd;
use std::ops::{Add, Mul, Sub};

/// As many complex numbers as the machine takes at once; with `pulp::Scalar` a single one.
///
/// Functions of it must be inlined where `pulp` dispatches, and hold no closures, so that they become its
/// instructions.
#[derive(Clone, Copy, Debug)]
pub struct Wide<S: Simd> {
    pub(crate) simd: S,
    /// Real parts.
    pub re: S::f64s,
    /// Imaginary parts.
    pub im: S::f64s,
}

impl<S: Simd> Wide<S> {
    /// From real and imaginary parts.
    #[inline(always)]
    pub fn new(simd: S, re: S::f64s, im: S::f64s) -> Self {
        Self { simd, re, im }
    }

    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(simd: S, z: C64) -> Self {
        Self::new(simd, simd.splat_f64s(z.re), simd.splat_f64s(z.im))
    }

    /// Each number times a real one of its own.
    #[inline(always)]
    #[must_use]
    pub fn scale(self, by: S::f64s) -> Self {
        Self::new(self.simd, self.simd.mul_f64s(self.re, by), self.simd.mul_f64s(self.im, by))
    }

    /// |z|^2.
    #[inline(always)]
    pub fn norm_sqr(self) -> S::f64s {
        self.simd.mul_add_e_f64s(self.re, self.re, self.simd.mul_f64s(self.im, self.im))
    }

    /// 1/z.
    #[inline(always)]
    #[must_use]
    pub fn recip(self) -> Self {
        let one = self.simd.splat_f64s(1.0);
        let conjugate = Self::new(self.simd, self.re, self.simd.neg_f64s(self.im));
        conjugate.scale(self.simd.div_f64s(one, self.norm_sqr()))
    }

    /// The polynomial with real ascending coefficients: the remainder after division by the quadratic factor
    /// x^2 - 2 x Re z + |z|^2 is its value at z, for two real products a term (Knuth, Seminumerical
    /// Algorithms, 4.6.4, (3)).
    #[inline(always)]
    #[must_use]
    pub fn polynomial(self, coefficients: &[f64]) -> Self {
        let simd = self.simd;
        let (twice, square) = (simd.add_f64s(self.re, self.re), self.norm_sqr());
        let (mut b, mut before) = (simd.splat_f64s(0.0), simd.splat_f64s(0.0));
        for &a in coefficients.iter().skip(1).rev() {
            let less = simd.negate_mul_add_e_f64s(square, before, simd.splat_f64s(a));
            (b, before) = (simd.mul_add_e_f64s(twice, b, less), b);
        }
        let first = simd.splat_f64s(coefficients.first().copied().unwrap_or(0.0));
        let constant = simd.negate_mul_add_e_f64s(square, before, first);
        Self::new(simd, simd.mul_add_e_f64s(self.re, b, constant), simd.mul_f64s(self.im, b))
    }
}

impl<S: Simd> Add for Wide<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self::new(self.simd, self.simd.add_f64s(self.re, o.re), self.simd.add_f64s(self.im, o.im))
    }
}

impl<S: Simd> Sub for Wide<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self::new(self.simd, self.simd.sub_f64s(self.re, o.re), self.simd.sub_f64s(self.im, o.im))
    }
}

impl<S: Simd> Mul for Wide<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        let simd = self.simd;
        Self::new(
            simd,
            simd.negate_mul_add_e_f64s(self.im, o.im, simd.mul_f64s(self.re, o.re)),
            simd.mul_add_e_f64s(self.im, o.re, simd.mul_f64s(self.re, o.im)),
        )
    }
}
