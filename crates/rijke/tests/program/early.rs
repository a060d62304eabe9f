//! What was once found after all work, or not at all: it is refused or said before.

use crate::{book::blocks, copy, example, rijke, scratch};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// The example of the quarter-wave tube, to be changed.
fn study(name: &str) -> PathBuf {
    let folder = scratch(name);
    copy(&example("quarter-wave"), &folder.join("rig"));
    folder
}

fn change(folder: &Path, file: &str, of: impl Fn(&str) -> String) {
    let path = folder.join("rig").join(file);
    let text = fs::read_to_string(&path).unwrap();
    fs::write(path, of(&text)).unwrap();
}

fn said(folder: &Path, words: &[&str]) -> (Option<i32>, String) {
    let output = rijke(folder, words);
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn message_check_refuses_what_ranking_would() {
    let folder = study("early-ambient");
    // The last two columns are T_amb and its standard deviation.
    let without = |text: &str| {
        let line = |line: &str| match line.starts_with('#') {
            true => line.to_owned(),
            false => line.rsplitn(3, ',').last().unwrap_or_default().to_owned(),
        };
        text.lines().map(line).collect::<Vec<_>>().join("\n") + "\n"
    };
    change(&folder, "campaign.csv", without);
    for command in ["check", "rank"] {
        let (code, said) = said(&folder, &[command, "rig"]);
        assert_eq!(code, Some(2), "{command}: {said}");
        assert!(
            said.contains("operating point e1-0 has no ambient temperature; give the column T_amb"),
            "{said}"
        );
    }
    // Before anything is measured a plan needs none.
    fs::remove_dir_all(folder.join("rig/observations")).unwrap();
    assert_eq!(said(&folder, &["check", "rig"]).0, Some(0));
}

#[test]
fn message_a_question_at_points_without_a_model_is_refused_before_training() {
    let folder = study("early-question");
    let ask = |points: &str| {
        format!("\n[[ask]]\nid = \"all\"\nask = \"prediction\"\nstage = \"heat\"\npoints = {points}\n")
    };
    let plan = fs::read_to_string(folder.join("rig/study.toml")).unwrap();
    // Laws of the heat release divide by the velocity, and some points have none.
    change(&folder, "study.toml", |_| plan.clone() + &ask("{}"));
    for command in ["check", "rank"] {
        let (code, said) = said(&folder, &[command, "rig"]);
        assert_eq!(code, Some(2), "{command}: {said}");
        for part in ["question `all`", "at operating point c120-0", "take the point out of its `points`"] {
            assert!(said.contains(part), "{command}: {part}\n{said}");
        }
    }
    change(&folder, "study.toml", |_| plan.clone() + &ask("{ where = { Q = { above = 0 } } }"));
    let (code, said) = said(&folder, &["check", "rig"]);
    assert_eq!(code, Some(0), "{said}");
}

#[test]
fn message_modes_of_exchanged_labels_are_named() {
    let folder = study("early-labels");
    let (_, quiet) = said(&folder, &["check", "rig"]);
    assert!(!quiet.contains("exchanged"), "{quiet}");
    let swapped = |text: &str| {
        text.replacen("e1-0,1,", "e1-0,X,", 1)
            .replacen("e1-0,2,", "e1-0,1,", 1)
            .replacen("e1-0,X,", "e1-0,2,", 1)
    };
    change(&folder, "observations/modes.csv", swapped);
    let (code, said) = said(&folder, &["check", "rig"]);
    assert_eq!(code, Some(0), "{said}");
    for part in ["lies above mode 2 (104.6 Hz), and below it at ", "whether labels or rows were exchanged"] {
        assert!(said.contains(part), "{said}");
    }
}

#[test]
fn message_a_file_of_channels_is_named_once_and_checked_early() {
    let folder = study("early-channels");
    fs::write(folder.join("rig/observations/channels.toml"), "\ngain_sd = 1\n").unwrap();
    for command in ["check", "rank"] {
        let (code, said) = said(&folder, &[command, "rig"]);
        assert_eq!(code, Some(2), "{command}: {said}");
        assert!(
            said.contains("error: rig/observations/channels.toml, line 2: there is no key `gain_sd`"),
            "{said}"
        );
    }
}

#[test]
fn message_slips_in_a_parameter_name_the_remedy() {
    let folder = study("early-parameter");
    let candidates = fs::read_to_string(folder.join("rig/candidates/heat-release.toml")).unwrap();
    for (from, to, parts) in [
        ("unit = \"1/W\"", "unit = \"1/ms\"", ["the unit of `k1` is `1/ms`", "and the unit `s^-1`"]),
        ("sd = 0.7e-3", "sd = 0", ["prior of parameter 'k1' is impossible: sd = 0", "`hold = { k1 = 1.5 }`"]),
    ] {
        assert!(candidates.contains(from));
        change(&folder, "candidates/heat-release.toml", |_| candidates.replacen(from, to, 1));
        let (code, said) = said(&folder, &["check", "rig"]);
        assert!(code == Some(2) && parts.iter().all(|part| said.contains(part)), "{said}");
    }
}

#[test]
fn message_a_microphone_beyond_the_rig_is_refused_with_its_line() {
    let folder = study("early-place");
    change(&folder, "rig.toml", |text| text.replacen("\"700 mm\"]", "\"900 mm\"]", 1));
    let text = fs::read_to_string(folder.join("rig/rig.toml")).unwrap();
    let line = 1 + text.lines().position(|l| l.starts_with("[microphones]")).unwrap();
    let (code, said) = said(&folder, &["check", "rig"]);
    assert_eq!(code, Some(2), "{said}");
    let place =
        format!("rig.toml: at operating point e1-0: `p5 of [microphones] on line {line}: at` is `0.9 m`");
    assert!(said.contains(&place), "{said}");
}

#[test]
fn message_a_damaged_model_is_refused_and_predictions_say_whose_temperature_they_take() {
    let folder = study("early-model");
    // As a run leaves it that was stopped.
    fs::create_dir(folder.join("rig/.results.partial-4000000001")).unwrap();
    let (code, text) = said(&folder, &["rank", "rig", "--until", "tube", "--one-start"]);
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("rig/results: what a run before this one left unfinished beside it is removed"));
    assert!(!folder.join("rig/.results.partial-4000000001").exists());
    let predict = ["predict", "rig", "--stage", "tube", "--at", "flow=0.0005"];
    let (code, text) = said(&folder, &predict);
    assert_eq!(code, Some(0), "{text}");
    assert!(
        text.contains("K: as at e") && text.contains(", the nearest point, with the campaign's"),
        "{text}"
    );
    // Modes of a point whose parts the stage knows, and of one with a gauze.
    for (point, by) in [("e1-0", "(of stage `tube`)"), ("c120-0", "by the first candidates")] {
        let output = rijke(&folder, &["modes", "rig", "--point", point]);
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(output.status.success() && text.contains(by), "{text}");
    }
    let path = folder.join("rig/results/models/tube.json");
    let model: serde_json::Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
    let damages: [fn(&mut serde_json::Value); 4] = [
        |m| m["covariance"][1][0] = 1e308.into(),
        |m| m["covariance"][0][1] = (1.001 * m["covariance"][0][1].as_f64().unwrap() + 1e-3).into(),
        |m| m["noise"][0][1] = 2.7e252.into(),
        |m| m["mean"][0] = 1e200.into(),
    ];
    for damage in damages {
        let mut model = model.clone();
        damage(&mut model);
        fs::write(&path, model.to_string()).unwrap();
        let (code, text) = said(&folder, &predict);
        assert_eq!(code, Some(2), "{text}");
        assert!(text.contains("the model that stage `tube` left is damaged; rank the study again"), "{text}");
    }
}

#[test]
fn exact_the_page_has_a_table_over_a_factor_that_works() {
    let page = include_str!("../../../../docs/study-folder.md");
    let block = blocks(page, "toml").into_iter().find(|block| block.contains("over = \"Q\", rows")).unwrap();
    let folder = study("early-table");
    // Gas whose temperature the file states.
    let heated = "[base.heated-flow]\nat = \"gauze\"\npower = \"Q\"\nflow = \"flow\"\n";
    change(&folder, "study.toml", |text| format!("base = \"rig\"\n{}", text.replacen(heated, "", 1)));
    change(&folder, "rig.toml", |text| format!("{text}\n{block}\n"));
    let mode = |point: &str| {
        let output = rijke(&folder, &["modes", "rig", "--point", point, "--format", "csv"]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let text = String::from_utf8(output.stdout).unwrap();
        text.lines().nth(1).unwrap().split(',').next().unwrap().parse::<f64>().unwrap()
    };
    // The hood is warmer where there is power, and the mode of the same tube higher.
    let [cold, hot] = ["c120-40", "h120-25-40"].map(mode);
    assert!(hot > cold + 0.5, "{cold} {hot}");
}
