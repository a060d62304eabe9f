//! Numbers that were kept, each with its own tolerance, and what moved since.

use crate::workspace::{Outcome, at, entries, read};
use serde_json::{Value, json};
use std::{collections::BTreeMap, fs, path::Path};

/// What is kept, by JSON pointer, `/models/5/evidence/ln_marginal`.
type Kept = BTreeMap<String, Value>;

/// Data, and what follows from parameters and evidences that are kept themselves.
const LEFT_OUT: [&str; 11] = [
    "measured",
    "predicted",
    "fitted",
    "frames",
    "panels",
    "checks",
    "missing",
    "lengths",
    "carried",
    "averaged",
    "narrowed",
];

/// Words that are answers, and must not change at all.
const ANSWERS: [&str; 3] = ["winner", "chosen", "holds"];

/// The tolerance of a number that nobody set by hand. A parameter may move by a twentieth of its standard
/// deviation, a logarithm of a likelihood, of all points together, by one nat, both without any consequence;
/// a standard deviation by 1 %. The search for a maximum stops where the distance of a parameter from its
/// prior, in standard deviations, and the misfit of a channel are known to some millionths. Any other number
/// may move by what another processor's arithmetic is worth after a long computation.
fn usual_tolerance(name: &str, value: f64, sd: Option<f64>) -> f64 {
    match (name, sd) {
        ("value" | "mean", Some(sd)) if sd > 0.0 => 0.05 * sd,
        ("ln_best_fit" | "ln_occam" | "ln_marginal", _) => 1.0,
        (name, _) if name == "sd" || name.ends_with("_sd") => 0.01 * value.abs(),
        ("prior_sds" | "misfit", _) => 1e-4f64.mul_add(value.abs(), 1e-5),
        _ => 1e-4f64.mul_add(value.abs(), 1e-8),
    }
}

/// Compares every file of `reference` with the one of the same name in `numbers`. A study that was not run is
/// not compared, so that a part of the campaign can be checked.
pub(super) fn check(numbers: &Path, reference: &Path) -> Outcome {
    if !reference.is_dir() {
        return Err(format!("{}: nothing to compare with; keep numbers with --accept", reference.display()));
    }
    let (mut compared, mut moved, mut absent) = (0, Vec::new(), Vec::new());
    for (name, kept) in json_files(reference)? {
        if !numbers.join(&name).exists() {
            absent.push(name);
            continue;
        }
        let now = leaves(&read_json(&numbers.join(&name))?);
        for (pointer, entry) in kept.as_object().into_iter().flatten() {
            compared += 1;
            moved.extend(difference(pointer, entry, now.get(pointer)).map(|d| format!("{name}{d}")));
        }
    }
    if compared == 0 {
        return Err(format!("{}: nothing to compare with; keep numbers with --accept", reference.display()));
    }
    if !absent.is_empty() {
        println!("not compared, because not run: {}", absent.join(", "));
    }
    if moved.is_empty() {
        println!("{compared} values are as in {}", reference.display());
        return Ok(());
    }
    Err(format!(
        "{} of {compared} values moved beyond their tolerance\n  {}",
        moved.len(),
        moved.join("\n  ")
    ))
}

/// Keeps the values of every file. A tolerance that was set by hand stays.
pub(super) fn accept(numbers: &Path, reference: &Path) -> Outcome {
    let said = |e: std::io::Error| format!("{}: {e}", reference.display());
    let before = if reference.is_dir() { json_files(reference)? } else { BTreeMap::new() };
    fs::create_dir_all(reference).map_err(said)?;
    for (name, found) in json_files(numbers)? {
        let by_hand = |pointer: &str| {
            let entry = before.get(&name)?.get(pointer)?;
            entry.get("set_by_hand")?.as_bool()?.then(|| entry.get("tolerance").cloned())?
        };
        let mut kept = leaves(&found);
        for (pointer, entry) in &mut kept {
            if let (Some(tolerance), Value::Object(entry)) = (by_hand(pointer), entry) {
                entry.insert("tolerance".to_owned(), tolerance);
                entry.insert("set_by_hand".to_owned(), true.into());
            }
        }
        let kept: serde_json::Map<_, _> = kept.into_iter().collect();
        fs::write(reference.join(&name), format!("{:#}\n", Value::Object(kept))).map_err(said)?;
    }
    println!("kept the numbers in {}", reference.display());
    Ok(())
}

