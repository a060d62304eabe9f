//! `rijke next`: what to measure next.

use crate::{copy, example, rijke, scratch, short};
use serde_json::Value;
use std::fs;

#[test]
fn behaviour_next_says_what_to_measure_and_when_to_stop() {
    let folder = scratch("next");
    copy(&example("quarter-wave"), &folder.join("study"));
    let said = |words: &str| {
        let output = rijke(&folder, &words.split(' ').collect::<Vec<_>>());
        let text = String::from_utf8(output.stdout).unwrap() + &String::from_utf8(output.stderr).unwrap();
        (output.status.code(), text)
    };
    let (code, text) = said("next study");
    assert!(code == Some(2) && text.contains("Run `rijke rank study` first"), "{text}");
    let plan = folder.join("study/study.toml");
    let stated = fs::read_to_string(&plan).unwrap();
    fs::write(&plan, format!("{stated}\n[cost]\npoint = \"40 mm\"\n")).unwrap();
    let (code, text) = said("next study");
    assert!(code == Some(2) && text.contains("cost.point"), "{text}");
    fs::write(&plan, format!("{stated}\n[cost]\npoint = \"40 min\"\ninstallation = \"1 h\"\n")).unwrap();
    assert_eq!(said("rank study --one-start").0, Some(0));

    let (code, text) = said("next study --plot next.svg");
    assert!(code == Some(0) && text.contains("(repeat)") && text.contains("Plan: "), "{text}");
    assert!(text.contains("the best further point would add"), "{text}");
    assert!(fs::read_to_string(folder.join("next.svg")).unwrap().contains("Expected information / nats"));

    let answer = |words: &str| -> Value {
        let words: Vec<&str> = words.split(' ').chain(["--json"]).collect();
        let output = rijke(&folder, &words);
        assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let number = |v: &Value| v.as_f64().unwrap_or_else(|| panic!("{v} is no number"));
    let found = answer("next study --points 4");
    assert_eq!((found["points"].as_array().unwrap().len(), found["aim"].as_str()), (24, Some("parameters")));
    let steps = found["plan"].as_array().unwrap();
    assert_eq!(steps.len(), 4);
    // What is known makes further points worth less.
    assert!(steps.windows(2).all(|s| number(&s[0]["adds"]) > 0.0 && number(&s[1]["hours"]) > 0.6));
    assert!(number(&found["further"][1]) < number(&steps[0]["adds"]));

    let models = answer("next study --models --map x_g,Q");
    assert_eq!(models["models"].as_array().unwrap().len(), 6);
    let which = |p: &Value| number(&p["which"]) > 0.0 && number(&p["which"]) < number(&models["entropy"]);
    assert!(models["points"].as_array().unwrap().iter().all(which), "{models}");
    assert!(models["points"].as_array().unwrap().iter().all(|p| number(&p["models"][0]) > -1e-9));
    let about = answer("next study --about x_g=0.24,Q=60");
    let sd = &about["quantity_sd"];
    assert!(about["aim"] == "quantity" && number(&sd[1]) < number(&sd[0]), "{about}");
    let (code, text) = said("next study --about x_g");
    assert!(code == Some(2) && text.contains("--about x_g: `x_g` is not a factor with its number"), "{text}");

    let found = answer("next study --microphones --place 0.8");
    let (in_use, further) = (found["in_use"].as_array().unwrap(), found["further"].as_array().unwrap());
    assert_eq!((in_use.len(), further.len()), (4, 2), "p4 was never heard, and one is asked for");
    assert!(in_use.iter().chain(further).all(|m| number(&m["nats"]) > 0.0), "{found}");
    let (code, text) = said("next study --microphones");
    assert!(code == Some(0) && text.contains("p1 (the reference: without it, p2 takes its role)"), "{text}");
    assert!(text.contains("None is worth adding: each brings less than 0.1 nats"), "{text}");
    let (code, text) = said("next study --microphones --place 0.9");
    assert!(code == Some(2) && text.contains("give a place from 0 to 0.8 m"), "{text}");
}

#[test]
fn behaviour_a_planned_point_has_gas_and_can_be_judged() {
    let folder = scratch("next-planned");
    short::record(&folder);
    let run = |words: &[&str]| {
        let output = rijke(&folder, words);
        assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
        output.stdout
    };
    run(&["process", ".", "--out", "observations"]);
    for file in ["points.csv", "pings.csv", "clicks.csv"] {
        let path = folder.join("observations").join(file);
        let planned = |line: &str| match (line.starts_with("H50-75,"), file) {
            (false, _) => Some(line.to_owned()),
            (true, "points.csv") => Some(line.replacen(",2,2,", ",0,0,", 1)),
            (true, _) => None,
        };
        let text = fs::read_to_string(&path).unwrap();
        let kept: Vec<String> = text.lines().filter_map(planned).collect();
        assert_eq!(kept.len() == text.lines().count(), file == "points.csv");
        fs::write(&path, kept.join("\n") + "\n").unwrap();
    }
    run(&["flow", ".", "--out", "base"]);
    run(&["rank", ".", "--one-start", "--quiet"]);
    let found: Value = serde_json::from_slice(&run(&["next", ".", "--json"])).unwrap();
    let points = found["points"].as_array().unwrap();
    let nats = |id: &str, repeat: bool| {
        let point = points.iter().find(|p| p["point"] == id && p["repeat"] == repeat);
        point.unwrap_or_else(|| panic!("{id} in {found}"))["nats"].as_f64().unwrap()
    };
    // What is planned tells more than what the same place and its neighbours repeat.
    assert!(nats("H50-75", false) > 2.0 * nats("H50-60", true), "{found}");
}
