//! From a fit of a ring-down to a measurement, or to the reason why there is none.

use super::alike::Decay;
use super::chirp::Drift;
use super::excess::{Excess, Excesses};
use super::forcing::Change;
use super::found::PingFit;
use super::jump::{self, Jump, Smooth};
use super::options::PingOptions;
use super::power;
use super::relative::relative;
use super::ringing::{self, Ringing};
use super::verdict::{self, Residue};
use crate::dsp::noise::Whitener;
use crate::ringdown::{Component, Kind, Solution, White, fundamental};
use crate::unstable::Unstable;
use crate::{Fault, Mishap, TwoReadings};
use rijke_numerics::C64;

/// A second mode nearer than this, with a drift beside it, is no mode of a rig, Hz.
const TOUCHING_HZ: f64 = 2.0;
/// Two parts of a decay have one shape if the square of their normalised product exceeds this.
const ONE_SHAPE: f64 = 0.98;
/// They have one frequency if their angular frequencies differ by less than this part of what their growth
/// rates do.
const ONE_FREQUENCY: f64 = 0.5;
/// A second part that decays so many times faster or slower than the first is no rival: the fit separates
/// them.
const LIKE: f64 = 5.0;
/// A second part of less than this share of the amplitude is no loudspeaker.
const FAINT: f64 = 0.1;
/// Damping that is lower by this share at first than at small amplitude is not ascribed to the rig: a
/// loudspeaker that fades, or a microphone that saturates, does the same.
const SLOW_AT_FIRST: f64 = 0.1;
/// Two readings of a decay differ if they are so many stated standard deviations apart.
const READINGS: f64 = 2.0;
/// A tone that loses less of its amplitude while it is fitted is no decay: one that goes on fits as well.
const LEAST_FALL: f64 = 0.05;

/// Samples of the residuals that are kept.
const NOISE: usize = 1024;

/// The maximum-likelihood fit together with what it was made from.
pub(super) struct Fitted {
    pub(super) whitener: Whitener,
    pub(super) harmonics: Vec<u32>,
    /// The quiet part, white.
    pub(super) silence: Vec<f64>,
    pub(super) ringing: Ringing,
    /// What the fit leaves of the white record, from the first of `rows` to its end.
    pub(super) left: Vec<f64>,
    pub(super) channels: usize,
    pub(super) step: f64,
    /// Samples from which the colour of the noise was learnt.
    pub(super) learnt_from: usize,
    /// First sample of the record that the rows stand for.
    pub(super) offset: usize,
    /// Rows that were fitted.
    pub(super) rows: (usize, usize),
    /// Where the forcing ended.
    pub(super) end: Change,
    /// Where the decay begins of which another mode hides the first part.
    pub(super) decays_from: Option<usize>,
    pub(super) guess: C64,
    pub(super) solution: Solution,
    /// The same fit by the other law of an excess of damping, if the first one has an excess.
    pub(super) other_law: Option<Solution>,
    /// A fit by two close modes that explains more, if there is one.
    pub(super) rival: Option<Solution>,
    /// Whether the forcing may have gone on after what was taken for its end.
    pub(super) doubtful: bool,
}

impl Fitted {
    /// What is left of the rows that were fitted.
    pub(super) fn residuals(&self) -> &[f64] {
        &self.left[..(self.rows.1 - self.rows.0) * self.channels]
    }

    /// Power of the noise that rings the mode, if there is any, enlarged for the few degrees of freedom that
    /// tell of it: silence, decay and tail.
    fn narrow(&self) -> Result<Option<f64>, Fault> {
        let s = self.solution.components[0].s;
        let white = |samples| White { samples, channels: self.channels, step: self.step };
        let found = power::power(&self.solution, white(&self.silence), Some(white(&self.left)));
        if self.ringing.is_some() {
            let silent = power::power(&self.solution, white(&self.silence), None).or(found);
            let most = silent.map_or(self.ringing.power, |p| p.value).max(0.5 * self.ringing.power);
            if let Some((row, channel, ratio)) = ringing::beyond(white(self.residuals()), s, most) {
                let at = (self.offset + self.rows.0 + row) as f64 * self.step;
                let frequency_hz = s.im / std::f64::consts::TAU;
                return Err(Fault::Residual { at, channel: channel.into(), ratio, frequency_hz });
            }
        }
        let Some(found) = found else { return Ok(None) };
        let clear = self.ringing.is_some() || found.clear;
        let enlarged = found.value.max(found.sd) * found.freedom / (found.freedom - 2.0);
        Ok(clear.then_some(enlarged))
    }

