//! A stepped tube without losses, whose reflection coefficient is a closed form, and a head that hears it
//! badly.

use rand_distr::{Distribution, StandardNormal};
use rijke_engine::EngineError;
use rijke_engine::response::{ResponseModelRecord, ResponseRun, ResponseStageRecord};
use rijke_numerics::{C64, Stream};
use rijke_rig::DataKind;
use rijke_study::responses::{ObservedResponse, ResponseKind, Responses};
use rijke_study::{Coefficient, Place, Study};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

pub(crate) const GAMMA: f64 = 1.4;
pub(crate) const GAS_CONSTANT: f64 = 287.0;
pub(crate) const WIDE: [f64; 2] = [0.15, 0.016];

/// The law k_eu of candidate `one` where it acts, measured by itself.
pub(crate) fn law_itself(study: &Study) -> ResponseKind {
    let at = study.catalogue.get("one").unwrap().effects[0].place.clone();
    let context = rijke_formula::Context {
        scope: &study.rig.scope,
        here: &|_| true,
        parameters: &[],
        definitions: &[],
    };
    let factor = rijke_formula::Formula::parse("1", &context).unwrap();
    ResponseKind::Law { at, coefficient: Coefficient::Eu, factor }
}

/// The rig, with temperatures of the wide and the narrow duct.
pub(crate) fn rig(temperatures: [Option<f64>; 2]) -> String {
    let line = |k: usize| temperatures[k].map_or(String::new(), |t| format!("temperature = {t}\n"));
    format!(
        "name = \"Stepped tube\"\n[gas]\ntemperature = 293.15\npressure = 101325\ngamma = {GAMMA}\ngas_constant = {GAS_CONSTANT}\n\
         [upstream]\ntype = \"anechoic\"\n[downstream]\ntype = \"free\"\n\
         [[element]]\nname = \"wide\"\ntype = \"duct\"\nlength = {}\ndiameter = {}\nwall = \"none\"\n{}\
         [[element]]\nname = \"narrow\"\ntype = \"duct\"\nlength = \"$l2\"\ndiameter = \"2*$b2\"\nwall = \"none\"\n{}\
         [unknown.l2]\nunit = \"m\"\nprior = {{ normal = {{ mean = 0.10, sd = 0.003 }} }}\n\
         [unknown.b2]\nunit = \"m\"\nprior = {{ normal = {{ mean = 5e-3, sd = 2e-4 }} }}\n",
        WIDE[0],
        WIDE[1],
        line(0),
        line(1)
    )
}

/// Two ends, the second of which is slow, and heads.
const CANDIDATES: &str = r#"
[[candidate]]
id = "end.constant"
role = "end"
name = "A constant share"
cite = ["a test"]
parameters.eta = { unit = "1", prior = { normal = { mean = 0.9, sd = 0.05 } } }
[[candidate.effect]]
acts_at = "downstream"
reflection = "-eta"
[[candidate]]
id = "end.slow"
role = "end"
name = "A share that falls with frequency"
cite = ["a test"]
parameters.eta = { unit = "1", prior = { normal = { mean = 0.9, sd = 0.05 } } }
[[candidate.effect]]
acts_at = "downstream"
reflection = "-eta/(1 + s*slow)"
[[candidate]]
id = "head"
role = "head"
name = "A head"
cite = ["a test"]
head = true
error = ERRORS
"#;

