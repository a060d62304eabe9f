//! A model error that is a smooth random function of one coordinate, say of frequency.

use serde::{Deserialize, Serialize};

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
        self.correlation_in_length(x, length)[0]
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
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_kernels_have_their_derivatives_in_the_length() {
        for kernel in [Kernel::SquaredExponential, Kernel::Matern52, Kernel::Matern32] {
            for x in [0.0, 0.2, 1.0, 2.7] {
                let (u, h): (f64, f64) = (0.3, 1e-4);
                let at = |u: f64| kernel.correlation(x, u.exp());
                let [_, first, second] = kernel.correlation_in_length(x, u.exp());
                assert!((first - (at(u + h) - at(u - h)) / (2.0 * h)).abs() < 1e-7, "{kernel:?} {x}");
                let bend = (at(u + h) - 2.0 * at(u) + at(u - h)) / (h * h);
                assert!((second - bend).abs() < 1e-6, "{kernel:?} {x}");
            }
        }
    }
}