/// What is wrong with a value, if anything.
fn difference(pointer: &str, entry: &Value, now: Option<&Value>) -> Option<String> {
    let Some(now) = now.and_then(|n| n.get("value")) else { return Some(format!("{pointer}: is gone")) };
    let before = entry.get("value")?;
    match (before.as_f64(), now.as_f64(), entry.get("tolerance").and_then(Value::as_f64)) {
        (Some(a), Some(b), Some(tolerance)) if (a - b).abs() <= tolerance => None,
        (Some(a), Some(b), Some(tolerance)) => {
            Some(format!("{pointer}: {a} became {b}, tolerance {tolerance:.1e}"))
        }
        _ => (before != now).then(|| format!("{pointer}: {before} became {now}")),
    }
}

/// All that is kept of a file, each with its usual tolerance.
fn leaves(file: &Value) -> Kept {
    let mut kept = Kept::new();
    collect(file, "", &mut kept);
    kept
}

fn collect(value: &Value, pointer: &str, kept: &mut Kept) {
    match value {
        Value::Array(items) => {
            // A number of a list goes by the name of the list; an answer is never one of many.
            let list = if items.iter().all(Value::is_number) { pointer.rsplit('/').next() } else { None };
            for (i, item) in items.iter().enumerate() {
                keep(item, &format!("{pointer}/{i}"), list.unwrap_or_default(), None, kept);
            }
        }
        Value::Object(fields) => {
            let sd = fields.get("sd").and_then(Value::as_f64);
            for (key, item) in fields.iter().filter(|(key, _)| !LEFT_OUT.contains(&key.as_str())) {
                keep(item, &format!("{pointer}/{key}"), key, sd, kept);
            }
        }
        _ => {}
    }
}

fn keep(value: &Value, pointer: &str, name: &str, sd: Option<f64>, kept: &mut Kept) {
    match value {
        Value::Number(number) => {
            let tolerance = number.as_f64().map(|v| usual_tolerance(name, v, sd));
            kept.insert(pointer.to_owned(), json!({ "value": number, "tolerance": tolerance }));
        }
        Value::String(_) | Value::Bool(_) if ANSWERS.contains(&name) => {
            kept.insert(pointer.to_owned(), json!({ "value": value }));
        }
        _ => collect(value, pointer, kept),
    }
}

fn json_files(folder: &Path) -> Result<BTreeMap<String, Value>, String> {
    let all = entries(folder)?.into_iter().filter(|path| path.extension().is_some_and(|e| e == "json"));
    let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    all.map(|path| Ok((name(&path), read_json(&path)?))).collect()
}

fn read_json(path: &Path) -> Result<Value, String> {
    let text = read(path)?;
    serde_json::from_str(&text).map_err(at(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_what_moved_is_named_with_both_values() {
        let folder = std::env::temp_dir().join(format!("rijke-reference-{}", std::process::id()));
        let (numbers, reference) = (folder.join("numbers"), folder.join("reference"));
        fs::create_dir_all(&numbers).unwrap();
        let write = |eta: f64, winner: &str| {
            let study = json!({ "parameters": [{ "name": "eta", "value": eta, "sd": 0.01 }], "measured": [1.0, 2.0],
                "winner": winner, "tau": 0.5 });
            fs::write(numbers.join("a.json"), study.to_string()).unwrap();
        };
        write(1.1, "prongs.6");
        assert!(check(&numbers, &reference).is_err(), "no reference yet");
        accept(&numbers, &reference).unwrap();
        check(&numbers, &reference).unwrap();
        // A twentieth of a standard deviation is nothing, more is something, and another winner always is.
        write(1.1004, "prongs.6");
        check(&numbers, &reference).unwrap();
        write(1.1006, "prongs.6");
        let message = check(&numbers, &reference).unwrap_err();
        assert!(
            message.contains("1 of 4 values")
                && message.contains("a.json/parameters/0/value: 1.1 became 1.1006")
        );
        write(1.1, "prongs.7");
        assert!(check(&numbers, &reference).unwrap_err().contains("\"prongs.6\" became \"prongs.7\""));
        // A tolerance that was set by hand survives.
        let path = reference.join("a.json");
        let mut kept = read_json(&path).unwrap();
        kept["/tau"] = json!({ "value": 0.5, "tolerance": 0.25, "set_by_hand": true });
        fs::write(&path, kept.to_string()).unwrap();
        accept(&numbers, &reference).unwrap();
        assert_eq!(read_json(&path).unwrap()["/tau"]["tolerance"], 0.25);
        // Where the search stopped is nothing.
        let fits = leaves(&json!({ "misfit": [6e-8], "prior_sds": 0.01, "rates": [6e-8] }));
        let moved = |at: &str, now: f64| difference(at, &fits[at], Some(&json!({ "value": now }))).is_some();
        assert!(!moved("/misfit/0", 1e-7) && !moved("/prior_sds", 0.010_001) && moved("/rates/0", 1e-7));
        assert!(moved("/misfit/0", 1e-4) && moved("/prior_sds", 0.0101));
        fs::remove_dir_all(folder).unwrap();
    }
}
