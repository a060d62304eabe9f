//! A steady tone, or hum, beside the mode: a fan that sounds in the silence, too.

use crate::driven::{Driven, three_errors};
use rayon::prelude::*;
use rijke_numerics::{C64, Streams};
use rijke_signal::PingFit;
use std::f64::consts::TAU;

/// A mode at 170 Hz four hundred times as loud as the noise, and tones of other strengths in each channel.
#[derive(Clone)]
struct Toned {
    driven: Driven,
    /// Frequencies, Hz, and amplitudes over the noise.
    tones: Vec<(f64, f64)>,
    /// Share by which all frequencies differ from record to record.
    apart: f64,
}

impl Toned {
    fn tube(quiet: f64, mode_hz: f64, tones: &[(f64, f64)]) -> Self {
        let driven = Driven {
            modes: vec![
                (C64::new(-12.0, TAU * mode_hz), 1.0),
                (C64::new(-18.0, TAU * (2.0 * mode_hz + 0.9)), 0.3),
            ],
            forcing_hz: mode_hz + 0.3,
            quiet,
            switched: vec![(quiet, quiet + 0.417)],
            end: quiet + 1.17,
            ratio: 400.0,
            channels: 5,
            ..Driven::tube()
        };
        Self { driven, tones: tones.to_vec(), apart: 0.0 }
    }

    fn record(&self, seed: u64) -> Vec<Vec<f64>> {
        use rand::RngExt;
        let mut stream = Streams::new(seed).stream("toned");
        let mut random = || stream.random::<f64>();
        let mut channels = self.driven.record(seed);
        let apart = 1.0 + self.apart * (2.0 * random() - 1.0);
        for (hz, amplitude) in &self.tones {
            let phase = TAU * random();
            for (y, share) in channels.iter_mut().zip([1.0, 0.9, 0.7, 0.8, 1.1]) {
                for (n, v) in y.iter_mut().enumerate() {
                    *v += share * amplitude * (TAU * hz * apart * n as f64 * 1e-4 + phase).cos();
                }
            }
        }
        channels
    }

    /// Errors over standard deviations of growth rate and frequency, then of pressures.
    fn pulls(&self, fit: &PingFit) -> Vec<f64> {
        let shape = |m: usize| (0.5 + 0.45 * m as f64).sin();
        let ping = &fit.ping;
        let pressures = (0..5).map(|m| C64::from(shape(m) / shape(ping.reference))).collect();
        let truth = rijke_rig::Ping { s: self.driven.modes[0].0, pressures, ..ping.clone() };
        let pairs = ping.vector().into_iter().zip(truth.vector()).enumerate();
        pairs.map(|(i, (have, want))| (have - want) / ping.covariance[(i, i)].sqrt()).collect()
    }

    /// Mains of six harmonics, five times as loud as the noise, that drift by 0.04 Hz.
    fn hum(quiet: f64, mode_hz: f64) -> Self {
        let harmonics: Vec<(f64, f64)> = (1..=6).map(|h| (50.0 * f64::from(h), 5.0)).collect();
        Self { apart: 8e-4, ..Self::tube(quiet, mode_hz, &harmonics) }
    }

    /// What is wrong where errors of so many records are not as stated, or more than one in ten is refused.
    fn wrong(&self, count: u64) -> Option<String> {
        let (hz, amplitude) = self.tones[0];
        let mode_hz = self.driven.modes[0].0.im / TAU;
        let name =
            format!("silence {} s, mode at {mode_hz} Hz, tone of {amplitude} at {hz} Hz", self.driven.quiet);
        let fits: Vec<_> = (0..count)
            .into_par_iter()
            .map(|seed| self.driven.fit_of(&self.record(seed)).map(|fit| self.pulls(&fit)))
            .collect();
        let mut squares = [0.0; 3];
        let mut n = 0.0;
        for fit in &fits {
            let Ok(pulls) = fit.as_ref().inspect_err(|fault| println!("{name}: {fault}")) else { continue };
            n += 1.0;
            let of_pressures = pulls[2..].iter().map(|p| p * p).sum::<f64>() / (pulls.len() - 2) as f64;
            for (sum, square) in squares.iter_mut().zip([pulls[0].powi(2), pulls[1].powi(2), of_pressures]) {
                *sum += square;
            }
        }
        let rms = squares.map(|s| (s / n).sqrt());
        println!("{name}: rms pulls {rms:.2?}, {} of {count} refused", count as f64 - n);
        let (_, most) = three_errors(count);
        let holds = rms.iter().all(|v| *v < most) && 10.0 * (count as f64 - n) <= count as f64;
        (!holds).then_some(name)
    }
}

/// Before, nearly all of these were refused for a gain that drifts, and pressures of the others were ten
/// standard deviations wrong.
#[test]
fn coverage_of_a_steady_tone_beside_the_mode() {
    hold(10, [0.2, 1.0].map(|quiet| Toned::tube(quiet, 170.0, &[(172.0, 2.5)])).to_vec());
}

#[test]
#[ignore = "long: 200 records of each of 12 kinds"]
fn coverage_of_a_steady_tone_beside_the_mode_over_200_seeds() {
    let tones = [(172.0, 1.0), (172.0, 2.5), (168.5, 5.0), (165.0, 1.0), (180.0, 1.0), (170.0, 0.0)];
    let of = |quiet: f64| tones.map(|tone| Toned::tube(quiet, 170.0, &[tone]));
    hold(200, [0.2, 1.0].into_iter().flat_map(of).collect());
}

/// Before, a long silence made of the third harmonic noise that rings the mode.
#[test]
fn coverage_of_hum_beside_the_mode_after_a_long_silence() {
    hold(8, vec![Toned::hum(1.0, 150.6), Toned::hum(2.0, 150.6)]);
}

#[test]
#[ignore = "long: 200 records of each of 6 kinds"]
fn coverage_of_hum_beside_the_mode_after_a_long_silence_over_200_seeds() {
    let kinds = [(0.2, 150.6), (0.7, 150.6), (1.0, 150.6), (2.0, 150.6), (1.0, 152.0), (2.0, 155.0)];
    hold(200, kinds.map(|(quiet, mode_hz)| Toned::hum(quiet, mode_hz)).to_vec());
}

fn hold(count: u64, kinds: Vec<Toned>) {
    let wrong: Vec<String> = kinds.iter().filter_map(|kind| kind.wrong(count)).collect();
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// A tone that is not steady is not fitted, and not called a gain that drifts.
#[test]
fn message_a_tone_that_no_fit_explains_is_said() {
    let toned = Toned::tube(1.0, 170.0, &[(172.0, 20.0)]);
    let mut named = 0;
    for seed in 0..4 {
        let mut channels = toned.driven.record(seed);
        for (y, share) in channels.iter_mut().zip([1.0, 0.9, 0.7, 0.8, 1.1]) {
            for (n, v) in y.iter_mut().enumerate() {
                // It grows louder after the silence.
                let t = n as f64 * 1e-4;
                let size = 20.0 * (1.0 + (t - 1.0).max(0.0));
                *v += share * size * (TAU * 172.0 * t + seed as f64).cos();
            }
        }
        let Err(fault) = toned.driven.fit_of(&channels) else { continue };
        let said = fault.to_string();
        assert!(!said.contains("gain drifts"), "{said}");
        named += usize::from(said.starts_with("a tone at 172.0 Hz sounds in the silence, "));
    }
    assert!(named > 2, "{named}");
}
