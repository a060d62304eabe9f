//! Random noise, against closed forms, plain sums and the truth.

use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use rijke_numerics::{C64, Stream, Streams};
use rijke_signal::{
    LossBand, RelativePressures, Spectra, SwitchedDoubt, SwitchedFault, SwitchedGains, TransmissionTube,
    TubeErrors,
};
use std::f64::consts::{PI, TAU};

fn normal(stream: &mut Stream) -> f64 {
    StandardNormal.sample(stream)
}

#[test]
fn oracle_cross_spectra_are_plain_sums() {
    let mut stream = Streams::new(1).stream("spectra");
    let channels: Vec<Vec<f64>> =
        (0..2).map(|_| (0..96).map(|_| 0.3 + normal(&mut stream)).collect()).collect();
    let (rate, n) = (64.0, 32);
    let found = Spectra::welch(&channels, rate, n, [5.0, 21.0]).unwrap();
    assert_eq!(found.frequency_hz, (3..=10).map(|k| 2.0 * f64::from(k)).collect::<Vec<_>>());
    let estimates = found.transfer(0, 1);
    for (f, estimate) in found.frequency_hz.iter().zip(&estimates) {
        let mut sums = [C64::ZERO; 3];
        for start in (0..=64).step_by(16) {
            let spectrum = |c: usize| -> C64 {
                let part = &channels[c][start..start + n];
                let mean = part.iter().sum::<f64>() / n as f64;
                let term = |(k, v): (usize, &f64)| {
                    let window = (PI * k as f64 / n as f64).sin().powi(2);
                    (v - mean) * window * C64::from_polar(1.0, -TAU * f * k as f64 / rate)
                };
                part.iter().enumerate().map(term).sum()
            };
            let (a, b) = (spectrum(0), spectrum(1));
            sums[0] += a.conj() * a;
            sums[1] += a.conj() * b;
            sums[2] += b.conj() * b;
        }
        assert!((estimate.value - sums[1] / sums[0]).norm() < 1e-12);
        let coherence = sums[1].norm_sqr() / (sums[0].re * sums[2].re);
        assert!((estimate.coherence - coherence).abs() < 1e-12);
        let sd = ((1.0 - coherence) / (2.0 * coherence * found.averages)).sqrt();
        assert!((estimate.relative_sd - sd).abs() < 1e-12);
    }
    // Five segments that overlap by half, each with 1/36 of the variance of its neighbours.
    let double: f64 = (1..5).map(|k| if k == 1 { 4.0 / 36.0 } else { 0.0 }).sum::<f64>() * 2.0 / 25.0;
    assert!((1.0 / found.averages - (0.2 + double)).abs() < 1e-12, "{}", found.averages);
}

/// A record of a sound field of two waves and their echoes, channel c at place `order[c]`, with gains of the
/// channels a_c + b_c z^-1, and noise.
fn record(order: &[usize], stream: &mut Stream) -> Vec<Vec<f64>> {
    const LENGTH: usize = 40_000;
    const GAINS: [[f64; 2]; 3] = [[1.0, 0.0], [1.1, 0.05], [0.8, -0.08]];
    let source: Vec<f64> = (0..LENGTH + 200).map(|_| normal(stream)).collect();
    let place = |m: usize, n: usize| {
        let late = |d: usize| source[n + 200 - d];
        late(3 + 7 * m) + 0.6 * late(60 - 5 * m) + 0.3 * late(150 + 4 * m)
    };
    let mut one = |(c, m): (usize, &usize)| -> Vec<f64> {
        let mut before = 0.0;
        let [a, b] = GAINS[c];
        (0..LENGTH)
            .map(|n| {
                let p = place(*m, n);
                let heard = a * p + b * before;
                before = p;
                heard + 0.02 * normal(stream)
            })
            .collect()
    };
    order.iter().enumerate().map(&mut one).collect()
}

/// Those gains at a frequency (Hz) of records of 10 kHz.
fn gain(c: usize, f: f64) -> C64 {
    let [a, b] = [[1.0, 0.0], [1.1, 0.05], [0.8, -0.08]][c];
    a + b * C64::from_polar(1.0, -TAU * f / 1e4)
}

