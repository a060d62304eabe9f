//! Studies of other people's measurements: run where `RIJKE_MEASURED` names the folder that holds them, said
//! to be left out elsewhere. What they do without the data, and what is said of bad data, is tested
//! everywhere.

use crate::{copy, rijke, scratch};
use serde_json::Value;
use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

/// A copy of an example in a scratch folder.
pub(crate) fn example(name: &str, scratch_name: &str) -> PathBuf {
    let folder = scratch(scratch_name);
    copy(&crate::example(name), &folder);
    folder
}

/// What a study of measured data finds; none where the data are not here.
pub(crate) fn found(name: &str) -> Option<Value> {
    found_by(name, &["run", ".", "--json"])
}

/// As [`found`], by other arguments of the program.
#[allow(clippy::print_stdout, reason = "who runs the tests must learn what was left out")]
pub(crate) fn found_by(name: &str, arguments: &[&str]) -> Option<Value> {
    if std::env::var_os("RIJKE_MEASURED").is_none_or(|v| v.is_empty()) {
        println!("left out: RIJKE_MEASURED names no folder of measured data");
        return None;
    }
    let folder = example(name, &format!("measured-{name}"));
    let output = rijke(&folder, arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let page = fs::read_to_string(folder.join("results/index.html")).unwrap();
    assert!(
        page.contains("Measured data")
            && page.contains("measured data</text>")
            && !page.contains("virtual data</text>")
    );
    Some(serde_json::from_slice(&output.stdout).unwrap())
}

pub(crate) fn stage<'a>(answer: &'a Value, id: &str) -> &'a Value {
    answer["stages"].as_array().unwrap().iter().find(|s| s["id"] == id).unwrap()
}

pub(crate) fn model<'a>(stage: &'a Value, id: &str) -> &'a Value {
    stage["models"].as_array().unwrap().iter().find(|m| m["id"] == id).unwrap()
}

/// Nats by which `a` leads `b`.
fn lead(stage: &Value, a: &str, b: &str) -> f64 {
    let ln = |id: &str| model(stage, id)["evidence"]["ln_marginal"].as_f64().unwrap();
    ln(a) - ln(b)
}

pub(crate) fn parameter(model: &Value, name: &str) -> [f64; 2] {
    let p = model["parameters"].as_array().unwrap().iter().find(|p| p["name"] == name).unwrap();
    [p["value"].as_f64().unwrap(), p["sd"].as_f64().unwrap()]
}

#[test]
fn oracle_measured_swirl_flame_has_three_delays_at_least() {
    let Some(answer) = found("swirl-flame") else { return };
    let delays = answer["responses"].as_array().unwrap().iter().find(|s| s["id"] == "delays").unwrap();
    assert!(lead(delays, "flame.three", "flame.two") > 20.0, "{delays}");
    assert!(lead(delays, "flame.two", "flame.one") > 5.0);
    assert!((5.0..20.0).contains(&lead(delays, "flame.four", "flame.three")), "{delays}");
    // The noise grows with the gain: a floor, and some per cent of it.
    let noise = &model(delays, "flame.four")["noise"];
    let sd = |k: usize| noise[k]["sd"].as_f64().unwrap();
    assert!((0.01..0.04).contains(&sd(0)) && (0.02..0.06).contains(&sd(1)), "{noise}");
}

#[test]
fn oracle_measured_plain_tube_does_not_decide() {
    let Some(answer) = found("plain-tube") else { return };
    let wall = stage(&answer, "wall");
    let models = wall["models"].as_array().unwrap();
    let mut all: Vec<f64> = models.iter().map(|m| m["evidence"]["ln_marginal"].as_f64().unwrap()).collect();
    all.sort_by(f64::total_cmp);
    assert!(all[2] - all[0] < 3.0, "{all:?}");
    // A perfect head would have decided, against the law that the tube with holes favours, and is found out
    // by its residuals.
    let perfect = stage(&answer, "perfect-head");
    assert!(lead(perfect, "wall.paper", "wall.bessel") > 5.0);
    let remark = model(perfect, "wall.paper")["remark"].as_str().unwrap();
    assert!(remark.contains("the residuals are not noise"), "{remark}");
}

