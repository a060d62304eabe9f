//! Transfer functions of two microphones that hear the same noise each, near nodes of the one below.

use super::bench::{GAMMA, GAS_CONSTANT, model, observed};
use rand_distr::{Distribution, StandardNormal};
use rijke_engine::response::{ResponseModelRecord, ResponseRun};
use rijke_numerics::{C64, Streams};
use rijke_study::Study;
use rijke_study::responses::{ObservedResponse, ResponseKind};
use std::f64::consts::PI;

const TEMPERATURE: f64 = 293.15;
const LENGTH: f64 = 0.6;
const AT: [f64; 2] = [0.3, 0.35];
/// Modulus of the reflection, and the depth of its plane behind the end, m.
const TRUTH: [f64; 2] = [0.85, 0.012];
/// Noise of each microphone, over the incident wave.
const NOISE: f64 = 0.01;
const SEEDS: u64 = 30;

fn study(name: &str, noise: &str) -> Study {
    let folder = std::env::temp_dir().join(format!("rijke-nodes-{name}-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("candidates")).unwrap();
    let write = |file: &str, text: &str| std::fs::write(folder.join(file), text).unwrap();
    write(
        "rig.toml",
        &format!(
            "name = \"Tube\"\n[gas]\ntemperature = {TEMPERATURE}\npressure = 101325\ngamma = {GAMMA}\ngas_constant = {GAS_CONSTANT}\n\
             [upstream]\ntype = \"anechoic\"\n[downstream]\ntype = \"free\"\n\
             [[element]]\nname = \"tube\"\ntype = \"duct\"\nlength = {LENGTH}\ndiameter = 0.04\nwall = \"none\"\n\
             [microphones]\nat = {AT:?}\n"
        ),
    );
    write("campaign.csv", &format!("point,row,T_amb [K]\na,a,{TEMPERATURE}\n"));
    write(
        "candidates/all.toml",
        "[[candidate]]\nid = \"plane\"\nrole = \"sample\"\nname = \"plane\"\ncite = [\"a test\"]\n\
         parameters.R = { unit = \"1\", prior = { normal = { mean = 0.8, sd = 0.2 } } }\n\
         parameters.d = { unit = \"m\", prior = { normal = { mean = 0.01, sd = 0.01 } } }\n\
         [[candidate.effect]]\nacts_at = \"downstream\"\nreflection = \"R*exp(-2*s*d/c)\"\n",
    );
    let stage = format!("[[responses]]\nid = \"tube\"\ncompete = [\"sample\"]\n{noise}\n");
    write("study.toml", &format!("name = \"tube\"\nbase = \"ambient\"\n{stage}"));
    Study::open(&folder).unwrap()
}

/// Trained on noise of `times` the size of [`NOISE`], with a column of what it is to first order where it is
/// `stated`.
fn trained(study: &Study, seed: u64, times: f64, stated: bool) -> ResponseModelRecord {
    let mut stream = Streams::new(seed).stream("nodes");
    let mut noise = || -> C64 {
        let mut normal = || -> f64 { StandardNormal.sample(&mut stream) };
        times * NOISE * C64::new(normal(), normal())
    };
    let c = (GAMMA * GAS_CONSTANT * TEMPERATURE).sqrt();
    let frequency_hz: Vec<f64> = (10..=150).map(|k| 10.0 * f64::from(k)).collect();
    let (mut values, mut sd) = (Vec::new(), Vec::new());
    for f in &frequency_hz {
        let s = C64::new(0.0, 2.0 * PI * f);
        let [p, q] = [AT[1], AT[0]]
            .map(|x| (-s * x / c).exp() + TRUTH[0] * (-2.0 * s * (LENGTH + TRUTH[1]) / c + s * x / c).exp());
        values.push((p + noise()) / (q + noise()));
        sd.push(NOISE * (1.0 + (p / q).norm_sqr()).sqrt() / q.norm());
    }
    let (rows, what) = (frequency_hz.len(), ResponseKind::Transfer { to: 1, from: 0 });
    let sd = if stated { sd } else { Vec::new() };
    let response = ObservedResponse { point: 0, what, rows, frequency_hz, values, sd, level: Vec::new() };
    let run = ResponseRun::new(study.clone(), observed(vec![response]));
    model(&run.unwrap().next_stage().unwrap().unwrap(), "plane").clone()
}

fn pulls(model: &ResponseModelRecord) -> [f64; 2] {
    [("R", TRUTH[0]), ("d", TRUTH[1])].map(|(name, truth)| {
        let p = model.parameters.iter().find(|p| p.name == name).unwrap();
        (p.value - truth) / p.sd
    })
}

/// A root mean square of sixty pulls scatters by 0.09 about 1.
#[test]
fn coverage_noise_of_both_microphones_is_found_in_their_quotient() {
    let mut rms = Vec::new();
    for (name, noise) in [("floated", ""), ("white", "noise_in_proportion = false"), ("stated", "noise = 0")]
    {
        let study = study(name, noise);
        let (mut sum, mut found) = (0.0, 0);
        for seed in 0..SEEDS {
            let model = trained(&study, seed, 1.0, name == "stated");
            found += usize::from(model.noise.iter().any(|n| n.name == "noise in proportion to 1 + |H|^2"));
            sum += pulls(&model).iter().map(|p| p * p).sum::<f64>() / (2 * SEEDS) as f64;
        }
        println!("{name}: rms pull {:.2}, {found} of {SEEDS} find the noise of a quotient", sum.sqrt());
        rms.push((sum.sqrt(), found));
    }
    let [(floated, found), (white, _), (stated, _)] = rms[..] else { panic!() };
    assert!(found as u64 >= SEEDS - 2, "{found}");
    assert!((0.75..1.3).contains(&stated), "{stated}");
    assert!(floated < 2.0 && white > 2.0 * floated, "{floated} {white}");
}

/// Of numbers that are five times as good as they state.
#[test]
fn message_noise_that_is_stated_too_large_is_told() {
    let study = study("large", "noise = 0");
    let remark = trained(&study, 1, 0.2, true).remark.unwrap_or_default();
    assert!(remark.contains("the stated noise is about ") && remark.contains(" times too large"), "{remark}");
    assert_eq!(trained(&study, 1, 1.0, true).remark, None);
}
