//! What a drift of the frequency and an excess of damping have in common: a slope that the residuals of a fit
//! without it show, and that several decays tell together.

use crate::dsp::kernels::Powers;
use rijke_numerics::C64;

/// What the residuals `left`, row by row, hold of a mode: the sum over rows and channels of residual,
/// `weight`, amplitude and `wave`. Its real part tells a change of the size of the mode, its imaginary part
/// with the other sign one of the phase.
pub(super) fn seen(left: &[f64], amplitudes: &[C64], wave: &Powers, weight: impl Fn(usize) -> f64) -> C64 {
    let mut sum = C64::ZERO;
    for (n, row) in left.chunks_exact(amplitudes.len()).enumerate() {
        let (mut re, mut im) = (0.0, 0.0);
        for (r, b) in row.iter().zip(amplitudes) {
            re += r * b.re;
            im += r * b.im;
        }
        let weight = weight(n);
        sum.re += weight * (re * wave.re[n] - im * wave.im[n]);
        sum.im += weight * (re * wave.im[n] + im * wave.re[n]);
    }
    sum
}

/// Several decays with the standard deviation of a slope of each.
pub(super) struct Several<'a, T> {
    all: &'a [T],
    sd: fn(&T) -> f64,
    total: f64,
}

impl<'a, T> Several<'a, T> {
    /// None if nothing is known of the slope of any.
    pub(super) fn of(all: &'a [T], sd: fn(&T) -> f64) -> Option<Self> {
        let total = all.iter().map(|one| sd(one).powi(-2)).sum();
        (total > 0.0).then_some(Self { all, sd, total })
    }

    /// Standard deviation of the slope that they have in common.
    pub(super) fn sd(&self) -> f64 {
        self.total.sqrt().recip()
    }

    /// Mean of a value of theirs, by the inverse of the variances of their slopes.
    pub(super) fn mean(&self, value: fn(&T) -> f64) -> f64 {
        self.all.iter().map(|one| (self.sd)(one).powi(-2) * value(one)).sum::<f64>() / self.total
    }
}