    /// Turns the fit into a measurement, or refuses it.
    pub(super) fn judged(self, options: &PingOptions) -> Result<PingFit, Fault> {
        let s = self.solution.components[0].s;
        if s.re >= 0.0 {
            return Err(Fault::NotDecaying(s.re));
        }
        let (from, to) = self.rows;
        let seconds = (to - from) as f64 * self.step;
        let fall = 1.0 - (s.re * seconds).exp();
        if fall < LEAST_FALL {
            let frequency_hz = s.im / std::f64::consts::TAU;
            return Err(Unstable::GoesOn { frequency_hz, seconds, fall }.into());
        }
        let at = |row: usize| (self.offset + row) as f64 * self.step;
        let (unwhiten, log_slopes) = self.whitener.unwhiten(s, self.step);
        let white_amplitudes = &self.solution.amplitudes[0];
        let amplitudes: Vec<C64> =
            unwhiten.iter().map(|row| row.iter().zip(white_amplitudes).map(|(u, b)| u * b).sum()).collect();
        let tone = |(k, component): (usize, &Component)| {
            let (unwhiten, _) = self.whitener.unwhiten(component.s, self.step);
            let white = &self.solution.amplitudes[k];
            let amplitude = |row: &Vec<C64>| row.iter().zip(white).map(|(u, b)| u * b).sum();
            (component.s, unwhiten.iter().map(amplitude).collect())
        };
        let tones = self.solution.components.iter().enumerate().map(tone).collect();
        let deviations = self.whitener.deviations(s.im, self.step);
        let signal_to_noise: Vec<f64> =
            amplitudes.iter().zip(&deviations).map(|(a, d)| a.norm() / d).collect();
        verdict::signal(&signal_to_noise, options.silent_channels)?;
        let left = self.residuals();
        let rings = self.ringing.is_some();
        let calm = self.ringing.taken_out(White { samples: left, channels: self.channels, step: self.step });
        let narrow = self.narrow()?;
        let residue = Residue {
            samples: &calm,
            channels: self.channels,
            step: self.step,
            begin: at(from),
            mode_hz: s.im / std::f64::consts::TAU,
            narrow: rings,
        };
        let checked = if rings {
            let samples = &ringing::levelled(calm.clone(), self.channels);
            Residue { samples, ..residue }.check(options.mains_hz)
        } else {
            residue.check(options.mains_hz)
        };
        let whole = || Residue { samples: &self.left, ..residue };
        checked.and_then(|()| residue.check_whole(self.learnt_from)).map_err(|fault| match fault {
            Fault::Residual { .. } | Fault::HumBurst { .. } if !rings && !self.silence.is_empty() => {
                whole().louder().map_or(fault, |times| Mishap::Louder { times, from: at(from) }.into())
            }
            fault => fault,
        })?;
        let variance =
            if rings { ringing::calm_variance(&calm, s, self.step) } else { self.solution.variance() };
        let whiten = &self.whitener.whiten(s, self.step);
        let (white, amplitudes_now, step) = (white_amplitudes, &amplitudes, self.step);
        let wave = &self.solution.wave(to - from, step);
        Decay { s, white, amplitudes: amplitudes_now, whiten, left, step, wave, variance }.check()?;
        let jump = Jump::of(&self.solution, left, step, Smooth::Cubic);
        if let Some(jump) = jump.filter(|jump| narrow.is_none() && jump.gain > jump::CLEAR * variance) {
            return Err(jump.fault(s, at(from + jump.row), step, variance));
        }
        let covariance = self.solution.mode_covariance(0);
        let mut ping =
            relative(s, &amplitudes, options.reference, &unwhiten, &log_slopes, &covariance, variance);
        let drift = Drift::of(&self.solution, left, step).with_variance(&self.solution, variance);
        let excess = Excesses::of(&self.solution, self.other_law.as_ref(), left, step);
        let excess = excess.with_variance(&self.solution, variance);
        if self.solution.components[0].excess.is_some() {
            excess.of_law(self.solution.components[0].law).put_back(&mut ping);
        }
        if self.solution.components[0].chirp.is_some() {
            drift.put_back(&mut ping);
        }
        let since = |rows: usize| rows as f64 * self.step;
        let mut drift = drift.counted_from(since(from - self.end.row), since(self.end.lag + 1));
        let mut excess = excess.counted_from((-s.re * since(from - self.end.row)).exp());
        if let Some(power) = narrow {
            ringing::widen(&mut ping, (&mut drift, &mut excess), power, &self.solution, to - from, self.step);
        }
        if excess.is_significant() {
            let Excess { share, sd, .. } = *excess.likelier();
            if share < -SLOW_AT_FIRST {
                return Err(Fault::TwoReadings(TwoReadings::SlowAtFirst(-share, sd)));
            }
            excess.remove(&mut ping);
        }
        if drift.is_significant() {
            let apart = |c: &Component| (c.s.im - s.im).abs() / std::f64::consts::TAU;
            let modes = self.solution.components.iter().skip(1).filter(|c| c.kind == Kind::Mode);
            if let Some(apart_hz) = modes.map(apart).find(|apart| *apart < TOUCHING_HZ) {
                return Err(Fault::TwoReadings(TwoReadings::Drifting(apart_hz, drift.rate)));
            }
            drift.remove(&mut ping);
        }
        if let Some(second) = self.of_one_shape() {
            return Err(Fault::TwoReadings(TwoReadings::OneShape(s.re, second.re)));
        }
        if let Some(rival) = &self.rival {
            let apart = |k: usize, distance: f64| distance.abs() > READINGS * ping.covariance[(k, k)].sqrt();
            let [first, second] = [0, 1].map(|k| rival.components[k].s);
            if apart(0, ping.s.re - first.re) || apart(1, ping.s.im - first.im) {
                return Err(Fault::TwoReadings(TwoReadings::TwoModes(
                    (second.im - first.im).abs() / std::f64::consts::TAU,
                )));
            }
        }
        let mut modes: Vec<C64> =
            self.solution.components.iter().filter(|c| c.kind == Kind::Mode).map(|c| c.s).collect();
        if let Some(mode) = modes.first_mut() {
            *mode = ping.s;
        }
        let mains = fundamental(&self.solution.components).map(|omega| omega / std::f64::consts::TAU);
        Ok(PingFit {
            ping,
            modes,
            drift,
            excess,
            subspace_guess: self.guess,
            amplitudes,
            tones,
            window: (at(from), at(to)),
            skipped_s: self.decays_from.map_or(0.0, |row| since(from.saturating_sub(row))),
            signal_to_noise,
            mains: (self.harmonics, mains.unwrap_or(options.mains_hz)),
            residual_variance: variance,
            noise: self.left.iter().take(NOISE).map(|v| *v as f32).collect(),
        })
    }

    /// A second mode that has the shape of the first, and differs from it by its growth rate and hardly by
    /// its frequency.
    fn of_one_shape(&self) -> Option<C64> {
        let Solution { components, amplitudes, .. } = &self.solution;
        let (s, own) = (components.first()?.s, amplitudes.first()?);
        let product = |a: &[C64], b: &[C64]| a.iter().zip(b).map(|(a, b)| a.conj() * b).sum::<C64>().norm();
        let alike = |a: &[C64]| product(a, own).powi(2) > ONE_SHAPE * product(a, a) * product(own, own);
        let others = components.iter().zip(amplitudes).skip(1).filter(|(c, _)| c.kind == Kind::Mode);
        let one = |c: &Component| {
            let ratio = c.s.re / s.re;
            (c.s.im - s.im).abs() < ONE_FREQUENCY * (c.s.re - s.re).abs()
                && (1.0 / LIKE..LIKE).contains(&ratio)
        };
        let strong = |a: &[C64]| product(a, a) > FAINT * FAINT * product(own, own);
        others.filter(|(c, a)| one(c) && own.len() > 1 && strong(a) && alike(a)).map(|(c, _)| c.s).next()
    }
}
