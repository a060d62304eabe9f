//! How often gains and delays lie within what is stated, for clicks of many shapes, in tubes with boundary
//! layers: channels, thermometer and noise drawn anew for each calibration.

use crate::pulses::{Duct, SOUND, Shape, Tube};
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use rijke_numerics::Streams;
use rijke_signal::{ChannelDelays, ClickOptions, Extent, Fault, Reflection, Trace, fit_click};

/// Dispersion of air at 293 K in a round tube of this radius, s^{1/2}/m: Kirchhoff 1868.
const fn layers(radius: f64) -> f64 {
    // sqrt(nu / 2) (1 + (gamma - 1) / sqrt(Pr)), nu = 1.51e-5 m^2/s, Pr = 0.71.
    2.748e-3 * 1.4747 / (radius * SOUND)
}

/// Five microphones in 0.9 m, the last 0.15 m below the end; near end without reflection.
const FIVE: Duct = Duct {
    positions: &[0.08, 0.25, 0.42, 0.6, 0.75],
    length: 0.9,
    radius: 0.025,
    layers: layers(0.025),
    near: 0.0,
};

/// Eight in a metre, the last 50 mm below the end.
const EIGHT: Duct = Duct {
    positions: &[0.25, 0.35, 0.45, 0.55, 0.65, 0.75, 0.85, 0.95],
    length: 1.0,
    radius: 0.0237,
    layers: layers(0.0237),
    near: -0.7,
};

/// Relative deviation of the speed of sound: 0.1 K.
const SPEED_SD: f64 = 1.7e-4;

/// One calibration: errors over stated deviations, relative to channel `reference`, and errors.
type Found = Vec<([f64; 2], [f64; 2])>;

fn calibration(shape: Shape, rate_hz: f64, duct: Duct, ratio: f64, seed: u64) -> Result<Found, String> {
    let mut stream = Streams::new(seed).stream(&format!("shapes/{shape:?}/{rate_hz}/{}", duct.length));
    let mut normal = |sd: f64| -> f64 { sd * Distribution::<f64>::sample(&StandardNormal, &mut stream) };
    let channels = duct.positions.len();
    let tube = Tube {
        ratio,
        gains: (0..channels).map(|_| 1.0 + normal(0.03)).collect(),
        delays: (0..channels).map(|_| normal(1e-5)).collect(),
        duct,
        ..Tube::new(shape, rate_hz)
    };
    let sound = SOUND * (1.0 + normal(SPEED_SD));
    let (clean, quiet) = tube.clean();
    let found: ChannelDelays = tube.calibration_at(&clean, quiet, seed, true, (sound, SPEED_SD))?;
    let (r, c) = (channels / 2, &found.covariance);
    let g = |m: usize, n: usize| found.gain_covariance[(m, n)] / (found.gains[m] * found.gains[n]);
    let error = |m: usize| {
        let gain = found.gains[m] / found.gains[r] * tube.gains[r] / tube.gains[m] - 1.0;
        let delay = found.delays[m] - found.delays[r] - tube.delays[m] + tube.delays[r];
        let sds = [g(m, m) + g(r, r) - 2.0 * g(m, r), c[(m, m)] + c[(r, r)] - 2.0 * c[(m, r)]].map(f64::sqrt);
        ([gain / sds[0], delay / sds[1]], [gain, delay])
    };
    Ok((0..channels).filter(|m| *m != r).map(error).collect())
}

/// Prints one kind of click; the least share inside 1.96 deviations of gains and delays together.
fn table(shape: Shape, rate_hz: f64, (name, duct): (&str, Duct), seeds: u64) -> [f64; 2] {
    let all: Vec<Result<Found, String>> =
        (0..seeds).into_par_iter().map(|seed| calibration(shape, rate_hz, duct, 300.0, seed)).collect();
    let refused: Vec<&String> = all.iter().filter_map(|r| r.as_ref().err()).collect();
    let found: Vec<&Found> = all.iter().filter_map(|r| r.as_ref().ok()).collect();
    let mut shares = [1.0; 2];
    print!("{name}, {shape:?}, {rate_hz} Hz: ");
    for (i, unit) in [(0, "%"), (1, "us")] {
        let pulls = || found.iter().flat_map(|f| f.iter().map(move |e| e.0[i]));
        let count = pulls().count().max(1) as f64;
        let inside = pulls().filter(|p| p.abs() < 1.96).count() as f64 / count;
        let rms = (pulls().map(|p| p * p).sum::<f64>() / count).sqrt();
        let channels = found.first().map_or(0, |f| f.len());
        // The worst channel: rms of its pulls, and their mean.
        let of = |m: usize, power: i32| {
            found.iter().map(|f| f[m].0[i].powi(power)).sum::<f64>() / found.len() as f64
        };
        let worst = (0..channels).max_by(|a, b| of(*a, 2).total_cmp(&of(*b, 2))).unwrap_or(0);
        let largest = found.iter().flat_map(|f| f.iter().map(|e| e.1[i].abs())).fold(0.0, f64::max);
        let scale = if i == 0 { 100.0 } else { 1e6 };
        if !found.is_empty() {
            print!(
                "{:.1} % inside, rms {rms:.2}, worst {worst}: {:.2} (mean {:.2}), at most {:.2} {unit} off; ",
                100.0 * inside,
                of(worst, 2).sqrt(),
                of(worst, 1),
                scale * largest
            );
            shares[i] = inside;
        }
    }
    println!("{} of {seeds} refused {}", refused.len(), refused.first().map_or("", |r| r.as_str()));
    shares
}

