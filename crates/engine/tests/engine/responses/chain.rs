//! Stages of modes that stand on stages of responses, against one inference by hand.
//!
//! The rig is a tube of length L without losses, closed at one end, whose other end reflects -exp(-a - k b):
//! s = c (i pi - a - k b)/(2 L). At another point a part stands alone, whose transfer function a + b s T is
//! measured. Both are linear in a and b, so that the evidence of the chain is that of all data at once.

use super::bench::{GAMMA, GAS_CONSTANT, law_itself, observed};
use rijke_engine::response::ResponseRun;
use rijke_engine::run::{Run, Trusted, forecast};
use rijke_numerics::{C64, Cholesky, Matrix};
use rijke_study::responses::ObservedResponse;
use rijke_study::{ObservedModes, Study};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

const LENGTH: f64 = 0.8;
/// Time by which the frequency of the transfer function is divided, s.
const TIME: f64 = 1e-3;
const PRIORS: [[f64; 2]; 2] = [[0.1, 0.05], [0.05, 0.03]];
const FREQUENCY_HZ: [f64; 4] = [50.0, 100.0, 170.0, 240.0];
const NOISE: f64 = 0.02;
/// Factor k of the points with modes, growth rate, 1/s, and its standard deviation.
const MODES: [[f64; 3]; 3] = [[0.0, -20.0, 1.0], [1.0, -32.0, 2.0], [2.0, -41.0, 1.5]];

fn sound_speed() -> f64 {
    (GAMMA * GAS_CONSTANT * 293.15).sqrt()
}

