//! Errors that points share: ends that come out anew at each setting of the rig, and channels that are a little off in every ping.

use super::{ALL, assembly, conditions};
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use rand_distr::StandardNormal;
use rijke_inference::{MapOptions, NoiseMode};
use rijke_model::{Assembly, Noise, Observed, PointModel, Trained, Training, Varying, Workspace, train};
use rijke_numerics::{C64, Matrix, Order, Streams};
use rijke_rig::{ChannelErrors, Ping};

/// eta, k_r, k_i, alpha, beta.
const TRUTH: [f64; 5] = [1.03, 0.998, 0.006, 0.9, 1.05];

/// Scatter of k_i between settings; errors of delays, s, and of gains; noise of growth rate, frequency and pressures.
const ENDS: f64 = 3e-3;
const CHANNELS: [f64; 2] = [2e-7, 1e-3];
const SD: [f64; 3] = [0.02, 0.3, 3e-4];

const POINTS: [&str; 10] =
    ["C3-E", "C3-15", "C3-25", "C3-35", "C3-45", "C3-55", "C3-65", "C3-75", "C3-85", "C3-95"];

/// Every point is a setting of its own; the channels are the same in all.
fn pings(assembly: &Assembly, seed: u64) -> Vec<Observed> {
    let mut draws = Streams::new(seed).stream("common");
    let normal = |draws: &mut ChaCha8Rng| draws.sample::<f64, _>(StandardNormal);
    let channels: Vec<[f64; 2]> = ALL.map(|_| CHANNELS.map(|sd| sd * normal(&mut draws))).to_vec();
    let mut one = |id: &&str| {
        let mut values = TRUTH;
        values[2] += ENDS * normal(&mut draws);
        let conditions = conditions(&assembly.rig, id);
        let model = PointModel::new(assembly, &conditions, &ALL).unwrap();
        let r = model.respond(&values, Order::Value, &mut Workspace::default()).unwrap();
        let s = r.s.value() + C64::new(SD[0] * normal(&mut draws), SD[1] * normal(&mut draws));
        let heard = r.pressures.iter().enumerate().map(|(m, p)| {
            let [delay, gain] = if m == 5 { [0.0; 2] } else { channels[m] };
            let noise = C64::new(normal(&mut draws), normal(&mut draws)) * if m == 5 { 0.0 } else { SD[2] };
            p.value() * (1.0 + s * delay - gain) + noise
        });
        let pressures: Vec<C64> = heard.collect();
        let mut ping = Ping { s, pressures, reference: 5, covariance: Matrix::default() };
        let vector = ping.vector();
        ping.covariance = Matrix::from_fn(16, 16, |i, j| {
            let of_channels = if i > 1 && i / 2 == j / 2 {
                let p = C64::new(vector[i / 2 * 2], vector[i / 2 * 2 + 1]);
                let (by_delay, by_gain) = (p * s * CHANNELS[0], p * CHANNELS[1]);
                let part = |z: C64, k: usize| if k.is_multiple_of(2) { z.re } else { z.im };
                part(by_delay, i) * part(by_delay, j) + part(by_gain, i) * part(by_gain, j)
            } else {
                0.0
            };
            of_channels + if i == j { SD[i.min(2)].powi(2) } else { 0.0 }
        });
        Observed { conditions, ping }
    };
    POINTS.iter().map(&mut one).collect()
}

fn trained(
    assembly: &Assembly,
    seed: u64,
    microphones: &[usize],
    varying: Vec<Varying>,
    channels: Option<ChannelErrors>,
) -> Trained {
    let training = Training {
        microphones: microphones.to_vec(),
        noise: Noise::MEASURED,
        known: Vec::new(),
        varying,
        channels,
        search: MapOptions::default(),
        base_errors: false,
        checks: None,
    };
    train(assembly, &pings(assembly, seed), &training).unwrap()
}

/// Of 60 sets of pings, how many find the truth of eta, k_r and k_i inside two standard deviations.
fn inside(varying: &[Varying], channels: Option<&ChannelErrors>) -> [usize; 3] {
    let assembly = assembly(&["wall.rayleigh", "ends.calibrated", "prongs.6"]);
    let mut inside = [0; 3];
    for seed in 0..60 {
        let trained = trained(&assembly, seed, &ALL, varying.to_vec(), channels.cloned());
        for (k, count) in inside.iter_mut().enumerate() {
            *count += usize::from((trained.values[k] - TRUTH[k]).abs() < 2.0 * trained.sd()[k]);
        }
    }
    inside
}

#[test]
fn exact_errors_that_points_share_do_not_vanish_in_their_mean() {
    let scatter = |sd| [Varying { parameter: "k_i".into(), sd }];
    let diagonal = |k: usize| Matrix::diagonal(&[CHANNELS[k] * CHANNELS[k]; 7]);
    let channels = ChannelErrors { delays: diagonal(0), gains: diagonal(1) };
    let both = inside(&scatter(NoiseMode::Fixed { sd: ENDS }), Some(&channels));
    // 95.4 % of 60 are 57.3 +- 1.6.
    assert!(both.iter().all(|n| (52..=60).contains(n)), "{both:?}");
    let inferred = inside(&scatter(NoiseMode::Inferred { median: 0.001, ln_sd: 1.0 }), Some(&channels));
    assert!(inferred.iter().all(|n| (50..=60).contains(n)), "{inferred:?}");
    // Left to the noise of each point, they are not seen.
    let neither = inside(&[], None);
    assert!(neither[2] < 30, "{neither:?}");
    let ends = inside(&scatter(NoiseMode::Fixed { sd: ENDS }), None);
    assert!(ends[0] < 50 || ends[1] < 50, "{ends:?}");
}

#[test]
fn exact_channels_belong_to_their_microphones_in_any_order() {
    let assembly = assembly(&["wall.rayleigh", "ends.calibrated", "prongs.6"]);
    // Every microphone with errors of its own.
    let diagonal = |k: usize| {
        let variance = |m: i32| (CHANNELS[k] * f64::from(m)).powi(2) / 50.0;
        Matrix::diagonal(&[1, 2, 3, 4, 5, 6, 7].map(variance))
    };
    let errors = ChannelErrors { delays: diagonal(0), gains: diagonal(1) };
    let [up, down] = [[1, 3, 5, 7], [7, 5, 3, 1]]
        .map(|microphones| trained(&assembly, 1, &microphones, Vec::new(), Some(errors.clone())));
    for (k, parameter) in up.parameters.iter().enumerate() {
        let other = down.parameters.iter().position(|p| p.name == parameter.name).unwrap();
        let (a, b) = (up.values[k], down.values[other]);
        assert!((a - b).abs() < 1e-4 * up.sd()[k], "{}: {a} {b} {}", parameter.name, up.sd()[k]);
        assert!((up.sd()[k] / down.sd()[other] - 1.0).abs() < 1e-6, "{}", parameter.name);
    }
}
