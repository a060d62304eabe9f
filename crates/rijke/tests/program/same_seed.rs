//! One seed gives the same bytes, from records to figures, whatever the number of threads.

use crate::{scratch, short};
use std::{collections::BTreeMap, fs, path::Path, process::Command};

/// Runs the steps in a folder with a number of threads.
fn run_steps(folder: &Path, threads: &str, steps: &[&[&str]]) {
    for step in steps {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rijke"));
        let output =
            command.args(*step).current_dir(folder).env("RAYON_NUM_THREADS", threads).output().unwrap();
        assert!(output.status.success(), "{step:?}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

fn run(folder: &Path, threads: &str, seed: &str) -> BTreeMap<String, Vec<u8>> {
    let study = folder.join("study");
    short::paper(&study);
    let plan = fs::read_to_string(study.join("study.toml")).unwrap();
    fs::write(
        study.join("study.toml"),
        plan.replacen("[base.states]\npoints = { where = { Q_h = { above = 0 } } }", "", 1),
    )
    .unwrap();
    let steps: [&[&str]; 4] = [
        &["lab", "--out", "study/records", "--row", "C3", "--repeats", "2", "--seed", seed],
        &["process", "study/records", "--out", "study/observations"],
        &["rank", "study", "--until", "prongs", "--one-start"],
        &["report", "study"],
    ];
    run_steps(folder, threads, &steps);
    let mut files = BTreeMap::new();
    collect(folder, folder, &mut files);
    files
}

fn collect(root: &Path, folder: &Path, files: &mut BTreeMap<String, Vec<u8>>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(root, &path, files);
        } else {
            let name = path.strip_prefix(root).unwrap().to_string_lossy().into_owned();
            files.insert(name, fs::read(&path).unwrap());
        }
    }
}

#[test]
fn exact_same_seed_same_bytes_for_one_and_two_threads() {
    let one = run(&scratch("one-thread"), "1", "3");
    let two = run(&scratch("two-threads"), "2", "3");
    let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&one), names(&two));
    for (name, content) in &one {
        assert!(two[name] == *content, "{name} differs");
    }
    for file in [
        "study/results/index.html",
        "study/results/figures/figure-3.svg",
        "study/results/figures/figure-4.svg",
    ] {
        assert!(one.contains_key(file), "{file} is missing");
    }
    // The comparison can fail: another seed gives other records.
    let other = run(&scratch("other-seed"), "2", "4");
    assert!(other["study/records/C3-E/ping-00.wav"] != one["study/records/C3-E/ping-00.wav"]);
    assert!(other["study/results/figures/figure-4.svg"] != one["study/results/figures/figure-4.svg"]);
}

#[test]
fn oracle_a_virtual_rig_gives_the_observations_of_its_files() {
    let folder = scratch("without-files");
    run_steps(
        &folder,
        "2",
        &[
            &["lab", "--out", "rig", "--rows", "C3,H7", "--repeats", "2", "--seed", "5"],
            &["process", "rig", "--out", "files"],
        ],
    );
    run_steps(
        &folder,
        "1",
        &[&[
            "process",
            "--virtual-rig",
            "--rows",
            "C3,H7",
            "--repeats",
            "2",
            "--seed",
            "5",
            "--out",
            "memory",
        ]],
    );
    let (mut files, mut memory) = (BTreeMap::new(), BTreeMap::new());
    collect(&folder.join("files"), &folder.join("files"), &mut files);
    collect(&folder.join("memory"), &folder.join("memory"), &mut memory);
    // Of nothing on disk.
    assert!(files.remove("made_of.json").is_some() && !memory.contains_key("made_of.json"));
    assert!(files.contains_key("clicks.csv") && files == memory);
}
