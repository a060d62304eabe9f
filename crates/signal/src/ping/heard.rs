//! What sounds in the silence before the forcing: hum, noise that rings the mode, steady tones beside it.

use super::diagnosis;
use super::fairest::APART_HZ;
use super::lines::lines;
use super::options::PingOptions;
use super::ringing;
use crate::dsp::noise::{MAX_HARMONIC, remove_hum};
use crate::{Fault, SteadyTone, Trace};

/// Distance from a harmonic of the mains that is there, up to which a tone is part of it, Hz.
const HUM_HZ: f64 = 1.5;

/// Distance from the mode up to which a tone leaks into it in a short silence, in resolutions of the silence.
const BINS: f64 = 5.0;

/// The silence, and what was taken out of it.
pub(super) struct Heard {
    /// What is left: noise.
    pub(super) noise: Vec<Vec<f64>>,
    /// Harmonics of the mains.
    pub(super) harmonics: Vec<u32>,
    /// Steady tones beside the mode that are none of these, Hz.
    pub(super) tones: Vec<f64>,
    /// The frequency at which the rest rings, Hz.
    pub(super) narrow_hz: Option<f64>,
}

impl Heard {
    /// In the first `quiet` samples.
    pub(super) fn of(trace: &Trace<'_>, options: &PingOptions, quiet: usize) -> Self {
        let silence = || -> Vec<Vec<f64>> { trace.channels.iter().map(|y| y[..quiet].to_vec()).collect() };
        let without = |left: &[u32]| {
            let mut noise = silence();
            let harmonics = remove_hum(&mut noise, trace.rate_hz, options.mains_hz, left);
            (noise, harmonics)
        };
        let (noise, harmonics) = without(&[]);
        let plain = |noise, harmonics| Self { noise, harmonics, tones: Vec::new(), narrow_hz: None };
        let Some(hz) = diagnosis::loudest(trace, options) else { return plain(noise, harmonics) };
        let rings = ringing::rings(&noise, trace.rate_hz, hz);
        let apart_hz = APART_HZ.max(BINS * trace.rate_hz / quiet as f64);
        let found = lines(&noise, trace.rate_hz, hz, apart_hz);
        if !found.hertz.is_empty() && found.steady {
            // Hum that is fitted takes what was left of it along.
            let is_hum = |hz: f64| harmonics.iter().any(|h| is_of_harmonic(options, *h, hz));
            let tones = found.hertz.into_iter().filter(|hz| !is_hum(*hz)).collect();
            return Self { tones, ..plain(found.rest, harmonics) };
        }
        if !rings {
            return plain(noise, harmonics);
        }
        // A short silence does not tell noise that rings the mode from hum beside it: the decay does.
        let mut beside = beside(options, hz);
        beside.retain(|h| harmonics.contains(h));
        let (noise, mut harmonics) = without(&beside);
        harmonics.extend(beside);
        Self { narrow_hz: Some(hz), ..plain(noise, harmonics) }
    }
}

/// Whether a tone is part of a harmonic of the mains.
pub(super) fn is_of_harmonic(options: &PingOptions, harmonic: u32, hz: f64) -> bool {
    (f64::from(harmonic) * options.mains_hz - hz).abs() < HUM_HZ
}

/// The harmonics of the mains beside a mode at `mode_hz`.
pub(super) fn beside(options: &PingOptions, mode_hz: f64) -> Vec<u32> {
    let near = |h: &u32| (f64::from(*h) * options.mains_hz - mode_hz).abs() < APART_HZ;
    (1..=MAX_HARMONIC).filter(near).collect()
}

/// A fault that a steady tone beside the mode explains, in its words; `tones` are in the silence, and the
/// mode is at `mode_hz`, and the silence lasts so long, s.
pub(super) fn beside_a_tone(fault: Fault, tones: &[f64], (mode_hz, silence_s): (Option<f64>, f64)) -> Fault {
    let Some(mode_hz) = mode_hz else { return fault };
    let apart = |hz: &f64| (hz - mode_hz).abs();
    let nearest = tones.iter().copied().min_by(|a, b| apart(a).total_cmp(&apart(b)));
    let Some(frequency_hz) = nearest else { return fault };
    let explained = match &fault {
        Fault::Residual { frequency_hz: left, .. } => (left - frequency_hz).abs() < APART_HZ,
        Fault::GainDrifts { .. }
        | Fault::GainsApart { .. }
        | Fault::NotFree { .. }
        | Fault::NotConverged { .. }
        | Fault::Singular(_)
        | Fault::TwoReadings(_)
        | Fault::StillDriven { .. } => true,
        _ => false,
    };
    let tone = SteadyTone { frequency_hz, apart_hz: apart(&frequency_hz), silence_s };
    if explained { tone.into() } else { fault }
}
