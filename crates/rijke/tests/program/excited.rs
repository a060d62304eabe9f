//! Records of random noise and of blows, from files to answers: those of other people where `RIJKE_MEASURED`
//! names them, and made ones.

use crate::measured::{example, found, model, parameter, stage};
use crate::rijke;
use serde_json::Value;
use std::f64::consts::TAU;
use std::fs;
use std::path::Path;
use std::process::Command;

#[test]
fn oracle_measured_transmission_tube_agrees_over_all_pairs() {
    let Some(answer) = found("transmission-tube") else { return };
    // The positions that the empty tube tells are those of the makers, to some millimetres.
    let empty = model(stage(&answer, "empty"), "waves.rough");
    for k in 1..=5 {
        let [x, sd] = parameter(empty, &format!("x{k}"));
        assert!(x.abs() < 0.01 && sd < 4e-3, "x{k}: {x} +- {sd}");
    }
    let folder = example("transmission-tube", "measured-transmission-tube-process");
    let output = rijke(&folder, &["process", ".", "--json"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    let pairs = answer["pairs"].as_array().unwrap();
    assert_eq!(pairs.len(), 25);
    for pair in pairs {
        let channel = pair["channel"].as_u64().unwrap();
        let [distance, sd] = ["distance", "sd"].map(|k| pair[k].as_f64().unwrap());
        // Channels 3 and 4 are heard otherwise where channel 0 was put in their place: docs/measured.md.
        let most = if matches!(channel, 3 | 4) { 0.025 } else { 8e-3 };
        assert!(distance < most && sd < 5e-3, "{pair}");
    }
    let bands = |what: &str| answer[what][0]["bands"].as_array().unwrap().clone();
    for band in bands("empty") {
        let [from, energy, down] = [0, 4, 5].map(|k| band[k].as_f64().unwrap());
        assert!((0.85..1.1).contains(&energy) && (0.9..1.1).contains(&down), "{from} Hz: {energy} {down}");
    }
    assert!(bands("transmission").len() >= 13);
}

#[test]
fn oracle_measured_struck_pipe_has_the_modes_of_its_bore() {
    let Some(answer) = found("struck-pipe") else { return };
    let wall = &answer["stages"][0];
    assert_eq!(wall["chosen"], "wall.rough", "{wall}");
    let rough = model(wall, "wall.rough");
    let [factor, sd] = parameter(rough, "factor");
    assert!((factor - 1.83).abs() < 0.2 && (0.1..0.3).contains(&sd), "{factor} +- {sd}");
    let measured = wall["measured"].as_array().unwrap();
    assert_eq!(measured.len(), 6);
    for id in ["wall.kirchhoff", "wall.rough"] {
        for (mode, predicted) in measured.iter().zip(model(wall, id)["predicted"].as_array().unwrap()) {
            let ratio = predicted[1].as_f64().unwrap() / mode["angular_frequency"][0].as_f64().unwrap();
            assert!((ratio - 1.0).abs() < 0.015, "{id}, {mode}: {ratio}");
        }
    }
}

#[test]
fn message_without_records_says_where_to_get_them() {
    for (name, command) in [("transmission-tube", "run"), ("struck-pipe", "run"), ("struck-pipe", "process")]
    {
        let folder = example(name, &format!("without-{command}-{name}"));
        let output = Command::new(env!("CARGO_BIN_EXE_rijke"))
            .args([command, "."])
            .current_dir(&folder)
            .env_remove("RIJKE_MEASURED")
            .output()
            .unwrap();
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{error}");
        for part in ["manifest.toml", "RIJKE_MEASURED", name, "https://github.com/", "commit"] {
            assert!(error.contains(part), "{part}: {error}");
        }
        assert!(!folder.join("results").exists() && !folder.join("observations").exists());
    }
}

/// Replaces what the manifest says of data elsewhere, and the rate.
pub(crate) fn here(folder: &Path, rate: &str, changes: &[(&str, &str)]) {
    let path = folder.join("records/manifest.toml");
    let text = fs::read_to_string(&path).unwrap();
    let (head, rest) = text.split_once("[measured]").unwrap();
    let (_, tail) = rest.split_once("\n[").unwrap();
    let head = head.replace("kind = \"measured\"", "kind = \"virtual\"").replace("rate_hz = 51200", rate);
    let mut text = format!("{}\n[{tail}", head.replace("rate_hz = 48000", rate))
        .replace(".h5", ".csv")
        .replace(".wav", ".csv");
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    fs::write(path, text).unwrap();
}

/// The empty tube with an end that reflects a half, driven by tones of random phase; channels 0 and
/// `switched` have changed places. Gain of channel c: 1 + 0.03 c. The wall takes what Kirchhoff's does in air
/// of 295 K, 50 mm from the axis.
pub(crate) fn noise_record(switched: usize, seed: u32) -> String {
    let places = [0.2, 0.615, 0.7, 1.8, 1.885, 2.3];
    let mut state = seed.wrapping_mul(2_654_435_761).wrapping_add(12_345);
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state) / f64::from(u32::MAX)
    };
    let c = (1.4 * 287.05 * 295.0_f64).sqrt();
    let layer = (0.5 * 1.53e-5_f64).sqrt() * (1.0 + 0.4 / 0.71_f64.sqrt()) / c / 0.05;
    let tones: Vec<[f64; 2]> = (150..1600).map(|f| [f64::from(f) + 0.5, TAU * random()]).collect();
    let mut text = String::from("m0,m1,m2,m3,m4,m5\n");
    let mut columns = Vec::new();
    for channel in 0..6 {
        let place = match channel {
            0 => switched,
            k if k == switched => 0,
            k => k,
        };
        let gain = 1.0 + 0.03 * channel as f64;
        let x = places[place];
        // Every tone turns by a constant step: one product a sample.
        let mut column = vec![0.0; 4096];
        for [f, phase] in &tones {
            let loss = layer * (TAU * f).sqrt();
            let k = TAU * f / c + loss;
            let (down, up) = (phase - k * x, phase + k * (x - 5.0));
            let [a, b] = [(-loss * x).exp(), 0.5 * (loss * (x - 5.0)).exp()];
            let (re, im) = (a * down.cos() + b * up.cos(), a * down.sin() + b * up.sin());
            let (turn_re, turn_im) = ((TAU * f / 4096.0).cos(), (TAU * f / 4096.0).sin());
            let (mut a, mut b) = (gain * re, gain * im);
            for value in &mut column {
                *value += a;
                (a, b) = (a * turn_re - b * turn_im, a * turn_im + b * turn_re);
            }
        }
        columns.push(column);
    }
    for n in 0..4096 {
        let cells: Vec<String> =
            columns.iter().map(|c| format!("{:.5}", c[n] + 0.05 * (random() - 0.5))).collect();
        text += &format!("{}\n", cells.join(","));
    }
    text
}

