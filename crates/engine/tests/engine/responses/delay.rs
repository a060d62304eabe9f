//! A delay that was measured at equal steps of frequency, and modes that tell it from its aliases.
//!
//! A part alone answers n exp(-s tau) at f = 40, 80, ... 600 Hz: tau and tau - 25 ms give the same numbers.
//! In the tube of length L without losses, closed at one end, the other end reflects -exp(-n - s tau/50), so
//! that s (2 L/c + tau/50) = i pi - n.

use super::bench::{GAMMA, GAS_CONSTANT, law_itself, observed};
use rijke_engine::response::{ResponseRun, ResponseStageRecord};
use rijke_engine::run::{Run, StageRecord, Trusted};
use rijke_numerics::C64;
use rijke_study::Study;
use rijke_study::responses::ObservedResponse;
use std::f64::consts::PI;

const LENGTH: f64 = 0.8;
const STEP_HZ: f64 = 40.0;
const GAIN: f64 = 0.3;
const DELAY: f64 = 28e-3;
const NOISE: f64 = 0.03;

/// Runs the study with this prior of the delay, and the mode known so well (1/s and Hz).
fn ran(name: &str, median: f64, ln_sd: f64, sd: f64) -> (ResponseStageRecord, StageRecord) {
    let folder = std::env::temp_dir().join(format!("rijke-delay-{name}-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("candidates")).unwrap();
    std::fs::create_dir_all(folder.join("observations")).unwrap();
    let write = |file: &str, text: &str| std::fs::write(folder.join(file), text).unwrap();
    write(
        "rig.toml",
        &format!(
            "name = \"Delay\"\n[gas]\ntemperature = 293.15\npressure = 101325\ngamma = {GAMMA}\ngas_constant = {GAS_CONSTANT}\n\
             [search]\nfrequency_hz = [50, 150]\n[upstream]\ntype = \"closed\"\n[downstream]\ntype = \"free\"\n\
             [[element]]\nname = \"tube\"\ntype = \"duct\"\nlength = {LENGTH}\ndiameter = 0.05\nwall = \"none\"\n\
             [[element]]\nname = \"part\"\ntype = \"device\"\nat = 0.4\npresent = \"alone\"\n"
        ),
    );
    write("campaign.csv", "point,row,alone\nalone,part,1\nm0,tube,0\n");
    write(
        "candidates/all.toml",
        &format!(
            "[[candidate]]\nid = \"one\"\nrole = \"part\"\nname = \"one\"\ncite = [\"a test\"]\n\
             parameters.n = {{ unit = \"1\", prior = {{ normal = {{ mean = 0.4, sd = 0.2 }} }} }}\n\
             parameters.tau = {{ unit = \"s\", prior = {{ log_normal = {{ median = {median}, ln_sd = {ln_sd} }} }} }}\n\
             [[candidate.effect]]\nacts_at = \"part\"\neu = \"n*exp(-s*tau)\"\n\
             [[candidate.effect]]\nacts_at = \"downstream\"\nreflection = \"-exp(-n - s*tau/50)\"\n"
        ),
    );
    write(
        "study.toml",
        &format!(
            "name = \"delay\"\nbase = \"rig\"\n[[responses]]\nid = \"alone\"\npoints = {{ rows = [\"part\"] }}\ncompete = [\"part\"]\n\
             noise = {NOISE}\n[[stage]]\nid = \"tube\"\npoints = {{ rows = [\"tube\"] }}\non = \"alone\"\n[stage.noise]\ngrowth_rate = 0.0\n\
             angular_frequency = 0.0\n"
        ),
    );
    let travel = 2.0 * LENGTH / (GAMMA * GAS_CONSTANT * 293.15).sqrt() + DELAY / 50.0;
    write(
        "observations/modes.csv",
        &format!(
            "point,growth_rate,growth_rate_sd,frequency [Hz],frequency_sd [Hz]\nm0,{},{sd},{},{sd}\n",
            -GAIN / travel,
            0.5 / travel
        ),
    );
    write("observations/observations.toml", "kind = \"virtual\"\nsource = \"a closed form\"\n");
    let study = Study::open(&folder).unwrap();
    let frequency_hz: Vec<f64> = (1..=15).map(|k| STEP_HZ * f64::from(k)).collect();
    // Errors that no delay follows.
    let wrong = |k: usize| NOISE * C64::from_polar(1.0, 2.4 * (k * k) as f64);
    let answer = |f: &f64| GAIN * C64::from_polar(1.0, -2.0 * PI * f * DELAY);
    let response = ObservedResponse {
        point: 0,
        what: law_itself(&study),
        rows: frequency_hz.len(),
        values: frequency_hz.iter().enumerate().map(|(k, f)| answer(f) + wrong(k)).collect(),
        frequency_hz,
        sd: Vec::new(),
        level: Vec::new(),
    };
    let mut responses = ResponseRun::new(study.clone(), observed(vec![response])).unwrap();
    let first = responses.next_stage().unwrap().unwrap();
    let observations = study.observations().unwrap();
    let mut run = Run::on_responses(study, &observations, Trusted::Laplace, responses.grounds()).unwrap();
    let second = run.next_stage().unwrap().unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    (first, second)
}

#[test]
fn exact_modes_choose_between_the_maxima_of_a_delay() {
    let (alone, tube) = ran("chosen", 8e-3, 0.7, 0.1);
    // The prior prefers the alias, 28 - 25 ms; both are in the record with their probabilities.
    let row = &alone.models[0];
    let tau = row.parameters.iter().find(|p| p.name == "tau").unwrap();
    assert!((tau.value - 3e-3).abs() < 1e-4, "{tau:?}");
    let other = row.maxima.iter().find(|m| (m.parameters[1] - 28e-3).abs() < 2e-4).unwrap();
    assert!(other.share > 0.01 && other.share < 0.5, "{other:?}");
    let remark = row.remark.clone().unwrap_or_default();
    assert!(remark.contains("40.0000 Hz apart cannot distinguish tau"), "{remark}");
    assert!(remark.contains("25.00 ms longer"), "{remark}");
    assert!(remark.contains("further maxim") && remark.contains("tau = 0.028"), "{remark}");
    // The frequency of the mode knows better.
    let own = &tube.models[0];
    let tau = own.parameters.iter().find(|p| p.name == "tau").unwrap();
    assert!((tau.value - 28e-3).abs() < 4.0 * tau.sd, "{tau:?}");
    let said = own.remark.clone().unwrap_or_default();
    assert!(!said.contains("do not decide"), "{said}");
    // What it says is worth the probability that the responses gave this maximum.
    let ln = own.evidence.unwrap();
    assert!((ln.ln_marginal - ln.ln_best_fit - ln.ln_occam).abs() < 1e-9);
    let (near, _) = ran("known", 28e-3, 0.05, 0.1);
    assert!(!near.models[0].remark.clone().unwrap_or_default().contains("apart cannot distinguish"));
}

#[test]
fn behaviour_maxima_that_modes_leave_open_are_named() {
    let (alone, tube) = ran("open", 8e-3, 0.7, 1000.0);
    let own = &tube.models[0];
    let said = own.remark.clone().unwrap_or_default();
    assert!(said.contains("these data do not decide between them"), "{said}");
    assert!(said.contains("tau = 0.02"), "{said}");
    let share = alone.models[0].maxima.iter().find(|m| (m.parameters[1] - 28e-3).abs() < 2e-4).unwrap().share;
    assert!(said.contains(&format!("probability {share:.2}")), "{share}: {said}");
}
