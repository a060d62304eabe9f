//! A candidate that takes the place of another, in stages of responses.

use super::bench::{folder, observed, reflection, rig};
use rijke_engine::response::{ResponseModelRecord, ResponseRun};
use rijke_numerics::C64;
use rijke_study::responses::{ObservedResponse, ResponseKind};
use rijke_study::{Place, Study};

const SAMPLE: &str = r#"
[[candidate]]
id = "sample.slow"
role = "sample"
EXTENDS
name = "In the place of the constant end"
cite = ["a test"]
parameters.eta_s = { unit = "1", prior = { normal = { mean = 0.6, sd = 0.05 } } }
[[candidate.effect]]
acts_at = "downstream"
reflection = "-eta_s/(1 + s*slow)"
"#;

const STUDY: &str = r#"
name = "stepped tube"
base = "rig"
[[responses]]
id = "plug"
points = { where = { sample = 0 } }
with = { head = "head", end = "end.constant" }
noise = 1e-4
[[responses]]
id = "sample"
points = { where = { sample = 1 } }
on = ["plug"]
compete = ["sample"]
noise = 1e-4
"#;

fn run(name: &str, extends: &str) -> Result<ResponseModelRecord, String> {
    let temperatures = [293.15; 2];
    let folder = folder(name, &rig(temperatures.map(Some)), "rig", "[]", "");
    let catalogue = std::fs::read_to_string(folder.join("candidates/all.toml")).unwrap();
    let sample = SAMPLE.replace("EXTENDS", extends);
    std::fs::write(folder.join("candidates/all.toml"), catalogue + &sample).unwrap();
    std::fs::write(folder.join("campaign.csv"), "point,slow [us],sample\na,10,0\nb,40,1\n").unwrap();
    std::fs::write(folder.join("study.toml"), STUDY).unwrap();
    let frequency_hz: Vec<f64> = (0..40).map(|k| 100.0 + 40.0 * f64::from(k)).collect();
    let response = |point: usize, eta: f64, slow: f64| ObservedResponse {
        point,
        what: ResponseKind::Reflection { at: Place::Upstream, reference_area: None },
        rows: frequency_hz.len(),
        frequency_hz: frequency_hz.clone(),
        values: frequency_hz
            .iter()
            .map(|f| reflection(*f, [0.1, 5e-3, eta], slow, temperatures))
            .collect::<Vec<C64>>(),
        sd: Vec::new(),
        level: Vec::new(),
    };
    let observed = observed(vec![response(0, 0.9, 0.0), response(1, 0.55, 40e-6)]);
    let mut run = ResponseRun::new(Study::open(&folder).unwrap(), observed).map_err(|e| e.to_string())?;
    run.next_stage().map_err(|e| e.to_string())?;
    let stage = run.next_stage().map_err(|e| e.to_string())?.unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    Ok(stage.models[0].clone())
}

#[test]
fn behaviour_a_candidate_takes_the_place_of_the_one_that_it_extends() {
    let model = run("extends", "extends = \"end.constant\"").unwrap();
    assert!(!model.candidates.values().any(|id| id == "end.constant"), "{:?}", model.candidates);
    let eta = model.parameters.iter().find(|p| p.name == "eta_s").unwrap();
    assert!((eta.value - 0.55).abs() < 1e-3 && model.residual < 1e-6, "{} {}", eta.value, model.residual);
}

#[test]
fn message_an_extension_of_what_no_model_has_is_refused() {
    let said = run("extends-none", "extends = \"end.slow\"").unwrap_err();
    assert!(said.contains("sample") && said.contains("extends"), "{said}");
}