#[test]
#[ignore = "long: several minutes"]
fn oracle_measured_side_hole_tube_prefers_bessel_functions() {
    let Some(answer) = found("side-hole-tube") else { return };
    let remark = model(stage(&answer, "perfect-head"), "wall.bessel")["remark"].as_str().unwrap();
    assert!(remark.contains("the residuals are not noise"), "{remark}");
    let head = stage(&answer, "head");
    assert!(lead(head, "head.three", "head.perfect") > 50.0 && lead(head, "head.three", "head.one") > 50.0);
    for session in [1, 2] {
        for step in [60, 20] {
            let wall = stage(&answer, &format!("wall-{session}-{step}"));
            assert_eq!(wall["winner"], "wall.bessel", "session {session}, every {step} Hz");
            assert!(lead(wall, "wall.bessel", "wall.kirchhoff") > 5.0, "{wall}");
        }
        // With the errors of the head on the model's R, three times the frequencies no longer treble the
        // lead.
        let [coarse, fine] = [60, 20]
            .map(|step| lead(stage(&answer, &format!("wall-{session}-{step}")), "wall.bessel", "wall.paper"));
        assert!(fine < 2.2 * coarse, "session {session}: {coarse} {fine}");
        // Every 60 Hz. Every 20 Hz the lead is larger: docs/measured.md says why that is no more knowledge.
        let wall = stage(&answer, &format!("wall-{session}-60"));
        assert!(lead(wall, "wall.bessel", "wall.paper") > 4.0, "{wall}");
        let [radius, sd] = parameter(model(wall, "wall.bessel"), "bore");
        assert!((radius - 2.0e-3).abs() < 2.0 * sd && sd < 2e-5, "session {session}: {radius} +- {sd}");
    }
}

#[test]
fn message_without_the_data_says_where_to_get_them() {
    for name in ["side-hole-tube", "plain-tube", "swirl-flame", "flow-duct"] {
        let folder = example(name, &format!("without-{name}"));
        let output = Command::new(env!("CARGO_BIN_EXE_rijke"))
            .args(["run", "."])
            .current_dir(&folder)
            .env_remove("RIJKE_MEASURED")
            .output()
            .unwrap();
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{error}");
        for part in ["observations.toml", "RIJKE_MEASURED", name, "https://github.com/", "commit"] {
            assert!(error.contains(part), "{part}: {error}");
        }
        assert!(!folder.join("results").exists());
    }
}

/// The plain tube with data of the network file that it is: a radius of 1.9 mm at frequencies from 100 Hz in
/// steps of 50.
pub(crate) fn own_data(scratch_name: &str) -> (PathBuf, Vec<[f64; 3]>) {
    let folder = example("plain-tube", scratch_name);
    let network = "[gas]\n[upstream]\ntype = \"anechoic\"\n[downstream]\ntype = \"unflanged\"\n[[element]]\ntype = \"duct\"\n\
                   length = 0.436\ndiameter = 0.0038\nwall = \"zwikker-kosten\"\n";
    fs::write(folder.join("network.toml"), network).unwrap();
    let arguments =
        ["response", "network.toml", "--csv", "--min-hz", "100", "--max-hz", "3000", "--step-hz", "50"];
    let output = rijke(&folder, &arguments);
    let text = String::from_utf8(output.stdout).unwrap();
    let row = |line: &str| -> [f64; 3] {
        let all: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
        [all[0], all[1], all[2]]
    };
    let rows = text.lines().skip(1).map(row).collect();
    let toml = "kind = \"virtual\"\nsource = \"network.toml\"\n[[response]]\nkind = \"impedance\"\nat = \"upstream\"\n\
                columns = [\"f [Hz]\", \"re [1]\", \"im [1]\"]\nreference_diameter = \"3.8 mm\"\nfiles = { plain = \"z.txt\" }\n";
    fs::write(folder.join("observations/observations.toml"), toml).unwrap();
    let study = "name = \"n\"\n[[responses]]\nid = \"wall\"\nwith = { mouth = \"mouth.unflanged\", head = \"head.perfect\" }\n\
                 compete = [\"wall\"]\nnoise = { median = 1e-3, ln_sd = 1.0 }\n";
    fs::write(folder.join("study.toml"), study).unwrap();
    (folder, rows)
}

pub(crate) fn write(folder: &Path, rows: &[[f64; 3]]) {
    let text: String = rows.iter().map(|[f, a, b]| format!("{f} {a} {b}\n")).collect();
    fs::write(folder.join("observations/z.txt"), text).unwrap();
}

