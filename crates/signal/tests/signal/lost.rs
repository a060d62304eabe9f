//! Samples that the acquisition lost, or repeated, in the decay.

use crate::driven::Driven;
use rijke_signal::{Fault, Mishap};

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
