//! Mains hum beside a slow mode of low frequency: the end of the forcing must be found all the same.

use crate::driven::{Driven, three_errors};
use rijke_numerics::C64;
use rijke_signal::{Fault, PingOptions, Trace, fit_ping};
use std::f64::consts::TAU;

/// A quarter-wave tube at 67.5 Hz with its next mode at 234 Hz, driven for 0.6 s: the build-up is not over.
/// Four pascals in noise of 0.2 Pa, and hum of a given amplitude in Pa at 50, 100 and 150 Hz.
fn quarter_wave(growth_rate: f64, hum: f64, detuned: f64) -> Driven {
    Driven {
        rate_hz: 25_600.0,
        modes: vec![
            (C64::new(growth_rate, TAU * 67.5), 1.0),
            (C64::new(-7.0, TAU * 234.0), 1.0),
            (C64::new(-12.0, TAU * 380.0), 1.0),
        ],
        forcing_hz: 67.5 * (1.0 + detuned),
        quiet: 0.25,
        switched: vec![(0.25, 0.8563)],
        end: 1.55,
        ratio: 20.0 / (1.0 - (0.6 * growth_rate).exp()),
        hum: hum / 0.2,
        third: 0.5,
        ..Driven::tube()
    }
}

/// Records of each kind by default, and in the long studies.
const FEW: u64 = 20;
const MANY: u64 = 200;

/// Whether the errors of a study of so many records are as stated, and hardly any record is refused.
fn holds((inside, rms, refused): ([f64; 2], [f64; 2], usize), count: u64) -> bool {
    let (least, most) = three_errors(count);
    inside.iter().all(|v| *v > least) && rms.iter().all(|v| *v < most) && refused as u64 <= 1 + count / 100
}

#[test]
fn coverage_of_slow_decays_with_and_without_hum() {
    slow_decays(FEW);
}

#[test]
#[ignore = "long: 200 records of each of 8 kinds"]
fn coverage_of_slow_decays_with_and_without_hum_over_200_seeds() {
    slow_decays(MANY);
}

fn slow_decays(count: u64) {
    let mut wrong = Vec::new();
    for growth_rate in [-2.0, -4.14, -8.0, -16.0] {
        for hum in [0.0, 0.5] {
            let name = format!("{growth_rate} 1/s, hum of {hum} Pa");
            if !holds(quarter_wave(growth_rate, hum, 0.0).study(&name, count), count) {
                wrong.push(name);
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
fn coverage_of_a_loudspeaker_off_the_mode() {
    off_the_mode(FEW);
}

#[test]
#[ignore = "long: 200 records of each of 8 kinds"]
fn coverage_of_a_loudspeaker_off_the_mode_over_200_seeds() {
    off_the_mode(MANY);
}

fn off_the_mode(count: u64) {
    let mut wrong = Vec::new();
    for (growth_rate, detuned) in [(-4.14, 0.03), (-4.14, -0.03), (-8.0, 0.03), (-6.0, 0.05)] {
        for hum in [0.0, 0.15] {
            let name = format!("{growth_rate} 1/s, off by {detuned}, hum of {hum} Pa");
            if !holds(quarter_wave(growth_rate, hum, detuned).study(&name, count), count) {
                wrong.push(name);
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
fn behaviour_a_mode_that_was_not_driven_is_refused_with_the_frequency_that_was() {
    let driven = quarter_wave(-4.14, 0.0, 0.0);
    let mut taken_before = 0;
    for seed in 0..12 {
        let channels = driven.record(seed);
        let quiet = (driven.quiet * driven.rate_hz) as usize;
        let trace = Trace { channels: &channels, rate_hz: driven.rate_hz, quiet, full_scale: f64::INFINITY };
        // The band of a metre of tube holds the second mode alone.
        let fault = fit_ping(&trace, &PingOptions { reference: 2, ..PingOptions::default() }).expect_err("");
        let driven_hz = match fault {
            Fault::DrivenElsewhere { driven_hz, mode_hz, .. } => {
                assert!((mode_hz - 234.0).abs() < 5.0, "{mode_hz}");
                taken_before += 1;
                driven_hz
            }
            Fault::DrivenOutside { driven_hz, .. } => driven_hz,
            other => panic!("{other}"),
        };
        assert!((driven_hz - 67.5).abs() < 2.0, "{driven_hz}");
    }
    println!("{taken_before} of 12 were taken for the second mode");
}

#[test]
fn message_a_mode_that_rings_just_outside_the_band_is_named() {
    let driven = quarter_wave(-4.14, 0.0, 0.0);
    let channels = driven.record(3);
    let quiet = (driven.quiet * driven.rate_hz) as usize;
    let trace = Trace { channels: &channels, rate_hz: driven.rate_hz, quiet, full_scale: f64::INFINITY };
    let options = PingOptions { reference: 2, band_hz: (70.0, 130.0), ..PingOptions::default() };
    let said = fit_ping(&trace, &options).expect_err("").to_string();
    assert!(said.starts_with("the loudspeaker drives 67."), "{said}");
    assert!(said.contains("from 70 to 130 Hz") && said.ends_with("or correct the sampling rate"), "{said}");
}
