//! `cargo xtask recovery`: each law of heat release of Table 4 as the truth of an otherwise unchanged
//! campaign, and which model wins.

use crate::reproduce::copy_study;
use crate::workspace::{Outcome, built, program, read, root, succeed, write};
use serde_json::Value;
use std::{fmt::Write as _, fs, path::Path, process::Command};

/// k_1 to k_6 of the nine models: what ranking finds of them in the standard laboratory, rounded.
const LAWS: [[f64; 6]; 9] = [
    [7.5e-4, 0.43, 0.0, 0.0, 0.0, 0.0],
    [7.4e-4, 3.9e-4, 0.0, 0.0, 0.0, 0.0],
    [1.7e-3, 0.40, 0.85, 0.0, 0.0, 0.0],
    [9.0e-4, 0.28, 0.0, 0.0, 0.0, 0.0],
    [9.0e-4, 2.5e-4, 0.0, 0.0, 0.0, 0.0],
    [7.1e-4, 0.41, 0.0, 0.0, 0.0, 0.0],
    [7.5e-4, 4.0e-4, 4.8e-5, 3.3e-5, 0.0, 0.0],
    [7.4e-4, 3.7e-4, 4.9e-5, 2.9e-5, 5.9e-5, 1.4e-5],
    [7.5e-4, 0.41, 4.8e-5, 3.0e-5, 5.8e-5, 1.4e-5],
];

const HEAD: &str = "# Which law is found where it is true

Written by `cargo xtask recovery`. Each row: one of the nine laws of Table 4 stands in the heater of the virtual
laboratory in the place of the wire's own, with numbers near those that ranking finds in the standard laboratory
(xtask/src/recovery.rs); all else is unchanged, four repeats, seed 1. Each column: nats by which a model is behind the
best of the nine, all 105 hot points together. The laboratory is no network of the models: its flow convects sound, its
boundary layers and plates are resolved.

";

pub(crate) fn run() -> Outcome {
    built()?;
    let mut text = String::from(HEAD)
        + "| true | 1 | 2 | 3 | 4 | 5 | 6 | 7 | 8 | 9 | found |\n|---|---|---|---|---|---|---|---|---|---|---|\n";
    let mut right = 0;
    for (k, law) in LAWS.iter().enumerate() {
        let behind = ranked(k + 1, law)?;
        let best = 1 + behind.iter().position(|nats| *nats == 0.0).unwrap_or(0);
        right += usize::from(best == k + 1);
        let cells: String = behind.iter().map(|nats| format!(" {nats:.1} |")).collect();
        let _ = writeln!(text, "| {} |{cells} {best} |", k + 1);
        println!("law {}: model {best} wins", k + 1);
    }
    let _ = writeln!(text, "\n{right} of 9 true laws win.");
    let path = root().join("docs/records/recovery.md");
    write(&path, text)
}

/// Nats by which each of the nine models is behind the best of them.
fn ranked(number: usize, law: &[f64; 6]) -> Result<Vec<f64>, String> {
    let folder = root().join("virtual-rig").join(format!("law-{number}"));
    copy_study(&folder)?;
    stages_alone(&folder)?;
    let standard = root().join("crates/lab/data/truth.toml");
    let text = read(&standard)?;
    let own = format!("{text}\n[heater.law]\nmodel = {number}\nk = {law:?}\n");
    let truth = folder.join("truth.toml");
    write(&truth, own)?;
    let step = |words: &str| succeed(Command::new(program()).args(words.split(' ')).current_dir(&folder));
    step("process --virtual-rig --truth truth.toml --seed 1 --repeats 4 --out observations --force --quiet")?;
    step("flow . --out base --force --quiet")?;
    step("rank . --one-start --until heat-release --force --quiet")?;
    evidences(&folder.join("results/numbers/stage-heat-release.json"))
}

/// Leaves maps, questions and statements out of a study: they would take as long as its stages.
fn stages_alone(folder: &Path) -> Outcome {
    let (study, paper) = (folder.join("study.toml"), folder.join("paper.toml"));
    let text = read(&study)?;
    let stages = text.split_once("[[map]]").map_or(text.as_str(), |(stages, _)| stages);
    write(&study, stages)?;
    fs::remove_file(&paper).map_err(|e| format!("{}: {e}", paper.display()))
}

fn evidences(path: &Path) -> Result<Vec<f64>, String> {
    let fail = |why: String| format!("{}: {why}", path.display());
    let text = fs::read_to_string(path).map_err(|e| fail(e.to_string()))?;
    let stage: Value = serde_json::from_str(&text).map_err(|e| fail(e.to_string()))?;
    let models = stage["models"].as_array().ok_or_else(|| fail("has no models".into()))?;
    let of = |number: usize| {
        let id = format!("heat-release.{number}");
        let model =
            models.iter().find(|m| m["id"] == id.as_str()).ok_or_else(|| fail(format!("has no {id}")))?;
        Ok(model["evidence"]["ln_marginal"].as_f64().unwrap_or(f64::NEG_INFINITY))
    };
    let all = (1..=9).map(of).collect::<Result<Vec<f64>, String>>()?;
    let best = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Ok(all.iter().map(|ln| best - ln).collect())
}
