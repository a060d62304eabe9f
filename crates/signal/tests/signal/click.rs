//! Clicks against the bound and against truth.

use crate::clicking::Clicking;
use rayon::prelude::*;
use rijke_numerics::Matrix;
use rijke_signal::{
    Channel, ChannelDelays, ClickFit, ClickOptions, Fault, KnownClick, Reflection, Trace, fit_click,
};

pub(crate) fn fit(clicking: &Clicking, channels: &[Vec<f64>]) -> Result<ClickFit, Fault> {
    fit_paced(clicking, channels, 1.0, 0.0)
}

/// With lags stated `wrong` times too long, known to `pace_sd`.
fn fit_paced(
    clicking: &Clicking,
    channels: &[Vec<f64>],
    wrong: f64,
    pace_sd: f64,
) -> Result<ClickFit, Fault> {
    let trace =
        Trace { channels, rate_hz: clicking.rate_hz, quiet: clicking.quiet, full_scale: f64::INFINITY };
    let reflection = Reflection {
        lags: clicking.gaps().iter().map(|lag| wrong * lag).collect(),
        strength: -clicking.reflection,
        smoothing: 3.1e-5,
        tolerance: 0.1,
        pace_sd,
        dispersion: Vec::new(),
    };
    fit_click(&trace, &ClickOptions { reflection: Some(reflection), ..ClickOptions::default() })
}

/// Per channel: mean error over its sd, mean square of the same, coverage of 2 sd, variance over the bound of
/// the direct impulse alone, and over that with the unknown reflection; mean error in samples.
fn study(clicking: &Clicking, count: u64) -> Vec<[f64; 6]> {
    let truth = clicking.arrivals();
    let clean = clicking.clean();
    let fits: Vec<ClickFit> = (0..count)
        .into_par_iter()
        .map(|seed| fit(clicking, &clicking.noisy(&clean, seed, "study")).unwrap())
        .collect();
    // The strongest channel is the pivot of almost every record: count those with one pivot only.
    let pivot = fits[0].pivot;
    let (direct, whole) = (clicking.bound(pivot), clicking.bound_with_reflection(pivot, 0.1));
    let mut sums = vec![([0.0; 6], 0.0); 8];
    for fit in fits {
        let p = fit.pivot;
        for m in (0..8).filter(|&m| m != p) {
            let error = fit.times[m] - fit.times[p] - truth[m] + truth[p];
            let z = error / fit.covariance[(m, m)].sqrt();
            let square = error * error;
            // Channels 0 to 5 are alike: their bound is that of any of them.
            let place = if m == pivot { p } else { m };
            let row = [
                z,
                z * z,
                f64::from(u8::from(z.abs() < 2.0)),
                square / direct[(place, place)],
                square / whole[(place, place)],
                error * clicking.rate_hz,
            ];
            for (sum, v) in sums[m].0.iter_mut().zip(row) {
                *sum += v;
            }
            sums[m].1 += 1.0;
        }
    }
    println!(
        "channel: bias/sd, mean square, coverage, variance/bound, the same with reflection, bias in samples"
    );
    let rows: Vec<[f64; 6]> = sums.into_iter().map(|(s, n)| s.map(|v| v / n)).collect();
    for (m, row) in rows.iter().enumerate() {
        println!("{m}: {row:.4?}");
    }
    rows
}

#[test]
fn oracle_arrival_times_reach_the_bound_and_cover() {
    let rows = study(&Clicking::tube(100.0), 100);
    // Channels 0 to 5 hear the impulse alone; at 6 and 7 the reflection overlaps and costs information.
    let mean = |range: std::ops::Range<usize>, i: usize| {
        rows[range.clone()].iter().map(|r| r[i]).sum::<f64>() / range.len() as f64
    };
    assert!(mean(0..6, 3) < 1.25, "variance over bound {}", mean(0..6, 3));
    assert!(mean(6..8, 4) < 1.4, "variance over bound with reflection {}", mean(6..8, 4));
    assert!((0.8..1.25).contains(&mean(0..8, 1)), "mean square {}", mean(0..8, 1));
    assert!((0.92..0.985).contains(&mean(0..8, 2)), "coverage {}", mean(0..8, 2));
}

