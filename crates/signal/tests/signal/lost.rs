//! Samples that the acquisition lost, or repeated, in the decay.

use crate::driven::Driven;
use rijke_numerics::C64;
use rijke_signal::{Fault, Mishap};
use std::f64::consts::TAU;

#[test]
fn behaviour_lost_and_repeated_samples_are_named_with_their_moment() {
    let driven = Driven { quiet: 0.19, switched: vec![(0.2, 0.62)], end: 1.4, channels: 5, ..Driven::tube() };
    let driven = Driven { ratio: 400.0, ..driven };
    for seed in 0..3 {
        let record = driven.record(seed);
        for (at_s, samples) in [(0.73, 1_isize), (0.74, 3), (0.78, 59), (0.75, 190), (0.76, -2)] {
            let (mut harmed, at) = (record.clone(), (at_s * driven.rate_hz) as usize);
            for y in &mut harmed {
                if samples > 0 {
                    y.drain(at..at + samples as usize);
                } else {
                    let again = y[at - samples.unsigned_abs()..at].to_vec();
                    y.splice(at..at, again);
                }
            }
            match driven.fit_of(&harmed) {
                Err(Fault::Mishap(Mishap::LostSamples { at, samples: found, .. })) => {
                    assert_eq!(found, samples, "seed {seed}, {at_s} s");
                    assert!((at - at_s).abs() < 5e-4, "seed {seed}, {samples} at {at_s} s: {at}");
                }
                other => panic!("seed {seed}, {samples} at {at_s} s: {:?}", other.map(|fit| fit.ping.s)),
            }
        }
        // One channel alone lost them: the acquisition did not.
        let mut harmed = record.clone();
        harmed[3].remove(7400);
        harmed[3].push(0.0);
        let said = driven.fit_of(&harmed).unwrap_err();
        assert!(!matches!(said, Fault::Mishap(_)), "{said}");
    }
}

/// A single mode, 8 decay times of it, noisy enough for a lost sample not to be seen in the residuals.
fn faint() -> Driven {
    let modes = vec![(C64::new(-14.0, TAU * 107.0), 1.0)];
    let times = Driven { quiet: 0.19, switched: vec![(0.2, 0.62)], end: 1.2, ..Driven::tube() };
    Driven { modes, forcing_hz: 107.0, rate_hz: 12_800.0, ratio: 160.0, channels: 3, ..times }
}

#[test]
fn behaviour_one_sample_lost_in_a_faint_decay_is_no_drift_of_the_gas() {
    let driven = faint();
    let (mut named, mut refused, mut used) = (0, 0, 0);
    for seed in 0..20 {
        let record = driven.record(seed);
        assert!(driven.fit_of(&record).is_ok_and(|fit| !fit.drift.is_significant()), "{seed}");
        let mut harmed = record;
        let at = (0.62 + 0.8 / 14.0) * driven.rate_hz;
        for y in &mut harmed {
            y.remove(at as usize);
        }
        match driven.fit_of(&harmed) {
            Err(Fault::Mishap(Mishap::LostSamples { samples, at, .. })) => {
                assert!(samples == 1 && (at - 0.677).abs() < 0.02, "{seed}: {samples} at {at}");
                named += 1;
            }
            Err(_) => refused += 1,
            Ok(fit) => {
                let error = fit.ping.s - driven.modes[0].0;
                let pull = |i: usize, e: f64| e.abs() / fit.ping.covariance[(i, i)].sqrt();
                assert!(pull(0, error.re) < 5.0 && pull(1, error.im) < 5.0, "{seed}: {error}");
                used += 1;
            }
        }
    }
    assert!(named >= 14 && used <= 5, "{named} named, {refused} refused otherwise, {used} used");
}

#[test]
fn behaviour_a_weak_kick_in_the_decay_is_no_drift() {
    let driven = faint();
    let (mut refused, mut named) = (0, 0);
    for seed in 0..20 {
        let mut record = driven.record(seed);
        let first = ((0.62 + 1.0 / 14.0) * driven.rate_hz) as usize;
        for y in &mut record {
            y[first..].iter_mut().for_each(|v| *v *= 1.04);
        }
        match driven.fit_of(&record) {
            Err(fault) => {
                refused += 1;
                named += u32::from(
                    matches!(fault, Fault::Mishap(Mishap::Jumps { factor, .. }) if (factor - 1.04).abs() < 0.02),
                );
            }
            Ok(fit) => {
                let error = fit.ping.s - driven.modes[0].0;
                let pull = |i: usize, e: f64| e.abs() / fit.ping.covariance[(i, i)].sqrt();
                assert!(
                    pull(0, error.re) < 4.0 && pull(1, error.im) < 4.0,
                    "{seed}: {error} {:?}",
                    fit.window
                );
            }
        }
    }
    assert!(refused >= 15 && named >= 8, "{refused} of 20 refused, {named} of them as a jump");
}

#[test]
fn message_of_lost_samples_says_when_and_how_many() {
    let of = |samples: isize| {
        let seconds = samples as f64 * 1e-4;
        Mishap::LostSamples { at: 0.70031, samples, seconds, frequency_hz: 170.0 }.to_string()
    };
    assert!(of(1).starts_with(
        "at 0.7003 s 1 sample is missing: the phase of all channels jumps there by 6.1 degrees"
    ));
    assert!(
        of(-2).starts_with("at 0.7003 s 2 samples are there twice") && of(-2).contains("0.200 ms earlier")
    );
    assert!(of(59).contains("The acquisition lost samples: record again"), "{}", of(59));
}
