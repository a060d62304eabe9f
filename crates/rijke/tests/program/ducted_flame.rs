//! The worked example of a ducted flame: virtual data, two networks, the better one found and its transfer
//! function true within its errors where the data are.

use crate::{book::follow, rijke, scratch};
use rand::RngExt;
use rand_distr::StandardNormal;
use rijke_network::{Workspace, file::read};
use rijke_numerics::Streams;
use serde_json::Value;
use std::{f64::consts::PI, fs, path::Path};

fn example(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/ducted-flame").join(name).display().to_string()
}

/// The modes of the truth with their noise.
fn data() -> String {
    let truth = fs::read_to_string(example("truth.toml")).unwrap();
    let mut noise = Streams::new(1).stream("ducted-flame");
    let mut text =
        "# Virtual: modes of truth.toml with noise; written by the test `ducted_flame` of crates/rijke.\n\
                    chamber_length [m],growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n"
            .to_owned();
    for length in (6..=18).map(|k| 0.05 * f64::from(k)) {
        let built = read(&truth.replace("\"$chamber_length\"", &format!("{length:.2}"))).unwrap();
        let found = built.network.modes(&built.laws, &built.region, &mut Workspace::default()).unwrap();
        for mode in &found.modes {
            let [a, b]: [f64; 2] = [noise.sample(StandardNormal), noise.sample(StandardNormal)];
            text +=
                &format!("{length:.2},{:.2},1,{:.3},0.2\n", mode.s.re + a, mode.s.im / (2.0 * PI) + 0.2 * b);
        }
    }
    text
}

#[test]
fn exact_the_data_are_those_of_the_truth() {
    let (kept, now) = (fs::read_to_string(example("modes.csv")).unwrap_or_default(), data());
    assert!(kept == now, "examples/ducted-flame/modes.csv should be\n{now}");
}

