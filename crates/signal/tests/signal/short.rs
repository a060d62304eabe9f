//! Records that are cut soon after the loudspeaker is switched off.

use crate::driven::Driven;
use rand::RngExt;
use rayon::prelude::*;
use rijke_numerics::{C64, Streams};
use rijke_signal::{Fault, PingFit, PingOptions, Trace, fit_ping};
use std::f64::consts::TAU;

/// Any rig: rate, mode, decay, number of channels and level of noise by lot, with a tail of so many decay
/// times.
pub(crate) fn any(seed: u64, tail: f64) -> Driven {
    let mut stream = Streams::new(seed).stream("any rig");
    let mut lot = |low: f64, high: f64| low * (high / low).powf(stream.random::<f64>());
    let (mode_hz, decay) = (lot(60.0, 900.0), lot(2.0, 60.0));
    let rate_hz = [1200.0, 2500.0, 5000.0, 1e4, 25_600.0, 51_200.0][lot(1.0, 7.0) as usize - 1];
    let rate_hz = if rate_hz < 5.0 * mode_hz { 1e4 } else { rate_hz };
    let forced = (5.0 / decay).max(0.4);
    let mode = |k: f64| (C64::new(-decay * k.sqrt(), TAU * mode_hz * (1.02 * k - 0.02)), 1.0);
    let most = (0.45 * rate_hz / mode_hz).min(4.0) as usize;
    Driven {
        rate_hz,
        modes: (1..=most.max(1)).map(|k| mode(k as f64)).collect(),
        forcing_hz: mode_hz * (1.0 + 0.01 * lot(0.01, 1.0)),
        quiet: 0.25,
        switched: vec![(0.25, 0.25 + forced)],
        end: 0.25 + forced + tail / decay,
        ratio: lot(30.0, 1000.0),
        channels: lot(1.0, 9.0) as usize,
        ..Driven::tube()
    }
}

/// Of growth rate and frequency: shares inside two stated deviations, root mean square of error over
/// deviation; the largest of both; records used and refused.
pub(crate) struct Tally {
    pub(crate) inside: [f64; 2],
    pub(crate) rms: [f64; 2],
    pub(crate) worst: f64,
    pub(crate) used: usize,
    pub(crate) faults: Vec<Fault>,
}

impl Tally {
    /// What `fit` makes of so many records of the rigs that `rig` draws.
    pub(crate) fn of(
        count: u64,
        rig: impl Fn(u64) -> Driven + Sync,
        fit: impl Fn(u64, &Driven) -> Result<PingFit, Fault> + Sync,
    ) -> Self {
        let judged = |seed| {
            let driven = rig(seed);
            let fit = fit(seed, &driven)?;
            let error = fit.ping.s - driven.modes[0].0;
            let sd = |i: usize| fit.ping.covariance[(i, i)].sqrt();
            Ok([error.re / sd(0), error.im / sd(1)])
        };
        let found: Vec<Result<[f64; 2], Fault>> = (0..count).into_par_iter().map(judged).collect();
        let pulls: Vec<[f64; 2]> = found.iter().filter_map(|f| f.clone().ok()).collect();
        let mean = |of: &dyn Fn(f64) -> f64, i: usize| {
            pulls.iter().map(|p| of(p[i])).sum::<f64>() / pulls.len() as f64
        };
        Self {
            inside: [0, 1].map(|i| mean(&|p| f64::from(u8::from(p.abs() < 2.0)), i)),
            rms: [0, 1].map(|i| mean(&|p| p * p, i).sqrt()),
            worst: pulls.iter().flatten().fold(0.0, |a, p| p.abs().max(a)),
            used: pulls.len(),
            faults: found.into_iter().filter_map(Result::err).collect(),
        }
    }

    pub(crate) fn show(&self, name: &str) {
        let Self { inside, rms, worst, used, faults } = self;
        println!(
            "| {name} | {:.1} %, {:.1} % | {:.2}, {:.2} | {worst:.1} | {used} | {} |",
            100.0 * inside[0],
            100.0 * inside[1],
            rms[0],
            rms[1],
            faults.len()
        );
    }
}

/// Tails in decay times, with and without a loudspeaker that takes 3 ms to come to rest.
fn tails(count: u64, each: &[f64]) -> Vec<(String, Tally)> {
    let mut tallies = Vec::new();
    for (coast, colour) in [(0.0, 0.0), (0.0, 0.7), (0.003, 0.0), (0.003, 0.7)] {
        for &tail in each {
            let name =
                format!("{tail} decay times, noise of colour {colour}, at rest after {} ms", 1e3 * coast);
            let rig = |seed| Driven { coast, colour, ..any(seed, tail) };
            let tally = Tally::of(count, rig, |seed, driven| driven.fit(seed));
            tally.show(&name);
            tallies.push((name, tally));
        }
    }
    tallies
}

fn check(tallies: &[(String, Tally)]) {
    for (name, Tally { rms, worst, used, .. }) in tallies {
        assert!(*worst < 5.0, "{name}: {worst:.1} deviations");
        assert!(*used < 10 || rms.iter().all(|r| *r < 1.6), "{name}: {rms:?}");
    }
}