/// The folder of a study of one stage. `errors` are those of the head, `more` further keys of the stage.
pub(crate) fn folder(name: &str, rig: &str, base: &str, errors: &str, more: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("rijke-responses-{name}-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("candidates")).unwrap();
    let write = |file: &str, text: &str| std::fs::write(folder.join(file), text).unwrap();
    write("rig.toml", rig);
    write("candidates/all.toml", &CANDIDATES.replace("ERRORS", errors));
    write("campaign.csv", "point,slow [us]\na,10\n");
    let study = format!(
        "name = \"stepped tube\"\nbase = \"{base}\"\n[[responses]]\nid = \"end\"\nwith = {{ head = \"head\" }}\ncompete = [\"end\"]\n{more}\n"
    );
    write("study.toml", &study);
    folder
}

/// Responses that a test makes up.
pub(crate) fn observed(list: Vec<ObservedResponse>) -> Responses {
    Responses {
        kind: DataKind::Virtual,
        source: "a closed form".into(),
        list,
        ambient: BTreeMap::new(),
        warnings: Vec::new(),
    }
}

/// Trains on a reflection coefficient.
pub(crate) fn trained(
    folder: &Path,
    frequency_hz: &[f64],
    values: &[C64],
) -> Result<ResponseStageRecord, EngineError> {
    let response = ObservedResponse {
        point: 0,
        what: ResponseKind::Reflection { at: Place::Upstream, reference_area: None },
        rows: frequency_hz.len(),
        frequency_hz: frequency_hz.to_vec(),
        values: values.to_vec(),
        sd: Vec::new(),
        level: Vec::new(),
    };
    let run = ResponseRun::new(Study::open(folder).unwrap(), observed(vec![response]));
    Ok(run?.next_stage()?.unwrap())
}

pub(crate) fn model<'a>(stage: &'a ResponseStageRecord, id: &str) -> &'a ResponseModelRecord {
    stage.models.iter().find(|m| m.id == id).unwrap()
}

/// Reflection coefficient of the tube, looking into the wide duct; `slow` is the end's time constant.
pub(crate) fn reflection(f: f64, [l2, b2, eta]: [f64; 3], slow: f64, temperatures: [f64; 2]) -> C64 {
    let s = C64::new(0.0, 2.0 * PI * f);
    let sound = temperatures.map(|t| (GAMMA * GAS_CONSTANT * t).sqrt());
    let density = temperatures.map(|t| 101325.0 / (GAS_CONSTANT * t));
    let area = [WIDE[1], 2.0 * b2].map(|d| 0.25 * PI * d * d);
    let end = -eta / (1.0 + s * slow);
    let narrow = end * (-2.0 * s * l2 / sound[1]).exp();
    let ratio = (density[1] * sound[1] / area[1]) / (density[0] * sound[0] / area[0]);
    let z = (1.0 + narrow) / (1.0 - narrow) * ratio;
    (z - 1.0) / (z + 1.0) * (-2.0 * s * WIDE[0] / sound[0]).exp()
}

/// Legendre polynomials over the frequencies, each of root mean square 1/sqrt(count).
pub(crate) fn polynomials(frequency_hz: &[f64], count: usize) -> Vec<Vec<f64>> {
    let (low, high) = (frequency_hz[0], frequency_hz[frequency_hz.len() - 1]);
    let one = |f: &f64| {
        let x = 2.0 * (f - low) / (high - low) - 1.0;
        let mut all = vec![1.0, x];
        for n in 2..count {
            let m = n as f64;
            all.push(((2.0 * m - 1.0) * x * all[n - 1] - (m - 1.0) * all[n - 2]) / m);
        }
        (0..count).map(|n| all[n] * ((2 * n + 1) as f64 / count as f64).sqrt()).collect()
    };
    frequency_hz.iter().map(one).collect()
}

pub(crate) fn normal(stream: &mut Stream) -> f64 {
    StandardNormal.sample(stream)
}

/// What a head with errors of these powers and sds, of `count` polynomials each, hears of R, with noise.
pub(crate) fn heard(
    frequency_hz: &[f64],
    answers: &[C64],
    terms: &[(i32, f64)],
    count: usize,
    noise: f64,
    stream: &mut Stream,
) -> Vec<C64> {
    let basis = polynomials(frequency_hz, count);
    let mut all = answers.to_vec();
    for (power, sd) in terms {
        let c: Vec<C64> = (0..count).map(|_| sd * C64::new(normal(stream), normal(stream))).collect();
        for ((y, r), row) in all.iter_mut().zip(answers).zip(&basis) {
            *y += row.iter().zip(&c).map(|(p, c)| c * p).sum::<C64>() * r.powi(*power);
        }
    }
    all.iter().map(|y| y + noise * C64::new(normal(stream), normal(stream))).collect()
}
