//! `rijke run` on the folder of a study.

use crate::{copy, example, rijke, scratch};
use serde_json::Value;
use std::{f64::consts::TAU, fs};

/// The same networks, priors and data by the engine of studies, with exact derivatives, and by `rijke infer`, with differences.
#[test]
fn oracle_a_ducted_flame_has_the_fit_that_infer_gives() {
    let folder = scratch("study-ducted-flame");
    let flame = example("ducted-flame");
    let network = fs::read_to_string(flame.join("n-tau.toml")).unwrap();
    fs::write(folder.join("rig.toml"), network.replace("\"$chamber_length\"", "\"chamber_length\"")).unwrap();
    let table = fs::read_to_string(flame.join("modes.csv")).unwrap();
    let rows: Vec<Vec<&str>> =
        table.lines().filter(|l| !l.starts_with('#')).skip(1).map(|l| l.split(',').collect()).collect();
    let (mut campaign, mut modes) = (String::from("point,chamber_length [m]\n"), String::new());
    modes += "point,mode,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n";
    for (k, row) in rows.iter().enumerate() {
        campaign += &format!("p{k},{}\n", row[0]);
        modes += &format!("p{k},1,{}\n", row[1..].join(","));
    }
    let write = |name: &str, text: &str| {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    };
    write("campaign.csv", &campaign);
    write("observations/modes.csv", &modes);
    write("observations/observations.toml", "kind = \"virtual\"\nsource = \"examples/ducted-flame\"\n");
    write("study.toml", "name = \"f\"\nbase = \"rig\"\n[[stage]]\nid = \"all\"\npoints = {}\n");
    let json = |words: &[&str]| -> Value {
        let output = rijke(&folder, words);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let ours = json(&["run", ".", "--one-start", "--json"]);
    let files = ["n-tau.toml", "modes.csv"].map(|f| flame.join(f).display().to_string());
    let theirs = json(&["infer", &files[0], "--data", &files[1], "--json"]);
    let model = &ours["stages"][0]["models"][0];
    let here = model["evidence"]["ln_best_fit"].as_f64().unwrap();
    // A density over Hz is 2 pi times one over rad/s. The Occam factors differ: `infer` has no second derivatives.
    let there = theirs[0]["ln_best_fit"].as_f64().unwrap() - rows.len() as f64 * TAU.ln();
    assert!((here - there).abs() < 1e-4, "{here} {there}");
    for unknown in theirs[0]["unknowns"].as_array().unwrap() {
        let number = |of: &Value, key: &str| of[key].as_f64().unwrap();
        let same = |p: &&Value| p["name"] == unknown["name"];
        let found = model["parameters"].as_array().unwrap().iter().find(same).unwrap();
        let (value, sd) = (number(unknown, "value"), number(unknown, "sd"));
        assert!((number(found, "value") - value).abs() < 1e-2 * sd, "{unknown} {found}");
    }
}

#[test]
fn behaviour_a_study_becomes_a_page_that_says_virtual() {
    let folder = scratch("study-page");
    copy(&example("quarter-wave"), &folder.join("rig"));
    let output = rijke(&folder, &["run", "rig", "--one-start"]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success() && said.contains("heat.king-lighthill  <- goes on"), "{said}");
    let page = fs::read_to_string(folder.join("rig/results/index.html")).unwrap();
    assert!(page.contains("Virtual data") && page.contains("Heat release of the gauze"));
    assert!(folder.join("rig/results/figures/heat.svg").is_file());
    // By default the points of the last stage; a place that was not measured is like the nearest of them.
    let csv = |words: &[&str]| {
        let output = rijke(&folder, &[&["predict", "rig"], words].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let hot = csv(&[]);
    assert_eq!(hot.lines().count(), 25, "{hot}");
    assert!(hot.lines().skip(1).all(|row| row.starts_with('h')), "{hot}");
    assert_eq!(csv(&["--map", "x_g,Q", "--svg", "map.svg"]).lines().count(), 1 + 15 * 15);
    let map = fs::read_to_string(folder.join("map.svg")).unwrap();
    assert!(map.contains("probability of instability") && !map.contains("NaN"));
    // A second run does not overwrite what a first one found.
    let again = rijke(&folder, &["run", "rig", "--one-start"]);
    assert_eq!(again.status.code(), Some(2));
}

#[test]
fn message_what_is_wrong_in_a_study_is_refused_with_file_and_line() {
    let folder = scratch("study-wrong");
    copy(&example("quarter-wave"), &folder.join("sound"));
    let refused = |file: &str, from: &str, to: &str, says: &[&str]| {
        let _ = fs::remove_dir_all(folder.join("rig"));
        copy(&folder.join("sound"), &folder.join("rig"));
        let path = folder.join("rig").join(file);
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{file} has no {from}");
        fs::write(&path, text.replacen(from, to, 1)).unwrap();
        let output = rijke(&folder, &["run", "rig", "--one-start"]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{file}: {from} -> {to}: {said}");
        for part in says.iter().chain(&[file]) {
            assert!(said.contains(part), "no `{part}` in\n{said}");
        }
        assert!(!folder.join("rig/results").exists());
    };
    refused("rig.toml", "\"0.8 m\"", "\"0.8 s\"", &["line", "`length`", "in m"]);
    refused("rig.toml", "type = \"device\"", "type = \"devise\"", &["devise", "known: duct, insert, device"]);
    refused("rig.toml", "at = \"x_g\"", "at = \"x_h\"", &["line", "`at`"]);
    refused("campaign.csv", "x_g [mm]", "x_g [mn]", &["line 4", "mn"]);
    refused(
        "study.toml",
        "compete = \"gauze\"",
        "compete = \"grid\"",
        &["line", "no role called `grid`", "gauze"],
    );
    refused("study.toml", "Q = 0", "P = 0", &["no factor called `P`", "x_g, Q, flow, gauze"]);
    refused("candidates/gauze.toml", "acts_at = \"gauze\"", "acts_at = \"gaze\"", &["line", "gauze.middle"]);
    refused(
        "candidates/gauze.toml",
        "drag*rho*c",
        "drag*rho*cc",
        &["line", "`cc` is not known", "did you mean `c`"],
    );
    refused("observations/modes.csv", "frequency [Hz]", "frequency [kg]", &["line 1", "kg"]);
    refused("observations/modes.csv", "p2_re,", "q2_re,", &["no column called `q2_re`", "p2_re"]);
}
