//! How long an impulse lasts and which frequencies it holds, from one record of it.

use super::options::ClickOptions;
use super::segment::HIGHEST_HZ;
use crate::dsp::parabola::Parabola;
use crate::dsp::transform;
use crate::{Fault, Trace};
use rijke_numerics::C64;

/// Time and frequencies that an impulse takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// How long before its peak it has risen to a twentieth of it, s.
    pub before: f64,
    /// How long after its peak it has fallen to a twentieth, s.
    pub after: f64,
    /// Frequencies between which all but some thousandths of its energy lie, Hz.
    pub band_hz: (f64, f64),
}

/// Share of the peak at which an impulse counts as begun or over, and the multiple of the noise that it must
/// exceed.
const LEVEL: f64 = 0.05;
const NOISE: f64 = 4.5;
/// What the window of a fit has on each side beyond the extent, over the larger of the part of the extent on
/// that side and half of the whole: a Ricker wavelet has then fallen to 3e-4. An impulse whose largest lobe
/// is its first one needs as much before it as one in the middle.
const MARGIN: f64 = 0.65;
/// The same at least, in periods of the highest frequency: the waveform of a fit is zero for half of it at
/// its ends.
const EDGE: f64 = 1.6;
/// Share of its length that an impulse must be over before its reflection begins.
const OVER: f64 = 0.1;
/// Twice the end correction of an open end over its radius: the reflection begins at the mouth itself.
const MOUTH: f64 = 1.22;
/// Room for an impulse without a reflection after it, and before its peak, s.
const ROOM: f64 = 5e-3;
/// How long before the first loud sample an impulse may begin, s.
const LEAD: f64 = 2e-3;
/// Share of the largest lobe from which another counts as large.
pub(crate) const EQUAL: f64 = 0.9;
/// Share of the peak of a whole record that marks the first impulse: reflections are hardly louder.
const FIRST: f64 = 0.2;
/// Shares of the energy left out below and above the band.
const BELOW: f64 = 5e-3;
const ABOVE: f64 = 5e-4;
/// Power of a bin over that of noise, above which it counts.
const ABOVE_NOISE: f64 = 8.0;
/// Frequencies over the sampling rate just below half of it, and the share of the largest amplitude that an
/// impulse may still have there: half of what a Ricker wavelet has at its centre.
const HIGHEST: (f64, f64) = (0.38, 0.48);
const CUT: f64 = 0.5;
/// Where these are looked at, on both sides of the peak, s.
const AROUND: f64 = 1.5e-3;
/// Window and band of the options are kept if the impulse needs no more than so much of them, and no less of
/// the band.
const ENOUGH: f64 = 1.1;
const HIGH_ENOUGH: f64 = 1.15;
const LEAST: f64 = 0.55;

