//! From the laboratory's clicks to base states: the laboratory's truth, which has closures that the model has not, is found
//! within the stated errors, and what the program writes can be read back.

use crate::{rijke, scratch};
use rijke_flow::BaseStates;
use rijke_lab::{Truth, VirtualRig};
use rijke_rig::{Campaign, RecordSource, Rig};
use rijke_signal::{ProcessOptions, process};
use std::path::Path;

const CAMPAIGN: [f64; 3] = [0.0, 30.0, 180.0];

fn campaign() -> Campaign {
    let rows = CAMPAIGN.map(|power| {
        format!(
            "[[row]]\nid = \"H{power}\"\nplates = true\nthermometers = true\npower_w = {power:?}\nrepeats = 3\n\
             positions_cm = [25, 60]\n"
        )
    });
    Campaign::parse(&format!("name = \"two positions\"\n{}", rows.concat()), Path::new("campaign")).unwrap()
}

#[test]
fn lab_base_states_are_true_within_their_errors() {
    let lab =
        VirtualRig::new(&Rig::juniper_yoko_2022(), &campaign(), &Truth::standard(), &[], None, 1).unwrap();
    let processed = process(&lab, &ProcessOptions::default(), &|| {}).unwrap();
    let work = scratch("base-states");
    let observations = work.join("observations");
    std::fs::create_dir_all(&observations).unwrap();
    processed.observations.write(&observations).unwrap();
    let run = rijke(&work, &["flow", ".", "--out", "base-flow"]);
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let states = BaseStates::read(&work.join("base-flow")).unwrap();
    assert_eq!(states.points.len(), 6);
    for (k, entry) in lab.set().points.iter().enumerate() {
        let (truth, found) = (lab.true_base_state(k), &states.points[&entry.point.id]);
        let heater = entry.point.position.unwrap();
        let places: Vec<f64> = (0..50).map(|k| 0.01 + 0.02 * f64::from(k)).collect();
        let covariance = found.sound_speed_covariance(&places);
        for (i, &x) in places.iter().enumerate().filter(|(_, x)| (*x - heater).abs() > 0.012) {
            let error = found.sound_speed(x) - truth.sound_speed(x);
            let sd = covariance[(i, i)].sqrt();
            assert!(error.abs() < 0.01 * truth.sound_speed(x), "{} at {x} m: {error} m/s", entry.point.id);
            assert!(error.abs() < 3.0 * sd, "{} at {x} m: {error} +- {sd} m/s", entry.point.id);
        }
        if entry.point.power > 0.0 {
            let (error, sd) = (found.heater_velocity - truth.heater_velocity, found.heater_velocity_sd());
            assert!(error.abs() < 0.1 * truth.heater_velocity, "{}: {error} m/s", entry.point.id);
            assert!(error.abs() < 3.0 * sd, "{}: {error} +- {sd} m/s", entry.point.id);
            assert!(sd < 0.12 * truth.heater_velocity, "{}: sd {sd} m/s", entry.point.id);
        }
    }
}
