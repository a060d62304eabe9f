//! Whether a fitted ring-down may be used, from what the fit leaves over.

use crate::Fault;
use crate::dsp::kernels::dot;
use crate::ringdown::White;
use rijke_numerics::C64;

/// Length of the stretches in which residuals are compared with noise, s.
const STRETCH: f64 = 0.02;
/// Residual power over noise power that rejects: 13 sd of one channel in a stretch of 200 samples ...
const CHANNEL_LIMIT: f64 = 2.3;
/// ... and 10 sd of 8 channels together. Gaussian noise does not reach either in the lifetime of a rig.
const TOTAL_LIMIT: f64 = 1.35;
/// Excess of the power of all residuals over that of noise that rejects, and the same in standard deviations:
/// the larger one counts. Noise of a rig may be louder after the forcing than before it, which the covariance
/// allows for.
const WHOLE_LIMIT: f64 = 0.15;
const WHOLE_DEVIATIONS: f64 = 5.0;
/// Length of the stretches in which residuals are compared with each other, s, how many there must be, and
/// the deviations by which their powers may differ: coloured noise has fewer degrees of freedom than samples.
const LONG: f64 = 0.08;
const STRETCHES: usize = 4;
const ALIKE: f64 = 8.0;
/// How many times more noise may be left where it rings the mode: in a stretch shorter than its memory, the
/// power of narrow noise has few degrees of freedom.
const NARROW: f64 = 8.0;

/// White residuals of a fit, one row of channels per sample.
pub(crate) struct Residue<'a> {
    pub(crate) samples: &'a [f64],
    pub(crate) channels: usize,
    pub(crate) step: f64,
    /// Time of the first row, s.
    pub(crate) begin: f64,
    /// Frequency of the mode that was fitted, Hz: what is left near it is not called hum.
    pub(crate) mode_hz: f64,
    /// Whether noise rings the mode: what is left beside it is no white noise, and comes and goes.
    pub(crate) narrow: bool,
}

impl Residue<'_> {
    fn wider(&self) -> f64 {
        if self.narrow { NARROW } else { 1.0 }
    }

    /// Refuses residuals that are more than noise in some stretch, and says when, where and at which
    /// frequency.
    pub(crate) fn check(&self, mains_hz: f64) -> Result<(), Fault> {
        let rows = ((STRETCH / self.step).round() as usize).max(16);
        let scatter = (2.0 / rows as f64).sqrt();
        let widen = scatter / 0.1 * self.wider();
        let (channel_limit, total_limit) = (
            1.0 + (CHANNEL_LIMIT - 1.0) * widen,
            1.0 + (TOTAL_LIMIT - 1.0) * widen * (8.0 / self.channels as f64).sqrt(),
        );
        let mut worst: Option<(f64, usize, usize, f64)> = None;
        for (block, stretch) in self.samples.chunks_exact(rows * self.channels).enumerate() {
            let mut power = vec![0.0; self.channels];
            for row in stretch.chunks_exact(self.channels) {
                for (sum, v) in power.iter_mut().zip(row) {
                    *sum += v * v / rows as f64;
                }
            }
            let total = power.iter().sum::<f64>() / self.channels as f64;
            let (channel, &largest) =
                power.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).unwrap_or((0, &0.0));
            let excess = ((largest - 1.0) / (channel_limit - 1.0)).max((total - 1.0) / (total_limit - 1.0));
            if excess > 1.0 && worst.is_none_or(|w| excess > w.0) {
                worst = Some((excess, block, channel, largest));
            }
        }
        let Some((_, block, channel, ratio)) = worst else { return Ok(()) };
        let middle = (block * rows + rows / 2) as f64;
        let at = self.begin + middle * self.step;
        let white = White { samples: self.samples, channels: self.channels, step: self.step };
        let (frequency_hz, amplitude) = strongest_tone(white, block * rows, channel);
        let harmonic = (frequency_hz / mains_hz).round();
        let of_the_mode = (frequency_hz - self.mode_hz).abs() < (frequency_hz - harmonic * mains_hz).abs();
        if !of_the_mode
            && (1.0..=3.0).contains(&harmonic)
            && (frequency_hz - harmonic * mains_hz).abs() < 12.0
        {
            return Err(Fault::HumBurst { at, frequency_hz: harmonic * mains_hz, ratio: amplitude });
        }
        Err(Fault::Residual { at, channel: channel.into(), ratio, frequency_hz })
    }

    /// Refuses residuals that are more than noise on the whole. The noise is known as well as `learnt_from`
    /// samples of a channel show it.
    pub(crate) fn check_whole(&self, learnt_from: usize) -> Result<(), Fault> {
        let count = self.samples.len() as f64;
        let power = dot(self.samples, self.samples) / count;
        let sd = (2.0 / count + 2.0 / (learnt_from * self.channels) as f64).sqrt();
        if power < 1.0 + self.wider() * WHOLE_LIMIT.max(WHOLE_DEVIATIONS * sd) {
            return Ok(());
        }
        let white = White { samples: self.samples, channels: self.channels, step: self.step };
        let of = |m: usize| self.samples.iter().skip(m).step_by(self.channels).map(|v| v * v).sum::<f64>();
        let channel = (0..self.channels).max_by(|&a, &b| of(a).total_cmp(&of(b))).unwrap_or(0);
        let (frequency_hz, _) = strongest_tone(white, 0, channel);
        Err(Fault::Residual { at: self.begin, channel: channel.into(), ratio: power, frequency_hz })
    }
}

