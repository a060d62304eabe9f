//! `cargo xtask reproduce` that is ended from outside leaves no program behind, and the next run completes.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    thread,
    time::{Duration, Instant},
};

/// The quickest table of the paper with all stages of the cold experiments.
fn start(folder: &Path, options: &[&str]) -> Child {
    let mut command = Command::new("env");
    // A test that runs in the background has SIGINT ignored, and all that it starts.
    command.args(["--default-signal=INT", env!("CARGO_BIN_EXE_xtask")]);
    command.args(["reproduce", "--quick", "--only", "prongs", "--into"]).arg(folder).args(options);
    // Beside the folder, which holds only what a run makes.
    let said = fs::File::options().create(true).append(true).open(folder.with_extension("said")).unwrap();
    command.stdin(Stdio::null()).stdout(said.try_clone().unwrap()).stderr(said).spawn().unwrap()
}

/// Runs to the end; what a run that fails has said is shown.
fn complete(folder: &Path) {
    let ended = start(folder, &[]).wait().unwrap();
    let said = fs::read_to_string(folder.with_extension("said")).unwrap();
    assert!(ended.success(), "{ended}: {said}");
}

/// Programs `rijke` that work in a folder.
fn left(folder: &Path) -> Vec<String> {
    let working = |process: fs::DirEntry| {
        let there = fs::read_link(process.path().join("cwd")).ok()? == folder;
        let words = fs::read(process.path().join("cmdline")).ok()?;
        let words = String::from_utf8_lossy(&words).replace('\0', " ");
        (there && words.contains("rijke")).then_some(words)
    };
    fs::read_dir("/proc").unwrap().flatten().filter_map(working).collect()
}

/// Every number and table, by path; times and hidden marks are left out.
fn made(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap().flatten() {
        let (path, name) = (entry.path(), entry.file_name());
        if path.is_dir() {
            found.extend(made(&path));
        } else if !name.to_string_lossy().starts_with('.') && name != "manifest.json" {
            found.insert(path.clone(), fs::read(path).unwrap());
        }
    }
    found
}

fn relative(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    made(folder).into_iter().map(|(p, b)| (p.strip_prefix(folder).unwrap().to_owned(), b)).collect()
}

/// An empty folder.
fn folder(name: &str, part: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{part}"));
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).unwrap();
    path
}

/// An undisturbed run into a folder: what it made, and how long it took.
fn whole(name: &str) -> (BTreeMap<PathBuf, Vec<u8>>, Duration) {
    let made = |part: &str| {
        let folder = folder(name, part);
        let begin = Instant::now();
        complete(&folder);
        (relative(&folder), begin.elapsed())
    };
    // Twice, because in the first one cargo may build.
    let ((first, _), (again, time)) = (made("whole"), made("again"));
    assert!(first == again && again.len() > 5);
    (again, time)
}

/// Ends a run with a signal after some time.
fn end(folder: &Path, signal: &str, after: Duration) {
    // All stages from the beginning, so that every moment of a run is met.
    let run = start(folder, &["--fresh"]);
    thread::sleep(after);
    let _ = Command::new("kill").args([&format!("-{signal}"), &run.id().to_string()]).status();
    let ended = { run }.wait().unwrap();
    if signal != "KILL" {
        assert_eq!(left(folder), [""; 0], "SIG{signal} after {after:?}: {ended}");
        return;
    }
    // Nobody can wait for it: it ends by itself, at once.
    let patience = Instant::now();
    while !left(folder).is_empty() {
        assert!(patience.elapsed() < Duration::from_secs(2), "left after {after:?}: {:?}", left(folder));
    }
}

#[test]
fn behaviour_a_run_that_is_ended_leaves_no_program_and_goes_on() {
    let (whole, time) = whole("ended");
    let torn = folder("ended", "torn");
    for signal in ["TERM", "INT", "KILL"] {
        end(&torn, signal, Duration::ZERO);
        end(&torn, signal, time / 2);
    }
    complete(&torn);
    assert!(relative(&torn) == whole);
}

#[test]
#[ignore = "long: ends 90 runs, three minutes"]
fn behaviour_a_run_that_is_ended_at_many_moments_leaves_no_program() {
    const MOMENTS: u32 = 30;
    let (whole, time) = whole("ended-long");
    for signal in ["TERM", "INT", "KILL"] {
        let torn = folder("ended-long", signal);
        for moment in 0..MOMENTS {
            end(&torn, signal, time * moment / MOMENTS);
        }
        complete(&torn);
        assert!(relative(&torn) == whole, "after SIG{signal}");
    }
}

#[test]
fn behaviour_a_second_run_into_one_folder_is_refused() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("reproduce-twice");
    fs::create_dir_all(folder.join("virtual-rig")).unwrap();
    let held = fs::File::create(folder.join("virtual-rig/.lock")).unwrap();
    held.lock().unwrap();
    let mut second = Command::new(env!("CARGO_BIN_EXE_xtask"));
    let second = second.args(["reproduce", "--quick", "--into"]).arg(&folder).output().unwrap();
    let said = String::from_utf8_lossy(&second.stderr);
    assert!(!second.status.success() && said.contains("is at work there; wait"), "{said}");
}