impl Extent {
    /// The extent of the direct impulse at the microphone farthest from the reflecting end: there it is alone
    /// for longest.
    ///
    /// # Errors
    /// [`Fault::NoImpulse`], [`Fault::LongImpulse`] if it has not ended when its reflection comes, or
    /// [`Fault::ShortImpulse`] if the sampling rate cuts its spectrum off.
    pub fn of(trace: &Trace<'_>, options: &ClickOptions) -> Result<Self, Fault> {
        trace.screen(64)?;
        let lags = options.reflection.as_ref().map_or(&[][..], |r| &r.lags);
        let far = lags.iter().enumerate().take(trace.channels.len()).max_by(|a, b| a.1.total_cmp(b.1));
        let (channel, room) = far.map_or((0, ROOM), |(m, lag)| (m, lag.min(ROOM)));
        let (y, quiet) = (&trace.channels[channel], trace.quiet.min(trace.len()));
        let samples = |seconds: f64| (seconds * trace.rate_hz) as usize;
        let mean = y[..quiet].iter().sum::<f64>() / quiet.max(1) as f64;
        let size = |y: &[f64]| y.iter().map(|v| (v - mean).abs()).fold(0.0, f64::max);
        let top = size(&y[quiet..]);
        let begun = quiet + y[quiet..].iter().position(|v| (v - mean).abs() > FIRST * top).unwrap_or(0);
        let from = begun.saturating_sub(samples(ROOM));
        let to = (begun + samples(room + ROOM)).min(y.len());
        let length = (to - from).clamp(8, quiet.max(8));
        let parabola = |y: &[f64]| {
            let mut left = y.to_vec();
            Parabola::new(y.len()).remove(&mut left);
            left
        };
        let root = |y: &[f64]| (y.iter().map(|v| v * v).sum::<f64>() / y.len().max(1) as f64).sqrt();
        // Over less than 15 ms hum and drift are a parabola. The level counts from the mean before the
        // impulse: hum is noise there.
        let still: Vec<f64> = y[..quiet].chunks_exact(length).flat_map(parabola).collect();
        let noise = root(&still);
        let hum = root(&y[..quiet].iter().map(|v| v - mean).collect::<Vec<f64>>());
        let before = &y[from..begun.saturating_sub(samples(LEAD)).max(from + 1)];
        let zero = before.iter().sum::<f64>() / before.len() as f64;
        let z: Vec<f64> = y[from..to].iter().map(|v| v - zero).collect();
        let begun = begun - from;
        let peak_end = (begun + samples(0.6 * room) + 1).min(z.len());
        let highest = z[begun..peak_end].iter().map(|v| v.abs()).fold(0.0, f64::max);
        // Of two equal lobes the first one: as in the fit.
        let turns = |n: &usize| z[*n].abs() >= z.get(n + 1).map_or(0.0, |v| v.abs());
        let peak = (begun..peak_end).find(|n| z[*n].abs() > EQUAL * highest && turns(n)).unwrap_or(begun);
        let height = z.get(peak).map_or(0.0, |v| v.abs());
        if height < 2.0 * NOISE * noise || height == 0.0 {
            return Err(Fault::NoImpulse { channel: channel.into(), ratio: height / noise });
        }
        let level = (LEVEL * height).max(NOISE * noise.max(hum));
        // At a higher level an impulse is shorter: a Ricker wavelet by a sixth where it is 15 %.
        let wider = 1.0 + 0.15 * (level / (LEVEL * height)).ln();
        let loud = |n: &usize| z[*n].abs() >= level;
        let before = wider * (peak - (0..=peak).find(loud).unwrap_or(peak)).max(1) as f64 / trace.rate_hz;
        let mouth = MOUTH * options.reflection.as_ref().map_or(0.0, |r| r.smoothing);
        let last =
            (peak + samples((room - mouth - (1.0 + 2.0 * OVER) * before).max(0.0))).clamp(peak + 1, z.len());
        let after = wider * ((peak..last).rfind(loud).unwrap_or(peak) - peak).max(1) as f64 / trace.rate_hz;
        let (lead, tail) = window(before, after, f64::INFINITY);
        let whole = &z[peak.saturating_sub(samples(lead))
            ..(peak + samples(tail).max(2)).min(last.max(peak + 3)).min(z.len())];
        // One that the sampling rate cuts off rings before and after it, and looks long.
        let near = &z[peak.saturating_sub(samples(AROUND))..(peak + samples(AROUND).max(8)).min(z.len())];
        let share = band(near, noise, trace.rate_hz)?.1;
        if share > CUT {
            return Err(Fault::ShortImpulse { channel: channel.into(), rate_hz: trace.rate_hz, share });
        }
        let over = (last - peak) as f64 / trace.rate_hz - after / wider;
        if lead + 0.4 * tail > room || (last < z.len() && over < OVER * (before + after)) {
            return Err(Fault::LongImpulse { channel: channel.into(), before, after, room });
        }
        let (low, high) = band(whole, noise, trace.rate_hz)?.0;
        Ok(Self { before, after, band_hz: (low, high.min(HIGHEST_HZ * trace.rate_hz)) })
    }

