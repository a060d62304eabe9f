//! What a fit of exponentials has found.

use super::component::Component;
use super::sums::{lengths, phasors};
use super::white::White;
use crate::Fault;
use crate::dsp::kernels::{Powers, run};
use pulp::NullaryFnOnce;
use rijke_numerics::{C64, Cholesky, Matrix};
use rijke_rig::ModeRows;

/// The maximum of the likelihood and its curvature.
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    pub(crate) components: Vec<Component>,
    /// Amplitude of each component in each white channel at the first sample.
    pub(crate) amplitudes: Vec<Vec<C64>>,
    /// Sum of squares left over.
    pub(crate) residual: f64,
    /// Number of white samples less number of parameters.
    pub(crate) freedom: f64,
    /// Covariance of the free frequencies for unit noise, in the order of `free`.
    pub(crate) covariance: Matrix,
    /// Inverse of the Gram matrix of the linear columns.
    pub(super) linear: Matrix,
    /// Derivative of the linear coefficients of each channel with respect to the free frequencies.
    pub(super) sensitivity: Vec<Matrix>,
    /// The free frequencies: `(component, direction)`, direction 0 growth rate, 1 frequency, 2 chirp,
    /// 3 excess of damping.
    pub(super) free: Vec<(usize, usize)>,
}

impl Solution {
    /// Estimated variance of the white noise; 1 if the whitener was right.
    pub(crate) fn variance(&self) -> f64 {
        self.residual / self.freedom
    }

    /// Sum over the white channels of the squared moduli of the first component's amplitudes.
    pub(crate) fn strength(&self) -> f64 {
        self.amplitudes[0].iter().map(C64::norm_sqr).sum()
    }

    /// How many numbers were fitted: amplitudes and free frequencies.
    pub(crate) fn numbers(&self) -> usize {
        2 * self.components.len() * self.sensitivity.len() + self.free.len()
    }

    /// Of the chirp (direction 2) or the excess (3) of the first component: its variance and its covariance
    /// with the frequency or the growth rate, for unit noise.
    pub(crate) fn curve_covariance(&self, direction: usize) -> Option<[f64; 2]> {
        let place = |direction: usize| self.free.iter().position(|&p| p == (0, direction));
        let (straight, curve) = (place(3 - direction)?, place(direction)?);
        Some([self.covariance[(curve, curve)], self.covariance[(straight, curve)]])
    }

    /// The first component at `rows` samples from the first one of the fit on, for the amplitude 1.
    pub(crate) fn wave(&self, rows: usize, step: f64) -> Powers {
        phasors(&self.components[0], 0.0, rows, step).0
    }

    /// As [`super::energies`], at the frequencies found.
    pub(crate) fn energies(&self) -> Result<Vec<f64>, Fault> {
        energies_of(&self.linear, |k, m| self.amplitudes[k][m], self.sensitivity.len())
    }

    /// Covariance, for unit noise, of (growth rate, frequency) of mode `k` and of the real and imaginary
    /// parts of its white amplitudes, channel by channel.
    pub(crate) fn mode_covariance(&self, k: usize) -> Matrix {
        let channels = self.sensitivity.len();
        let free = &self.free;
        let rows: Vec<usize> = (0..2).filter_map(|d| free.iter().position(|&p| p == (k, d))).collect();
        // Rows of the map from free frequencies to the numbers wanted.
        let map = Matrix::from_fn(ModeRows::count(channels), free.len(), |i, j| {
            if i < 2 {
                f64::from(u8::from(rows.get(i) == Some(&j)))
            } else {
                self.sensitivity[(i - 2) / 2][(2 * k + (i - 2) % 2, j)]
            }
        });
        let mut covariance = map.product(&self.covariance).product(&map.transpose());
        for m in 0..channels {
            let first = ModeRows::pressure(m);
            for i in 0..2 {
                for j in 0..2 {
                    covariance[(first + i, first + j)] += self.linear[(2 * k + i, 2 * k + j)];
                }
            }
        }
        covariance
    }

    /// Residuals of the samples of `white`, whose first row is sample `first` of the fit.
    pub(crate) fn residuals(&self, white: White<'_>, first: f64) -> Vec<f64> {
        let mut left = white.samples.to_vec();
        let lengths = lengths(&self.components, usize::MAX, white.step);
        for ((component, amplitudes), length) in self.components.iter().zip(&self.amplitudes).zip(lengths) {
            let rows = white.rows().min((length as f64 - first).max(0.0) as usize);
            let (phasors, start) = phasors(component, first, rows, white.step);
            let amplitudes: Vec<C64> = amplitudes.iter().map(|a| a * start).collect();
            run(Subtract { left: &mut left, amplitudes: &amplitudes, phasors: &phasors });
        }
        left
    }
}

/// Takes Re(b_m z^n) out of channel m of interleaved samples.
struct Subtract<'a> {
    left: &'a mut [f64],
    amplitudes: &'a [C64],
    phasors: &'a Powers,
}

impl NullaryFnOnce for Subtract<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let rows = self.left.chunks_exact_mut(self.amplitudes.len());
        for ((row, re), im) in rows.zip(&self.phasors.re).zip(&self.phasors.im) {
            for (value, amplitude) in row.iter_mut().zip(self.amplitudes) {
                *value -= amplitude.re * re - amplitude.im * im;
            }
        }
    }
}

/// The energies of [`super::energies`] from the inverse Gram matrix and the amplitude of component k in
/// channel m.
pub(super) fn energies_of(
    linear: &Matrix,
    amplitude: impl Fn(usize, usize) -> C64,
    channels: usize,
) -> Result<Vec<f64>, Fault> {
    let energy = |k: usize| {
        let information = Cholesky::new(&linear.select(&[2 * k, 2 * k + 1]))?.inverse();
        let of = |m: usize| {
            let a = amplitude(k, m);
            information.quadratic(&[a.re, a.im])
        };
        Ok((0..channels).map(of).sum())
    };
    (0..linear.rows() / 2).map(energy).collect()
}
