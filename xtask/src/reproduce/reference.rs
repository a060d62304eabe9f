//! Numbers that were kept, each with its own tolerance, and what moved since.

use crate::Outcome;
use serde_json::{Value, json};
use std::{collections::BTreeMap, fs, path::Path};

/// A number by its JSON pointer, `/models/5/evidence/ln_marginal`.
type Numbers = BTreeMap<String, f64>;

/// Curves are drawn from parameters that are kept themselves.
const LEFT_OUT: [&str; 2] = ["line", "at_points"];

/// Tolerance of a number: what the last digits of a converged search and another processor's arithmetic are worth,
/// relative to the number, or to one for numbers near zero.
const RELATIVE: f64 = 1e-6;
const ABSOLUTE: f64 = 1e-8;

/// Compares every file of `reference` with the one of the same name in `numbers`.
pub(super) fn check(numbers: &Path, reference: &Path) -> Outcome {
    let (mut compared, mut moved) = (0, Vec::new());
    for (name, kept) in json_files(reference)? {
        let found = read(&numbers.join(&name))?;
        let mut now = Numbers::new();
        collect(&found, String::new(), &mut now);
        for (pointer, entry) in kept.as_object().into_iter().flatten() {
            compared += 1;
            moved.extend(difference(pointer, entry, now.get(pointer)).map(|d| format!("{name}{d}")));
        }
    }
    if compared == 0 {
        return Err(format!("{}: nothing to compare with; keep numbers with --accept", reference.display()));
    }
    if moved.is_empty() {
        println!("{compared} numbers are as in {}", reference.display());
        return Ok(());
    }
    Err(format!(
        "{} of {compared} numbers moved beyond their tolerance\n  {}",
        moved.len(),
        moved.join("\n  ")
    ))
}

/// Keeps the numbers of every file. A tolerance that was set by hand stays.
pub(super) fn accept(numbers: &Path, reference: &Path) -> Outcome {
    let said = |e: std::io::Error| format!("{}: {e}", reference.display());
    let before = if reference.is_dir() { json_files(reference)? } else { BTreeMap::new() };
    fs::create_dir_all(reference).map_err(said)?;
    for (name, found) in json_files(numbers)? {
        let mut now = Numbers::new();
        collect(&found, String::new(), &mut now);
        let entry = |(pointer, value): (String, f64)| {
            let by_hand = before.get(&name).and_then(|b| b.get(&pointer)?.get("tolerance")?.as_f64());
            let usual = RELATIVE.mul_add(value.abs(), ABSOLUTE);
            // Tolerances that follow the rule follow the number; wider ones were set by hand.
            let tolerance = by_hand.filter(|t| *t > 2.0 * usual).unwrap_or(usual);
            (pointer, json!({ "value": value, "tolerance": tolerance }))
        };
        let kept: serde_json::Map<_, _> = now.into_iter().map(entry).collect();
        fs::write(reference.join(&name), format!("{:#}\n", Value::Object(kept))).map_err(said)?;
    }
    println!("kept the numbers in {}", reference.display());
    Ok(())
}

/// What is wrong with a number, if anything.
fn difference(pointer: &str, entry: &Value, now: Option<&f64>) -> Option<String> {
    let field = |name: &str| entry.get(name).and_then(Value::as_f64);
    let (Some(value), Some(tolerance)) = (field("value"), field("tolerance")) else {
        return Some(format!("{pointer}: the reference lacks a value or a tolerance"));
    };
    match now {
        Some(now) if (now - value).abs() <= tolerance => None,
        Some(now) => Some(format!("{pointer}: {value} became {now}, tolerance {tolerance:.1e}")),
        None => Some(format!("{pointer}: {value} is gone")),
    }
}

/// All numbers of a value.
fn collect(value: &Value, pointer: String, numbers: &mut Numbers) {
    match value {
        Value::Number(number) => drop(number.as_f64().map(|v| numbers.insert(pointer, v))),
        Value::Array(items) => {
            for (i, item) in items.iter().enumerate() {
                collect(item, format!("{pointer}/{i}"), numbers);
            }
        }
        Value::Object(fields) => {
            for (key, item) in fields.iter().filter(|(key, _)| !LEFT_OUT.contains(&key.as_str())) {
                collect(item, format!("{pointer}/{key}"), numbers);
            }
        }
        _ => {}
    }
}

fn json_files(folder: &Path) -> Result<BTreeMap<String, Value>, String> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))? {
        let path = entry.map_err(|e| e.to_string())?.path();
        if path.extension().is_some_and(|e| e == "json") {
            found.insert(path.file_name().unwrap_or_default().to_string_lossy().into_owned(), read(&path)?);
        }
    }
    Ok(found)
}

fn read(path: &Path) -> Result<Value, String> {
    let text = fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    serde_json::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_moved_number_is_named_with_both_values() {
        let folder = std::env::temp_dir().join(format!("rijke-reference-{}", std::process::id()));
        let (numbers, reference) = (folder.join("numbers"), folder.join("reference"));
        fs::create_dir_all(&numbers).unwrap();
        let write = |eta: f64| {
            let study = json!({ "rows": [{ "eta": eta, "scheme": "line" }], "line": [1.0, 2.0] });
            fs::write(numbers.join("a.json"), study.to_string()).unwrap();
        };
        write(1.1235);
        assert!(check(&numbers, &reference).is_err(), "no reference yet");
        accept(&numbers, &reference).unwrap();
        check(&numbers, &reference).unwrap();
        write(1.1235 + 5e-7);
        check(&numbers, &reference).unwrap();
        write(1.124);
        let message = check(&numbers, &reference).unwrap_err();
        assert!(
            message.contains("1 of 1") && message.contains("a.json/rows/0/eta: 1.1235 became 1.124"),
            "{message}"
        );
        fs::write(numbers.join("a.json"), "{}").unwrap();
        assert!(check(&numbers, &reference).unwrap_err().contains("is gone"));
        fs::remove_dir_all(folder).unwrap();
    }
}
