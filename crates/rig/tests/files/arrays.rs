//! One record in every format: `fixtures/records`, written by SciPy, h5py and by hand (README there).
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may fail by panicking")]

use rijke_rig::{Arrays, Layout, Reading, Record, RigError, inspect, read_record};
use std::path::{Path, PathBuf};

const CHANNELS: [Option<usize>; 2] = [Some(1), Some(0)];

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/records").join(name)
}

fn arrays(names: &[&str], rate: &str) -> Arrays {
    Arrays {
        names: names.iter().map(|n| (*n).to_owned()).collect(),
        rate: Some(rate.to_owned()).filter(|r| !r.is_empty()),
    }
}

fn read(path: &Path, arrays: &Arrays) -> Result<Record, RigError> {
    read_record(
        path,
        Layout {
            channels: &CHANNELS,
            full_scale: 20.0,
            rate_hz: 1e4,
            quiet: 10,
            arrays,
            reading: &Reading::default(),
        },
    )
}

/// Every file with the names of its arrays.
fn files() -> Vec<(&'static str, Arrays)> {
    vec![
        ("wave.wav", Arrays::default()),
        ("text.csv", Arrays::default()),
        ("v5.mat", arrays(&["p"], "fs")),
        ("v5.mat", Arrays::default()), // one array is long: it must be the record
        ("v7.mat", arrays(&["p"], "fs")),
        ("struct.mat", arrays(&["run.left", "run.right"], "run.fs")),
        ("v73.mat", arrays(&["p"], "fs")),
        ("plain.h5", arrays(&["run/p"], "run/fs")),
        ("packed.h5", arrays(&["left", "right"], "")),
    ]
}

#[test]
fn exact_every_format_gives_the_same_record() {
    let wave = read(&fixture("wave.wav"), &Arrays::default()).unwrap();
    assert_eq!((wave.len(), wave.channels.len(), wave.channels[1][0]), (40, 2, -4e6 * 20.0 / 8_388_608.0));
    for (name, arrays) in files() {
        let record = read(&fixture(name), &arrays).unwrap();
        assert!(record.channels == wave.channels, "{name} holds something else");
    }
    // Integers are fractions of full scale; these lack the last eight bits.
    let short = read(&fixture("int16.mat"), &arrays(&["p"], "")).unwrap();
    assert_eq!(short.full_scale, 20.0);
    let off = |(a, b): (&f64, &f64)| (a - b).abs() * 32_768.0 / 20.0;
    let worst = wave.channels[0].iter().zip(&short.channels[0]).map(off).fold(0.0, f64::max);
    assert!(worst > 0.5 && worst < 1.0, "{worst} units of the 16 bits");
}

#[test]
fn exact_contents_are_listed_by_name() {
    let names = |file: &str| {
        let found = inspect(&fixture(file)).unwrap();
        let names: Vec<String> = found.channels.into_iter().filter_map(|c| c.name).collect();
        (found.format, names.join(" "), found.others.join("; "))
    };
    let owned = |a: &str, b: &str, c: &str| (a.to_owned(), b.to_owned(), c.to_owned());
    assert_eq!(names("v7.mat"), owned("MATLAB 5", "p[0] p[1]", "fs = 10000; note (1 x 13, text)"));
    let (_, channels, others) = names("struct.mat");
    assert_eq!(channels, "run.left run.right");
    for part in ["run.fs = 10000", "z (1 x 1, complex)", "empty is empty"] {
        assert!(others.contains(part), "{others}");
    }
    assert_eq!(names("v73.mat"), owned("MATLAB 7.3", "p[0] p[1]", "fs = 10000; note (7 x 1, text)"));
    let (format, channels, others) = names("plain.h5");
    assert_eq!((&*format, &*channels), ("HDF5", "run/p[0] run/p[1]"));
    assert!(others.contains("run/fs = 10000") && others.contains("run/note ("), "{others}");
}

#[test]
fn exact_what_is_missing_is_named_with_what_is_there() {
    let refused = |file: &str, arrays: Arrays, says: &[&str]| {
        let said = read(&fixture(file), &arrays).unwrap_err().to_string();
        for part in [file].iter().chain(says) {
            assert!(said.contains(part), "no `{part}` in: {said}");
        }
    };
    let (none, p) = (Arrays::default(), || vec!["p".to_owned()]);
    refused(
        "v73.mat",
        arrays(&["q"], ""),
        &["no numeric array `q`", "p (40 x 2)", "correct `arrays` in the manifest"],
    );
    refused("v5.mat", arrays(&["note"], ""), &["no numeric array `note`", "note (1 x 13, text)"]);
    refused("packed.h5", none, &["left (40 x 1), right (40 x 1)", "names = [...]"]);
    refused("packed.h5", arrays(&["left"], ""), &["1 channels", "lists 2"]);
    refused("v5.mat", Arrays { names: p(), rate: Some("p".into()) }, &["sampled at", "expected 10000 Hz"]);
    refused("struct.mat", arrays(&["run.left", "run.fs"], ""), &["run.fs", "1 samples", "same length"]);
    refused("int16.mat", arrays(&["p"], "fs"), &["no numeric array `fs`"]);
}

#[test]
fn message_a_rate_in_the_file_that_is_not_the_manifests() {
    // Nobody said which array is the rate: its name does.
    for (file, names, place) in
        [("v5.mat", ["p"].as_slice(), "fs"), ("struct.mat", &["run.left", "run.right"], "run.fs")]
    {
        let read = |rate_hz: f64| {
            let arrays = arrays(names, "");
            let reading = Reading::default();
            let layout = Layout {
                channels: &CHANNELS,
                full_scale: 20.0,
                rate_hz,
                quiet: 10,
                arrays: &arrays,
                reading: &reading,
            };
            read_record(&fixture(file), layout)
        };
        assert!(read(1e4).is_ok() && read(1e7).is_ok(), "{file}: Hz, or kHz");
        let error = read(2e4).unwrap_err().to_string();
        for part in [file, place, "sampled at 10000 Hz, expected 20000 Hz"] {
            assert!(error.contains(part), "{part}: {error}");
        }
    }
}

/// Damaged files end in an error or in other numbers; never in a panic, and a truncated one never passes for
/// whole.
#[test]
fn exact_damage_is_survived() {
    let folder = std::env::temp_dir().join(format!("rijke-damage-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    for (name, arrays) in files().into_iter().filter(|(name, _)| !name.ends_with("csv")) {
        let (whole, path) = (std::fs::read(fixture(name)).unwrap(), folder.join(name));
        let good = read(&fixture(name), &arrays).unwrap();
        let step = whole.len() / 60 + 1;
        for cut in (0..whole.len()).step_by(step) {
            std::fs::write(&path, &whole[..cut]).unwrap();
            // What comes after the samples may go.
            assert!(
                read(&path, &arrays).map_or(true, |r| r.channels == good.channels),
                "{name} cut at {cut}"
            );
        }
        for (k, turn) in (0..whole.len()).step_by(step).flat_map(|k| [(k, 0xff), (k, 0x01), (k, 0x80)]) {
            let mut spoilt = whole.clone();
            spoilt[k] ^= turn;
            std::fs::write(&path, &spoilt).unwrap();
            let _ = (read(&path, &arrays), inspect(&path));
        }
    }
    std::fs::remove_dir_all(folder).unwrap();
}
