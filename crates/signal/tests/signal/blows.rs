//! Records of blows, against the truth and closed forms.

use rand_distr::{Distribution, StandardNormal};
use rijke_numerics::{C64, Matrix, Stream, Streams};
use rijke_signal::{BlowFit, BlowMode, BlowOptions, Channel, Fault, Mishap, combine_blows, fit_blow};
use std::f64::consts::TAU;

fn normal(stream: &mut Stream) -> f64 {
    StandardNormal.sample(stream)
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
    let mode = |s: C64| BlowMode { s, covariance: covariance.clone() };
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
fn behaviour_flat_tops_in_the_stretch_are_clipped() {
    let options = BlowOptions { stretch_s: [0.02, 0.3], highest_hz: 600.0, near_hz: vec![150.0] };
    let mut blow = struck(0.02, &mut Streams::new(6).stream("clipped"));
    blow.pop();
    let clipped: Vec<f64> = blow[0].iter().map(|v| v.clamp(-0.6, 0.6)).collect();
    let fault = fit_blow(&[clipped], 8000.0, &options).unwrap_err();
    assert!(matches!(fault, Fault::Clipped { .. }), "{fault}");
    // The blow itself may reach the limit of the channel.
    let loud: Vec<f64> = blow[0].iter().map(|v| v.clamp(-6.0, 6.0)).collect();
    assert!(fit_blow(&[loud], 8000.0, &options).is_ok());
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
