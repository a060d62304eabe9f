//! Files of numbers with an entry less or more in any of their lists, or with a list that is empty: refused
//! or drawn, never a panic.
#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

mod sample;

use rijke_report::{Numbers, Report};
use serde_json::Value;
use std::{fs, path::PathBuf};

/// Every list of a file, as the pointer to it.
fn lists(value: &Value, at: &str, into: &mut Vec<String>) {
    match value {
        Value::Array(entries) => {
            into.push(at.to_owned());
            // Lists of many alike entries are told by their first and last.
            let last = entries.len().saturating_sub(1);
            for (k, entry) in entries.iter().enumerate().filter(|(k, _)| *k == 0 || *k == last) {
                lists(entry, &format!("{at}/{k}"), into);
            }
        }
        Value::Object(keys) => {
            keys.iter().for_each(|(key, entry)| lists(entry, &format!("{at}/{key}"), into))
        }
        _ => {}
    }
}

#[test]
fn regress_no_list_of_another_length_makes_the_report_panic() {
    let numbers = sample::numbers();
    fn json<T: serde::Serialize>(value: &T) -> Value {
        serde_json::to_value(value).unwrap()
    }
    let mut files = vec![
        ("empty_tube.json", json(&numbers.empty_tube)),
        ("prongs.json", json(&numbers.prongs)),
        ("cold.json", json(&numbers.cold)),
        ("feedback.json", json(&numbers.feedback)),
        ("heat_release.json", json(&numbers.heat_release)),
        ("microphones.json", json(&numbers.microphones)),
        ("consistency.json", json(&numbers.consistency)),
        ("lumped_convergence.json", json(&numbers.lumped_convergence)),
        ("truths.json", json(&numbers.truths)),
        ("campaign.json", json(&numbers.campaign)),
        ("figure_10.json", json(&numbers.predictions[2])),
    ];
    files.retain(|(_, value)| !value.is_null());
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("damaged");
    let (mut panics, mut shapes, mut tried) = (Vec::new(), 0, 0);
    for (name, whole) in files {
        let mut places = Vec::new();
        lists(&whole, "", &mut places);
        for place in places {
            for damage in ["less", "empty", "more"] {
                let mut value = whole.clone();
                let Some(Value::Array(entries)) = value.pointer_mut(&place) else { continue };
                match damage {
                    "less" => drop(entries.pop()),
                    "empty" => entries.clear(),
                    _ => entries.extend(entries.last().cloned()),
                }
                let _ = fs::remove_dir_all(&folder);
                fs::create_dir_all(&folder).unwrap();
                fs::write(folder.join(name), value.to_string()).unwrap();
                tried += 1;
                let drawn = std::panic::catch_unwind(|| {
                    Numbers::read(&folder)
                        .and_then(|numbers| Report::new(&numbers))
                        .map(|_| ())
                        .map_err(|e| e.to_string())
                });
                match drawn {
                    Err(_) => panics.push(format!("{name}{place}: one {damage}")),
                    Ok(Err(said)) if said.contains("the file is damaged") => shapes += 1,
                    Ok(_) => {}
                }
            }
        }
    }
    assert!(panics.is_empty(), "{} of {tried} panic:\n{}", panics.len(), panics.join("\n"));
    assert!(shapes > 20 && tried > 200, "{shapes} of {tried}");
}