/// Numbers of mean zero and unit variance, the same in every run.
pub(crate) fn noise(k: usize) -> f64 {
    let mut x = (k as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x ^= x >> 31;
    x = x.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x ^= x >> 29;
    ((x >> 11) as f64 / (1u64 << 53) as f64 - 0.5) * 12_f64.sqrt()
}

#[test]
fn oracle_a_study_recovers_the_tube_of_a_network_file() {
    let (folder, mut rows) = own_data("responses-recovered");
    for (k, row) in rows.iter_mut().enumerate() {
        // Noise of 1e-3 on R: dz = (z + 1)^2/2 dR.
        let (re, im) = (row[1] + 1.0, row[2]);
        let square = [re * re - im * im, 2.0 * re * im].map(|v| 0.5e-3 * v);
        let [a, b] = [noise(2 * k), noise(2 * k + 1)];
        row[1] += square[0] * a - square[1] * b;
        row[2] += square[0] * b + square[1] * a;
    }
    write(&folder, &rows);
    let output = rijke(&folder, &["run", ".", "--json"]);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && !error.contains("warning"), "{error}");
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    let wall = stage(&answer, "wall");
    assert_eq!(wall["winner"], "wall.bessel", "{wall}");
    let best = model(wall, "wall.bessel");
    for (name, truth) in [("bore", 1.9e-3), ("extra", 0.0)] {
        let [value, sd] = parameter(best, name);
        assert!((value - truth).abs() < 3.0 * sd, "{name}: {value} +- {sd}");
    }
    let size = best["residual"].as_f64().unwrap();
    assert!((1e-3..2e-3).contains(&size) && best["remark"].is_null(), "{best}");
}

