//! Noise of a floor and of a part in proportion to the modulus: whether stated deviations are those of the
//! errors, for a flame with a gain, a delay and a filter.

use super::bench::{GAMMA, GAS_CONSTANT, law_itself, model, observed};
use rand_distr::{Distribution, StandardNormal};
use rijke_engine::response::{ResponseRun, ResponseStageRecord};
use rijke_numerics::{C64, Streams};
use rijke_study::Study;
use rijke_study::responses::ObservedResponse;
use std::f64::consts::PI;

const GAIN: f64 = 0.9;
const DELAY: f64 = 3e-3;
const FILTER: f64 = 1.1e-3;
const SEEDS: u64 = 30;
const SHARE: &str = "noise in proportion to the modulus";

/// A law of a part alone, with these candidates' parameters; `more` are further keys of the stage.
fn study(name: &str, more: &str) -> Study {
    let folder = std::env::temp_dir().join(format!("rijke-noise-{name}-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("candidates")).unwrap();
    let write = |file: &str, text: &str| std::fs::write(folder.join(file), text).unwrap();
    write(
        "rig.toml",
        &format!(
            "name = \"Flame\"\n[gas]\ntemperature = 293.15\npressure = 101325\ngamma = {GAMMA}\ngas_constant = {GAS_CONSTANT}\n\
             [upstream]\ntype = \"closed\"\n[downstream]\ntype = \"open\"\n\
             [[element]]\nname = \"tube\"\ntype = \"duct\"\nlength = 0.8\ndiameter = 0.05\nwall = \"none\"\n\
             [[element]]\nname = \"part\"\ntype = \"device\"\nat = 0.4\n"
        ),
    );
    write("campaign.csv", "point,row\na,part\n");
    let candidate = |id: &str, parameter: &str, law: &str| {
        format!(
            "[[candidate]]\nid = \"{id}\"\nrole = \"part\"\nname = \"{id}\"\ncite = [\"a test\"]\n\
             parameters.n = {{ unit = \"1\", prior = {{ normal = {{ mean = 1.0, sd = 0.3 }} }} }}\n\
             parameters.tau = {{ unit = \"s\", prior = {{ normal = {{ mean = 0.003, sd = 0.0005 }} }} }}\n{parameter}\
             [[candidate.effect]]\nacts_at = \"part\"\neu = \"{law}\"\n"
        )
    };
    let sigma =
        "parameters.sigma = { unit = \"s\", prior = { log_normal = { median = 0.001, ln_sd = 0.5 } } }\n";
    let filtered = candidate("one", sigma, "n*exp(-s*tau + (s*sigma)^2/2)");
    write("candidates/all.toml", &(filtered + &candidate("bare", "", "n*exp(-s*tau)")));
    write(
        "study.toml",
        &format!(
            "name = \"flame\"\nbase = \"rig\"\n[[responses]]\nid = \"alone\"\ncompete = [\"part\"]\n{more}\n"
        ),
    );
    Study::open(&folder).unwrap()
}

/// The stage trained on numbers with normal errors, of which both parts have this floor and this share of the
/// modulus; with `stated`, their files say so.
fn trained(study: &Study, seed: u64, noise: [f64; 2], stated: bool) -> ResponseStageRecord {
    let (mut response, exact) = response(study, seed, noise);
    if stated {
        response.sd = exact.iter().map(|z| noise[0].hypot(noise[1] * z.norm())).collect();
    }
    ResponseRun::new(study.clone(), observed(vec![response])).unwrap().next_stage().unwrap().unwrap()
}

/// The numbers, and what they would be without errors.
fn response(study: &Study, seed: u64, [floor, share]: [f64; 2]) -> (ObservedResponse, Vec<C64>) {
    let mut stream = Streams::new(seed).stream("noise in proportion");
    let mut normal = || -> f64 { StandardNormal.sample(&mut stream) };
    let frequency_hz: Vec<f64> = (2..=40).map(|k| 10.0 * f64::from(k)).collect();
    let truth = |f: &f64| {
        let w = 2.0 * PI * f;
        C64::from_polar(GAIN * (-0.5 * (w * FILTER).powi(2)).exp(), -w * DELAY)
    };
    let sd = |z: &C64| floor.hypot(share * z.norm());
    let exact: Vec<C64> = frequency_hz.iter().map(truth).collect();
    let values = exact.iter().map(|z| z + sd(z) * C64::new(normal(), normal())).collect();
    let (rows, what) = (frequency_hz.len(), law_itself(study));
    (
        ObservedResponse { point: 0, what, rows, frequency_hz, values, sd: Vec::new(), level: Vec::new() },
        exact,
    )
}

/// Root mean squares of the errors of gain, delay and filter over their stated deviations, and how many seeds
/// found a part in proportion.
fn errors(study: &Study, noise: [f64; 2]) -> ([f64; 3], usize) {
    let (mut sums, mut found) = ([0.0; 3], 0);
    for seed in 0..SEEDS {
        let stage = trained(study, seed, noise, false);
        assert_eq!(stage.winner, "one");
        let best = model(&stage, "one");
        found += usize::from(best.noise.iter().any(|n| n.name == SHARE));
        for (sum, (name, truth)) in sums.iter_mut().zip([("n", GAIN), ("tau", DELAY), ("sigma", FILTER)]) {
            let p = best.parameters.iter().find(|p| p.name == name).unwrap();
            *sum += ((p.value - truth) / p.sd).powi(2) / SEEDS as f64;
        }
    }
    (sums.map(f64::sqrt), found)
}

/// A root mean square of thirty errors scatters by 0.13 about 1, of ninety by 0.075.
#[test]
fn coverage_errors_have_their_stated_deviations_whatever_the_noise() {
    let asks = study("asks", "");
    for (noise, least, most) in [([0.01, 0.0], 0, 3), ([0.0003, 0.03], 30, 30), ([0.006, 0.03], 25, 30)] {
        let (rms, found) = errors(&asks, noise);
        let all = (rms.iter().map(|r| r * r).sum::<f64>() / 3.0).sqrt();
        assert!((0.85..1.2).contains(&all), "{noise:?}: {rms:?}");
        assert!(rms.iter().all(|r| (0.65..1.3).contains(r)), "{noise:?}: {rms:?}");
        assert!((least..=most).contains(&found), "{noise:?}: {found} found a part in proportion");
    }
    // What becomes of the second one with one noise for all.
    let (rms, _) = errors(&study("white", "noise_in_proportion = false"), [0.0003, 0.03]);
    assert!(rms.iter().any(|r| *r > 1.5), "{rms:?}");
}

#[test]
fn lab_both_parts_of_a_noise_are_found_and_all_models_have_one_ratio_of_them() {
    let stage = trained(&study("parts", ""), 7, [0.006, 0.03], false);
    let parts = |id: &str| {
        let sd = |name: &str| model(&stage, id).noise.iter().find(|n| n.name == name).unwrap().sd;
        [sd("noise"), sd(SHARE)]
    };
    let [floor, share] = parts("one");
    // Of 78 numbers, which are of the one kind or of the other.
    assert!((floor / 0.006).ln().abs() < 0.5 && (share / 0.03).ln().abs() < 0.5, "{floor} {share}");
    let [other_floor, other_share] = parts("bare");
    assert!((other_floor / other_share / (floor / share) - 1.0).abs() < 1e-9 && other_floor > 2.0 * floor);
}

#[test]
fn exact_numbers_that_state_their_deviations_are_not_asked() {
    let stage = trained(&study("stated", "noise = 0"), 7, [0.0003, 0.03], true);
    let best = model(&stage, "one");
    assert!(best.noise.iter().all(|n| n.sd == 0.0 && n.name != SHARE), "{:?}", best.noise);
    // 3 % of 39 numbers of which each counts alike.
    let n = best.parameters.iter().find(|p| p.name == "n").unwrap();
    assert!((0.003..0.012).contains(&(n.sd / n.value)), "{}", n.sd);
}

/// n e^(-s tau) at N frequencies has N/noise^2 of n, the sum of (n omega)^2/noise^2 of tau, and nothing of
/// both together; the prior adds one over its variance. n is tried up to half a deviation above its centre.
#[test]
fn exact_foresight_of_a_gain_and_a_delay() {
    let frequency_hz: Vec<f64> = (1..=40).map(|k| 10.0 * f64::from(k)).collect();
    let squares: f64 = frequency_hz.iter().map(|f| (2.0 * PI * f).powi(2)).sum();
    for (name, more, noise) in [
        ("foreseen-fixed", "noise = 0.2", 0.2),
        ("foreseen-inferred", "noise = { median = 0.5, ln_sd = 1.0 }", 0.5),
        ("foreseen-floated", "noise = \"floated\"", 0.01),
    ] {
        let study = study(name, more);
        let response = ObservedResponse {
            point: 0,
            what: law_itself(&study),
            rows: frequency_hz.len(),
            frequency_hz: frequency_hz.clone(),
            values: vec![C64::ONE; frequency_hz.len()],
            sd: Vec::new(),
            level: Vec::new(),
        };
        let found = ResponseRun::new(study, observed(vec![response])).unwrap().foresight().unwrap();
        assert_eq!(found[0].noise, noise);
        let bare = found[0].models.iter().find(|m| m.id == "bare").unwrap();
        let width = |told: f64, sd: f64| (1.0 + told * sd * sd / (noise * noise)).sqrt().recip();
        let expected = [width(40.0, 0.3), width(1.15_f64.powi(2) * squares, 0.0005)];
        assert_eq!(bare.widths.len(), 2);
        for ((name, found), expected) in bare.widths.iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 1e-6, "{more}, {name}: {found} {expected}");
        }
    }
}