    /// The extent that the middle one of several has in every respect. None if there is none.
    #[must_use]
    pub fn median(all: &[Self]) -> Option<Self> {
        let middle = |value: fn(&Self) -> f64| {
            let mut values: Vec<f64> = all.iter().map(value).collect();
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 2).copied()
        };
        Some(Self {
            before: middle(|e| e.before)?,
            after: middle(|e| e.after)?,
            band_hz: (middle(|e| e.band_hz.0)?, middle(|e| e.band_hz.1)?),
        })
    }
}

impl ClickOptions {
    /// These options with a window and a band that hold an impulse of such an extent. Where those given hold
    /// it already, they are kept.
    #[must_use]
    pub fn holding(&self, extent: &Extent) -> Self {
        let (least, last) = window(extent.before, extent.after, f64::INFINITY);
        let long = least > ENOUGH * self.window.0 || last > ENOUGH * self.window.1;
        let high = extent.band_hz.1;
        if !long && high < HIGH_ENOUGH * self.band_hz.1 && high > LEAST * self.band_hz.1 {
            return self.clone();
        }
        let window = window(extent.before, extent.after, extent.band_hz.1);
        Self { window, band_hz: extent.band_hz, ..self.clone() }
    }
}

/// The window that holds an impulse of such an extent and highest frequency.
fn window(before: f64, after: f64, highest_hz: f64) -> (f64, f64) {
    let margin = |own: f64| own + (MARGIN * own.max(0.5 * (before + after))).max(EDGE / highest_hz);
    (margin(before), margin(after))
}

/// Frequencies between which the energy of `y` lies, in white noise of the given deviation, and the largest
/// amplitude just below half the sampling rate over that of all.
fn band(y: &[f64], noise: f64, rate_hz: f64) -> Result<((f64, f64), f64), Fault> {
    let length = (8 * y.len()).max(1024).next_power_of_two();
    let forward = transform::forward(length);
    let (mut series, mut spectrum) = (forward.make_input_vec(), forward.make_output_vec());
    let edge = (y.len() / 8).max(1) as f64;
    let weight = |n: usize| {
        let depth = ((n.min(y.len() - 1 - n) as f64 + 0.5) / edge).min(1.0);
        0.5 - 0.5 * (std::f64::consts::PI * depth).cos()
    };
    series.iter_mut().zip(y).enumerate().for_each(|(n, (out, v))| *out = weight(n) * v);
    let floor = ABOVE_NOISE * noise * noise * (0..y.len()).map(|n| weight(n).powi(2)).sum::<f64>();
    let short = |_| Fault::TooShort { what: "impulse", have: y.len(), need: 8 };
    forward.process(&mut series, &mut spectrum).map_err(short)?;
    let power = |z: &C64| Some(z.norm_sqr()).filter(|p| *p > floor).unwrap_or(0.0);
    let powers: Vec<f64> = spectrum.iter().map(power).collect();
    let total: f64 = powers.iter().sum();
    let place = |share: f64| {
        let mut sum = 0.0;
        powers.iter().position(|p| {
            sum += p;
            sum >= share * total
        })
    };
    let frequency = |k: Option<usize>| k.unwrap_or(1) as f64 * rate_hz / length as f64;
    let (low, high) = (frequency(place(BELOW)), frequency(place(1.0 - ABOVE)));
    let top = |from: f64, to: f64| -> f64 {
        let bin = |share: f64| ((share * length as f64) as usize).min(powers.len());
        powers[bin(from)..bin(to)].iter().copied().fold(0.0, f64::max)
    };
    let cut = (top(HIGHEST.0, HIGHEST.1) / top(0.0, 1.0).max(f64::MIN_POSITIVE)).sqrt();
    Ok(((0.8 * low.max(50.0), 1.15 * high.max(100.0)), cut))
}