#[test]
#[ignore = "long: 2000 clicks at three levels of noise"]
fn oracle_arrival_times_over_2000_clicks() {
    let mut met = true;
    for ratio in [30.0, 100.0, 300.0] {
        println!("peak over noise {ratio}");
        for row in study(&Clicking::tube(ratio), 2000) {
            // Five taps do not stand for every reflection: channels 6 and 7 keep a bias, below 0.01 sample.
            met &= row[4] < 1.2 && (0.92..0.98).contains(&row[2]) && row[5].abs() < 0.01;
        }
    }
    assert!(met);
}

#[test]
fn oracle_no_bias_at_any_fraction_of_a_sample() {
    // Almost no noise; the far end absorbs, so that nothing but sampling can bias.
    for k in 0..8 {
        let mut clicking = Clicking { reflection: 1e-9, ..Clicking::tube(1e4) };
        let sample = 1.0 / clicking.rate_hz;
        clicking.delays = (0..8).map(|m| sample * f64::from(k * m) / 8.0).collect();
        let fit = fit(&clicking, &clicking.record(1, "fraction")).unwrap();
        let truth = clicking.arrivals();
        for m in 0..8 {
            let error = fit.times[m] - fit.times[fit.pivot] - truth[m] + truth[fit.pivot];
            assert!(error.abs() < 0.01 * sample, "channel {m}, {k}/8 sample: {error:e}");
        }
    }
}

#[test]
fn oracle_a_reflection_from_hot_gas_comes_early_and_is_found() {
    // Gas at 530 K between the upper microphones and the end: lags as stated for 293 K are 35 % too long.
    let clicking = Clicking::tube(1e3);
    let (mut known, mut free) = (0.0_f64, 0.0_f64);
    for seed in 0..10 {
        let record = clicking.record(seed, "hot");
        let truth = clicking.arrivals();
        let worst = |fit: ClickFit| {
            let p = fit.pivot;
            (0..8).map(|m| (fit.times[m] - fit.times[p] - truth[m] + truth[p]).abs()).fold(0.0, f64::max)
        };
        // Lags taken as stated: refused, or far off.
        known = known.max(fit_paced(&clicking, &record, 1.35, 0.0).map_or(f64::INFINITY, worst));
        free = free.max(worst(fit_paced(&clicking, &record, 1.35, 0.2).unwrap()));
    }
    assert!(free < 0.5e-6 && known > 2.0 * free, "free lags: {free:e} s, lags taken as stated: {known:e} s");
}

#[test]
fn exact_inverted_channel_has_negative_gain() {
    let mut clicking = Clicking::tube(300.0);
    clicking.gains[2] = -0.9;
    let fit = fit(&clicking, &clicking.record(3, "inverted")).unwrap();
    assert!((fit.gains[2] / fit.gains[0] + 0.9).abs() < 0.01, "{:?}", fit.gains);
}

#[test]
fn exact_clicks_in_loud_hum_or_without_impulse_are_refused_with_the_right_reason() {
    let loud = Clicking { hum: 60.0, ..Clicking::tube(100.0) };
    let fault = fit(&loud, &loud.record(1, "hum")).unwrap_err();
    let said = matches!(fault, Fault::LoudHum(Channel::Place(0), 50.0, _));
    assert!(said && fault.to_string().contains("hum in channel 0"), "{fault}");
    // An offset of many times the hum does not hide it.
    let mut offset = loud.record(1, "hum");
    let most = offset[0].iter().fold(0.0_f64, |most, y| most.max(y.abs()));
    offset.iter_mut().flatten().for_each(|y| *y += 20.0 * most);
    assert!(matches!(fit(&loud, &offset), Err(Fault::LoudHum(..))));
    let clicking = Clicking::tube(100.0);
    let mut record = clicking.record(1, "unplugged");
    record[3] = (0..record[0].len()).map(|n| ((n * 7919) % 1009) as f64 / 1009.0).collect();
    let fault = fit(&clicking, &record).unwrap_err();
    assert!(matches!(fault, Fault::NoImpulse { channel: Channel::Place(3), .. }), "{fault}");
}

