//! Pings that were not taken as a ping must be: what is said of them.

use crate::driven::Driven;
use rand_distr::{Distribution, StandardNormal};
use rijke_numerics::{C64, Streams};
use rijke_signal::{Fault, Mishap, Unstable};
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

#[test]
fn message_a_burst_of_hum_has_the_frequency_of_its_louder_harmonic() {
    let driven = Driven { modes: vec![(C64::new(-12.0, TAU * 230.0), 1.0)], forcing_hz: 230.2, ..ping() };
    let record = driven.record(1);
    // Where it begins, a burst of the second harmonic alone has more at the first one.
    let bursts = [([800.0, 300.0], 0.4), ([300.0, 800.0], 0.4), ([0.0, 800.0], 0.0), ([0.0, 800.0], 1.6)];
    for (sizes, phase) in bursts {
        let mut record = record.clone();
        for y in &mut record {
            for (n, v) in y.iter_mut().enumerate() {
                let (t, turn) = (n as f64 / driven.rate_hz, TAU * 50.0 * n as f64 / driven.rate_hz);
                if (0.75..0.85).contains(&t) {
                    *v += sizes[0] * (turn + phase).sin() + sizes[1] * (2.0 * turn + phase).sin();
                }
            }
        }
        match driven.fit_of(&record) {
            Err(Fault::HumBurst { at, frequency_hz, .. }) => {
                assert_eq!(frequency_hz, if sizes[0] > sizes[1] { 50.0 } else { 100.0 }, "phase {phase}");
                assert!((at - 0.75).abs() < 0.02, "{at}");
            }
            other => panic!("{sizes:?}, phase {phase}: {:?}", other.map(|fit| fit.ping.s)),
        }
    }
}

#[test]
fn message_a_tone_that_hardly_falls_is_no_decay() {
    // A loudspeaker that was turned down to six tenths, and then falls at a rate, 1/s.
    let fit = |rate: f64| {
        let driven =
            Driven { modes: vec![(C64::new(rate, TAU * 172.0), 1.0)], quiet: 0.19, ..Driven::tube() };
        let mut stream = Streams::new(3).stream("falls");
        let record: Vec<Vec<f64>> = (0..6)
            .map(|m| {
                let shape = 200.0 * (0.5 + 0.45 * f64::from(m)).sin();
                let sound = |t: f64| match t {
                    ..0.2 => 0.0,
                    ..0.6 => shape * (TAU * 172.0 * t).cos(),
                    _ => 0.6 * shape * (rate * (t - 0.6)).exp() * (TAU * 172.0 * t).cos(),
                };
                let noise = |stream: &mut _| -> f64 { StandardNormal.sample(stream) };
                (0..16_000).map(|n| sound(f64::from(n) * 1e-4) + noise(&mut stream)).collect()
            })
            .collect();
        driven.fit_of(&record)
    };
    match fit(-0.03) {
        Err(Fault::Unstable(Unstable::GoesOn { seconds, fall, .. })) => {
            assert!(
                seconds > 0.9 && (fall / (1.0 - (-0.03 * seconds).exp()) - 1.0).abs() < 0.1,
                "{seconds} s {fall}"
            );
        }
        other => panic!("{:?}", other.map(|fit| fit.ping.s)),
    }
    let slow = fit(-0.15).unwrap().ping;
    assert!((slow.s.re + 0.15).abs() < 4.0 * slow.covariance[(0, 0)].sqrt(), "{}", slow.s);
}

#[test]
fn message_strong_hum_is_named_with_its_frequency_and_share() {
    let driven = Driven { modes: vec![(C64::new(-12.0, TAU * 230.0), 1.0)], forcing_hz: 230.2, ..ping() };
    let mut record = driven.record(2);
    let top = record.iter().flatten().fold(0.0_f64, |a, v| a.max(v.abs()));
    for (m, y) in record.iter_mut().enumerate() {
        for (n, v) in y.iter_mut().enumerate() {
            let turn = TAU * 50.02 * n as f64 / driven.rate_hz;
            *v += 3.0 * top * ((turn + m as f64).cos() + 0.3 * (3.0 * turn).cos());
        }
    }
    match driven.fit_of(&record) {
        // Its third harmonic is the loudest tone in the band.
        Err(Fault::SteadyHum { frequency_hz, share, .. }) => {
            assert!(frequency_hz == 50.0 && (0.3 * share - 1.0).abs() < 0.05, "{frequency_hz} {share}");
        }
        other => panic!("{:?}", other.map(|fit| fit.ping.s)),
    }
}