#[test]
fn coverage_gains_of_switched_channels_lie_within_their_errors() {
    let (mut within, mut all) = (0_u32, 0_u32);
    for seed in 0..12 {
        let mut stream = Streams::new(seed).stream("switched");
        let mut spectra = |order: &[usize]| {
            Spectra::welch(&record(order, &mut stream), 1e4, 2048, [300.0, 3000.0]).unwrap()
        };
        let straight = spectra(&[0, 1, 2]);
        let switched = [(1, spectra(&[1, 0, 2])), (2, spectra(&[2, 1, 0]))];
        let found = SwitchedGains::new(&straight, &switched, 3, 4).unwrap();
        assert!(found.gains[0].iter().all(|g| *g == C64::ONE));
        for c in 1..3 {
            // Three of them are as many as four polynomials tell.
            for k in [40, 280, 500] {
                let f = found.frequency_hz[k];
                let error = (found.gains[c][k] / gain(c, f)).ln();
                let sd = found.relative_sd[c][k];
                assert!(
                    sd < 4e-3 && error.norm() < 6.0 * sd,
                    "{seed}, channel {c} at {f} Hz: {error} +- {sd}"
                );
                for part in [error.re, error.im] {
                    (within, all) = (within + u32::from(part.abs() < 2.0 * sd), all + 1);
                }
            }
        }
        for pair in &found.pairs {
            assert!(pair.distance < 5.0 * pair.sd, "{pair:?}");
        }
    }
    let share = f64::from(within) / f64::from(all);
    assert!((0.88..=1.0).contains(&share), "{within} of {all}");
}

/// By record, channel and sample.
type Records = Vec<Vec<Vec<f64>>>;

/// Records of channels that changed places, straight first; what `change` does to them; and what is said of
/// them.
fn doubt_of(seed: u64, change: impl Fn(&mut Records)) -> (SwitchedGains, Option<SwitchedDoubt>) {
    let mut stream = Streams::new(seed).stream("doubts");
    let orders = [[0, 1, 2], [1, 0, 2], [2, 1, 0]];
    let mut records: Records = orders.iter().map(|order| record(order, &mut stream)).collect();
    change(&mut records);
    let spectra = |k: usize| Spectra::welch(&records[k], 1e4, 2048, [300.0, 3000.0]).unwrap();
    let (straight, switched) = (spectra(0), [(1, spectra(1)), (2, spectra(2))]);
    let gains = SwitchedGains::new(&straight, &switched, 3, 4).unwrap();
    let doubt = gains.doubt(&straight, &switched, 4);
    (gains, doubt)
}

fn turn(channel: &mut [f64]) {
    channel.iter_mut().for_each(|v| *v = -*v);
}

#[test]
fn behaviour_sound_records_of_switched_channels_raise_no_alarm_over_200_seeds() {
    let alarms: Vec<u64> = (0..200_u64)
        .into_par_iter()
        .filter(|seed| {
            let (gains, doubt) = doubt_of(*seed, |_| ());
            doubt.is_some() || !gains.inverted().is_empty()
        })
        .collect();
    assert!(alarms.is_empty(), "{alarms:?}");
}

#[test]
fn behaviour_exchanged_and_inverted_records_are_named() {
    let told = |fault: SwitchedFault, change: &dyn Fn(&mut Records)| {
        for seed in 0..5 {
            let (_, doubt) = doubt_of(seed, change);
            let doubt = doubt.unwrap_or_else(|| panic!("{fault:?}: nothing is said"));
            assert_eq!(doubt.fault, fault, "{doubt:?}");
            assert!(doubt.before > 0.1 && doubt.after < 0.01, "{doubt:?}");
        }
    };
    told(SwitchedFault::Records([1, 2]), &|r| r.swap(1, 2));
    told(SwitchedFault::Records([0, 1]), &|r| r.swap(0, 1));
    told(SwitchedFault::Channels { record: 1, channels: [0, 2] }, &|r| r[1].swap(0, 2));
    for (record, channel) in [(0, 1), (0, 2), (1, 1), (2, 2), (2, 0)] {
        let fault = SwitchedFault::Inverted { record: Some(record), channel };
        told(fault, &|r| turn(&mut r[record][channel]));
    }
}

#[test]
fn behaviour_a_channel_that_is_always_inverted_has_a_gain_of_minus_one() {
    let (sound, _) = doubt_of(3, |_| ());
    let (gains, doubt) = doubt_of(3, |r| r.iter_mut().for_each(|record| turn(&mut record[2])));
    assert_eq!((gains.inverted(), doubt), (vec![2], None));
    for (a, b) in gains.gains[2].iter().zip(&sound.gains[2]) {
        assert!((a + b).norm() < 1e-9, "{a} {b}");
    }
    // Of three microphones two estimates cannot tell whether another one was inverted while this one changed
    // places.
    let (gains, doubt) = doubt_of(3, |r| turn(&mut r[1][2]));
    assert_eq!((gains.inverted(), doubt), (vec![1], None));
}