#[test]
fn oracle_a_made_tube_gives_its_gains_and_lets_all_through() {
    let folder = example("transmission-tube", "made-transmission-tube");
    here(
        &folder,
        "rate_hz = 4096",
        &[("segment = 16384", "segment = 1024"), ("polynomials = 6", "polynomials = 2")],
    );
    let records = folder.join("records");
    let names = [
        "00_11_22_33_44_55",
        "01_10_22_33_44_55",
        "02_11_20_33_44_55",
        "03_11_22_30_44_55",
        "04_11_22_33_40_55",
        "05_11_22_33_44_50",
    ];
    for (k, name) in names.iter().enumerate() {
        fs::write(records.join(format!("empty_{name}.csv")), noise_record(k, k as u32)).unwrap();
    }
    fs::copy(records.join(format!("empty_{}.csv", names[0])), records.join("measurement.csv")).unwrap();
    let output = rijke(&folder, &["process", ".", "--json"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    let text = fs::read_to_string(folder.join("observations/gains.csv")).unwrap();
    let row: Vec<f64> = text.lines().nth(150).unwrap().split(',').map(|v| v.parse().unwrap()).collect();
    for c in 0..6 {
        let (re, im, sd) = (row[1 + 3 * c], row[2 + 3 * c], row[3 + 3 * c]);
        let error = (re / (1.0 + 0.03 * c as f64) - 1.0).hypot(im);
        assert!(sd < 0.01 && error <= 4.0 * sd + 1e-12, "channel {c}: {re} {im} +- {sd}");
    }
    for band in answer["transmission"][0]["bands"].as_array().unwrap() {
        let [loss, sd, energy] = [2, 3, 4].map(|k| band[k].as_f64().unwrap());
        assert!(loss.abs() < 4.0 * sd && (energy - 1.0).abs() < 0.1, "{band}");
    }
    // The wall between microphones and specimen, 1 to 2 %, is none of it.
    let bands = answer["transmission"][0]["bands"].as_array().unwrap();
    let all: Vec<f64> = bands.iter().map(|band| band[5].as_f64().unwrap()).collect();
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    assert!((mean - 1.0).abs() < 4e-3, "{mean} {all:?}");
    // A point that the campaign does not have.
    let manifest = fs::read_to_string(records.join("manifest.toml")).unwrap();
    here_points(&folder);
    let output = rijke(&folder, &["process", ".", "--force"]);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("operating point `nothing`") && error.contains("empty, specimen"), "{error}");
    fs::write(records.join("manifest.toml"), manifest).unwrap();
    unswitched(&folder, &names);
}

/// Noise without records in which channels changed places: gains are stated, or taken for perfect, and that
/// is said.
fn unswitched(folder: &Path, names: &[&str; 6]) {
    let path = folder.join("records/manifest.toml");
    let whole = fs::read_to_string(&path).unwrap();
    let (head, rest) = whole.split_once("straight = ").unwrap();
    let (_, points) = rest.split_once("[random.points]").unwrap();
    let bare = format!("{head}[random.points]{points}");
    let gains = "gain = [1, 1.03, 1.06, 1.09, 1.12, 1.15]\ngain_sd = '0.1 %'\ndelay_sd = '1 us'\n";
    // A loudspeaker's voltage in the last channel, which is no microphone.
    for name in [format!("empty_{}.csv", names[0]), "measurement.csv".to_owned()] {
        let file = folder.join("records").join(name);
        let text = fs::read_to_string(&file).unwrap();
        let wider = |(n, line): (usize, &str)| format!("{line},{}\n", if n == 0 { "drive" } else { "0.5" });
        fs::write(&file, text.lines().enumerate().map(wider).collect::<String>()).unwrap();
    }
    let listed = bare.replace("band_hz", "channels = [0, 1, 2, 3, 4, 5, -1]\nband_hz");
    for (text, said) in [
        (format!("{listed}\n[microphones]\n{gains}"), None),
        (listed.clone(), Some("the channels are taken to have the same gain")),
    ] {
        fs::write(&path, &text).unwrap();
        let output = rijke(folder, &["process", ".", "--force", "--json"]);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{error}");
        assert_eq!(error.contains("warning"), said.is_some(), "{error}");
        assert!(said.is_none_or(|said| error.contains(said)), "{error}");
        let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
        for band in answer["transmission"][0]["bands"].as_array().unwrap() {
            let [loss, sd] = [2, 3].map(|k| band[k].as_f64().unwrap());
            let is_right = loss.abs() < 4.0 * sd;
            assert!(is_right || said.is_some(), "{band}");
        }
    }
    // `check` refuses what `run` would.
    for (from, to, part) in [
        ("channels = [0, 1, 2, 3, 4, 5, -1]\n", "", "7"),
        ("segment = 1024", "segment = 65536", "segment"),
        ("between = [1.0, 1.5]", "between = [0.1, 1.5]", "0 microphones upstream"),
    ] {
        assert!(listed.contains(from), "{from}");
        fs::write(&path, listed.replace(from, to)).unwrap();
        let output = rijke(folder, &["check", "."]);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && error.contains(part), "{from}: {error}");
    }
    fs::remove_dir_all(folder.join("observations")).unwrap();
    fs::write(&path, &listed).unwrap();
    let output = rijke(folder, &["check", "."]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(
        said.contains("2 records of random noise") && said.contains("no record is processed yet"),
        "{said}"
    );
    fs::write(&path, whole).unwrap();
}

#[test]
fn message_exchanged_and_inverted_records_of_a_tube() {
    let folder = example("transmission-tube", "exchanged-transmission-tube");
    here(
        &folder,
        "rate_hz = 4096",
        &[("segment = 16384", "segment = 1024"), ("polynomials = 6", "polynomials = 2")],
    );
    let names = [
        "00_11_22_33_44_55",
        "01_10_22_33_44_55",
        "02_11_20_33_44_55",
        "03_11_22_30_44_55",
        "04_11_22_33_40_55",
        "05_11_22_33_44_50",
    ];
    let path = |k: usize| folder.join(format!("records/empty_{}.csv", names[k]));
    let sound: Vec<String> = (0..6).map(|k| noise_record(k, k as u32)).collect();
    fs::write(folder.join("records/measurement.csv"), &sound[0]).unwrap();
    let turned = |text: &str, column: usize| -> String {
        let cells = |line: &str| -> String {
            let turn = |(k, cell): (usize, &str)| match cell.parse::<f64>() {
                Ok(value) if k == column => (-value).to_string(),
                _ => cell.to_owned(),
            };
            line.split(',').enumerate().map(turn).collect::<Vec<_>>().join(",") + "\n"
        };
        text.lines().map(cells).collect()
    };
    let process = |records: &[String]| {
        records.iter().enumerate().for_each(|(k, text)| fs::write(path(k), text).unwrap());
        let output = rijke(&folder, &["process", ".", "--force"]);
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (code, said) = process(&sound);
    assert!(code == Some(0) && !said.contains("near -1") && !said.contains("exchanging"), "{said}");
    let mut exchanged = sound.clone();
    exchanged.swap(2, 4);
    let (code, said) = process(&exchanged);
    assert_eq!(code, Some(2), "{said}");
    let files = format!("exchanging the files empty_{}.csv and empty_{}.csv brings", names[2], names[4]);
    assert!(said.contains(&files) && said.contains("in the manifest"), "{said}");
    let mut inverted = sound.clone();
    inverted[3] = turned(&sound[3], 3);
    // All other estimates say that the gain is near -1: both causes are named, with the file.
    let (code, said) = process(&inverted);
    let names_it = format!("or one of them in empty_{}.csv alone", names[3]);
    assert!(
        code == Some(0) && said.contains("gain of microphone m3 is near -1") && said.contains(&names_it),
        "{said}"
    );
    let always: Vec<String> = sound.iter().map(|text| turned(text, 2)).collect();
    let (code, said) = process(&always);
    assert!(code == Some(0) && said.contains("is near -1: is it inverted in all records"), "{said}");
}

fn here_points(folder: &Path) {
    let path = folder.join("records/manifest.toml");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, text.replace("\nempty = ", "\nnothing = ")).unwrap();
}

#[test]
fn oracle_a_made_blow_gives_its_modes() {
    let folder = example("struck-pipe", "made-struck-pipe");
    here(&folder, "rate_hz = 8000", &[]);
    for (hit, name) in ["hit-1", "hit-2"].iter().enumerate() {
        let mut state = 77 + hit as u32;
        let mut noise = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state) / f64::from(u32::MAX) - 0.5
        };
        let mut text = String::from("p\n");
        for n in 0..2400 {
            let t = f64::from(n) / 8000.0;
            let ring = |f: f64| (-15.0 * t).exp() * (TAU * f * t + f).cos();
            let sum: f64 = [148.0, 291.0, 445.0, 221.5, 367.0, 535.0].map(ring).iter().sum();
            text += &format!("{}\n", sum + 0.05 * noise());
        }
        fs::write(folder.join(format!("records/{name}.csv")), text).unwrap();
    }
    let output = rijke(&folder, &["process", ".", "--json"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    let modes = answer["modes"].as_array().unwrap();
    for (mode, truth) in modes.iter().zip([148.0, 291.0, 445.0, 221.5, 367.0, 535.0]) {
        let [f, f_sd] = [0, 1].map(|k| mode["frequency"][k].as_f64().unwrap());
        let [s, s_sd] = [0, 1].map(|k| mode["growth_rate"][k].as_f64().unwrap());
        assert!((f - truth).abs() < 4.0 * f_sd && f_sd < 0.2, "{mode}");
        assert!((s + 15.0).abs() < 4.0 * s_sd && s_sd < 1.0, "{mode}");
    }
    assert_eq!(modes.len(), 6);
    assert_eq!(modes[3]["point"], "closed");
    // A stretch behind the end of the records.
    let path = folder.join("records/manifest.toml");
    let text = fs::read_to_string(&path).unwrap().replace("[0.03, 0.22]", "[0.03, 2.0]");
    fs::write(&path, text).unwrap();
    let output = rijke(&folder, &["process", ".", "--force"]);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(
        error.contains("too short") && error.contains("hit-1.csv") && error.contains("stretch_s"),
        "{error}"
    );
}
