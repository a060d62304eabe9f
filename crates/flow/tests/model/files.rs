//! Records on disk: what is written is read back, and a wrong file says which, where and why.

use super::pipe;
use rijke_flow::FlowError;
use rijke_flow::TubeRig;
use rijke_flow::assimilate::{Records, Twin, TwinOptions, staircase};
use rijke_numerics::Streams;
use rijke_rig::DataKind;
use std::path::PathBuf;

/// A folder of its own under the build's temporary folder.
fn folder(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).unwrap();
    path
}

fn records() -> Records {
    let options = TwinOptions { powers: staircase(&[0.0, 30.0], 5), ..TwinOptions::default() };
    let twin = Twin::new(&pipe(0.25, 1), &options, &Streams::new(1), None).unwrap();
    Records { kind: DataKind::Virtual, rig: TubeRig::juniper_yoko_2022(), runs: vec![(0.25, twin.record)] }
}

#[test]
fn exact_records_survive_the_disk() {
    let (path, written) = (folder("flow-round-trip"), records());
    written.write(&path).unwrap();
    let read = Records::read(&path).unwrap();
    assert_eq!(read.runs, written.runs);
    assert_eq!((read.kind, read.rig), (written.kind, written.rig));
}

#[test]
fn exact_wrong_files_are_named_with_place_and_reason() {
    let path = folder("flow-wrong");
    records().write(&path).unwrap();
    let samples = path.join("heater-250mm.csv");
    let good = std::fs::read_to_string(&samples).unwrap();
    let broken = |text: &str| {
        std::fs::write(&samples, text).unwrap();
        Records::read(&path).unwrap_err()
    };
    let word = broken(&good.replacen("\n0,", "\nx,", 1));
    assert!(
        word.to_string().contains("heater-250mm.csv: line 2, column power_w: `x` is not a number"),
        "{word}"
    );
    let hot = broken(&good.replacen("\n0,", "\n7,", 1));
    assert!(
        matches!(&hot, FlowError::InRun { source, .. } if matches!(**source, FlowError::NotCalibrated { .. })),
        "{hot}"
    );
    let cold = broken(&good.replacen("\n0,29", "\n0,18", 1)).to_string();
    assert!(cold.contains("heater-250mm.csv: line 2: the ambient temperature is 18"), "{cold}");
    let renamed = broken(&good.replacen("arrival_3_s", "arrival_9_s", 1));
    assert!(renamed.to_string().contains("flow.toml asks for"), "{renamed}");
    let short = broken(&good.lines().take(3).collect::<Vec<_>>().join("\n"));
    assert!(short.to_string().contains("16 readings cannot fix 18 unknowns"), "{short}");
    std::fs::remove_file(&samples).unwrap();
    assert!(matches!(Records::read(&path), Err(FlowError::File { .. })));
    let manifest = path.join("flow.toml");
    let text = std::fs::read_to_string(&manifest).unwrap();
    std::fs::write(&manifest, text.replacen("power_sd", "power_sb", 1)).unwrap();
    let key = Records::read(&path).unwrap_err().to_string();
    assert!(key.contains("flow.toml") && key.contains("power_sb"), "{key}");
}
