//! Records of a converter whose steps are larger than the noise, and silence that is none.

use crate::driven::Driven;
use crate::short::{Tally, any};
use rijke_signal::Fault;

/// The samples rounded to steps.
fn rounded(record: &[Vec<f64>], step: f64) -> Vec<Vec<f64>> {
    let of = |y: &Vec<f64>| y.iter().map(|v| (v / step).round() * step).collect();
    record.iter().map(of).collect()
}

#[test]
fn coverage_of_coarse_converters() {
    check(40, &[(0.02, 30.0), (0.1, 15.0), (0.5, 30.0)]);
}

#[test]
#[ignore = "long: 200 records of each of seven converters"]
fn coverage_of_coarse_converters_over_200_seeds() {
    let more = [(0.02, 30.0), (0.1, 15.0), (0.1, 30.0), (0.1, 200.0), (0.3, 30.0), (0.5, 30.0), (1.0, 30.0)];
    check(200, &more);
}

fn check(count: u64, converters: &[(f64, f64)]) {
    for &(noise, steps) in converters {
        // An amplitude of so many steps, and noise of that share of one.
        let rig = |seed| Driven { ratio: 2.0 * steps / noise, ..any(seed, 5.0) };
        let tally =
            Tally::of(count, rig, |seed, driven| driven.fit_of(&rounded(&driven.record(seed), 1.0 / noise)));
        let name = format!("{steps} steps, noise of {noise} steps");
        tally.show(&name);
        assert!(tally.worst < 5.0 && tally.rms.iter().all(|r| *r < 1.4), "{name}");
        assert!(
            !tally.faults.iter().any(|f| matches!(f, Fault::Dropout { .. } | Fault::Clipped { .. })),
            "{name}"
        );
        assert!(tally.used as u64 > count / 3, "{name}");
    }
}

#[test]
fn behaviour_a_signal_below_the_converter_s_steps_is_refused_with_the_step() {
    let driven = Driven { ratio: 60.0, ..Driven::tube() };
    for step in [20.0, 30.0, 50.0] {
        let fault = driven.fit_of(&rounded(&driven.record(1), step)).expect_err("coarse");
        assert!(
            matches!(fault, Fault::Coarse { step: s, .. } if (s / step - 1.0).abs() < 1e-9),
            "{step}: {fault}"
        );
    }
}

#[test]
fn behaviour_silence_that_holds_forcing_is_refused_with_both_numbers() {
    for (seed, covered) in [(1, 0.1), (2, 0.2), (3, 0.4), (4, 0.8)] {
        let driven = any(seed, 4.0);
        let wrong = Driven { quiet: driven.quiet + covered * 0.4, ..driven.clone() };
        let fault = wrong.fit(seed).expect_err("not quiet");
        let Fault::NotQuiet { stated, found, .. } = fault else { panic!("{covered}: {fault}") };
        assert_eq!(stated, (wrong.quiet * wrong.rate_hz) as usize);
        let silent = driven.quiet * driven.rate_hz;
        assert!((found as f64) < 1.05 * silent && found as f64 > 0.5 * silent, "{found} of {silent}");
    }
    // The record begins within the forcing.
    let loud = Driven { switched: vec![(0.0, 1.5)], ..Driven::tube() };
    let late: Vec<Vec<f64>> = loud.record(1).iter().map(|y| y[7000..].to_vec()).collect();
    let fault = loud.fit_of(&late).expect_err("not quiet");
    assert!(matches!(fault, Fault::NotQuiet { found: 0, .. }), "{fault}");
}
