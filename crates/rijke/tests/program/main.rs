//! The program as a user meets it: exit status, messages, and what is left on disk.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may fail by panicking")]

mod at_once;
mod bad_input;
mod base_states;
mod bench;
mod book;
mod calibration_clicks;
mod campaign_forms;
mod chain;
mod compared;
mod coverage_study;
mod design_few;
mod design_figure;
mod design_study;
mod ducted_flame;
mod early;
mod excited;
mod flow_over_time;
mod foresight;
mod formats;
mod help;
#[cfg(unix)]
mod interrupted;
mod json;
mod measured;
mod modes;
mod new_rig;
mod next;
mod own_microphones;
mod own_records;
mod plots;
mod pressures;
mod profiles;
mod ramp_study;
mod records;
mod response;
mod responses;
mod same_seed;
mod search;
mod short;
mod stale;
mod studies;
mod sweep_study;
mod two_rates;
mod watch;

use std::{
    path::{Path, PathBuf},
    process::{Command, Output},
};

/// Runs `rijke` in a folder.
fn rijke(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_rijke")).args(arguments).current_dir(folder).output().unwrap()
}

/// The folder of examples, or one of them.
fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples").join(name)
}

/// Copies a folder with all that it holds, but for the results of somebody who ran the study there.
fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap).filter(|e| e.file_name() != "results") {
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            std::fs::copy(entry.path(), target).unwrap();
        }
    }
}

/// An empty folder for one test.
fn scratch(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).unwrap();
    path
}
