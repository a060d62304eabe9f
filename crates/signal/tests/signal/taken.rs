//! Pings that were not taken as a ping must be: what is said of them.

use crate::driven::Driven;
use rand_distr::{Distribution, StandardNormal};
use rijke_numerics::{C64, Streams};
use rijke_signal::{Fault, Mishap};
use std::f64::consts::TAU;

fn ping() -> Driven {
    Driven {
        modes: vec![(C64::new(-12.0, TAU * 170.0), 1.0), (C64::new(-18.0, TAU * 341.0), 1.0)],
        forcing_hz: 170.3,
        quiet: 0.19,
        switched: vec![(0.2, 0.62)],
        end: 1.4,
        channels: 5,
        ratio: 400.0,
        ..Driven::tube()
    }
}

#[test]
fn behaviour_a_mode_far_from_the_forcing_is_named_with_both_frequencies() {
    for driven_hz in [0.72 * 170.0, 1.3 * 170.0] {
        let driven = Driven { forcing_hz: driven_hz, ..ping() };
        for seed in 0..3 {
            match driven.fit(seed) {
                Err(Fault::DrivenElsewhere { driven_hz: found, mode_hz, .. }) => {
                    assert!(
                        (found - driven_hz).abs() < 1.5 && (mode_hz - 170.0).abs() < 2.0,
                        "{found} {mode_hz}"
                    );
                }
                other => panic!("{driven_hz} Hz, seed {seed}: {:?}", other.map(|fit| fit.ping.s)),
            }
        }
    }
}

#[test]
fn behaviour_noise_that_is_louder_after_the_release_is_named_and_the_remedy_helps() {
    let driven = ping();
    for seed in 0..3 {
        let mut record = driven.record(seed);
        let mut stream = Streams::new(seed).stream("louder");
        for y in &mut record {
            for v in y.iter_mut().skip(6200) {
                let more: f64 = StandardNormal.sample(&mut stream);
                *v += 3.0 * more;
            }
        }
        match driven.fit_of(&record) {
            Err(Fault::Mishap(Mishap::Louder { times, from })) => {
                assert!(
                    (times - 10.0_f64.sqrt()).abs() < 0.3 && (from - 0.62).abs() < 0.05,
                    "{times} {from}"
                );
            }
            other => panic!("seed {seed}: {:?}", other.map(|fit| fit.ping.s)),
        }
        let fit = Driven { quiet: 0.0, ..driven.clone() }.fit_of(&record).unwrap();
        let error = fit.ping.s - driven.modes[0].0;
        let pulls = [error.re, error.im].map(|e| e.abs());
        assert!((0..2).all(|i| pulls[i] < 4.5 * fit.ping.covariance[(i, i)].sqrt()), "{error}");
        // A decay that leaves more than noise for another reason does not leave it alike to the end.
        let mut record = driven.record(seed);
        record.iter_mut().for_each(|y| (9000..9400).for_each(|n| y[n] += 40.0 * (0.3 * n as f64).sin()));
        let said = driven.fit_of(&record).unwrap_err();
        assert!(!matches!(said, Fault::Mishap(Mishap::Louder { .. })), "{said}");
    }
}

#[test]
fn message_several_pings_in_one_file_are_named() {
    let driven = ping();
    for seed in 0..3 {
        let record: Vec<Vec<f64>> =
            driven.record(seed).into_iter().map(|y| [y.clone(), y].concat()).collect();
        let said = driven.fit_of(&record).unwrap_err();
        assert!(matches!(said, Fault::SecondExcitation { factor, .. } if factor > 100.0), "{said}");
        assert!(said.to_string().ends_with("give every ping a file of its own"), "{said}");
    }
}