impl Residue<'_> {
    /// By how much the amplitude of the residuals exceeds that of the noise, if it does so alike in all
    /// channels and to the end of the record: then it is noise, and the silence was another one. What a fit
    /// leaves of a decay dies away with it.
    pub(crate) fn louder(&self) -> Option<f64> {
        let rows = ((LONG / self.step).round() as usize).max(64);
        let of = |stretch: &[f64], m: usize| {
            let own = stretch.iter().skip(m).step_by(self.channels);
            own.map(|v| v * v).sum::<f64>() * self.channels as f64 / stretch.len() as f64
        };
        let stretches: Vec<&[f64]> = self.samples.chunks_exact(rows * self.channels).collect();
        let all: Vec<f64> =
            stretches.iter().flat_map(|stretch| (0..self.channels).map(|m| of(stretch, m))).collect();
        let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
        let chance = ALIKE * (2.0 / rows as f64).sqrt();
        let alike = |m: usize| {
            let own = all.iter().skip(m).step_by(self.channels);
            let mean = own.clone().sum::<f64>() / stretches.len() as f64;
            mean > 1.0 + WHOLE_LIMIT && own.clone().all(|power| (power / mean - 1.0).abs() < chance)
        };
        (stretches.len() >= STRETCHES && (0..self.channels).all(alike)).then(|| mean.sqrt())
    }
}

/// A channel that carries no signal where the others do, or no signal anywhere.
pub(crate) fn signal(ratios: &[f64], silent_channels: bool) -> Result<(), Fault> {
    let mut sorted = ratios.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (median, best) = (sorted[sorted.len() / 2], sorted[sorted.len() - 1]);
    if best < 0.5 {
        return Err(Fault::Weak(best));
    }
    let quietest = ratios.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
    match quietest {
        // A microphone at 0.95 of an open tube sees 0.16 of the largest amplitude; an unplugged one sees
        // none.
        Some((channel, &ratio)) if !silent_channels && ratio < 0.01 * median => {
            Err(Fault::NoSignal { channel: channel.into(), ratio, median })
        }
        _ => Ok(()),
    }
}