fn kinds(f: f64) -> [Shape; 7] {
    [
        Shape::Ricker(f),
        Shape::Lobe(f),
        Shape::Slope(f),
        Shape::Damped(f, 0.4),
        Shape::Damped(f, 0.8),
        Shape::Chirplet(f, 0.8),
        Shape::Chirplet(f, 1.5),
    ]
}

#[test]
fn coverage_of_clicks_whose_largest_lobe_is_not_in_the_middle() {
    // Before: refused as singular; 18 %, 1 %, and 70 % off.
    for (shape, rate_hz, worst) in [
        (Shape::Lobe(1000.0), 62_500.0, 0.006),
        (Shape::Slope(1000.0), 62_500.0, 0.004),
        (Shape::Damped(1000.0, 0.4), 62_500.0, 0.01),
        (Shape::Slope(4000.0), 100_000.0, 0.004),
    ] {
        let (mut inside, mut count) = (0, 0);
        for seed in 0..6 {
            for (pulls, [gain, _]) in calibration(shape, rate_hz, FIVE, 300.0, seed).unwrap() {
                assert!(gain.abs() < worst, "{shape:?}: {gain}");
                inside += pulls.iter().filter(|p| p.abs() < 1.96).count();
                count += 2;
            }
        }
        assert!(10 * inside >= 8 * count, "{shape:?}: {inside} of {count}");
    }
}

#[test]
fn message_a_click_that_lasts_until_its_reflection_comes() {
    // Before: gains up to 18 % off, without a word.
    let reason = calibration(Shape::Chirplet(1000.0, 1.5), 62_500.0, FIVE, 300.0, 1).unwrap_err();
    assert!(reason.contains("ms or more") && reason.contains("use a shorter one"), "{reason}");
}

#[test]
fn exact_noise_is_as_loud_as_undoing_the_boundary_layers_makes_it() {
    // Three times the boundary layers: what undoes them makes noise up to 1.5 times as loud.
    let duct = Duct { layers: 3.0 * EIGHT.layers, near: 0.0, ..EIGHT };
    let tube = Tube { ratio: 300.0, duct, ..Tube::new(Shape::Ricker(3000.0), 62_500.0) };
    let (clean, quiet) = tube.clean();
    let mut stream = Streams::new(1).stream("layers");
    let mut noisy = |y: &Vec<f64>| -> Vec<f64> {
        y.iter().map(|v| v + Distribution::<f64>::sample(&StandardNormal, &mut stream)).collect()
    };
    let channels: Vec<Vec<f64>> = clean.iter().map(&mut noisy).collect();
    let trace = Trace { channels: &channels, rate_hz: tube.rate_hz, quiet, full_scale: f64::INFINITY };
    let options = tube.options(SOUND);
    let options = options.holding(&Extent::of(&trace, &options).unwrap());
    let found = fit_click(&trace, &options).unwrap().chi_squared;
    assert!((0.75..1.25).contains(&found), "{found}");
}

#[test]
#[ignore = "long: 7 shapes, 5 frequencies, 3 sampling rates, 2 tubes, 24 calibrations of each"]
fn coverage_of_calibrations_over_shapes() {
    let mut wrong = Vec::new();
    for tube in [("five", FIVE), ("eight", EIGHT)] {
        // Above 3 kHz the end of the generator goes on from its last exact values: no truth for a microphone
        // that hears it together with the impulse.
        let high = if tube.0 == "five" { 5 } else { 3 };
        for f in [500.0, 1000.0, 2000.0, 3000.0, 4000.0].into_iter().take(high) {
            for shape in kinds(f) {
                for rate_hz in [20_000.0, 62_500.0, 100_000.0] {
                    let shares = table(shape, rate_hz, tube, 24);
                    if shares.iter().any(|s| *s < 0.75) {
                        wrong.push(format!("{} {shape:?} {rate_hz}: {shares:?}", tube.0));
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn message_an_impulse_must_be_over_before_its_reflection_begins() {
    // Halves of two Gaussian curves: to a twentieth of its peak the second takes four times as long.
    let (rate_hz, rise) = (250e3, 5e-5);
    let shape = |t: f64| (-0.5 * (t / if t < 0.0 { rise } else { 4.0 * rise }).powi(2)).exp();
    let before = rise * (2.0 * 20.0_f64.ln()).sqrt();
    let after = 4.0 * before;
    let extent = |room: f64| {
        let mut stream = Streams::new(4).stream("over");
        let mut noise = || -> f64 { 1e-4 * Distribution::<f64>::sample(&StandardNormal, &mut stream) };
        let sound = |t: f64| shape(t) - 0.9 * shape(t - room);
        let y: Vec<f64> = (0..8000).map(|n| sound(f64::from(n) / rate_hz - 16e-3) + noise()).collect();
        let reflection = Reflection {
            lags: vec![room],
            strength: -0.9,
            smoothing: 0.0,
            tolerance: 0.1,
            pace_sd: 0.0,
            dispersion: Vec::new(),
        };
        let trace = Trace { channels: &[y], rate_hz, quiet: 2500, full_scale: f64::INFINITY };
        Extent::of(&trace, &ClickOptions { reflection: Some(reflection), ..ClickOptions::default() })
    };
    // The reflection begins as long before its own peak. A tenth of the length must be silent before it does,
    // and a part of the rise that the level of a twentieth does not see.
    let length = before + after;
    let found = extent(1.2 * length).unwrap();
    assert!((found.before / before - 1.0).abs() < 0.05, "{found:?} {before}");
    assert!((found.after / after - 1.0).abs() < 0.05, "{found:?} {after}");
    let fault = extent(1.07 * length).unwrap_err();
    assert!(matches!(fault, Fault::LongImpulse { .. }), "{fault}");
}
