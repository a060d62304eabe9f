//! Studies of pressures at microphones while sources of unknown strength drive the rig: with data of a closed
//! form, and with bad ones.

use crate::measured::{example, found_by, model, noise, parameter, stage};
use crate::rijke;
use rijke_numerics::C64;
use serde_json::Value;
use std::f64::consts::PI;
use std::fs;
use std::path::PathBuf;

/// Microphones, away from the section.
const AT: [f64; 12] = [0.0, 0.04, 0.05, 0.06, 0.07, 0.09, 0.10, 0.10, 0.12, 0.14, 0.14, 0.18];
/// Mach number, factor of the speed of sound, length beyond the stated one, m.
const TRUTH: [f64; 3] = [0.0815, 0.998, 0.012];

/// Frequency, excitation and complex pressures of one row.
type Row = (f64, usize, Vec<C64>);

/// Rows of waves that lose what Kirchhoff's law takes of the frequency that the gas hears, with noise of 0.5
/// % of their level.
fn rows() -> Vec<Row> {
    let [mach, warm, extra] = TRUTH;
    let (temperature, gas): (f64, f64) = (296.0, 287.05);
    let c = (1.4 * gas * temperature).sqrt();
    let density = 101_325.0 / (gas * temperature);
    let mut k = 0;
    let mut next = || {
        k += 2;
        C64::new(noise(k), noise(k + 1))
    };
    let mut rows = Vec::new();
    for step in 0..8 {
        let f = 500.0 + 60.0 * f64::from(step);
        let s = C64::new(0.0, 2.0 * PI * f);
        let lossy = 1.0 + (1.0 + 0.4 / 0.71_f64.sqrt()) / (0.075 * (s * density / 1.813e-5).sqrt());
        let still = s / (c * warm);
        let [forward, backward] = [1.0, -1.0].map(|sign| still * lossy / (1.0 + sign * mach * lossy));
        for excitation in 0..2 {
            let [a, b] = [next(), next()];
            let clean = |x: f64| a * (-forward * x).exp() + b * (backward * x).exp();
            let level = (a.norm_sqr() + b.norm_sqr()).sqrt();
            let places = AT.iter().map(|x| 0.25 - x).chain(AT.iter().map(|x| 1.35 + extra + x));
            rows.push((f, excitation, places.map(|x| clean(x) + 5e-3 * level * next()).collect()));
        }
    }
    rows
}

/// The example with a file of its own that has these rows.
fn own(name: &str, rows: &[Row]) -> PathBuf {
    let folder = example("flow-duct", name);
    let path = folder.join("observations/observations.toml");
    let text = fs::read_to_string(&path).unwrap();
    let (before, rest) = text.split_once("[measured]").unwrap();
    let (_, after) = rest.split_once("[[response]]").unwrap();
    let before = before.replace("\"measured\"", "\"virtual\"");
    fs::write(&path, format!("{before}[[response]]{after}").replace("higherOrderModes.txt", "p.csv"))
        .unwrap();
    let names: String = (1..=24).map(|k| format!(",Mic{k}")).collect();
    let line = |(f, case, pressures): &Row| {
        let cells: String = pressures.iter().map(|z| format!(", ({:.6e}{:+.6e}j)", z.re, z.im)).collect();
        format!("({f}+0j), ({case}+0j){cells}\n")
    };
    let lines: String = rows.iter().map(line).collect();
    fs::write(folder.join("observations/p.csv"), format!("f,case{names}\n{lines}")).unwrap();
    folder
}

#[test]
fn oracle_measured_flow_duct_tells_flow_loss_and_length() {
    let Some(answer) = found_by("flow-duct", &["rank", ".", "--json", "--until", "waves"]) else { return };
    let joined = stage(&answer, "waves");
    for id in ["waves.loss-over-time", "waves.loss-carried"] {
        let found = model(joined, id);
        // Stated: 0.08455 at 296 K.
        let [mach, sd] = parameter(found, "mach");
        // Gains and delays are unknown, too: a delay that grows along a side is Mach number.
        assert!((mach / 0.084_548 - 1.0).abs() < 3e-3 && sd < 3e-4, "{mach} +- {sd}");
        assert!(found["residual"].as_f64().unwrap() < 7.5e-3, "{}", found["residual"]);
        let [extra, sd] = parameter(found, "extra");
        assert!((extra - 0.02).abs() < 1e-3 && sd < 1e-3, "{extra} +- {sd}");
    }
    let ln = |id: &str| model(joined, id)["evidence"]["ln_marginal"].as_f64().unwrap();
    assert!(ln("waves.loss-carried") - ln("waves.loss-at-rest") > 5.0, "{joined}");
    assert!(ln("waves.loss-at-rest") - ln("waves.lossless") > 100.0, "{joined}");
}

