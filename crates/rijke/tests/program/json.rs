//! `--json`: one document per command, nothing else on standard output; errors as one line of JSON.

use crate::{copy, example, records, rijke, scratch};
use serde_json::Value;
use std::collections::BTreeSet;

#[test]
fn exact_every_result_is_one_document() {
    let folder = scratch("json");
    records::write(&folder.join("records"));
    copy(&example("quarter-wave"), &folder.join("study"));
    let answer = |words: &str| -> Value {
        let words: Vec<&str> = words.split(' ').chain(["--json"]).collect();
        let output = rijke(&folder, &words);
        assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{words:?}: {error}"))
    };
    let files = answer("new my-rig --template burner");
    assert!(files["files"].as_array().unwrap().iter().any(|f| f == "study.toml"), "{files}");
    assert_eq!(answer("inspect records/C3-E/ping-0.wav")["channels"].as_array().unwrap().len(), 8);
    let check = answer("check records");
    assert_eq!((&check["points"], &check["pings"]), (&Value::from(2), &Value::from(4)));
    assert_eq!(answer("check study")["stages"][1]["id"], "gauze");
    assert_eq!(answer("check study --names")[0]["name"], "s");
    let network = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/networks/rig-tube.toml");
    assert!(
        answer(&format!("modes {network} --max-hz 300"))["modes"][0]["growth_rate"].as_f64().unwrap() < 0.0
    );
    let ranked = answer("rank study --until gauze --one-start");
    assert_eq!(ranked["stages"].as_array().unwrap().len(), 2);
    assert!(ranked["stages"][1]["models"].as_array().unwrap().len() >= 4);
    // What the terminal says against a stage is in the document.
    let output = rijke(&folder, &["rank", "study", "--until", "gauze", "--one-start", "--force"]);
    let said = String::from_utf8(output.stdout).unwrap();
    let stages = ranked["stages"].as_array().unwrap();
    let doubts: Vec<&str> =
        stages.iter().flat_map(|s| s["doubts"].as_array().unwrap()).map(|v| v.as_str().unwrap()).collect();
    assert!(doubts.iter().all(|doubt| said.contains(doubt)), "{doubts:#?}\n{said}");
    for part in ["one fit stands behind each evidence", "not identified by these data", "not decided"] {
        let of_it = |all: &str| all.contains(part);
        assert_eq!(doubts.iter().any(|d| of_it(d)), of_it(&said), "{part}: {said}");
    }
    assert!(answer("report study")["page"].as_str().unwrap().ends_with("index.html"));
    let predicted = answer("predict study --stage gauze --at x_g=0.3,Q=0,flow=0.001,gauze=1");
    assert_eq!(predicted["stage"], "gauze");
    // What the numbers of the arrays are, and what is said on standard error.
    let columns = &predicted["columns"];
    let count = |key: &str| columns[key].as_array().unwrap().len();
    assert_eq!(count("factors"), predicted["points"][0]["factors"].as_array().unwrap().len());
    assert_eq!((count("growth_rate"), columns["growth_rate"][0].as_str()), (3, Some("value [1/s]")));
    let far = answer("predict study --stage gauze --at x_g=0.3,Q=0,flow=0.002,gauze=1");
    let notes = far["notes"].as_array().unwrap();
    assert!(notes.iter().any(|note| note.as_str().unwrap().contains("are extrapolated")), "{notes:?}");

    let output = rijke(&folder, &["predict", "study", "--stage", "gauze", "--at", "x_g", "--json"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        output.status.code() == Some(2) && said.contains("--at x_g: `x_g` is not a factor with its number"),
        "{said}"
    );
    let output = rijke(&folder, &["inspect", "absent.wav", "--json"]);
    let error: Value = serde_json::from_slice(&output.stderr).unwrap();
    assert!(output.status.code() == Some(2) && output.stdout.is_empty());
    assert_eq!(error["exit_status"], 2);
    assert!(error["error"].as_str().unwrap().contains("absent.wav"));
}

/// Keys of a document, at any depth, but the roles of a model with their candidates.
fn keys(document: &Value, all: &mut BTreeSet<String>) {
    match document {
        Value::Object(map) => {
            for (key, value) in map {
                all.insert(key.clone());
                let of_roles = |v: &Value| v.as_object().is_some_and(|m| m.values().all(Value::is_string));
                let roles =
                    value.as_array().map_or_else(|| of_roles(value), |list| list.iter().all(of_roles));
                if !(roles && ["candidates", "models"].contains(&key.as_str())) {
                    keys(value, all);
                }
            }
        }
        Value::Array(list) => list.iter().for_each(|value| keys(value, all)),
        _ => {}
    }
}

/// Every key that commands print stands on the page as a word of its own.
#[test]
fn exact_every_key_is_on_the_page() {
    let folder = scratch("json-keys");
    records::write(&folder.join("records"));
    copy(&example("quarter-wave"), &folder.join("study"));
    let networks = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/networks");
    let ducted = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/ducted-flame");
    let mut all = BTreeSet::new();
    for words in [
        "new my-rig --template burner".to_owned(),
        "inspect records/C3-E/ping-0.wav".into(),
        "check records".into(),
        "check study".into(),
        "check study --names".into(),
        "rank study --until gauze --one-start".into(),
        "predict study --stage gauze --at x_g=0.3,Q=0,flow=0.001,gauze=1".into(),
        "next study --stage gauze".into(),
        "next study --stage gauze --microphones".into(),
        "report study".into(),
        format!("modes {networks}/rig-tube.toml --max-hz 300"),
        format!("response {networks}/combustor.toml --at-hz 100"),
        format!("infer {ducted}/n-tau.toml --data {ducted}/modes.csv --one-start"),
    ] {
        let output = rijke(&folder, &words.split(' ').chain(["--json"]).collect::<Vec<_>>());
        assert!(output.status.success(), "{words}: {}", String::from_utf8_lossy(&output.stderr));
        keys(&serde_json::from_slice(&output.stdout).unwrap(), &mut all);
    }
    assert!(all.len() > 100, "{all:?}");
    let page = include_str!("../../../../docs/reference/json.md");
    // Words within backticks, of paths their last part.
    let written: BTreeSet<&str> =
        page.split('`').skip(1).step_by(2).map(|word| word.rsplit('.').next().unwrap_or(word)).collect();
    let missing: Vec<&String> = all
        .iter()
        .filter(|key| !written.contains(key.as_str()) && !written.contains(format!("{key}[]").as_str()))
        .collect();
    assert!(missing.is_empty(), "docs/reference/json.md lacks {missing:?}");
}

#[test]
fn exact_quiet_says_nothing_and_pipes_get_no_colours() {
    let folder = scratch("quiet");
    records::write(&folder.join("records"));
    for words in [
        &["check", "records", "--quiet"][..],
        &["new", "my-rig", "--template", "kundt-tube", "-q"],
        &["inspect", "records/C3-E/ping-0.wav", "-q"],
    ] {
        let output = rijke(&folder, words);
        assert!(output.status.success() && output.stdout.is_empty() && output.stderr.is_empty(), "{words:?}");
    }
    for words in [&["--help"][..], &["check", "records"], &["check", "absent"], &["check", "my-rig"]] {
        let output = rijke(&folder, words);
        assert!(
            ![output.stdout, output.stderr].concat().contains(&0x1b),
            "{words:?} sends colours into a pipe"
        );
    }
}
