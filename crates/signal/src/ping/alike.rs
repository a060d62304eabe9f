//! Whether all channels decay alike. A microphone that warms up has a gain that drifts: its amplitude
//! changes beside the decay, and the common growth rate takes a part of it.
//!
//! Let channel m decay with s + delta_m, delta_m real. To first order its amplitude a_m e^{st} gets a part
//! delta_m t a_m e^{st}. In white samples this is the vector d_m t e^{st}, d_m = a_m times column m of
//! W(s). The amplitudes b and the frequency s have been fitted: of t only t - m_1/m_0 is left (moments of
//! e^{2 sigma t}), and of d_m only what is at right angles to b. What the residuals hold of g (t - m_1/m_0)
//! e^{st} is g = S/J with independent errors of variance 1/J in all white channels, however the noise of
//! the record is correlated; delta_m follows from g by least squares. Terms at twice the frequency are left
//! out, and so are the neighbours, as in [`super::chirp`].

use crate::Fault;
use crate::dsp::kernels::Powers;
use rijke_numerics::C64;

/// Standard deviations from which a channel decays otherwise than the others: noise feigns it in one
/// channel of 16 000.
const APART: f64 = 4.0;
/// By how much the channel must explain more of the differences than any other (twice the logarithm of the
/// likelihood), so that it is known which one drifts.
const CLEAR: f64 = 9.0;

/// A fitted decay in white samples.
pub(super) struct Decay<'a> {
    pub(super) s: C64,
    /// White amplitudes at the first row.
    pub(super) white: &'a [C64],
    /// Amplitudes in the record.
    pub(super) amplitudes: &'a [C64],
    /// [`crate::dsp::noise::Whitener::whiten`] at `s`.
    pub(super) whiten: &'a [Vec<C64>],
    /// White residuals, row by row.
    pub(super) left: &'a [f64],
    pub(super) step: f64,
    /// The decay itself, for the amplitude 1.
    pub(super) wave: &'a Powers,
    /// Variance of the white noise.
    pub(super) variance: f64,
}

/// By how much one channel decays otherwise than the others.
struct Apart {
    /// Its growth rate less that of the others, 1/s, and the standard deviation.
    rate: f64,
    sd: f64,
    /// What this moves the common growth rate by, 1/s.
    moved: f64,
}

impl Decay<'_> {
    /// Refuses a decay of which a channel has a growth rate of its own.
    pub(super) fn check(&self) -> Result<(), Fault> {
        let all: Vec<Apart> = self.apart();
        let mut order: Vec<usize> = (0..all.len()).collect();
        let distance = |m: usize| (all[m].rate / all[m].sd).abs();
        order.sort_by(|a, b| distance(*b).total_cmp(&distance(*a)));
        let [first, second, ..] = order[..] else { return Ok(()) };
        if distance(first) < APART {
            return Ok(());
        }
        let Apart { rate, sd, moved } = all[first];
        let distance_of_first = distance(first);
        if distance_of_first.powi(2) < distance(second).powi(2) + CLEAR {
            let channels = [first.min(second), first.max(second)];
            return Err(Fault::GainsApart {
                channels: channels.map(Into::into),
                rate: rate.abs(),
                distance: distance_of_first,
            });
        }
        let others = self.s.re - moved;
        let growth_rates = [others + rate, others];
        Err(Fault::GainDrifts { channel: first.into(), growth_rates, sd, distance: distance_of_first })
    }

    /// For every channel, taken alone as the one that differs.
    fn apart(&self) -> Vec<Apart> {
        let (slopes, information) = self.slopes();
        let strength: f64 = self.white.iter().map(C64::norm_sqr).sum();
        let of = |m: usize| {
            let own: Vec<C64> = self.whiten.iter().map(|row| row[m] * self.amplitudes[m]).collect();
            let along = own.iter().zip(self.white).map(|(d, b)| b.conj() * d).sum::<C64>() / strength;
            let across: Vec<C64> = own.iter().zip(self.white).map(|(d, b)| d - along * b).collect();
            let weight: f64 = across.iter().map(C64::norm_sqr).sum();
            let seen: f64 = across.iter().zip(&slopes).map(|(p, g)| (p.conj() * g).re).sum();
            let (rate, sd) = (seen / weight, (self.variance / (information * weight)).sqrt());
            let known = rate.is_finite() && sd.is_finite() && sd > 0.0;
            if known {
                Apart { rate, sd, moved: along.re * rate }
            } else {
                Apart { rate: 0.0, sd: 1.0, moved: 0.0 }
            }
        };
        // One channel, or the only loud one, has none to be compared with.
        (0..self.amplitudes.len()).map(of).collect()
    }

    /// The slopes g of the white amplitudes, 1/s times them, and J.
    fn slopes(&self) -> (Vec<C64>, f64) {
        let channels = self.white.len();
        let rows = self.left.len() / channels.max(1);
        let phasors = self.wave;
        let (mut m0, mut m1, mut m2) = (0.0, 0.0, 0.0);
        for n in 0..rows {
            let (t, weight) = (n as f64 * self.step, phasors.re[n].powi(2) + phasors.im[n].powi(2));
            (m0, m1, m2) = (m0 + weight, m1 + weight * t, m2 + weight * t * t);
        }
        let (middle, information) = (m1 / m0, 0.5 * (m2 - m1 * m1 / m0));
        let mut sums = vec![C64::ZERO; channels];
        for (n, row) in self.left.chunks_exact(channels).enumerate() {
            let wave = C64::new(phasors.re[n], -phasors.im[n]) * (n as f64 * self.step - middle);
            for (sum, y) in sums.iter_mut().zip(row) {
                *sum += wave * y;
            }
        }
        (sums.into_iter().map(|z| z / information).collect(), information)
    }
}