#[test]
fn lab_the_transfer_function_of_a_ducted_flame_is_found() {
    let folder = scratch("ducted-flame");
    let files = ["n-tau.toml", "n-tau-filter.toml", "second-order.toml", "modes.csv"].map(example);
    let [one, two, three, modes] = &files;
    let words = ["infer", one, two, three, "--data", modes, "--fitted", "fitted.toml", "--json"];
    let output = rijke(&folder, &words);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    let (best, next) = (&found[0], &found[1]);
    assert!(best["file"].as_str().unwrap().ends_with("second-order.toml"), "{found:#}");
    let number = |of: &Value, name: &str| of[name].as_f64().unwrap();
    assert!(number(best, "ln_marginal") > number(next, "ln_marginal") + 50.0, "{found:#}");
    // Covariance and residuals are those of the unknowns and of the rows.
    let unknowns = best["unknowns"].as_array().unwrap();
    let covariance = &best["covariance"];
    for (k, unknown) in unknowns.iter().enumerate() {
        assert_eq!(covariance["names"][k], unknown["name"]);
        let sd = covariance["rows"][k][k].as_f64().unwrap().sqrt();
        assert!((sd / number(unknown, "sd") - 1.0).abs() < 1e-9, "{unknown} {sd}");
    }
    let residuals = best["residuals"].as_array().unwrap();
    let rms = |key: &str| {
        let all: Vec<f64> = residuals.iter().filter_map(|r| r[key].as_f64()).collect();
        (all.iter().map(|r| r * r).sum::<f64>() / all.len() as f64).sqrt()
    };
    assert!(rms("growth_rate") < 3.0 && rms("frequency_hz") < 1.0, "{residuals:?}");
    // What a file says with a formula of its unknowns is a number in the one that is written.
    let text = fs::read_to_string(one).unwrap();
    let named = text.replace("\"$delay\"", "\"$tau*0.5*2\"").replace("[unknown.delay]", "[unknown.tau]");
    fs::write(folder.join("formula.toml"), named).unwrap();
    let words = ["infer", "formula.toml", "--data", modes, "--fitted", "numbers.toml"];
    assert!(rijke(&folder, &words).status.success());
    // An unknown that is called as another key of its element is refused.
    fs::write(folder.join("clash.toml"), text.replace("\"$delay\"", "\"2*$delay\"")).unwrap();
    let output = rijke(&folder, &["infer", "clash.toml", "--data", modes]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && said.contains("call the unknown delay_1"), "{said}");
    // A factor in a formula, with and without the sign of an unknown, among names that begin alike.
    let table = fs::read_to_string(modes).unwrap();
    let with_factor = |line: &str| match line.starts_with('#') || line.is_empty() {
        true => format!("{line}\n"),
        false => format!("{line},{}\n", if line.contains("growth_rate") { "tau_of" } else { "0.5" }),
    };
    fs::write(folder.join("factor.csv"), table.lines().map(with_factor).collect::<String>()).unwrap();
    let named = text.replace("\"$delay\"", "\"$tau*tau_of/0.5\"").replace("[unknown.delay]", "[unknown.tau]");
    fs::write(folder.join("factor.toml"), named).unwrap();
    let output =
        rijke(&folder, &["infer", "factor.toml", "--data", "factor.csv", "--fitted", "numbers.toml"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let modes_of = rijke(&folder, &["modes", "numbers.toml"]);
    assert!(modes_of.status.success(), "{}", String::from_utf8_lossy(&modes_of.stderr));
    let modes_of = rijke(&folder, &["modes", "numbers.toml"]);
    assert!(modes_of.status.success(), "{}", String::from_utf8_lossy(&modes_of.stderr));
    // What is inferred is what is true, within the stated errors, and they are small.
    for (name, truth, relative) in
        [("n", 0.4, 0.02), ("delay", 1.9e-3, 0.02), ("a1", 7.9e-4, 0.05), ("a2", 4.1e-7, 0.05)]
    {
        let all = best["unknowns"].as_array().unwrap();
        let unknown = all.iter().find(|u| u["name"] == name).unwrap();
        let (value, sd) = (number(unknown, "value"), number(unknown, "sd"));
        assert!(
            (value - truth).abs() < 3.0 * sd && sd < relative * truth,
            "{name} = {value} +- {sd}, true {truth}"
        );
    }
}

#[test]
fn exact_the_page_of_the_example_prints_what_the_program_prints() {
    let folder = scratch("ducted-flame-page");
    for name in ["n-tau.toml", "n-tau-filter.toml", "second-order.toml", "modes.csv"] {
        fs::copy(example(name), folder.join(name)).unwrap();
    }
    follow(include_str!("../../../../examples/ducted-flame/README.md"), &folder);
}

#[test]
fn exact_what_cannot_be_inferred_is_refused() {
    let folder = scratch("ducted-flame-wrong");
    let refused = |from: &str, to: &str, says: &[&str]| {
        let text = fs::read_to_string(example("n-tau.toml")).unwrap();
        assert!(text.contains(from));
        fs::write(folder.join("own.toml"), text.replacen(from, to, 1)).unwrap();
        let output = rijke(&folder, &["infer", "own.toml", "--data", &example("modes.csv")]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{said}");
        for part in says.iter().chain(&["own.toml, line"]) {
            assert!(said.contains(part), "no `{part}` in\n{said}");
        }
    };
    refused("\"$n\"", "\"$gain\"", &["unknown or factor called `$gain", "chamber_length"]);
    refused("delay = \"$delay\"", "delay = 2e-3", &["`$delay` is used nowhere"]);
    refused("sd = 0.5", "sd = -0.5", &["n", "-0.5"]);
    refused("type = \"flame\"", "type = \"fire\"", &["fire", "helmholtz"]);
    let output = rijke(&folder, &["infer", &example("n-tau.toml"), "--data", &example("truth.toml")]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(2) && said.contains("truth.toml, line"), "{said}");
}

#[test]
fn behaviour_the_best_network_becomes_a_study_with_a_page() {
    let folder = scratch("ducted-flame-study");
    let [file, modes] = ["second-order.toml", "modes.csv"].map(example);
    let output = rijke(&folder, &["infer", &file, "--data", &modes, "--study", "flame", "--one-start"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let output = rijke(&folder, &["run", "flame", "--one-start"]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success() && said.contains("n = 0.398"), "{said}");
    assert!(folder.join("flame/results/index.html").is_file());
}

/// What is printed as a check is in the JSON too, and numbers that no network has are said.
#[test]
fn exact_checks_are_printed_and_are_in_the_json() {
    let folder = scratch("ducted-flame-checks");
    let text = fs::read_to_string(example("n-tau.toml")).unwrap();
    let prior = "{ normal = { mean = -1.5e-3, sd = 1e-6 } }";
    let at = text.find("[unknown.delay]").unwrap();
    let from = at + text[at..].find("prior = ").unwrap() + "prior = ".len();
    let to = from + text[from..].find('\n').unwrap();
    fs::write(folder.join("early.toml"), format!("{}{prior}{}", &text[..from], &text[to..])).unwrap();
    let data = example("modes.csv");
    let said = |more: &[&str]| {
        let output =
            rijke(&folder, &[&["infer", "early.toml", "--data", &data, "--one-start"], more].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let (text, json) = (said(&[]), said(&["--json"]));
    let json: Value = serde_json::from_str(&json).unwrap();
    let remark = json[0]["remark"].as_str().unwrap();
    let checks: Vec<&str> =
        text.lines().filter_map(|line| line.trim_start().strip_prefix("check: ")).collect();
    assert_eq!(checks, remark.lines().collect::<Vec<_>>());
    let impossible =
        checks.iter().find(|c| c.starts_with("no network has the most probable numbers")).unwrap();
    assert!(
        impossible.contains("delay is -0.00") && impossible.contains("must be zero or more"),
        "{impossible}"
    );
    assert!(checks.iter().any(|c| c.contains("the model misses")), "{checks:?}");
}