fn folder(name: &str, stage: &str, law: &str, end: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("rijke-chain-{name}-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("candidates")).unwrap();
    std::fs::create_dir_all(folder.join("observations")).unwrap();
    let write = |file: &str, text: &str| std::fs::write(folder.join(file), text).unwrap();
    write(
        "rig.toml",
        &format!(
            "name = \"Chain\"\n[gas]\ntemperature = 293.15\npressure = 101325\ngamma = {GAMMA}\ngas_constant = {GAS_CONSTANT}\n\
             [search]\nfrequency_hz = [50, 150]\n[upstream]\ntype = \"closed\"\n[downstream]\ntype = \"free\"\n\
             [[element]]\nname = \"tube\"\ntype = \"duct\"\nlength = {LENGTH}\ndiameter = 0.05\nwall = \"none\"\n\
             [[element]]\nname = \"part\"\ntype = \"device\"\nat = 0.4\npresent = \"alone\"\nnumbers = {{ time = \"{TIME} s\" }}\n"
        ),
    );
    write(
        "campaign.csv",
        "point,row,alone,k\nalone,part,1,0\nm0,tube,0,0\nm1,tube,0,1\nm2,tube,0,2\nnew,new,0,3\n",
    );
    let prior = |k: usize| {
        let [mean, sd] = PRIORS[k];
        format!("{{ normal = {{ mean = {mean}, sd = {sd} }} }}")
    };
    let candidate = |id: &str, law: &str| {
        format!(
            "[[candidate]]\nid = \"{id}\"\nrole = \"part\"\nname = \"{id}\"\ncite = [\"a test\"]\nparameters.a = {{ prior = {} }}\n\
             parameters.b = {{ prior = {} }}\n[[candidate.effect]]\nacts_at = \"part\"\neu = \"{law}\"\n\
             [[candidate.effect]]\nacts_at = \"downstream\"\nreflection = \"{end}\"\n",
            prior(0),
            prior(1)
        )
    };
    let worse = candidate("other", &format!("1.4*({law})"));
    write("candidates/all.toml", &(candidate("one", law) + &worse));
    write(
        "study.toml",
        &format!(
            "name = \"chain\"\nbase = \"rig\"\n[[responses]]\nid = \"alone\"\npoints = {{ rows = [\"part\"] }}\ncompete = [\"part\"]\nnoise = {NOISE}\n\
             decides = 1000.0\n{stage}"
        ),
    );
    let rows: String = MODES
        .iter()
        .enumerate()
        .map(|(k, [_, growth, sd])| format!("m{k},{growth},{sd},{},0.05\n", sound_speed() / (4.0 * LENGTH)))
        .collect();
    write(
        "observations/modes.csv",
        &format!("point,growth_rate,growth_rate_sd,frequency [Hz],frequency_sd [Hz]\n{rows}"),
    );
    write("observations/observations.toml", "kind = \"virtual\"\nsource = \"a closed form\"\n");
    folder
}

const STAGE: &str = "[[stage]]\nid = \"tube\"\npoints = { rows = [\"tube\"] }\non = \"alone\"\n[stage.noise]\ngrowth_rate = 0.0\n\
                     angular_frequency = 0.0\n";

/// What the part answers by itself.
fn measured() -> Vec<C64> {
    let s = |f: &f64| C64::new(0.0, 2.0 * PI * f);
    let wrong = [C64::new(0.01, -0.015), C64::new(-0.02, 0.01), C64::new(0.005, 0.02), C64::new(0.01, 0.0)];
    FREQUENCY_HZ.iter().zip(wrong).map(|(f, e)| 0.12 + 0.06 * TIME * s(f) + e).collect()
}

/// The transfer function of the part, as it was measured.
fn response(study: &Study) -> ObservedResponse {
    ObservedResponse {
        point: 0,
        what: law_itself(study),
        rows: FREQUENCY_HZ.len(),
        frequency_hz: FREQUENCY_HZ.to_vec(),
        values: measured(),
        sd: Vec::new(),
        level: Vec::new(),
    }
}

fn ran(folder: &Path) -> (ResponseRun, Run, ObservedModes) {
    let study = Study::open(folder).unwrap();
    let response = response(&study);
    let mut responses = ResponseRun::new(study.clone(), observed(vec![response])).unwrap();
    responses.next_stage().unwrap().unwrap();
    let observations = study.observations().unwrap();
    let run = Run::on_responses(study, &observations, Trusted::Laplace, responses.grounds()).unwrap();
    (responses, run, observations)
}

/// ln evidence, mean and covariance of data that are linear in two parameters with [`PRIORS`]: the data,
/// their slopes, and their standard deviations.
fn by_hand(rows: &[(f64, [f64; 2], f64)]) -> (f64, [f64; 2], [[f64; 2]; 2]) {
    let n = rows.len();
    let offset: Vec<f64> =
        rows.iter().map(|(y, g, _)| y - g[0] * PRIORS[0][0] - g[1] * PRIORS[1][0]).collect();
    let variance = |k: usize| PRIORS[k][1].powi(2);
    let covariance = Matrix::from_fn(n, n, |i, j| {
        let own = if i == j { rows[i].2.powi(2) } else { 0.0 };
        own + (0..2).map(|k| rows[i].1[k] * variance(k) * rows[j].1[k]).sum::<f64>()
    });
    let factor = Cholesky::new(&covariance).unwrap();
    let white = factor.whiten(&offset);
    let ln = -0.5 * (white.iter().map(|w| w * w).sum::<f64>() + factor.ln_det() + n as f64 * (2.0 * PI).ln());
    let inverse = factor.inverse();
    let pull = inverse.times(&offset);
    let along =
        |k: usize, v: &[f64]| rows.iter().zip(v).map(|((_, g, _), v)| variance(k) * g[k] * v).sum::<f64>();
    let mean = [0, 1].map(|k| PRIORS[k][0] + along(k, &pull));
    let less = |i: usize, j: usize| {
        let column: Vec<f64> = rows.iter().map(|(_, g, _)| g[j] * variance(j)).collect();
        along(i, &inverse.times(&column))
    };
    let own = |i: usize, j: usize| if i == j { variance(i) } else { 0.0 };
    (ln, mean, [0, 1].map(|i| [0, 1].map(|j| own(i, j) - less(i, j))))
}

/// The rows of [`by_hand`], of the responses with the law times `scale` and of growth rates.
fn rows(scale: f64) -> Vec<(f64, [f64; 2], f64)> {
    let of_responses = FREQUENCY_HZ.iter().zip(measured()).flat_map(|(f, z)| {
        let slope = 2.0 * PI * f * TIME;
        [(z.re, [scale, 0.0], NOISE), (z.im, [0.0, scale * slope], NOISE)]
    });
    let rate = -sound_speed() / (2.0 * LENGTH);
    of_responses.chain(MODES.map(|[k, growth, sd]| (growth, [rate, k * rate], sd))).collect()
}

/// ln density of the frequencies, which say nothing of a and b.
fn of_the_frequencies() -> f64 {
    let sd: f64 = 0.05 * 2.0 * PI;
    MODES.len() as f64 * (-sd.ln() - 0.5 * (2.0 * PI).ln())
}

#[test]
fn oracle_evidence_of_the_chain_is_that_of_all_data_at_once() {
    let folder = folder("linear", STAGE, "a + b*s*time", "-exp(-a - k*b)");
    let (responses, mut run, _) = ran(&folder);
    let stage = run.next_stage().unwrap().unwrap();
    // What the responses leave open, they decide by less than 1000 nats, is a row of the stage.
    let ids: Vec<&str> = stage.models.iter().map(|m| m.id.as_str()).collect();
    assert_eq!(ids, ["one", "other"]);
    let ground = &responses.grounds()[0];
    let best = ground.models[0].evidence.ln_marginal;
    for (id, scale) in [("one", 1.0), ("other", 1.4)] {
        let model = stage.models.iter().find(|m| m.id == id).unwrap();
        let (ln, mean, covariance) = by_hand(&rows(scale));
        let chain = best + model.evidence.unwrap().ln_marginal;
        assert!(
            (chain - ln - of_the_frequencies()).abs() < 1e-6,
            "{id}: {chain} {ln} {}",
            of_the_frequencies()
        );
        for (k, p) in model.parameters.iter().enumerate() {
            assert!(
                (p.value - mean[k]).abs() < 1e-8 && (p.sd - covariance[k][k].sqrt()).abs() < 1e-8,
                "{p:?}"
            );
        }
    }
    // The prior of a and b once: with the priors of the candidates the stage alone says something else.
    let alone = by_hand(&rows(1.0)[2 * FREQUENCY_HZ.len()..]).0 + of_the_frequencies();
    let own = stage.models[0].evidence.unwrap().ln_marginal;
    assert!((own - alone).abs() > 0.5, "{own} {alone}");
}

#[test]
fn oracle_predicted_responses_have_the_covariance_of_their_parameters() {
    let folder = folder("told", STAGE, "a + b*s*time", "-exp(-a - b)");
    let (responses, _, _) = ran(&folder);
    let study = Study::open(&folder).unwrap();
    let observed = observed(vec![response(&study)]);
    let f = 333.0;
    let found = responses.grounds()[0].forecast(&study, &observed, &[0], &[f]).unwrap();
    let [law, end] = &found[..] else { panic!("{found:?}") };
    let (_, [a, b], c) = by_hand(&rows(1.0)[..2 * FREQUENCY_HZ.len()]);
    let turn = 2.0 * PI * f * TIME;
    let near =
        |found: f64, exact: f64| assert!((found - exact).abs() < 1e-7 * exact.abs(), "{found} {exact}");
    near(law.value[0], a);
    near(law.value[1], b * turn);
    near(law.covariance[0], c[0][0]);
    near(law.covariance[1], c[1][1] * turn * turn);
    assert!((law.covariance[2] - c[0][1] * turn).abs() < 1e-12 && law.absorption().is_none());
    // R = -exp(-a - b) has no phase but that of an open end, and the absorption 1 - exp(-2 a - 2 b).
    let r = (-a - b).exp();
    let variance = r * r * (c[0][0] + c[1][1] + 2.0 * c[0][1]);
    near(end.value[0], -r);
    near(end.modulus()[1], variance.sqrt());
    let [absorption, sd] = end.absorption().unwrap();
    near(absorption, 1.0 - r * r);
    near(sd, (4.0 * r * r * variance + 2.0 * variance * variance).sqrt());
    near(end.phase().unwrap()[0].abs(), PI);
}

#[test]
fn oracle_modes_that_nobody_measured_are_predicted_as_the_responses_say() {
    let new =
        "[[stage]]\nid = \"new\"\npoints = { rows = [\"new\"] }\non = \"alone\"\nwith = { part = \"one\" }\n";
    let folder = folder("unmeasured", new, "a + b*s*time", "-exp(-a - k*b)");
    let (_, mut run, observations) = ran(&folder);
    let stage = run.next_stage().unwrap().unwrap();
    assert!(stage.measured.is_empty() && stage.missing.is_none() && stage.checks.is_none());
    let (_, mean, covariance) = by_hand(&rows(1.0)[..2 * FREQUENCY_HZ.len()]);
    let saved = run.saved("new").unwrap();
    let (found, lost) = forecast(&run.study, &observations, &saved, &[], &[4]).unwrap();
    assert!(lost.is_empty() && found.len() == 1, "{found:?}");
    let rate = -sound_speed() / (2.0 * LENGTH);
    let growth = rate * (mean[0] + 3.0 * mean[1]);
    let slope = [rate, 3.0 * rate];
    let variance: f64 = (0..2)
        .flat_map(|i| (0..2).map(move |j| (i, j)))
        .map(|(i, j)| slope[i] * covariance[i][j] * slope[j])
        .sum();
    let [value, sd, of_the_model] = found[0].growth_rate;
    assert!((value - growth).abs() < 1e-8 * growth.abs(), "{value} {growth}");
    assert!((sd - variance.sqrt()).abs() < 1e-6 * sd && sd == of_the_model, "{sd} {}", variance.sqrt());
    assert_eq!(found[0].mode, "1");
}

/// Growth rates are a bent function of the gain n of the end's reflection -exp(-n^2): quadrature over n tells
/// what Laplace's method in the chain leaves out.
#[test]
fn oracle_a_bent_chain_against_quadrature() {
    let folder = folder("bent", STAGE, "a + b*s*time", "-exp(-3*a^2 - k*b)");
    let (responses, mut run, _) = ran(&folder);
    let stage = run.next_stage().unwrap().unwrap();
    let chain = responses.grounds()[0].models[0].evidence.ln_marginal
        + stage.models.iter().find(|m| m.id == "one").unwrap().evidence.unwrap().ln_marginal;
    let rate = -sound_speed() / (2.0 * LENGTH);
    let ln = |x: f64, sd: f64| -0.5 * (x / sd).powi(2) - sd.ln() - 0.5 * (2.0 * PI).ln();
    let answers = measured();
    let joint = |a: f64, b: f64| {
        let mut sum = ln(a - PRIORS[0][0], PRIORS[0][1]) + ln(b - PRIORS[1][0], PRIORS[1][1]);
        for (f, z) in FREQUENCY_HZ.iter().zip(&answers) {
            sum += ln(z.re - a, NOISE) + ln(z.im - b * TIME * 2.0 * PI * f, NOISE);
        }
        sum + MODES.iter().map(|[k, growth, sd]| ln(growth - rate * (3.0 * a * a + k * b), *sd)).sum::<f64>()
    };
    let (steps, mut total) = (400, 0.0);
    let (da, db) = (0.3 / steps as f64, 0.2 / steps as f64);
    let peak = joint(0.13, 0.06);
    for i in 0..steps {
        for j in 0..steps {
            total += (joint(-0.02 + (i as f64 + 0.5) * da, -0.02 + (j as f64 + 0.5) * db) - peak).exp();
        }
    }
    let whole = peak + (total * da * db).ln() + of_the_frequencies();
    assert!((chain - whole).abs() < 0.02, "{chain} {whole}");
}

#[test]
fn message_a_chain_that_counts_twice_or_stands_on_nothing_is_refused() {
    let twice = format!(
        "{STAGE}[[stage]]\nid = \"again\"\npoints = {{ rows = [\"new\"] }}\non = [\"tube\", \"alone\"]\n"
    );
    let error = Study::open(&folder("twice", &twice, "a", "-exp(-a - b)")).unwrap_err().to_string();
    assert!(error.contains("study.toml, line") && error.contains("counts once"), "{error}");
    let folder = folder("bare", STAGE, "a", "-exp(-a - b)");
    let study = Study::open(&folder).unwrap();
    let observations = study.observations().unwrap();
    let error = Run::new(study, &observations, Trusted::Laplace).err().unwrap().to_string();
    assert!(error.contains("`tube`") && error.contains("trains on responses"), "{error}");
}