/// Noise that the data chose may be an error of the law itself: as large, and apart from frequency to
/// frequency. A part in proportion makes it larger where the law is.
#[test]
fn exact_what_a_law_was_not_measured_to_is_an_error_of_it() {
    for (name, more) in [("white-law", "noise_in_proportion = false"), ("grey-law", "")] {
        let study = study(name, more);
        let (response, truth) = response(&study, 7, [0.006, 0.03]);
        let mut run = ResponseRun::new(study, observed(vec![response.clone()])).unwrap();
        let stage = run.next_stage().unwrap().unwrap();
        let error = run.grounds()[0].models[0].law.clone().unwrap();
        let found =
            |name: &str| model(&stage, "one").noise.iter().find(|n| n.name == name).map_or(0.0, |n| n.sd);
        let [floor, share] = [found("noise"), found(SHARE)];
        let variance = |z: &C64| floor * floor + (share * z.norm()).powi(2);
        let mean = truth.iter().map(variance).sum::<f64>() / truth.len() as f64;
        assert_eq!((error.role.as_str(), error.over), ("part", None));
        // The modulus is that of the model where this was fitted.
        assert!((error.sd / mean.sqrt() - 1.0).abs() < 0.02, "{name}: {} {}", error.sd, mean.sqrt());
        let added = error.added.unwrap();
        assert!((added.length_hz - 10.0).abs() < 1e-9 && added.coefficient == "eu", "{added:?}");
        assert_eq!(added.along.is_empty(), share == 0.0);
        for ([hz, size], (f, z)) in added.along.iter().zip(response.frequency_hz.iter().zip(&truth)) {
            assert_eq!(hz, f);
            assert!((size / (variance(z) / mean).sqrt() - 1.0).abs() < 0.05, "{hz}: {size}");
        }
    }
}
