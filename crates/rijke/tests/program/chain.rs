//! Studies whose stages of modes stand on stages of responses: what every command makes of them.

use crate::{copy, example, rijke, scratch};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

fn own(name: &str) -> PathBuf {
    let folder = scratch(name);
    copy(&example("swirl-duct"), &folder);
    folder
}

fn told(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = rijke(folder, arguments);
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

/// Rows of a table: point and mode, and the numbers by their headings.
fn rows(text: &str) -> Vec<(String, String, Vec<f64>)> {
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let numbers = cells[2..].iter().map(|c| c.parse().unwrap_or(f64::NAN)).collect();
        (cells[0].to_owned(), cells[1].to_owned(), numbers)
    };
    text.lines().skip(1).map(row).collect()
}

/// Growth rate, 1/s, and frequency, Hz, of what truth.py prints.
const PLANNED: [(&str, [[f64; 2]; 4]); 2] = [
    ("planned-450", [[-225.24, 66.77], [243.36, 224.91], [-118.30, 267.89], [-43.65, 481.44]]),
    ("planned-700", [[-173.36, 62.31], [310.77, 213.69], [-90.57, 267.04], [-67.47, 413.55]]),
];

#[test]
fn lab_a_flame_that_was_measured_alone_predicts_the_modes_of_a_duct() {
    let folder = own("chain-run");
    let (code, said, error) = told(&folder, &["run", ".", "--json"]);
    assert_eq!(code, Some(0), "{error}");
    let answer: Value = serde_json::from_str(&said).unwrap();
    assert_eq!(answer.as_object().map(|o| !o.is_empty()), Some(true), "{answer}");
    let page = fs::read_to_string(folder.join("results/index.html")).unwrap();
    assert!(page.contains("responses/index.html") && page.contains("No mode was measured at its points"));
    let beside = fs::read_to_string(folder.join("results/responses/index.html")).unwrap();
    assert!(beside.contains("Three Gaussian delays"), "{beside}");
    // Before a duct is built, all its modes.
    let (code, said, error) = told(&folder, &["predict", ".", "--stage", "plan"]);
    assert_eq!(code, Some(0), "{error}");
    assert!(error.contains("no mode was measured at the points of this stage"), "{error}");
    let planned = rows(&said);
    assert_eq!(planned.len(), 8, "{said}");
    for (point, truth) in PLANNED {
        for (k, [growth, hertz]) in truth.into_iter().enumerate() {
            let found = planned.iter().find(|(p, m, _)| p == point && *m == (k + 1).to_string()).unwrap();
            let n = &found.2;
            assert!((n[1] - growth).abs() < 3.0 * n[3], "{point} {k}: {n:?} {growth}");
            assert!(
                (n[4] / std::f64::consts::TAU - hertz).abs() < 3.0 * n[6] / std::f64::consts::TAU,
                "{n:?} {hertz}"
            );
        }
    }
    // With the modes of other ducts it knows far more.
    let ask = ["predict", ".", "--stage", "duct", "--at", "chamber=0.45", "--at", "chamber=0.7"];
    let (code, said, error) = told(&folder, &ask);
    assert_eq!(code, Some(0), "{error}");
    for (point, mode, n) in rows(&said) {
        let (planned_at, k) = (point.ends_with("0.7"), if mode == "low" { 0 } else { 3 });
        let [growth, _] = PLANNED[usize::from(planned_at)].1[k];
        let before = &planned[4 * usize::from(planned_at) + k].2;
        assert!(
            (n[1] - growth).abs() < 3.0 * n[3] && n[3] < 0.3 * before[3],
            "{point} {mode}: {n:?} {before:?}"
        );
    }
    // Modes beyond the frequencies of the transfer function are said.
    let rig = fs::read_to_string(folder.join("rig.toml")).unwrap();
    fs::write(folder.join("rig.toml"), rig.replace("frequency_hz = [60, 620]", "frequency_hz = [60, 900]"))
        .unwrap();
    let (_, _, error) = told(&folder, &["predict", ".", "--stage", "plan"]);
    assert!(error.contains("20 to 620 Hz: it is extrapolated"), "{error}");
    let (code, said, error) = told(&folder, &["next", "."]);
    assert!(code == Some(0) && said.contains("duct-300 (repeat)"), "{error}");
    let (code, _, error) = told(&folder, &["next", ".", "--stage", "plan"]);
    assert!(code == Some(2) && error.contains("measure one point first"), "{error}");
    let (code, said, error) = told(&folder, &["modes", ".", "--point", "planned-450"]);
    assert!(code == Some(0) && said.contains("flame.three"), "{said}{error}");
    let before = fs::read(folder.join("results/index.html")).unwrap();
    assert_eq!(told(&folder, &["report", "."]).0, Some(0));
    assert!(fs::read(folder.join("results/index.html")).unwrap() == before, "the page differs");
}

#[test]
fn message_commands_that_cannot_take_both_kinds_of_stages_say_why() {
    let folder = own("chain-refused");
    let (code, said, error) = told(&folder, &["check", "."]);
    assert_eq!(code, Some(0), "{error}");
    for part in
        ["law at flame: 31 of 31", "these ratios leave out what the data of delays add", "nothing is trained"]
    {
        assert!(said.contains(part), "{part}: {said}");
    }
    for command in ["search", "watch"] {
        let (code, _, error) = told(&folder, &[command, "."]);
        assert!(
            code == Some(2) && error.contains("stages of responses") && error.contains("rijke rank"),
            "{error}"
        );
    }
    let (code, _, error) = told(&folder, &["rank", ".", "--until", "delays"]);
    assert!(code == Some(2) && error.contains("trains on responses"), "{error}");
    let plan = fs::read_to_string(folder.join("study.toml")).unwrap();
    fs::write(folder.join("study.toml"), plan.replace("id = \"plan\"", "id = \"delays\"")).unwrap();
    let (code, _, error) = told(&folder, &["check", "."]);
    assert!(code == Some(2) && error.contains("a second stage is called `delays`"), "{error}");
    assert!(!folder.join("results").exists());
}

#[test]
fn message_data_of_the_other_convention_are_suspected() {
    let folder = own("chain-conjugate");
    let path = folder.join("observations/flame.csv");
    let text = fs::read_to_string(&path).unwrap();
    let turned = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        match cells[2].parse::<f64>() {
            Ok(im) => format!("{},{},{}\n", cells[0], cells[1], -im),
            Err(_) => format!("{line}\n"),
        }
    };
    fs::write(&path, text.lines().map(turned).collect::<String>()).unwrap();
    let (_, said, error) = told(&folder, &["rank", ".", "--one-start"]);
    assert!(error.contains("the phase rises by") && error.contains("exp(-i omega t)"), "{error}");
    assert!(said.contains("the complex conjugates of these data have"), "{said}");
}