/// Names what made the envelope of the tone at `mode_hz` grow again by `row`: mains hum if it is stronger
/// there than at the start of the record and not just what leaks from the mode, a second excitation
/// otherwise.
pub(crate) fn regrowth(
    white: White<'_>,
    mode_hz: f64,
    row: usize,
    at: f64,
    factor: f64,
    mains_hz: f64,
) -> Fault {
    let span = ((0.06 / white.step) as usize).min(white.rows() / 2);
    // Under a Hann window the mode, 20 Hz or more away, leaves hum alone.
    let size = |from: usize, frequency_hz: f64| loudness(white, from, span, frequency_hz);
    // A burst may end at the row where the envelope has grown most, or begin there. Of its edge alone a
    // stretch holds all frequencies: the louder stretch says which one it is.
    let last = row.min(white.rows() - span);
    // The third harmonic of the mains is too near the fundamental of a metre of tube.
    let heard = [last.saturating_sub(span), last].into_iter().filter_map(|from| {
        // Two bins away a jump of the mode's phase would do the same.
        let apart = |h: u32| (mains_hz * f64::from(h) - mode_hz).abs() * span as f64 * white.step > 2.0;
        let hum = |h: &u32| if apart(*h) { size(from, mains_hz * f64::from(*h)) } else { 0.0 };
        let harmonic = if hum(&1) >= hum(&2) { 1 } else { 2 };
        let frequency_hz = mains_hz * f64::from(harmonic);
        let now = hum(&harmonic);
        let clear = now > 4.0 * size(0, frequency_hz) && now > 0.1 * size(from, mode_hz);
        clear.then_some((now, frequency_hz))
    });
    match heard.max_by(|a, b| a.0.total_cmp(&b.0)) {
        Some((ratio, frequency_hz)) => Fault::HumBurst { at, frequency_hz, ratio },
        None => Fault::SecondExcitation { at, factor },
    }
}

/// Amplitude of a tone in each channel under a Hann window.
pub(super) fn tones(white: White<'_>, from: usize, span: usize, frequency_hz: f64) -> Vec<f64> {
    phasors(white, from, span, frequency_hz).iter().map(|z| z.norm()).collect()
}

/// The same with the phase at row `from`.
pub(super) fn phasors(white: White<'_>, from: usize, span: usize, frequency_hz: f64) -> Vec<C64> {
    let turn = C64::from_polar(1.0, -std::f64::consts::TAU * frequency_hz * white.step);
    let around = C64::from_polar(1.0, std::f64::consts::TAU / span.max(1) as f64);
    let (mut phasor, mut window) = (C64::ONE, around.sqrt());
    let (mut re, mut im) = (vec![0.0; white.channels], vec![0.0; white.channels]);
    for row in white.samples.chunks_exact(white.channels).skip(from).take(span) {
        let wave = phasor * (1.0 - window.re);
        for ((re, im), y) in re.iter_mut().zip(&mut im).zip(row) {
            *re += wave.re * y;
            *im += wave.im * y;
        }
        phasor *= turn;
        window *= around;
    }
    re.into_iter().zip(im).map(|(re, im)| C64::new(re, im) * (2.0 / span.max(1) as f64)).collect()
}

/// The same of all channels together.
pub(super) fn loudness(white: White<'_>, from: usize, span: usize, frequency_hz: f64) -> f64 {
    tones(white, from, span, frequency_hz).iter().map(|a| a * a).sum::<f64>().sqrt()
}

/// Frequency (Hz) and amplitude of the strongest tone of one channel in the 60 ms from row `from`, on a grid
/// of 2 Hz.
fn strongest_tone(white: White<'_>, from: usize, channel: usize) -> (f64, f64) {
    let span = ((0.06 / white.step) as usize).min(white.rows());
    let from = from.min(white.rows() - span);
    let series: Vec<f64> = (from..from + span).map(|n| white.samples[n * white.channels + channel]).collect();
    let mean = series.iter().sum::<f64>() / span.max(1) as f64;
    let highest = (0.45 / white.step).min(1200.0);
    (5..)
        .map(|k| 2.0 * f64::from(k))
        .take_while(|&f| f < highest)
        .map(|f| {
            let turn = C64::from_polar(1.0, -std::f64::consts::TAU * f * white.step);
            let (mut phasor, mut sum) = (C64::ONE, C64::ZERO);
            for y in &series {
                sum += phasor * (y - mean);
                phasor *= turn;
            }
            (f, 2.0 * sum.norm() / span.max(1) as f64)
        })
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap_or((0.0, 0.0))
}
