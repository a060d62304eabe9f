//! `rijke run` on the folder of a study.

use crate::{copy, example, rijke, scratch};
use std::fs;

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