#[test]
fn message_bad_responses_are_named_with_place_and_remedy() {
    let (folder, good) = own_data("responses-bad");
    let text = fs::read_to_string(folder.join("observations/observations.toml")).unwrap();
    let replaced = |from: &str, to: &str| text.replace(from, to);
    let told = |toml: &str, rows: &[[f64; 3]]| {
        fs::write(folder.join("observations/observations.toml"), toml).unwrap();
        write(&folder, rows);
        let output = rijke(&folder, &["run", ".", "--force"]);
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let refused = |toml: &str, rows: &[[f64; 3]], parts: &[&str]| {
        let (code, error) = told(toml, rows);
        assert_eq!(code, Some(2), "{error}");
        parts.iter().for_each(|part| assert!(error.contains(part), "{part}: {error}"));
    };
    let mut twice = good.clone();
    twice[4][0] = twice[3][0];
    refused(&text, &twice, &["z.txt, line 5", "250 Hz", "given once", "average"]);
    let mut unsorted = good.clone();
    unsorted.swap(2, 6);
    refused(&text, &unsorted, &["z.txt, line 4", "sort the rows"]);
    refused(&replaced("f [Hz]", "f"), &good, &["line 3", "`unit of f`", "brackets"]);
    refused(&replaced("f [Hz]", "f [m]"), &good, &["f [m]"]);
    let levels: Vec<[f64; 3]> =
        good.iter().map(|[f, a, b]| [*f, 20.0 * a.hypot(*b).log10(), b.atan2(*a)]).collect();
    let polar = replaced("\"re [1]\", \"im [1]\"", "\"abs [1]\", \"arg [rad]\"");
    refused(&polar, &levels, &["z.txt, line", "abs [dB]"]);
    // Headings of the file that contradict what is declared of its columns.
    fs::write(folder.join("observations/observations.toml"), &text).unwrap();
    for heading in ["f [kHz],re [1],im [1]", "f/kHz,re,im", "f [Hz],gain [dB],phase [deg]"] {
        let rows: String = good.iter().map(|[f, a, b]| format!("{f},{a},{b}\n")).collect();
        fs::write(folder.join("observations/z.txt"), format!("{heading}\n{rows}")).unwrap();
        let output = rijke(&folder, &["run", ".", "--force"]);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        let right = output.status.code() == Some(2)
            && error.contains("z.txt")
            && error.contains("the units that the file states");
        assert!(right, "{heading}: {error}");
    }
    // Said, and gone on with.
    let warned = |toml: &str, rows: &[[f64; 3]], parts: &[&str]| {
        let (code, error) = told(toml, rows);
        assert_ne!(code, Some(2), "{error}");
        parts.iter().for_each(|part| assert!(error.contains(part), "{part}: {error}"));
    };
    let degrees: Vec<[f64; 3]> =
        good.iter().map(|[f, a, b]| [*f, a.hypot(*b), b.atan2(*a).to_degrees()]).collect();
    warned(&polar, &degrees, &["z.txt: the phase differs by", "arg [deg]"]);
    // Radians that are declared as degrees.
    let mut radians: Vec<[f64; 3]> = good.iter().map(|[f, a, b]| [*f, a.hypot(*b), b.atan2(*a)]).collect();
    radians[0][2] = -3.0;
    let declared = polar.replace("arg [rad]", "arg [deg]");
    warned(&declared, &radians, &["z.txt: no phase is beyond", "arg [rad]"]);
    let active: Vec<[f64; 3]> = good.iter().map(|[f, a, b]| [*f, -a, *b]).collect();
    warned(&text, &active, &["|R| is above 1", "line", "check sign"]);
    let conjugated: Vec<[f64; 3]> = good.iter().map(|[f, a, b]| [*f, *a, -b]).collect();
    warned(&text, &conjugated, &["z.txt: the phase rises by", "exp(-i omega t)", "imaginary parts"]);
    let mut stuck = good.clone();
    for row in &mut stuck[..4] {
        (row[1], row[2]) = (0.5, 0.25);
    }
    warned(&text, &stuck, &["4 rows repeat", "lines 1 to 4", "left out"]);
}

#[test]
fn behaviour_a_model_error_counts_once_however_fine_the_frequencies() {
    // A smooth error of the model along frequency, far above the noise: with four times as many frequencies
    // the lead of one law over another grows by as much if the errors are taken for noise, and stays if they
    // are taken for correlated.
    let (folder, coarse) = own_data("responses-thinned");
    let network =
        ["response", "network.toml", "--csv", "--min-hz", "100", "--max-hz", "3000", "--step-hz", "12.5"];
    let text = String::from_utf8(rijke(&folder, &network).stdout).unwrap();
    let mut rows: Vec<[f64; 3]> = text
        .lines()
        .skip(1)
        .map(|line| {
            let all: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
            [all[0], all[1], all[2]]
        })
        .collect();
    assert!(rows.len() > 3 * coarse.len());
    for (k, row) in rows.iter_mut().enumerate() {
        let (f, re, im) = (row[0], row[1] + 1.0, row[2]);
        let square = [re * re - im * im, 2.0 * re * im];
        let a = 0.02 * (f / 230.0).sin() + 2e-4 * noise(2 * k);
        let b = 0.02 * (f / 310.0 + 1.0).cos() + 2e-4 * noise(2 * k + 1);
        row[1] += 0.5 * (square[0] * a - square[1] * b);
        row[2] += 0.5 * (square[0] * b + square[1] * a);
    }
    write(&folder, &rows);
    let stages = |misfit: &str| -> String {
        [50.0, 12.5]
            .map(|step| {
                format!(
                    "[[responses]]\nid = \"s{step}\"\nstep_hz = {step}\nwith = {{ mouth = \"mouth.unflanged\", head = \"head.perfect\" }}\n\
                     compete = [\"wall\"]\namong = [\"wall.bessel\", \"wall.kirchhoff\"]\nnoise = {{ median = 1e-3, ln_sd = 2.0 }}\n{misfit}\n"
                )
            })
            .concat()
    };
    let growth = |misfit: &str| {
        fs::write(folder.join("study.toml"), format!("name = \"n\"\n{}", stages(misfit))).unwrap();
        let output = rijke(&folder, &["run", ".", "--json", "--force"]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
        let [coarse, fine] =
            ["s50", "s12.5"].map(|id| lead(stage(&answer, id), "wall.bessel", "wall.kirchhoff"));
        (fine - coarse).abs() / coarse.abs().max(1.0)
    };
    let white = growth("");
    let correlated = growth(
        "misfit = { size = { median = 0.02, ln_sd = 1.0 }, length_hz = { median = 200, ln_sd = 1.0 }, kernel = \"squared_exponential\" }",
    );
    assert!(white > 1.5, "{white}");
    assert!(correlated < 0.5 * white, "{correlated} {white}");
}
