//! The slow background of a short stretch of record.

use super::kernels::{add_scaled_inline, dot_inline, run};
use pulp::NullaryFnOnce;

/// Gram's orthogonal polynomials of degree 0 to 2 over the samples of a stretch, of unit length.
#[derive(Clone, Debug)]
pub(crate) struct Parabola([Vec<f64>; 3]);

impl Parabola {
    pub(crate) fn new(samples: usize) -> Self {
        let n = samples as f64;
        let u = |i: usize| i as f64 - 0.5 * (n - 1.0);
        let shift = (n * n - 1.0) / 12.0;
        let norms = [n, n * shift, n * shift * (n * n - 4.0) / 15.0];
        let unit = |degree: usize, value: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let scale = norms[degree].max(f64::MIN_POSITIVE).sqrt().recip();
            (0..samples).map(|i| scale * value(u(i))).collect()
        };
        Self([unit(0, &|_| 1.0), unit(1, &|u| u), unit(2, &|u| u * u - shift)])
    }

    /// Subtracts from `column` its least-squares parabola.
    pub(crate) fn remove(&self, column: &mut [f64]) {
        struct Remove<'a>(&'a Parabola, &'a mut [f64]);
        impl NullaryFnOnce for Remove<'_> {
            type Output = ();
            #[inline(always)]
            fn call(self) {
                self.0.remove_inline(self.1);
            }
        }
        run(Remove(self, column));
    }

    #[inline(always)]
    pub(crate) fn remove_inline(&self, column: &mut [f64]) {
        let shares = self.0.each_ref().map(|unit| dot_inline(unit, column));
        for (unit, share) in self.0.iter().zip(shares) {
            add_scaled_inline(column, -share, unit);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_parabola_vanishes_and_what_is_left_is_orthogonal_to_it() {
        let parabola = Parabola::new(93);
        let mut curve: Vec<f64> =
            (0..93).map(|i| 3.0 - 0.2 * f64::from(i) + 0.01 * f64::from(i * i)).collect();
        parabola.remove(&mut curve);
        assert!(curve.iter().all(|v| v.abs() < 1e-11));
        let mut tone: Vec<f64> = (0..93).map(|i| (0.4 * f64::from(i)).sin()).collect();
        parabola.remove(&mut tone);
        for degree in 0..3 {
            let moment: f64 = (0..93).map(|i| tone[i] * (i as f64 / 93.0).powi(degree)).sum();
            assert!(moment.abs() < 1e-12);
        }
    }
}
