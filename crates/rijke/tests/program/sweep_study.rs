//! From sweeps of the virtual laboratory to a ranked study of the tube in which they were recorded.

use crate::measured::{model, parameter, stage};
use crate::{rijke, scratch};
use rijke_flow::{TubeCampaign, TubeRig};
use rijke_lab::{Truth, VirtualRig, open_ends};
use rijke_numerics::C64;
use serde_json::Value;
use std::fs;
use std::path::Path;

const CAMPAIGN: &str = "name = \"The empty tube\"\nsource = \"a test\"\n[[row]]\nid = \"C3\"\nplates = false\nthermometers = false\n\
                        power_w = 0.0\nrepeats = 4\nempty_tube = true\npositions_cm = []\n";

const RIG: &str = r#"
name = "The empty tube of the virtual laboratory"
source = "crates/flow/data/rigs/juniper-yoko-2022.toml"

[gas]
pressure = "101325 Pa"
molar_mass = "28.97 g/mol"
heat_capacity = [28.11, 0.1967e-2, 0.4802e-5, -1.966e-9]
viscosity = [1.716e-5, 110.4]
conductivity = [0.0241, 194.0]

[upstream] # where the loudspeaker acts: what enters there is unknown
type = "anechoic"

[downstream]
type = "free"

[[element]]
name = "tube"
type = "duct"
length = "1 m"
diameter = "47.4 mm"
temperature = "$air"
wall = "none"

[microphones]
at = [0.25, 0.35, 0.45, 0.55, 0.65, 0.75, 0.85, 0.95]

[unknown.air]
unit = "K"
symbol = "T"
prior = { normal = { mean = 294.0, sd = 3.0 } }
"#;

const CANDIDATES: &str = r#"
[[candidate]]
id = "wall.none"
role = "wall"
name = "No loss"
cite = ["own judgement"]
[[candidate.effect]]
acts_at = "ducts"
mu = "0"

[[candidate]]
id = "wall.layers"
role = "wall"
name = "Zwikker and Kosten, times a factor"
cite = ["C. Zwikker & C. W. Kosten, Sound Absorbing Materials (Elsevier, 1949), chapter II"]
parameters.rough = { symbol = "r", unit = "1", prior = { normal = { mean = 1.2, sd = 0.5 } } }
[[candidate.effect]]
acts_at = "ducts"
mu = "s*rho*rough/(D/4*sqrt(s*rho/mu)/bessel_ratio(D/2*sqrt(s*rho/mu)) - rough)"
ep = "rough*s*(gamma - 1)/(rho*c^2)*bessel_ratio(D/2*sqrt(s*rho/mu*Pr))/(D/4*sqrt(s*rho/mu*Pr))"

[[candidate]]
id = "mouth.unflanged"
role = "mouth"
name = "Thin unflanged end, a length that its wall adds, and a share that it takes"
cite = ["H. Levine & J. Schwinger, Phys. Rev. 73 (1948) 383"]
parameters.extra = { symbol = "l", unit = "m", prior = { normal = { mean = 0.0, sd = 0.003 } } }
parameters.taken = { symbol = "a", unit = "1", prior = { normal = { mean = 0.0, sd = 0.005 } } }
[[candidate.effect]]
acts_at = "downstream"
reflection = "R_LS*exp(-2*s*extra/c)*(1 - taken)"
"#;

const STUDY: &str = r#"
name = "Sweeps in an empty tube"
question = "What does the wall take, and where does the tube end?"
base = "rig"

[[responses]]
id = "tube"
with = { mouth = "mouth.unflanged" }
compete = ["wall"]
step_hz = 10
noise = 0.0
"#;

/// A study folder with sweeps of the laboratory.
fn study(name: &str, seed: u64) -> std::path::PathBuf {
    let folder = scratch(name);
    fs::create_dir_all(folder.join("candidates")).unwrap();
    for (file, text) in [
        ("lab.toml", CAMPAIGN),
        ("rig.toml", RIG),
        ("campaign.csv", "point,row\nC3-E,empty\n"),
        ("candidates/tube.toml", CANDIDATES),
        ("study.toml", STUDY),
    ] {
        fs::write(folder.join(file), text).unwrap();
    }
    let seed = seed.to_string();
    let words =
        ["lab", "--out", "records", "--campaign", "lab.toml", "--sweep", "100", "700", "--seed", &seed];
    let output = rijke(&folder, &words);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    folder
}

/// Temperature of the gas, K, and the length by which the top mouth is longer than a thin one, m, in the
/// laboratory: at ka = 0.2, where a thin one is longer by 0.606379597 radii (the exact integrals of Levine &
/// Schwinger; fixtures/reference/levine_schwinger.csv).
fn truth(folder: &Path, seed: u64) -> [f64; 2] {
    let (rig, truth) = (TubeRig::juniper_yoko_2022(), Truth::standard());
    let campaign = TubeCampaign::read(&folder.join("lab.toml")).unwrap();
    let point = campaign.row("C3").next().unwrap().clone();
    let lab = VirtualRig::new(&rig, &campaign, &truth, &[], None, seed).unwrap();
    let [_, top] = open_ends(&rig, &truth, &point, seed);
    let gas = rig.gas.at(lab.true_temperature(0), rig.pressure);
    let reflection = top.reflection(&gas, C64::new(0.0, 0.2 * gas.sound_speed / top.inner_radius));
    [lab.true_temperature(0), top.inner_radius * (-(-reflection).arg() / 0.4 - 0.606_379_597)]
}

/// Errors over stated standard deviations of temperature, length of the mouth and roughness of the wall,
/// which is 1 in the laboratory.
fn errors(name: &str, seed: u64) -> [f64; 3] {
    let folder = study(name, seed);
    let output = rijke(&folder, &["run", ".", "--json"]);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && !error.contains("warning"), "{error}");
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    let tube = stage(&answer, "tube");
    assert_eq!(tube["winner"], "wall.layers", "{tube}");
    let best = model(tube, "wall.layers");
    // The noise of the stage is none: the standard deviations that come from the records explain the
    // residuals.
    assert!(best["remark"].is_null(), "{best}");
    let [temperature, extra] = truth(&folder, seed);
    [("air", temperature, 0.1), ("extra", extra, 5e-5), ("rough", 1.0, 0.02)].map(|(name, truth, most)| {
        let [value, sd] = parameter(best, name);
        assert!(sd < most, "{name}: {value} +- {sd}");
        (value - truth) / sd
    })
}

#[test]
fn oracle_virtual_sweeps_tell_wall_end_and_temperature() {
    let errors = errors("sweep-study", 1);
    assert!(errors.iter().all(|e| e.abs() < 3.0), "{errors:?}");
}

#[test]
#[ignore = "long: a minute"]
#[allow(clippy::print_stdout, reason = "shows a table")]
fn coverage_of_studies_of_virtual_sweeps() {
    let all: Vec<[f64; 3]> = (1..=40).map(|seed| errors("sweep-coverage", seed)).collect();
    for (k, name) in ["temperature", "end", "wall"].into_iter().enumerate() {
        let n = all.len() as f64;
        let mean = all.iter().map(|e| e[k]).sum::<f64>() / n;
        let rms = (all.iter().map(|e| e[k] * e[k]).sum::<f64>() / n).sqrt();
        let inside = all.iter().filter(|e| e[k].abs() < 2.0).count();
        println!("{name}: mean {mean:.2}, rms {rms:.2}, {inside} of {n} within two");
        assert!(rms < 1.6, "{name}: {rms}");
    }
}
