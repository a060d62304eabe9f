//! From the laboratory's clicks to base states: the laboratory's truth, which has closures that the model has
//! not, is found within the stated errors, and what the program writes can be read back.

use crate::{rijke, scratch};
use rijke_flow::BaseStates;
use rijke_flow::{TubeCampaign, TubeRig};
use rijke_lab::{Truth, VirtualRig};
use rijke_rig::RecordSource;
use rijke_signal::{ProcessOptions, process};
use std::path::Path;

const CAMPAIGN: [f64; 3] = [0.0, 30.0, 180.0];

fn campaign() -> TubeCampaign {
    let rows = CAMPAIGN.map(|power| {
        format!(
            "[[row]]\nid = \"H{power}\"\nplates = true\nthermometers = true\npower_w = {power:?}\nrepeats = 3\n\
             positions_cm = [25, 60]\n"
        )
    });
    TubeCampaign::parse(&format!("name = \"two positions\"\n{}", rows.concat()), Path::new("campaign"))
        .unwrap()
}

#[test]
fn lab_base_states_are_true_within_their_errors() {
    let lab = VirtualRig::new(&TubeRig::juniper_yoko_2022(), &campaign(), &Truth::standard(), &[], None, 1)
        .unwrap();
    let processed = process(&lab, &ProcessOptions::default(), &|| {}).unwrap();
    let work = scratch("base-states");
    let observations = work.join("observations");
    std::fs::create_dir_all(&observations).unwrap();
    processed.observations.write(&observations).unwrap();
    lab.tube().write_within(&observations, &|_| true).unwrap();
    let run = rijke(&work, &["flow", ".", "--out", "base-flow"]);
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let states = BaseStates::read(&work.join("base-flow")).unwrap();
    assert_eq!(states.points.len(), 6);
    true_within_errors(&lab, &states);
}

#[test]
fn lab_states_of_a_ramp_are_true_within_their_errors() {
    // Three powers in 50 minutes and one in cooling gas, beside one cold point.
    let points = [
        ("H0", 0.0, 0.0),
        ("R30", 30.0, 960.0),
        ("R80", 80.0, 1960.0),
        ("R180", 180.0, 2960.0),
        ("R0", 0.0, 3200.0),
    ];
    let rows = points.map(|(row, power, _)| {
        format!(
            "[[row]]\nid = \"{row}\"\nplates = true\nthermometers = true\npower_w = {power:?}\nrepeats = 3\npositions_cm = [25]\n"
        )
    });
    let work = scratch("ramp-states");
    let log = "ramp,time [s],power [W],point\na,0,30,\na,960,30,R30-25\na,1000,80,\na,1960,80,R80-25\na,2000,180,\n\
               a,2960,180,R180-25\na,3000,0,\na,3200,0,R0-25\n";
    std::fs::write(
        work.join("campaign.toml"),
        format!("name = \"up\"\nramps = \"log.csv\"\n{}", rows.concat()),
    )
    .unwrap();
    std::fs::write(work.join("log.csv"), log).unwrap();
    let campaign = TubeCampaign::read(&work.join("campaign.toml")).unwrap();
    let lab =
        VirtualRig::new(&TubeRig::juniper_yoko_2022(), &campaign, &Truth::standard(), &[], None, 1).unwrap();
    // Through files: what the laboratory writes is read with its ramps, and observations keep them.
    for command in [
        &["lab", "--campaign", "campaign.toml", "--out", "records"][..],
        &["process", "records", "--out", "observations"],
        &["flow", ".", "--out", "base-flow"],
    ] {
        let run = rijke(&work, command);
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    }
    let states = BaseStates::read(&work.join("base-flow")).unwrap();
    assert_eq!(states.points.len(), 5);
    // Hot still after 200 s without power, and not what 180 W end in.
    assert!(states.points["R0-25"].temperature(0.9) > 305.0, "{:?}", states.points["R0-25"].temperature(0.9));
    true_within_errors(&lab, &states);
    let file = std::fs::read_to_string(work.join("base-flow/states.json")).unwrap();
    assert!(file.contains("R0-25") && !file.contains("H0-25"));

    // A wrong row ends every command that reads it, and nothing is written.
    let path = work.join("observations/ramps.csv");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace("a,1960.0,80.0,R80-25", "a,1960.0,70.0,R80-25")).unwrap();
    let run = rijke(&work, &["flow", ".", "--out", "again"]);
    let said = String::from_utf8_lossy(&run.stderr).into_owned();
    assert_eq!(run.status.code(), Some(2), "{said}");
    assert!(
        said.contains("ramps.csv:5:1: `R80-25` is a point at 80 W, but the power is 70 W; correct one"),
        "{said}"
    );
    assert!(!work.join("again").exists());
}

/// Whether the laboratory's states lie within three standard deviations of those found.
fn true_within_errors(lab: &VirtualRig, states: &BaseStates) {
    for (k, entry) in lab.set().points.iter().enumerate() {
        let (truth, found) = (lab.true_base_state(k), &states.points[&entry.point.id]);
        let heater = entry.point.factor(rijke_flow::POSITION).unwrap();
        let places: Vec<f64> = (0..50).map(|k| 0.01 + 0.02 * f64::from(k)).collect();
        let covariance = found.sound_speed_covariance(&places);
        for (i, &x) in places.iter().enumerate().filter(|(_, x)| (*x - heater).abs() > 0.012) {
            let error = found.sound_speed(x) - truth.sound_speed(x);
            let sd = covariance[(i, i)].sqrt();
            assert!(error.abs() < 0.01 * truth.sound_speed(x), "{} at {x} m: {error} m/s", entry.point.id);
            assert!(error.abs() < 3.0 * sd, "{} at {x} m: {error} +- {sd} m/s", entry.point.id);
        }
        if truth.mass_flux != 0.0 {
            let (error, sd) = (found.heater_velocity - truth.heater_velocity, found.heater_velocity_sd());
            assert!(error.abs() < 0.1 * truth.heater_velocity, "{}: {error} m/s", entry.point.id);
            assert!(error.abs() < 3.0 * sd, "{}: {error} +- {sd} m/s", entry.point.id);
            assert!(sd < 0.12 * truth.heater_velocity, "{}: sd {sd} m/s", entry.point.id);
        }
    }
}
