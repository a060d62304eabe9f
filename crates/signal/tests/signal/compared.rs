//! Channels that hear the same pressure, against the truth.

use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use rijke_numerics::{C64, Stream, Streams};
use rijke_signal::{ChannelGains, ComparedChannels, ComparisonFault, RelativePressures, Spectra};
use rustfft::FftPlanner;
use std::f64::consts::TAU;

const RATE: f64 = 8000.0;
const BAND: [f64; 2] = [50.0, 300.0];
/// Gain, delay (s), noise (relative to the sound).
const TRUTH: [[f64; 3]; 4] =
    [[1.0, 0.0, 0.05], [1.07, 31e-6, 0.02], [-0.92, -12e-6, 0.15], [0.8, 250e-6, 0.05]];

fn normal(stream: &mut Stream) -> f64 {
    StandardNormal.sample(stream)
}

/// Noise of 40 to 400 Hz, whose spectrum a delay turns exactly, and white noise of every channel.
fn record(seconds: f64, truth: &[[f64; 3]], stream: &mut Stream) -> Vec<Vec<f64>> {
    let count = (seconds * RATE) as usize;
    let bins = (40.0 * seconds) as usize..(400.0 * seconds) as usize;
    let size = (2.0 * bins.len() as f64).sqrt();
    let source: Vec<C64> = bins.clone().map(|_| C64::new(normal(stream), normal(stream)) / size).collect();
    let inverse = FftPlanner::new().plan_fft_inverse(count);
    let mut one = |[gain, delay, noise]: &[f64; 3]| -> Vec<f64> {
        let mut spectrum = vec![C64::ZERO; count];
        for (k, value) in bins.clone().zip(&source) {
            spectrum[k] = 2.0 * value * C64::from_polar(1.0, -TAU * k as f64 / seconds * delay);
        }
        inverse.process(&mut spectrum);
        spectrum.iter().map(|p| gain * (p.re + noise * normal(stream))).collect()
    };
    truth.iter().map(&mut one).collect()
}

/// Distances from the truth over the stated standard deviations: of gains, and of delays. That of the
/// reference belongs to either.
fn pulls(found: &ComparedChannels, truth: &[[f64; 3]]) -> [Vec<f64>; 2] {
    let c = &found.channels;
    let of = |m: usize| {
        let gain = (c.gains[m] / truth[m][0] - 1.0) / c.gain_sds[m].hypot(c.gain_sds[0]);
        let delay = (c.delays[m] - truth[m][1]) / c.delay_sds[m].hypot(c.delay_sds[0]);
        [gain, delay]
    };
    let all: Vec<[f64; 2]> = (1..truth.len()).map(of).collect();
    [0, 1].map(|k| all.iter().map(|p| p[k]).collect())
}

fn rms(pulls: &[f64]) -> f64 {
    (pulls.iter().map(|p| p * p).sum::<f64>() / pulls.len() as f64).sqrt()
}

#[test]
fn coverage_compared_channels_lie_within_their_errors() {
    for truth in [&TRUTH[..], &TRUTH[..3], &TRUTH[..2]] {
        let all: Vec<[Vec<f64>; 2]> = (0..200)
            .into_par_iter()
            .map(|seed| {
                let mut stream = Streams::new(seed).stream("compared");
                let records = vec![record(8.0, truth, &mut stream)];
                let found = ComparedChannels::new(&records, RATE, BAND, 0, [0.0; 2]).unwrap();
                assert!(found.silent.is_empty() && found.coherence[1] > 0.98);
                pulls(&found, truth)
            })
            .collect();
        for (k, what) in ["gain", "delay"].iter().enumerate() {
            let pulls: Vec<f64> = all.iter().flat_map(|p| p[k].clone()).collect();
            let (size, mean) = (rms(&pulls), pulls.iter().sum::<f64>() / pulls.len() as f64);
            let inside = pulls.iter().filter(|p| p.abs() < 2.0).count() as f64 / pulls.len() as f64;
            println!(
                "{} channels, {what}: rms {size:.2}, mean {mean:.2}, within 2 sd {inside:.3}",
                truth.len()
            );
            assert!(
                (0.85..1.1).contains(&size) && mean.abs() < 0.35 && inside > 0.93,
                "{what}: {size} {mean}"
            );
        }
    }
}

#[test]
fn exact_noise_of_one_channel_does_not_lean_the_gain_of_another() {
    // Noise of the reference as large as a third of the sound: H1 would have gains 10 % too small.
    let mut stream = Streams::new(5).stream("leaning");
    let truth = [[1.0, 0.0, 0.35], [1.1, 0.0, 0.0], [0.9, 0.0, 0.0]];
    let records = vec![record(30.0, &truth, &mut stream)];
    let found = ComparedChannels::new(&records, RATE, BAND, 0, [0.0; 2]).unwrap();
    let c = &found.channels;
    for m in 1..3 {
        assert!((c.gains[m] / truth[m][0] - 1.0).abs() < 0.01, "{:?}", c.gains);
        // The noise is the reference's, and both gains share its error.
        assert!(c.gain_sds[m] < 0.3 * c.gain_sds[0], "{:?}", c.gain_sds);
    }
}