/// Microphones 0.5, 0.3 and 0.2 m before and behind a thin mass at 1 m, and the pressures there with an end
/// that reflects, in a pipe whose walls take something.
fn tube_with_mass(f: f64, sound_speed: f64) -> (TransmissionTube, Vec<C64>, C64) {
    let places = vec![0.5, 0.7, 0.8, 1.2, 1.3, 1.5];
    // Layers of pipes of 60 and 30 mm, half as rough again.
    let (layers, wall_factor) = ([4e-4, 8e-4], 1.5);
    let tube =
        TransmissionTube { places: places.clone(), between: [1.0, 1.0], sound_speed, layers, wall_factor };
    let k = TAU * f / sound_speed;
    let mass = C64::new(0.0, 2e-3 * f);
    // Behind it: c = 1 and d by an end at 2 m. Velocity times rho c is the same on both sides.
    let (c, d) = (C64::ONE, C64::from_polar(0.7, 2.0 - 2.0 * k));
    let (p, u) = (c + d + mass * (c - d), c - d);
    let (a, b) = (0.5 * (p + u), 0.5 * (p - u));
    let at = |x: &f64| {
        let (down, up, layer) = if *x < 1.0 { (a, b, 6e-4) } else { (c, d, 12e-4) };
        let wave = C64::new(0.0, k) + C64::new(1.0, 1.0) * layer * (TAU * f).sqrt();
        down * (-wave * (x - 1.0)).exp() + up * (wave * (x - 1.0)).exp()
    };
    (tube, places.iter().map(at).collect(), 2.0 / (2.0 + mass))
}

#[test]
fn exact_a_mass_lets_through_what_it_must() {
    for f in [210.0, 555.0, 1234.0] {
        let (tube, pressures, coefficient) = tube_with_mass(f, 343.0);
        let found = tube.transmitted(f, &pressures).unwrap();
        assert!((found.coefficient - coefficient).norm() < 1e-9, "{found:?} {coefficient}");
        assert!((found.energy - 1.0).abs() < 1e-9, "{found:?}");
        let [loss, sd] = tube.loss(f, &pressures, &[0.0; 6], &TubeErrors::default()).unwrap();
        assert!((loss + 20.0 * coefficient.norm().log10()).abs() < 1e-8 && sd == 0.0, "{loss} {sd}");
    }
    // By bands of 100 Hz: the median of three frequencies.
    let (tube, _, _) = tube_with_mass(300.0, 343.0);
    let frequency_hz = vec![310.0, 320.0, 330.0, 455.0];
    let heard = RelativePressures {
        pressures: frequency_hz.iter().map(|f| tube_with_mass(*f, 343.0).1).collect(),
        relative_sd: vec![vec![0.0; 6]; 4],
        frequency_hz,
        left_out: 0,
        of_the_source: vec![1.0; 6],
    };
    assert_eq!(tube.sides(), [3, 3]);
    let bands = LossBand::of(&tube.losses(&heard, &TubeErrors::default()));
    assert!(
        bands.len() == 2 && bands[0].from_to_hz == [300.0, 400.0] && bands[1].from_to_hz == [400.0, 500.0]
    );
    for (band, f) in bands.iter().zip([320.0, 455.0]) {
        let loss = -20.0 * tube_with_mass(f, 343.0).2.norm().log10();
        assert!((band.loss_db[0] - loss).abs() < 1e-8 && (band.energy - 1.0).abs() < 1e-9, "{band:?} {loss}");
    }
    // One microphone of a side cannot tell two waves apart.
    let (tube, pressures, _) = tube_with_mass(300.0, 343.0);
    let less = TransmissionTube { places: tube.places[2..].to_vec(), ..tube };
    assert_eq!(less.transmitted(300.0, &pressures[2..]), None);
}

#[test]
fn oracle_errors_of_the_loss_are_those_of_random_trials() {
    let (tube, pressures, _) = tube_with_mass(700.0, 343.0);
    let all = TubeErrors { place: 1e-3, sound_speed: 2e-3, wall_factor: 0.4 };
    let speed = TubeErrors { place: 0.0, sound_speed: 2e-4, wall_factor: 0.0 };
    for (more, sds) in [(all, [0.0, 0.01, 0.02, 0.01, 0.015, 0.01]), (speed, [0.0; 6])] {
        let [middle, sd] = tube.loss(700.0, &pressures, &sds, &more).unwrap();
        let mut stream = Streams::new(2).stream("loss");
        let trial = |_| {
            let mut other = tube.clone();
            other.places.iter_mut().for_each(|x| *x += more.place * normal(&mut stream));
            other.sound_speed *= 1.0 + more.sound_speed * normal(&mut stream);
            other.wall_factor += more.wall_factor * normal(&mut stream);
            let mut noise = |sd: &f64| 1.0 + sd * C64::new(normal(&mut stream), normal(&mut stream));
            let p: Vec<C64> = pressures.iter().zip(&sds).map(|(p, sd)| p * noise(sd)).collect();
            -20.0 * other.transmitted(700.0, &p).unwrap().coefficient.norm().log10()
        };
        let trials: Vec<f64> = (0..20_000).map(trial).collect();
        let n = trials.len() as f64;
        let mean = trials.iter().sum::<f64>() / n;
        let spread = (trials.iter().map(|t| (t - mean).powi(2)).sum::<f64>() / n).sqrt();
        assert!((sd / spread - 1.0).abs() < 0.05, "{more:?}: {sd} {spread}");
        assert!((mean - middle).abs() < 0.2 * sd, "{more:?}: {mean} {middle}");
    }
}
