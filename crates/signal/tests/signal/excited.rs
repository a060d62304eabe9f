//! Random noise and blows, against closed forms, plain sums and the truth.

use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use rijke_numerics::{C64, Matrix, Stream, Streams};
use rijke_signal::{
    BlowFit, BlowMode, BlowOptions, Channel, Fault, LossBand, Mishap, RelativePressures, Spectra,
    SwitchedDoubt, SwitchedFault, SwitchedGains, TransmissionTube, TubeErrors, combine_blows, fit_blow,
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

/// Growth rate, frequency (Hz) and size of what sounds.
const MODES: [[f64; 3]; 5] =
    [[-14.0, 150.0, 1.0], [-17.0, 222.0, 0.5], [-19.0, 293.0, 0.9], [-22.0, 368.0, 0.5], [-25.0, 446.0, 0.4]];

/// 10 ms of silence, a blow, and the decay; in two channels that are the same, as recorders of one microphone
/// write them.
fn struck(noise: f64, stream: &mut Stream) -> Vec<Vec<f64>> {
    let rate = 8000.0;
    let phases: Vec<f64> = MODES.iter().map(|_| TAU * normal(stream)).collect();
    let channel: Vec<f64> = (0..3000)
        .map(|n| {
            let t = f64::from(n) / rate - 0.01;
            let ring = |(m, phase): (&[f64; 3], &f64)| {
                if t < 0.0 { 0.0 } else { m[2] * (m[0] * t).exp() * (TAU * m[1] * t + phase).cos() }
            };
            let blow = if (0.0..0.004).contains(&t) { 8.0 * normal(stream) } else { 0.0 };
            MODES.iter().zip(&phases).map(ring).sum::<f64>() + blow + noise * normal(stream)
        })
        .collect();
    vec![channel.clone(), channel]
}

#[test]
fn coverage_modes_of_a_blow_lie_within_their_errors() {
    let options = BlowOptions {
        stretch_s: [0.02, 0.3],
        highest_hz: 600.0,
        near_hz: MODES.iter().map(|m| m[1] + 3.0).chain([550.0]).collect(),
    };
    let (mut within, mut all) = (0_u32, 0_u32);
    for seed in 0..20 {
        let mut stream = Streams::new(seed).stream("blow");
        let fits: Vec<_> =
            (0..2).map(|_| fit_blow(&struck(0.02, &mut stream), 8000.0, &options).unwrap()).collect();
        for fit in &fits {
            assert!(fit.onsets_s.len() == 1 && (fit.onsets_s[0] - 0.01).abs() < 1.5e-3, "{:?}", fit.onsets_s);
        }
        let found = combine_blows(&fits);
        assert!(found.modes[5].is_none(), "{:?}", found.modes[5]);
        for (mode, truth) in found.modes.iter().zip(&MODES) {
            let mode = mode.as_ref().unwrap();
            for (k, error) in [mode.s.re - truth[0], mode.s.im - TAU * truth[1]].into_iter().enumerate() {
                let sd = mode.covariance[(k, k)].sqrt();
                assert!(sd < 4.0, "{sd}");
                (within, all) = (within + u32::from(error.abs() < 2.0 * sd), all + 1);
            }
        }
    }
    // Starts share most of the record, so that their scatter adds to an error that is there already: more
    // than 95 %.
    let share = f64::from(within) / f64::from(all);
    assert!((0.93..=1.0).contains(&share), "{within} of {all}");
}

#[test]
fn exact_means_of_blows_count_noise_once() {
    // Twelve records whose modes scatter as their fits say: the variance of the mean is a twelfth of that.
    let mut stream = Streams::new(3).stream("means");
    let covariance = Matrix::diagonal(&[4.0, 9.0]);
    let mode = |s: C64| BlowMode { s, covariance: covariance.clone(), excess: None };
    let mut fits: Vec<BlowFit> = (0..12)
        .map(|_| {
            let modes = (0..20).map(|k| {
                let truth = C64::new(-20.0, 1000.0 * f64::from(k + 1));
                Some(mode(truth + C64::new(2.0 * normal(&mut stream), 3.0 * normal(&mut stream))))
            });
            BlowFit { onsets_s: vec![0.0], modes: modes.collect() }
        })
        .collect();
    let found = combine_blows(&fits);
    assert!(found.outliers.is_empty(), "{:?}", found.outliers);
    for mode in found.modes.iter().flatten() {
        for (k, noise) in [4.0, 9.0].into_iter().enumerate() {
            let ratio = (mode.covariance[(k, k)] / (noise / 12.0)).sqrt();
            assert!((1.0..1.25).contains(&ratio), "{ratio}");
        }
    }
    // A mode that one record lacks, and another record that has it far away: places are those of the records.
    fits[0].modes[3] = None;
    fits[7].modes[3].as_mut().unwrap().s.re += 500.0;
    let found = combine_blows(&fits);
    let [(7, why)] = &found.outliers[..] else { panic!("{:?}", found.outliers) };
    assert!(why.to_string().starts_with("growth rate of the mode at 636."), "{why}");
    assert!((found.modes[3].as_ref().unwrap().s.re + 20.0).abs() < 3.0);
    // One record alone says what it says; none says nothing.
    let one = combine_blows(&fits[..1]);
    assert!(one.modes[3].is_none() && one.modes[4].as_ref().unwrap().covariance == covariance);
    assert!(combine_blows(&[]).modes.is_empty());
}

#[test]
fn behaviour_what_does_not_become_quieter_is_no_blow() {
    let options =
        BlowOptions { stretch_s: [0.03, 0.5], highest_hz: 620.0, near_hz: vec![104.0, 313.0, 524.0] };
    for seed in 0..60 {
        let mut stream = Streams::new(seed).stream("noise");
        let noise = |stream: &mut Stream| (0..9600).map(|_| normal(stream)).collect::<Vec<f64>>();
        let channels: Vec<Vec<f64>> = (0..3).map(|_| noise(&mut stream)).collect();
        let said = fit_blow(&channels, 16_000.0, &options).unwrap_err();
        assert!(matches!(said, Fault::Mishap(Mishap::NoBlow { .. })), "{seed}: {said}");
    }
}

#[test]
fn behaviour_damping_of_a_blow_that_depends_on_the_amplitude_widens_its_error() {
    let options = BlowOptions { stretch_s: [0.03, 0.5], highest_hz: 620.0, near_hz: vec![313.0] };
    let (mut pulls, mut said) = (0.0, 0);
    for seed in 0..10 {
        let mut stream = Streams::new(seed).stream("bent");
        let phase = TAU * normal(&mut stream);
        let ring = |n: i32, stream: &mut Stream| {
            let t = f64::from(n) / 16_000.0 - 0.05;
            let envelope = 5.0 * (-9.0 * t).exp() / (1.0 + 0.3 * (1.0 - (-9.0 * t).exp()));
            let sound = if t < 0.0 { 0.0 } else { envelope * (TAU * 313.0 * t + phase).cos() };
            let blow = if (0.0..0.004).contains(&t) { 20.0 * normal(stream) } else { 0.0 };
            sound + blow + 0.01 * normal(stream)
        };
        let channel: Vec<f64> = (0..9600).map(|n| ring(n, &mut stream)).collect();
        let found = fit_blow(&[channel.clone()], 16_000.0, &options).unwrap();
        let mode = found.modes[0].as_ref().unwrap();
        said += u32::from(mode.excess.is_some_and(|[share, _]| share > 0.0));
        pulls += (mode.s.re + 9.0).powi(2) / mode.covariance[(0, 0)];
        // A channel that reaches its limit while it rings is no decay.
        let clipped: Vec<f64> = channel.iter().map(|v| v.clamp(-2.0, 2.0)).collect();
        let fault = fit_blow(&[clipped], 16_000.0, &options).unwrap_err();
        assert!(matches!(fault, Fault::Clipped { .. }), "{fault}");
    }
    let rms = (pulls / 10.0_f64).sqrt();
    assert!(said == 10 && rms < 1.5, "{said} of 10, rms {rms}");
}

#[test]
fn behaviour_offsets_of_a_blow_do_not_matter_and_broken_channels_are_refused() {
    let options = BlowOptions { stretch_s: [0.02, 0.3], highest_hz: 600.0, near_hz: vec![150.0] };
    let mut blow = struck(0.02, &mut Streams::new(5).stream("offset"));
    blow.pop();
    let fit = |channels: &[Vec<f64>]| fit_blow(channels, 8000.0, &options);
    let level = fit(&blow).unwrap();
    // More than a tenth of the peak: without its removal the blow begins with the record.
    let offset: Vec<f64> = blow[0].iter().map(|v| v + 8.0).collect();
    let found = fit(&[offset]).unwrap();
    assert_eq!(found.onsets_s, level.onsets_s);
    let [a, b] = [&level, &found].map(|f| f.modes[0].as_ref().unwrap());
    assert!((a.s - b.s).norm() < 1e-6 && (a.covariance[(0, 0)] - b.covariance[(0, 0)]).abs() < 1e-6);
    let mut bad = blow.clone();
    bad[0][99] = f64::NAN;
    assert_eq!(fit(&bad), Err(Fault::NotFinite { channel: Channel::Place(0), sample: 99 }));
    bad = vec![blow[0].clone(), vec![0.3; blow[0].len()]];
    let dead = fit(&bad).unwrap_err();
    assert!(matches!(dead, Fault::DeadChannel { channel: Channel::Place(1), .. }), "{dead}");
}

#[test]
fn behaviour_a_second_blow_ends_the_decay_of_the_first() {
    let mut stream = Streams::new(7).stream("two blows");
    let (first, second) = (struck(0.02, &mut stream), struck(0.02, &mut stream));
    let both: Vec<f64> = first[0].iter().chain(&second[0]).copied().collect();
    let options = BlowOptions { stretch_s: [0.02, 0.6], highest_hz: 600.0, near_hz: vec![150.0] };
    let fit = fit_blow(&[both], 8000.0, &options).unwrap();
    assert_eq!(fit.onsets_s.len(), 2, "{:?}", fit.onsets_s);
    let mode = fit.modes[0].as_ref().unwrap();
    assert!((mode.s.im / TAU - 150.0).abs() < 1.0 && (mode.s.re + 14.0).abs() < 4.0, "{mode:?}");
    let late = BlowOptions { stretch_s: [0.5, 0.6], ..options };
    assert!(fit_blow(&first, 8000.0, &late).is_err());
}
