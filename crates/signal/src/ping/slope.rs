//! A curve that the residuals of a plain fit show: that of a drift of the frequency, of an excess of damping,
//! or of a loudspeaker that comes to rest. Several decays tell of it together.

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

/// What is left of e^{-kt} at right angles to 1 and t under e^{-2ct}, as the fit of a decay c leaves it.
pub(super) struct Curve {
    pub(super) values: Vec<f64>,
    /// The slope that was taken out, 1/s.
    pub(super) slope: f64,
    /// The sum of the squares of what is left.
    pub(super) spread: f64,
}

impl Curve {
    pub(super) fn of(k: f64, decay: f64, rows: usize, step: f64) -> Self {
        let (fall, own) = ((-decay * step).exp(), (-k * step).exp());
        let (mut fallen, mut curve, mut m, mut f) = (1.0, 1.0, [0.0; 3], [0.0; 2]);
        for n in 0..rows {
            let (t, weight) = (n as f64 * step, fallen * fallen);
            m = [m[0] + weight, m[1] + weight * t, m[2] + weight * t * t];
            f = [f[0] + weight * curve, f[1] + weight * curve * t];
            (fallen, curve) = (fallen * fall, curve * own);
        }
        let slope = (f[1] * m[0] - f[0] * m[1]) / (m[2] * m[0] - m[1] * m[1]);
        let level = (f[0] - slope * m[1]) / m[0];
        let (mut values, mut spread) = (Vec::with_capacity(rows), 0.0);
        (fallen, curve) = (1.0, 1.0);
        for n in 0..rows {
            let q = curve - slope * (n as f64 * step) - level;
            spread += (q * fallen).powi(2);
            values.push(q);
            (fallen, curve) = (fallen * fall, curve * own);
        }
        Self { values, slope, spread }
    }
}
