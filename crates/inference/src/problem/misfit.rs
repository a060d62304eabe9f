//! A model error that is a smooth random function of one coordinate, say of frequency.

use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// How smooth the error is: its correlation at distance x, for the length l.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kernel {
    /// exp(-x^2/(2 l^2)): all derivatives exist.
    SquaredExponential,
    /// (1 + s + s^2/3) exp(-s), s = 5^1/2 x/l: two derivatives.
    Matern52,
    /// (1 + s) exp(-s), s = 3^1/2 x/l: one derivative.
    Matern32,
}

impl Kernel {
    /// Correlation at distance `x`.
    #[must_use]
    pub fn correlation(self, x: f64, length: f64) -> f64 {
        let x = x.abs() / length;
        match self {
            Self::SquaredExponential => (-0.5 * x * x).exp(),
            Self::Matern52 => {
                let s = 5_f64.sqrt() * x;
                (1.0 + s + s * s / 3.0) * (-s).exp()
            }
            Self::Matern32 => {
                let s = 3_f64.sqrt() * x;
                (1.0 + s) * (-s).exp()
            }
        }
    }

    /// Correlation at distance `x`, and its first two derivatives with respect to ln of the length.
    pub(crate) fn correlation_in_length(self, x: f64, length: f64) -> [f64; 3] {
        let x = x.abs() / length;
        // With c(s) and s falling as 1/length: dc/du = -s c', d2c/du2 = s c' + s^2 c''.
        match self {
            Self::SquaredExponential => {
                let (square, c) = (x * x, (-0.5 * x * x).exp());
                [c, square * c, (square * square - 2.0 * square) * c]
            }
            Self::Matern52 => {
                let s = 5_f64.sqrt() * x;
                let e = (-s).exp();
                // c' = -s (1 + s)/3 e^-s, c'' = (s^2 - s - 1)/3 e^-s.
                let (c1, c2) = (-s * (1.0 + s) / 3.0 * e, (s * s - s - 1.0) / 3.0 * e);
                [(1.0 + s + s * s / 3.0) * e, -s * c1, s * c1 + s * s * c2]
            }
            Self::Matern32 => {
                let s = 3_f64.sqrt() * x;
                let e = (-s).exp();
                let (c1, c2) = (-s * e, (s - 1.0) * e);
                [(1.0 + s) * e, -s * c1, s * c1 + s * s * c2]
            }
        }
    }

    /// ln of the spectral density at the angular frequency `w` (its integral over 2 pi is one), and its first
    /// two derivatives with respect to ln of the length (Rasmussen & Williams 2006, equations 4.10 and 4.15).
    fn ln_spectrum(self, w: f64, length: f64) -> [f64; 3] {
        let nu2 = match self {
            Self::SquaredExponential => {
                let square = (w * length).powi(2);
                return [0.5 * (2.0 * PI).ln() + length.ln() - 0.5 * square, 1.0 - square, -2.0 * square];
            }
            Self::Matern52 => 5.0,
            Self::Matern32 => 3.0,
        };
        let a = nu2 / (length * length);
        let constant =
            2.0_f64.ln() + 0.5 * PI.ln() + libm::lgamma(0.5 * (nu2 + 1.0)) - libm::lgamma(0.5 * nu2);
        let ln = constant + 0.5 * nu2 * a.ln() - 0.5 * (nu2 + 1.0) * (a + w * w).ln();
        let share = a / (a + w * w);
        [ln, (nu2 + 1.0) * share - nu2, -2.0 * (nu2 + 1.0) * share * (1.0 - share)]
    }

    /// Functions that the shortest length needs, per half of the range in units of that length (Riutort-Mayol
    /// et al. 2023, Stat. Comput. 33, 17, equations 13 to 15: 1.75, 2.65, 3.42), half as many again.
    fn density(self) -> f64 {
        1.5 * match self {
            Self::SquaredExponential => 1.75,
            Self::Matern52 => 2.65,
            Self::Matern32 => 3.42,
        }
    }
}