#[test]
fn exact_loud_hum_is_said_with_its_amplitude() {
    let clicking = Clicking::tube(100.0);
    for phase in [0.0, 0.25, 0.5, 0.75] {
        let mut record = clicking.record(1, "amplitude");
        for y in &mut record {
            for (n, v) in y.iter_mut().enumerate() {
                *v += 60.0 * (std::f64::consts::TAU * (50.02 * n as f64 / clicking.rate_hz + phase)).cos();
            }
        }
        let peak = record[0].iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        match fit(&clicking, &record) {
            Err(Fault::LoudHum(_, 50.0, ratio)) => {
                assert!((ratio * peak / 60.0 - 1.0).abs() < 0.02, "{phase}: {}", ratio * peak);
            }
            other => panic!("{phase}: {:?}", other.map(|fit| fit.times)),
        }
    }
}

#[test]
fn oracle_calibration_returns_delays_and_gains_at_both_rates() {
    let delays: Vec<f64> = (0..8).map(|m| 1e-5 * f64::from((m * 5) % 7)).collect();
    let gains: Vec<f64> = (0..8).map(|m| 1.0 + 0.03 * f64::from((m * 3) % 5 - 2)).collect();
    for (rate_hz, quiet, length) in [(62_500.0, 1250, 6250), (1e4, 200, 1000)] {
        let clicking = Clicking {
            rate_hz,
            quiet,
            length,
            delays: delays.clone(),
            gains: gains.clone(),
            hum: 20.0,
            ..Clicking::tube(300.0)
        };
        let known: Vec<KnownClick> = (0..16)
            .map(|seed| KnownClick {
                fit: fit(&clicking, &clicking.record(seed, "calibration")).unwrap(),
                expected: clicking.positions.iter().map(|x| x / clicking.sound_speed).collect(),
                group: 0,
                speed_sd: 1e-4,
            })
            .collect();
        let calibration = ChannelDelays::calibrate(&known, rate_hz).unwrap();
        println!("scatter {}", calibration.scatter);
        for m in 0..8 {
            let error = calibration.delays[m] - calibration.delays[4] - delays[m] + delays[4];
            assert!(error.abs() < 0.5e-6, "{rate_hz} Hz, channel {m}: {error:e} s");
            let gain = calibration.gains[m] / calibration.gains[4] / (gains[m] / gains[4]);
            assert!((gain - 1.0).abs() < 0.01, "{rate_hz} Hz, channel {m}: {gain}");
        }
        // The error of the sound speed is common: it grows with distance and does not average out.
        let common = Matrix::from_fn(8, 8, |i, j| {
            1e-8 * clicking.positions[i] * clicking.positions[j] / clicking.sound_speed.powi(2)
        });
        for m in 0..8 {
            assert!(calibration.covariance[(m, m)] >= common[(m, m)]);
        }
        // A click in warmer air, corrected with this calibration, arrives when sound does.
        let warm = Clicking { sound_speed: 352.0, ..clicking.clone() };
        let click = calibration.arrival(&fit(&warm, &warm.record(99, "warm")).unwrap(), false).unwrap();
        for (m, t) in click.arrival_times.iter().enumerate() {
            let error = t - warm.positions[m] / warm.sound_speed;
            assert!(error.abs() < 1.5e-6, "{rate_hz} Hz, channel {m}: {error:e} s");
        }
    }
}

#[test]
fn behaviour_options_with_which_no_click_can_be_fitted_are_refused() {
    let clicking = Clicking::tube(300.0);
    let channels = clicking.record(1, "options");
    let with = |change: &dyn Fn(&mut ClickOptions)| {
        let trace =
            Trace { channels: &channels, rate_hz: clicking.rate_hz, quiet: clicking.quiet, full_scale: 1e9 };
        let mut options = ClickOptions::default();
        change(&mut options);
        fit_click(&trace, &options)
    };
    type Change<'a> = &'a dyn Fn(&mut ClickOptions);
    let wrong: [(&str, Change<'_>); 5] = [
        ("window", &|o| o.window = (-1.0, f64::NAN)),
        ("band", &|o| o.band_hz = (4000.0, 300.0)),
        ("mains", &|o| o.mains_hz = 0.0),
        ("dispersion", &|o| o.dispersion = vec![1e-4]),
        ("dispersion", &|o| o.dispersion = vec![f64::NAN; 8]),
    ];
    for (word, change) in wrong {
        let fault = with(change).expect_err(word);
        assert!(matches!(fault, Fault::Options(what) if what.contains(word)), "{word}: {fault}");
    }
    assert!(!matches!(with(&|_| ()), Err(Fault::Options(_))));
}