#[test]
fn exact_records_that_disagree_widen_the_errors() {
    let mut stream = Streams::new(7).stream("anew");
    let again = |stream: &mut Stream| {
        let mut truth = TRUTH;
        truth[1..].iter_mut().for_each(|t| t[0] *= 1.0 + 0.02 * normal(stream));
        record(8.0, &truth, stream)
    };
    let records: Vec<_> = (0..4).map(|_| again(&mut stream)).collect();
    let [found, one] = [&records[..], &records[..1]]
        .map(|records| ComparedChannels::new(records, RATE, BAND, 0, [0.0; 2]).unwrap());
    for m in 1..4 {
        // The mean of four numbers that scatter by 2 % is known to 1 %.
        let sd = found.channels.gain_sds[m].hypot(found.channels.gain_sds[0]);
        assert!((0.005..0.02).contains(&sd) && one.channels.gain_sds[m] < 0.005, "{m}: {sd}");
        assert!((found.channels.gains[m] / TRUTH[m][0] - 1.0).abs() < 3.0 * sd);
    }
    let wide = ComparedChannels::new(&records[..1], RATE, BAND, 0, [0.02, 3e-6]).unwrap();
    assert!((wide.channels.gain_sds[1].powi(2) - one.channels.gain_sds[1].powi(2) - 4e-4).abs() < 1e-9);
    assert!((wide.channels.delay_sds[1].powi(2) - one.channels.delay_sds[1].powi(2) - 9e-12).abs() < 1e-18);
}

#[test]
fn message_records_that_compare_nothing_are_refused() {
    let mut stream = Streams::new(3).stream("refused");
    let good = record(8.0, &TRUTH, &mut stream);
    let compared = |record: Vec<Vec<f64>>| ComparedChannels::new(&[record], RATE, BAND, 0, [0.0; 2]);
    let mut deaf = good.clone();
    deaf[3] = (0..deaf[0].len()).map(|_| normal(&mut stream)).collect();
    let fault = compared(deaf).unwrap_err();
    assert!(matches!(fault, ComparisonFault::Incoherent { channel: 3, .. }), "{fault}");
    let short: Vec<Vec<f64>> = good.iter().map(|c| c[..4000].to_vec()).collect();
    assert!(matches!(compared(short).unwrap_err(), ComparisonFault::Record { file: 0, .. }));
    let mut dead = good.clone();
    dead[2] = vec![0.5; dead[0].len()];
    let found = compared(dead).unwrap();
    assert_eq!(found.silent, [2]);
    assert_eq!([found.channels.gain_sds[2], found.channels.delay_sds[2]], [1.0, 1e-3]);
    assert!((found.channels.gains[3] - 0.8).abs() < 0.01);
    let alone = compared(vec![good[0].clone(), vec![0.0; good[0].len()]]).unwrap_err();
    assert!(matches!(alone, ComparisonFault::Alone { .. }));
}

#[test]
fn exact_the_share_of_the_source_is_the_median_over_frequencies() {
    // Over the lower 42 % of the band the third microphone hears noise of its own, as loud as the source.
    const COUNT: usize = 1 << 16;
    let mut stream = Streams::new(8).stream("share");
    let mut noise = |to_hz: f64, size: f64| -> Vec<f64> {
        let mut spectrum = vec![C64::ZERO; COUNT];
        let bin = |hz: f64| (hz / RATE * COUNT as f64) as usize;
        for z in &mut spectrum[bin(50.0)..bin(to_hz)] {
            *z = size * C64::new(normal(&mut stream), normal(&mut stream));
        }
        FftPlanner::new().plan_fft_inverse(COUNT).process(&mut spectrum);
        spectrum.iter().map(|z| z.re).collect()
    };
    let (source, own) = (noise(3000.0, 1.0), noise(1250.0, 1.0));
    let channels: Vec<Vec<f64>> = [0.0, 0.0, 1.0]
        .iter()
        .map(|share| {
            let faint = noise(3900.0, 0.03);
            (0..COUNT).map(|n| source[n] + share * own[n] + faint[n]).collect()
        })
        .collect();
    let found = Spectra::welch(&channels, RATE, 512, [500.0, 2300.0]).unwrap();
    let shares = RelativePressures::of_noise(found, 3, &ChannelGains::Equal).of_the_source;
    assert!(shares.len() == 3 && shares.iter().all(|share| *share > 0.98), "{shares:?}");
}