/// Before, one in five was off by more than five deviations, up to 7500.
#[test]
fn coverage_of_short_tails() {
    check(&tails(40, &[0.3, 1.0, 2.0]));
}

#[test]
#[ignore = "long: 200 records at each of 24 settings"]
fn coverage_of_tails_of_all_lengths_over_200_seeds() {
    check(&tails(200, &[0.3, 0.5, 1.0, 2.0, 3.0, 6.0]));
}

/// Why rigs without a fault are refused, by the first words of the reason.
#[test]
#[ignore = "a count: 200 records at each of two settings"]
fn coverage_reasons_for_which_sound_rigs_are_refused() {
    for (coast, tail) in [(0.0, 6.0), (0.003, 6.0)] {
        let rig = |seed| Driven { coast, ..any(seed, tail) };
        let tally = Tally::of(200, rig, |seed, driven| driven.fit(seed));
        tally.show(&format!("at rest after {} ms", 1e3 * coast));
        for seed in 0..200 {
            let driven = rig(seed);
            if let Err(fault) = driven.fit(seed) {
                let (mode_hz, tail) = (driven.modes[0].0.im / TAU, driven.end - driven.switched[0].1);
                println!(
                    "{:.1} periods, {:.0} samples, {mode_hz:.0} Hz, {} modes, {} channels: {fault}",
                    tail * mode_hz,
                    tail * driven.rate_hz,
                    driven.modes.len(),
                    driven.channels
                );
                // Modes above the highest frequency at which neighbours are sought are no part of the fit.
                if matches!(fault, Fault::Residual { .. }) {
                    let record = driven.record(seed);
                    let quiet = (driven.quiet * driven.rate_hz) as usize;
                    let (channels, rate_hz) = (&record, driven.rate_hz);
                    let trace = Trace { channels, rate_hz, quiet, full_scale: f64::INFINITY };
                    let (band_hz, highest_hz) = ((0.8 * mode_hz, 1.15 * mode_hz), 4.3 * mode_hz);
                    let options = PingOptions { band_hz, highest_hz, ..PingOptions::default() };
                    let again = fit_ping(&trace, &options).map(|fit| {
                        (fit.ping.s.re - driven.modes[0].0.re) / fit.ping.covariance[(0, 0)].sqrt()
                    });
                    println!("   with neighbours up to {highest_hz:.0} Hz: {again:?}");
                    assert!(again.is_err() || again.is_ok_and(|error| error.abs() < 4.0));
                }
            }
        }
        assert!(tally.used > 150, "{} used", tally.used);
    }
}

/// An amplitude of three times the noise of a sample: blocks of the plateau differ by a tenth. Before, most
/// were refused as a second excitation. Where there is one, the record is refused or its last decay is right.
#[test]
fn coverage_of_decays_in_strong_noise() {
    for ratio in [2.2, 3.3] {
        let faint = Driven {
            modes: vec![(C64::new(-6.0, TAU * 105.0), 1.0), (C64::new(-13.0, TAU * 318.0), 0.4)],
            forcing_hz: 106.0,
            switched: vec![(0.12, 0.5)],
            channels: 5,
            ratio,
            ..Driven::tube()
        };
        let tally = Tally::of(60, |_| faint.clone(), |seed, driven| driven.fit(seed));
        tally.show(&format!("amplitude over noise {ratio}"));
        tally.faults.iter().for_each(|fault| println!("{fault}"));
        assert!(tally.used >= 57 && tally.worst < 4.5, "{} used, {:.1} sd", tally.used, tally.worst);
        assert!(tally.rms.iter().all(|rms| (0.75..1.3).contains(rms)), "{:?}", tally.rms);
        let twice = Driven { switched: vec![(0.12, 0.5), (0.75, 1.1)], ..faint };
        let taken = Tally::of(20, |_| twice.clone(), |seed, driven| driven.fit(seed));
        // The last decay is as good as any, if nothing of what was before is in it.
        assert!(taken.used == 0 || taken.worst < 4.0, "{} used, {:.1} sd", taken.used, taken.worst);
    }
}

#[test]
fn behaviour_a_record_that_ends_80_ms_after_the_forcing_says_so() {
    let short = Driven { end: 1.13, ..Driven::tube() };
    let fault = short.fit(1).expect_err("too short");
    assert!(matches!(fault, Fault::ShortDecay { have, .. } if (0.01..0.08).contains(&have)), "{fault}");
}

#[test]
fn oracle_coloured_noise_is_learnt_where_there_is_no_silence() {
    let switched = vec![(0.0, 0.8)];
    let driven = Driven { quiet: 0.0, switched, colour: 0.8, ..Driven::tube() };
    let tally = Tally::of(10, |_| driven.clone(), |seed, driven| driven.fit(seed));
    assert!(tally.used == 10 && tally.worst < 4.0, "{} used, {}", tally.used, tally.worst);
}