#[test]
fn oracle_a_study_of_unknown_sources_recovers_flow_and_length() {
    let folder = own("pressures-recovered", &rows());
    let output = rijke(&folder, &["rank", ".", "--json", "--until", "waves"]);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && !error.contains("warning"), "{error}");
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    let best = model(stage(&answer, "waves"), "waves.loss-carried");
    for (name, truth) in ["mach", "warm", "extra"].iter().zip(TRUTH) {
        let [value, sd] = parameter(best, name);
        assert!((value - truth).abs() < 3.5 * sd && sd < 1e-3, "{name}: {value} +- {sd}");
    }
    assert!(best["remark"].is_null(), "{best}");
    let ln = |id: &str| model(stage(&answer, "waves"), id)["evidence"]["ln_marginal"].as_f64().unwrap();
    assert!(ln("waves.loss-carried") - ln("waves.lossless") > 10.0);
}

#[test]
fn message_bad_pressures_are_named_with_place_and_remedy() {
    let told = |name: &str, rows: &[Row], change: &dyn Fn(String) -> String| {
        let folder = own(name, rows);
        let path = folder.join("observations/observations.toml");
        let text = change(fs::read_to_string(&path).unwrap());
        fs::write(&path, text).unwrap();
        let output = rijke(&folder, &["check", "."]);
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let refused = |name: &str, rows: &[Row], change: &dyn Fn(String) -> String, parts: &[&str]| {
        let (code, error) = told(name, rows, change);
        assert_eq!(code, Some(2), "{error}");
        parts.iter().for_each(|part| assert!(error.contains(part), "{part}: {error}"));
    };
    let same = |text: String| text;
    let mut twice = rows();
    twice[4].0 = twice[2].0;
    refused("pressures-twice", &twice, &same, &["p.csv, line 6", "560 Hz", "given once"]);
    let mut unsorted = rows();
    unsorted.swap(2, 8);
    refused("pressures-unsorted", &unsorted, &same, &["p.csv, line", "sort the rows"]);
    let mut silent = rows();
    silent[3].2 = vec![C64::new(0.0, 0.0); 24];
    refused("pressures-silent", &silent, &same, &["p.csv, line 5", "other than zero"]);
    let few = |text: String| {
        let keep = |line: &&str| !line.contains("Mic") || line.starts_with("u1 ") || line.starts_with("d1 ");
        text.lines().filter(keep).map(|line| format!("{line}\n")).collect::<String>()
    };
    refused(
        "pressures-few",
        &rows(),
        &few,
        &["observations.toml", "more microphones than waves are unknown"],
    );
    let other = |text: String| text.replace("u1 = ", "v1 = ");
    refused("pressures-name", &rows(), &other, &["observations.toml", "v1", "u1"]);
    let ends = |text: String| text.replace("\"upstream\", \"downstream\"", "\"above\"");
    refused("pressures-ends", &rows(), &ends, &["observations.toml", "above", "upstream, downstream"]);
    let outside = |text: String| text.replace("[500, 1000]", "[10, 20]");
    refused("pressures-outside", &rows(), &outside, &["observations.toml", "band_hz"]);
    // The file's own heading against what the study says of it.
    let folder = own("pressures-unit", &rows());
    let path = folder.join("observations/p.csv");
    let text = fs::read_to_string(&path).unwrap();
    for (heading, code) in [("f [kHz]", 2), ("f [Hz]", 0)] {
        fs::write(&path, text.replacen("f,case", &format!("{heading},case"), 1)).unwrap();
        let output = rijke(&folder, &["check", "."]);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{error}");
        assert_eq!(error.contains("kHz") && error.contains("the unit that `columns`"), code == 2, "{error}");
    }
    // Degrees that are taken for radians are said.
    let folder = own("pressures-degrees", &rows());
    let names: String = (1..=24).map(|k| format!(",a{k},w{k}")).collect();
    let line = |(f, case, pressures): &Row| {
        let cells: String =
            pressures.iter().map(|z| format!(",{:.6e},{:.6e}", z.norm(), z.arg().to_degrees())).collect();
        format!("{f},{case}{cells}\n")
    };
    let lines: String = rows().iter().map(line).collect();
    fs::write(folder.join("observations/p.csv"), format!("f,case{names}\n{lines}")).unwrap();
    let path = folder.join("observations/observations.toml");
    let text = fs::read_to_string(&path).unwrap();
    for (unit, is_said) in [("rad", true), ("deg", false)] {
        let polar = |line: &str| match line.split_once(" = \"Mic") {
            Some((name, k)) => {
                let k = k.trim_end_matches('\"');
                format!("\"{name}_abs [Pa]\" = \"a{k}\"\n\"{name}_arg [{unit}]\" = \"w{k}\"\n")
            }
            None => format!("{line}\n"),
        };
        fs::write(&path, text.lines().map(polar).collect::<String>()).unwrap();
        let output = rijke(&folder, &["check", "."]);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{error}");
        assert_eq!(error.contains("arg [deg]"), is_said, "{error}");
    }
}

/// A tube whose ends are both taken for sources, but one of which reflects: nothing is told of what it
/// reflects, and that is said for every model, in the answer and on the page.
#[test]
fn message_ends_that_are_taken_for_sources_are_not_identified() {
    let folder = crate::scratch("pressures-both-ends");
    let write = |file: &str, text: &str| {
        let path = folder.join(file);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    };
    write(
        "rig.toml",
        "name = \"tube\"\n[gas]\ntemperature = 293.15\n[upstream]\ntype = \"closed\"\n[downstream]\ntype = \"free\"\n[[element]]\n\
         name = \"tube\"\ntype = \"duct\"\nlength = 1.0\ndiameter = 0.1\nwall = \"none\"\n[microphones]\nat = [0.2, 0.5, 0.65, 0.9]\n",
    );
    let candidate = |id: &str, parameter: &str, prior: &str| {
        format!(
            "[[candidate]]\nid = \"{id}\"\nrole = \"sample\"\nname = \"{id}\"\ncite = [\"a test\"]\nparameters.{parameter} = {{ prior = {prior} }}\n\
             [[candidate.effect]]\nacts_at = \"downstream\"\nreflection = \"{parameter}\"\n"
        )
    };
    let all = candidate("normal", "r", "{ normal = { mean = 0.5, sd = 0.3 } }")
        + &candidate("uniform", "q", "{ uniform = { low = 0.0, high = 1.0 } }");
    write("candidates/sample.toml", &all);
    write("campaign.csv", "point\ntube\n");
    write("study.toml", "name = \"t\"\n[[responses]]\nid = \"s\"\ncompete = [\"sample\"]\n");
    let origin = |more: &str| {
        format!(
            "kind = \"virtual\"\nsource = \"a closed form\"\n[[response]]\nkind = \"pressures\"\n{more}files = {{ tube = \"p.csv\" }}\n\
             [response.columns]\n\"f [Hz]\" = \"f\"\np1 = \"m1\"\np2 = \"m2\"\np3 = \"m3\"\np4 = \"m4\"\n"
        )
    };
    let c = (1.4 * 287.05 * 293.15_f64).sqrt();
    let mut text = "f,m1,m2,m3,m4\n".to_owned();
    for k in 0..30_usize {
        let f = 200.0 + 20.0 * k as f64;
        let s = C64::new(0.0, 2.0 * PI * f);
        let cells = [0.2, 0.5, 0.65, 0.9].iter().enumerate().map(|(m, x)| {
            let e = 3e-3 * C64::new(noise(8 * k + 2 * m), noise(8 * k + 2 * m + 1));
            let p = (-s * x / c).exp() + 0.6 * (-s * (2.0 - x) / c).exp() + e;
            format!(",({:.6e}{:+.6e}j)", p.re, p.im)
        });
        text += &format!("{f}{}\n", cells.collect::<String>());
    }
    write("observations/p.csv", &text);
    write("observations/observations.toml", &origin(""));
    let ranked = || {
        let output = rijke(&folder, &["rank", ".", "--force", "--json"]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice::<Value>(&output.stdout).unwrap()
    };
    let answer = ranked();
    for (id, parameter) in [("normal", "r"), ("uniform", "q")] {
        let remark = model(stage(&answer, "s"), id)["remark"].as_str().unwrap_or_default().to_owned();
        let said =
            format!("not identified by these data, as their priors: {parameter}; waves of unknown strength");
        assert!(remark.contains(&said) && remark.contains("sources = "), "{remark}");
    }
    let page = fs::read_to_string(folder.join("results/index.html")).unwrap();
    assert!(page.contains("not identified by these data"));
    // With one source the other end is told.
    write("observations/observations.toml", &origin("sources = [\"upstream\"]\n"));
    let answer = ranked();
    let [r, sd] = parameter(model(stage(&answer, "s"), "normal"), "r");
    assert!((r - 0.6).abs() < 4.0 * sd && sd < 0.01, "{r} +- {sd}");
}
