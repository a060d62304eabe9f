//! Lengths that are taken as exact.

use super::ORIGIN;
use crate::common::folder::Folder;
use crate::common::tube::speed;
use rijke_engine::run::{Run, StageRecord, Trusted};
use rijke_study::Study;

const RIG: &str = r#"
name = "tube"
[gas]
temperature = "20 degC"
[upstream]
type = "constant"
modulus = 0.97
angle = "180 deg"
[downstream]
type = "constant"
modulus = 0.97
angle = "180 deg"
[[element]]
name = "first"
type = "duct"
length = "300 mm"
diameter = "50 mm"
[[element]]
name = "gauze"
type = "device"
[[element]]
name = "rest"
type = "duct"
length = "x - 0.3"
diameter = "50 mm"
"#;

const CANDIDATES: &str = r#"
[[candidate]]
id = "gauze.drag"
role = "gauze"
name = "a drag"
cite = ["test"]
parameters.d = { symbol = "d", unit = "1", prior = { normal = { mean = 5e-3, sd = 5e-3 } } }
[[candidate.effect]]
acts_at = "gauze"
mu = "d*rho*c"

[[candidate]]
id = "gauze.mass"
role = "gauze"
name = "a mass of gas"
cite = ["test"]
parameters.l = { symbol = "l", unit = "m", prior = { normal = { mean = 5e-3, sd = 5e-3 } } }
[[candidate.effect]]
acts_at = "gauze"
mu = "s*rho*l"
"#;

const PLAN: &str = "name = \"t\"\n[[stage]]\nid = \"s\"\npoints = {}\ncompete = \"gauze\"\n[stage.noise]\n\
                    growth_rate = 0.5\nangular_frequency = 1.0\n";

/// A gauze that damps, in tubes of four lengths.
fn tubes(name: &str, first: &str) -> Folder {
    let c = speed();
    let length = |k: usize| 1.0 - 0.1 * k as f64;
    let row = |k: usize| {
        let growth = c * 0.97_f64.ln() / length(k) - 1.0;
        format!("p{k},{growth:.12},0.1,{:.12},0.01\n", 0.5 * c / length(k))
    };
    let rows: String = (0..4).map(row).collect();
    let points: String = (0..4).map(|k| format!("p{k},{},20\n", 100.0 * length(k))).collect();
    let head = "point,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n";
    Folder::new(
        name,
        &[
            ("rig.toml", &RIG.replace("300 mm", first)),
            ("campaign.csv", &format!("point,x [cm],T_amb [degC]\n{points}")),
            ("study.toml", PLAN),
            ("candidates/all.toml", CANDIDATES),
            ("observations/observations.toml", ORIGIN),
            ("observations/modes.csv", &format!("{head}{rows}")),
        ],
    )
}

fn run(folder: &Folder) -> StageRecord {
    let study = Study::open(&folder.0).unwrap();
    let observations = study.observations().unwrap();
    let mut run = Run::new(study, &observations, Trusted::Laplace).unwrap();
    run.lengths = true;
    run.next_stage().unwrap().unwrap()
}

/// The lead of the drag over the mass.
fn lead(folder: &Folder) -> f64 {
    let stage = run(folder);
    let evidence = |id: &str| stage.models.iter().find(|m| m.id == id).unwrap().ln_evidence();
    evidence("gauze.drag") - evidence("gauze.mass")
}

#[test]
fn oracle_the_error_of_a_length_that_reverses_a_lead_does_so_in_a_fit() {
    let folder = tubes("exact-length", "300 mm");
    let found = run(&folder).lengths.unwrap();
    assert!(found.models == ["gauze.drag", "gauze.mass"] && found.lead > 2.0, "{found:?}");
    let error =
        found.smallest.iter().find(|e| e.what == "length of `first`").unwrap_or_else(|| panic!("{found:?}"));
    // The tube is longer by as much: what the campaign calls x counts from there.
    let left = lead(&tubes("exact-length-longer", &format!("{} mm", 300.0 + 1e3 * error.by)));
    assert!(left.abs() < 0.2 * found.lead, "{left} of {}", found.lead);
}

#[test]
fn oracle_the_error_of_a_bore_that_reverses_a_lead_does_so_in_a_fit() {
    let found = run(&tubes("exact-bore", "300 mm")).lengths.unwrap();
    let error = found.smallest.iter().find(|e| e.what == "diameter of `first`");
    let error = error.unwrap_or_else(|| panic!("{found:?}"));
    let wider = tubes("exact-bore-wider", "300 mm");
    // The first duct alone.
    let rig = RIG.replacen("50 mm", &format!("{} mm", 50.0 + 1e3 * error.by), 1);
    std::fs::write(wider.0.join("rig.toml"), rig).unwrap();
    let left = lead(&wider);
    assert!(left.abs() < 0.2 * found.lead, "{left} of {}", found.lead);
}

#[test]
fn oracle_the_error_of_a_length_that_moves_a_parameter_does_so_in_a_fit() {
    let stated = run(&tubes("exact-moving", "300 mm"));
    let found = stated.lengths.clone().unwrap();
    let [moving] = &found.moving[..] else { panic!("{found:?}") };
    assert!(moving.what == "length of `first`" && moving.parameter == "d", "{found:?}");
    // A tenth of it: a step of 24 mm would bend.
    let longer = run(&tubes("exact-moving-longer", &format!("{} mm", 300.0 + 100.0 * moving.by)));
    let [[before, sd], [after, _]] = [&stated, &longer].map(|stage: &StageRecord| {
        let model = stage.models.iter().find(|m| m.id == "gauze.drag").unwrap();
        let d = model.parameters.iter().find(|p| p.name == "d").unwrap();
        [d.value, d.sd]
    });
    assert!(((after - before) / (0.1 * sd) - 1.0).abs() < 0.2, "{before} {after} of {sd}, {moving:?}");
    let said = "mm on the length of `first` raises d by one standard deviation";
    assert!(found.words().ends_with(said), "{}", found.words());
}
