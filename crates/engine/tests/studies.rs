//! Studies of rigs that have nothing in common with the paper's, from their files.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use rijke_engine::EngineError;
use rijke_engine::run::{Run, StageRecord, Trusted};
use rijke_study::Study;
use std::path::{Path, PathBuf};

/// A folder of a study that goes with the test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str, files: &[(&str, &str)]) -> Self {
        let folder = std::env::temp_dir().join(format!("rijke-engine-{name}-{}", std::process::id()));
        for (file, text) in files {
            let path = folder.join(file);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        Self(folder)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn run(folder: &Path) -> Result<Vec<StageRecord>, EngineError> {
    let study = Study::open(folder)?;
    let observations = study.observations()?;
    let mut run = Run::new(study, &observations, Trusted::Laplace)?;
    let mut stages = Vec::new();
    while let Some(stage) = run.next_stage()? {
        stages.push(stage);
    }
    Ok(stages)
}

fn parameter(stage: &StageRecord, name: &str) -> [f64; 2] {
    let model = stage.models.iter().find(|m| m.id == stage.chosen).unwrap();
    let found = model.parameters.iter().find(|p| p.name == name).unwrap();
    [found.value, found.sd]
}

/// A tube of 1 m without losses whose ends reflect -r: s = c (ln r + i pi) / L.
const TUBE: &str = r#"
name = "tube"
[gas]
temperature = "20 degC"
[upstream]
type = "constant"
modulus = "$r"
angle = "180 deg"
[downstream]
type = "constant"
modulus = "$r"
angle = "180 deg"
[[element]]
name = "tube"
type = "duct"
length = "x"
diameter = "50 mm"
[unknown.r]
prior = { normal = { mean = 0.9, sd = 0.2 } }
"#;
const CAMPAIGN: &str = "point,x [cm],T_amb [degC]\na,100,20\nb,80,20\n";
const ORIGIN: &str = "kind = \"virtual\"\nsource = \"closed form\"\n";
const PLAN: &str = "name = \"t\"\n[[stage]]\nid = \"s\"\npoints = {}\n[stage.noise]\ngrowth_rate = 0.0\nangular_frequency = 0.0\n";

fn tube(name: &str, modes: &str) -> Folder {
    let files = [
        ("rig.toml", TUBE),
        ("campaign.csv", CAMPAIGN),
        ("study.toml", PLAN),
        ("observations/observations.toml", ORIGIN),
        ("observations/modes.csv", modes),
    ];
    Folder::new(name, &files)
}

#[test]
fn exact_an_unknown_of_the_rig_file_is_found_from_frequencies_and_growth_rates() {
    let c = (1.4_f64 * 287.05 * 293.15).sqrt();
    let row = |id: &str, length: f64| {
        let (sigma, hertz) = (c * 0.85_f64.ln() / length, 0.5 * c / length);
        format!("{id},{sigma:.12},0.1,{hertz:.12},0.05\n")
    };
    let head = "point,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n";
    let folder = tube("closed-form", &format!("{head}{}{}", row("a", 1.0), row("b", 0.8)));
    let stages = run(&folder.0).unwrap();
    let [r, sd] = parameter(&stages[0], "r");
    // Each point tells r to 0.1 L r/c; the prior pulls by (0.05/0.2) sd/0.2.
    let expected = 0.1 * 0.85 / c / (1.0_f64 / 1.0 + 1.0 / 0.64).sqrt();
    assert!((sd / expected - 1.0).abs() < 1e-3, "{sd} {expected}");
    assert!((r - 0.85).abs() < 2e-3 * sd, "{r} +- {sd}");
}

#[test]
fn behaviour_growth_rates_or_frequencies_alone_are_enough() {
    let folder = tube("alone", "point,frequency [Hz],frequency_sd [Hz]\na,171.6,0.05\n");
    let stages = run(&folder.0).unwrap();
    // A frequency says nothing of losses that move the growth rate alone.
    let [_, sd] = parameter(&stages[0], "r");
    assert!(sd > 0.19, "{sd}");
}

#[test]
fn message_a_mode_that_the_rig_does_not_have_is_refused() {
    let folder = tube("other-mode", "point,frequency [Hz],frequency_sd [Hz]\na,265.0,0.05\n");
    let refused = run(&folder.0).unwrap_err().to_string();
    assert!(refused.contains("265.0 Hz was measured, the rig as described rings at"), "{refused}");
}

#[test]
fn message_two_modes_of_a_point_must_be_two() {
    let rows = "point,mode,frequency [Hz],frequency_sd [Hz]\na,1,171.6,0.05\na,2,174.0,0.05\n";
    let folder = tube("twins", rows);
    let refused = run(&folder.0).unwrap_err().to_string();
    assert!(refused.contains("are both nearest to that at 171.6 Hz"), "{refused}");
}

/// The data come from an integrator of its own, with a truth that no candidate equals (truth.toml of the example): Lighthill's delay
/// with a spread over the wires, and King's law in the form of Collis and Williams.
#[test]
fn lab_quarter_wave_tube_finds_the_form_of_its_law() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/quarter-wave");
    let stages = run(&folder).unwrap();
    let heat = stages.last().unwrap();
    assert_eq!((heat.measured.len(), heat.chosen.as_str()), (48, "heat.king-lighthill"));
    let total =
        |id: &str| heat.models.iter().find(|m| m.id == id).and_then(|m| m.evidence).unwrap().ln_marginal;
    assert!(total("heat.king-lighthill") > total("heat.king") + 20.0);
    assert!(total("heat.king") > total("heat.constant") + 20.0);
}
