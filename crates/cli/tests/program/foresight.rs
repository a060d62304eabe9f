//! What `rijke check` says of the models before anything is measured, and what `rijke rank` refuses because of it.

use crate::{bad_input::observations, rijke, scratch};
use std::{fs, path::Path};

fn said(folder: &Path, command: &str) -> (Option<i32>, String) {
    let output = rijke(folder, &command.split(' ').collect::<Vec<_>>());
    let text = String::from_utf8(output.stdout).unwrap() + &String::from_utf8(output.stderr).unwrap();
    (output.status.code(), text)
}

#[test]
fn exact_a_plan_is_checked_and_drawn_without_records() {
    let folder = scratch("plan");
    assert_eq!(said(&folder, "new my-rig").0, Some(0));
    let (code, text) = said(&folder, "check my-rig --plan --plots priors");
    assert!(code == Some(0) && text.contains("My rig: planned, 35 operating points"), "{text}");
    // Eleven heat releases of the project and two of the file; nothing is in doubt.
    assert!(text.contains("heat-release: 13 models on 14 points") && !text.contains("warning"), "{text}");
    for name in ["prongs", "heater", "thermocouples", "heat-release", "heat-release-2"] {
        let svg = fs::read_to_string(folder.join(format!("priors/{name}.svg"))).unwrap();
        assert!(svg.contains("computed, no data") && !svg.contains("NaN"), "{name}");
    }
    // Existing pictures stay.
    assert_eq!(said(&folder, "check my-rig --plan --plots priors").0, Some(2));
    assert_eq!(said(&folder, "check my-rig --plan --plots priors --force").0, Some(0));
}

#[test]
fn exact_what_no_measurement_can_tell_is_named() {
    let folder = scratch("unidentified");
    said(&folder, "new my-rig");
    let candidate = "[[candidate]]\nid = 'twice'\nrole = 'prongs'\nname = 'two factors'\ncite = ['none']\n\
        parameters.a = { symbol = 'a', unit = '1', prior = { normal = { mean = 1.0, sd = 0.3 } } }\n\
        parameters.b = { symbol = 'b', unit = '1', prior = { normal = { mean = 1.0, sd = 0.3 } } }\n\
        [[candidate.effect]]\nacts_at = 'prong-end'\neu = 'a*b*A_p/A'\n";
    fs::write(folder.join("twice.toml"), candidate).unwrap();
    let (code, text) = said(&folder, "check my-rig --plan --candidates twice.toml");
    let warning = text.lines().find(|line| line.contains("warning: twice")).unwrap();
    assert!(code == Some(0) && warning.contains("0.71 a") && warning.ends_with("b at 1.00"), "{text}");
}

/// Observations without records are drawn beside what the priors allow.
#[test]
fn exact_observations_stand_in_the_pictures() {
    let folder = scratch("observed-priors");
    observations::write(&folder);
    let (code, text) = said(&folder, "check data --plots priors");
    assert!(code == Some(0) && text.contains("heater: needs a cold heater without thermocouples"), "{text}");
    let svg = fs::read_to_string(folder.join("priors/prongs.svg")).unwrap();
    // Three positions with prongs, eight models, two panels.
    assert_eq!(svg.matches("<title>observed</title>").count(), 3 * 8 * 2);
    assert!(svg.contains("virtual data"));
}

/// Two positions, through which every model goes: the noise would float to zero.
#[test]
fn exact_too_few_positions_are_refused_with_the_number_that_is_needed() {
    let folder = scratch("too-few");
    observations::write(&folder);
    let data = folder.join("data/observations");
    for file in ["points.csv", "pings.csv"] {
        let text = fs::read_to_string(data.join(file)).unwrap();
        let kept: Vec<&str> = text.lines().filter(|line| !line.starts_with("C3-15,")).collect();
        fs::write(data.join(file), kept.join("\n") + "\n").unwrap();
    }
    let (code, text) = said(&folder, "rank data --out results");
    assert!(code == Some(2) && !folder.join("results").exists(), "{text}");
    for part in [
        "data/observations: row C3",
        "2 points, of which",
        "at 3 positions or more",
        "remedy: Measure row C3",
    ] {
        assert!(text.contains(part), "no `{part}` in\n{text}");
    }
}
