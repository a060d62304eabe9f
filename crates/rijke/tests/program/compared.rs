//! Microphones that are compared with each other, from files to the answers that stand on them.

use crate::excited::{here, noise_record};
use crate::measured::example;
use crate::rijke;
use serde_json::Value;
use std::fs;

/// Six channels that hear the same noise, with the gains of [`noise_record`].
fn comparison_record(seed: u32) -> String {
    let mut state = seed;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state) / f64::from(u32::MAX) - 0.5
    };
    let mut text = String::from("m0,m1,m2,m3,m4,m5\n");
    for _ in 0..16_384 {
        let pressure = random();
        let heard =
            |c: usize, noise: f64| format!("{:.6}", (1.0 + 0.03 * c as f64) * (pressure + 0.02 * noise));
        let cells: Vec<String> = (0..6).map(|c| heard(c, random())).collect();
        text += &format!("{}\n", cells.join(","));
    }
    text
}

#[test]
fn oracle_compared_microphones_calibrate_a_tube() {
    let folder = example("transmission-tube", "compared-transmission-tube");
    here(&folder, "rate_hz = 4096", &[("segment = 16384", "segment = 1024")]);
    let comparison = folder.join("comparison");
    fs::create_dir(&comparison).unwrap();
    let manifest = "kind = \"virtual\"\nsource = \"a plate with six microphones\"\nrate_hz = 4096\nband_hz = [100, 1500]\n\
                    [comparison]\nfiles = [\"a.csv\", \"b.csv\"]\ngain_sd = \"0.05 %\"\ndelay_sd = \"0.2 us\"\n";
    fs::write(comparison.join("manifest.toml"), manifest).unwrap();
    for (seed, name) in [(1, "a.csv"), (2, "b.csv")] {
        fs::write(comparison.join(name), comparison_record(seed)).unwrap();
    }
    let output = rijke(&folder, &["process", "comparison", "--json"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    for (c, row) in answer["microphones"].as_array().unwrap().iter().enumerate() {
        let [gain, sd, delay, late] =
            [("gain", 0), ("gain", 1), ("delay", 0), ("delay", 1)].map(|(k, n)| row[k][n].as_f64().unwrap());
        assert!((gain - 1.0 - 0.03 * c as f64).abs() < 4.0 * sd && sd < 2e-3, "{row}");
        assert!(delay.abs() < 4.0 * late && late < 1e-6, "{row}");
        assert!(row["coherence"].as_f64().unwrap() > 0.99, "{row}");
    }
    // The table in the place of records in which channels have changed places.
    let path = folder.join("records/manifest.toml");
    let text = fs::read_to_string(&path).unwrap();
    let (head, rest) = text.split_once("straight = ").unwrap();
    let (_, points) = rest.split_once("[random.points]").unwrap();
    let table = "[microphones]\ntable = \"../comparison/microphones.csv\"\n";
    fs::write(&path, format!("{head}[random.points]{points}\n{table}")).unwrap();
    for name in ["empty_00_11_22_33_44_55", "measurement"] {
        fs::write(folder.join(format!("records/{name}.csv")), noise_record(0, 0)).unwrap();
    }
    let output = rijke(&folder, &["process", ".", "--json"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    for band in answer["transmission"][0]["bands"].as_array().unwrap() {
        let [loss, sd] = [2, 3].map(|k| band[k].as_f64().unwrap());
        assert!(loss.abs() < 4.0 * sd, "{band}");
    }
    // A dead microphone may be declared, and what the largest integer stands for.
    let dead = "full_scale = \"2 V\"\ndead = [3]\n[microphones]\nsensitivity = \"50 mV/Pa\"\n[comparison]";
    fs::write(comparison.join("manifest.toml"), manifest.replace("[comparison]", dead)).unwrap();
    let output = rijke(&folder, &["process", "comparison", "--force", "--json"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    let gain = |m: usize, k: usize| answer["microphones"][m]["gain"][k].as_f64().unwrap();
    assert!(gain(3, 1) == 1.0 && (gain(4, 0) - 1.12).abs() < 4.0 * gain(4, 1), "{answer}");
    // What it cannot be.
    let refused = |from: &str, to: &str, part: &str| {
        fs::write(comparison.join("manifest.toml"), manifest.replace(from, to)).unwrap();
        let output = rijke(&folder, &["process", "comparison", "--force"]);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && error.contains(part), "{to}: {error}");
    };
    refused("[\"a.csv\", \"b.csv\"]", "[]", "must list files");
    refused("0.05 %", "0.05 m", "gain_sd");
    refused(
        "[comparison]",
        "[microphones]\ngain_sd = 0.1\ndelay_sd = 1e-6\n[comparison]",
        "leave all but `sensitivity` out",
    );
    refused("[100, 1500]", "[1, 3]", "a.csv");
    let records = folder.join("records");
    fs::write(records.join("manifest.toml"), manifest).unwrap();
    let output = rijke(&folder, &["check", "."]);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && error.contains("a folder of its own"), "{error}");
}
