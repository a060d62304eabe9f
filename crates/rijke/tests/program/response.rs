//! `rijke response`: its formats agree with each other and with closed forms; places that are none are
//! refused.

use crate::{rijke, scratch};
use serde_json::Value;
use std::{f64::consts::PI, fs, path::Path};

const TUBE: &str = "name = \"A tube\"\n[gas]\ntemperature = 293.15\n[upstream]\ntype = \"closed\"\n[downstream]\ntype = \"END\"\n\
    [[element]]\ntype = \"duct\"\nlength = 0.3\ndiameter = 0.04\n[[element]]\nname = \"middle\"\ntype = \"feedback\"\n\
    [[element]]\ntype = \"duct\"\nlength = 0.2\ndiameter = 0.04\n";

fn said(folder: &Path, arguments: &[&str]) -> String {
    let output = rijke(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// The complex numbers of one response, from the CSV.
fn column(csv: &str, k: usize) -> Vec<[f64; 3]> {
    let row = |line: &str| -> Vec<f64> { line.split(',').map(|v| v.parse().unwrap()).collect() };
    csv.lines().skip(1).map(row).map(|r| [r[0], r[1 + 2 * k], r[2 + 2 * k]]).collect()
}

#[test]
fn exact_impedance_of_closed_open_and_matched_tubes() {
    let folder = scratch("response-closed-forms");
    let c = (1.4_f64 * 287.05 * 293.15).sqrt();
    for (end, closed_form) in [
        ("closed", (|kl: f64| [0.0, -1.0 / kl.tan()]) as fn(f64) -> [f64; 2]),
        ("open", |kl: f64| [0.0, kl.tan()]),
        ("anechoic", |_| [1.0, 0.0]),
    ] {
        fs::write(folder.join("tube.toml"), TUBE.replace("END", end)).unwrap();
        let csv = said(&folder, &["response", "tube.toml", "--csv", "--max-hz", "900", "--step-hz", "37"]);
        let all = column(&csv, 0);
        assert_eq!(all.len(), 24);
        for [f, re, im] in all {
            let [a, b] = closed_form(2.0 * PI * f / c * 0.5);
            assert!(
                (re - a).hypot(im - b) < 1e-10 * (1.0 + b.abs() * b.abs()),
                "{end} {f}: {re} {im}, {a} {b}"
            );
        }
    }
}

#[test]
fn exact_a_lossless_stretch_keeps_energy_and_is_reciprocal() {
    let folder = scratch("response-scattering");
    fs::write(folder.join("tube.toml"), TUBE.replace("END", "open").replacen("0.04", "0.02", 1)).unwrap();
    let arguments = ["response", "tube.toml", "--scattering", "upstream", "downstream", "--csv"];
    let csv = said(&folder, &arguments);
    let [r, back, t, other] = [0, 1, 2, 3].map(|k| column(&csv, k));
    // Areas 1 : 4, so that rho c is the same and power goes with the area.
    for k in 0..r.len() {
        let square = |c: &[[f64; 3]]| c[k][1].powi(2) + c[k][2].powi(2);
        assert!((square(&r) + 4.0 * square(&t) - 1.0).abs() < 1e-12);
        assert!((square(&other) + 0.25 * square(&back) - 1.0).abs() < 1e-12);
        assert!((back[k][1] - 4.0 * t[k][1]).hypot(back[k][2] - 4.0 * t[k][2]) < 1e-12);
    }
}

#[test]
fn exact_table_csv_json_and_plot_hold_the_same() {
    let folder = scratch("response-formats");
    fs::write(folder.join("tube.toml"), TUBE.replace("END", "unflanged")).unwrap();
    let common = [
        "response",
        "tube.toml",
        "--port",
        "middle",
        "--transfer",
        "upstream",
        "0.3",
        "--at-hz",
        "200",
        "555",
    ];
    let with = |more: &[&str]| said(&folder, &[&common[..], more].concat());
    let csv = with(&["--csv"]);
    let json: Value = serde_json::from_str(&with(&["--json"])).unwrap();
    let table = with(&["--plot", "r.svg"]);
    for (k, name) in ["Z/(rho c) at middle", "R at middle", "p(0.3)/p(upstream)"].iter().enumerate() {
        let answer = &json["responses"][k];
        assert_eq!(answer["name"], **name);
        for (row, [f, re, im]) in column(&csv, k).into_iter().enumerate() {
            assert_eq!([json["frequency_hz"][row].as_f64(), answer["re"][row].as_f64()], [Some(f), Some(re)]);
            assert_eq!(answer["im"][row].as_f64(), Some(im));
            assert!(table.contains(&format!("{:.6}", re.hypot(im))), "{table}");
        }
    }
    let svg = fs::read_to_string(folder.join("r.svg")).unwrap();
    assert!(svg.contains("phase / deg") && svg.contains("R at middle"), "{svg}");
    assert_eq!(with(&["--plot", "r.pdf"]), table);
    assert_eq!(fs::read(folder.join("r.pdf")).unwrap(), rijke_draw::pdf(&svg).unwrap());
}

#[test]
fn message_a_figure_is_svg_or_pdf() {
    let folder = scratch("figure-ending");
    for command in ["response", "modes"] {
        let output = rijke(&folder, &[command, "absent.toml", "--plot", "r.png"]);
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains("'r.png'") && text.contains("name a file that ends in .svg or .pdf"), "{text}");
    }
    assert!(fs::read_dir(&folder).unwrap().next().is_none());
}

#[test]
fn oracle_impedance_with_flow_is_that_of_moving_waves() {
    let folder = scratch("response-flow");
    let text = TUBE.replace("END", "anechoic") + "[flow]\nmach = 0.1\n";
    fs::write(folder.join("tube.toml"), text).unwrap();
    let csv = said(&folder, &["response", "tube.toml", "--csv", "--scattering", "upstream", "downstream"]);
    let c = (1.4_f64 * 287.05 * 293.15).sqrt();
    for (k, direction) in [(2, 1.0), (1, -1.0)] {
        for [f, re, im] in column(&csv, k) {
            let angle = -2.0 * PI * f * 0.5 / (c * (1.0 + 0.1 * direction));
            assert!((re - angle.cos()).hypot(im - angle.sin()) < 1e-9, "{f}");
        }
    }
}

#[test]
fn message_what_is_wrong_is_named_with_a_remedy() {
    let folder = scratch("response-bad");
    fs::write(folder.join("tube.toml"), TUBE.replace("END", "open")).unwrap();
    for (arguments, message) in [
        (&["--port", "flame"][..], "no element between ducts is called `flame`; known: middle"),
        (&["--port", "0.123"], "feedback"),
        (&["--scattering", "downstream", "upstream"], "does not lie downstream"),
        (&["--min-hz", "500", "--max-hz", "100"], "--max-hz above --min-hz"),
        (&["--step-hz", "1e-9"], "larger --step-hz"),
    ] {
        let output = rijke(&folder, &[&["response", "tube.toml"][..], arguments].concat());
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains(message) && error.contains("remedy"), "{error}");
    }
}

#[test]
fn message_the_rig_of_a_study_is_no_network_file() {
    let folder = crate::example("quarter-wave");
    let output = rijke(&folder, &["response", "rig.toml"]);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("rig.toml") && error.contains("`rijke modes DIR --point ID`"), "{error}");
}