/// Sines on an interval twice and a half as long as the range of the data, whose coefficients are independent
/// (Solin & Sarkka 2020, Stat. Comput. 30, 419): a random function of any length between `shortest` and about
/// 0.7 of half the range.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Basis {
    pub(crate) kernel: Kernel,
    centre: f64,
    half: f64,
    pub(crate) count: usize,
}

/// Half the interval over half the range.
const BEYOND: f64 = 2.5;

impl Basis {
    pub(crate) fn new(kernel: Kernel, low: f64, high: f64, shortest: f64) -> Self {
        let range = 0.5 * (high - low);
        let half = BEYOND * range;
        let count = (kernel.density() * half / shortest).ceil() as usize;
        Self { kernel, centre: 0.5 * (low + high), half, count: count.max(4) }
    }

    /// The functions at `x`.
    pub(crate) fn at(&self, x: f64) -> impl Iterator<Item = f64> {
        let angle = PI * (x - self.centre + self.half) / (2.0 * self.half);
        let size = self.half.sqrt().recip();
        (1..=self.count).map(move |j| size * (j as f64 * angle).sin())
    }

    /// ln of the variance of each coefficient for a standard deviation of one, with two derivatives with
    /// respect to ln of the length.
    pub(crate) fn ln_variances(&self, length: f64) -> Vec<[f64; 3]> {
        let w = |j: usize| j as f64 * PI / (2.0 * self.half);
        (1..=self.count).map(|j| self.kernel.ln_spectrum(w(j), length)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oracle_the_basis_gives_the_kernel() {
        let cases =
            [(Kernel::SquaredExponential, 1e-3), (Kernel::Matern52, 4e-3), (Kernel::Matern32, 1.2e-2)];
        for (kernel, accuracy) in cases {
            let basis = Basis::new(kernel, 100.0, 300.0, 10.0);
            let mut worst: f64 = 0.0;
            for length in [10.0, 20.0, 50.0, 70.0] {
                let variances = basis.ln_variances(length);
                for (x, y) in [(100.0, 100.0), (100.0, 103.0), (180.0, 195.0), (220.0, 290.0), (300.0, 300.0)]
                {
                    let sum: f64 = basis
                        .at(x)
                        .zip(basis.at(y))
                        .zip(&variances)
                        .map(|((a, b), v)| a * b * v[0].exp())
                        .sum();
                    worst = worst.max((sum - kernel.correlation(x - y, length)).abs());
                }
            }
            println!("{kernel:?}: {} functions, {worst:.1e}", basis.count);
            assert!(worst < accuracy, "{kernel:?}: {worst}");
        }
    }

    #[test]
    fn order_kernels_have_their_derivatives_in_the_length() {
        for kernel in [Kernel::SquaredExponential, Kernel::Matern52, Kernel::Matern32] {
            for x in [0.0, 0.2, 1.0, 2.7] {
                let (u, h): (f64, f64) = (0.3, 1e-4);
                let at = |u: f64| kernel.correlation(x, u.exp());
                let [value, first, second] = kernel.correlation_in_length(x, u.exp());
                assert!((value - at(u)).abs() < 1e-15);
                assert!((first - (at(u + h) - at(u - h)) / (2.0 * h)).abs() < 1e-7, "{kernel:?} {x}");
                let bend = (at(u + h) - 2.0 * at(u) + at(u - h)) / (h * h);
                assert!((second - bend).abs() < 1e-6, "{kernel:?} {x}");
            }
        }
    }

    #[test]
    fn order_spectra_have_their_derivatives() {
        for kernel in [Kernel::SquaredExponential, Kernel::Matern52, Kernel::Matern32] {
            for w in [0.1, 1.0, 3.0] {
                let (u, h): (f64, f64) = (0.3, 1e-4);
                let at = |u: f64| kernel.ln_spectrum(w, u.exp())[0];
                let [_, first, second] = kernel.ln_spectrum(w, u.exp());
                assert!((first - (at(u + h) - at(u - h)) / (2.0 * h)).abs() < 1e-6, "{kernel:?} {w}");
                assert!(
                    (second - (at(u + h) - 2.0 * at(u) + at(u - h)) / (h * h)).abs() < 1e-5,
                    "{kernel:?} {w}"
                );
            }
        }
    }
}
