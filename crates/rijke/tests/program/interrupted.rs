//! Ctrl-C leaves no torn file, and the next run goes on where it was.

use crate::{copy, rijke, scratch, short};
use std::{
    collections::BTreeMap,
    fs,
    os::unix::process::ExitStatusExt,
    path::Path,
    process::{Child, Command, Output, Stdio},
    thread,
    time::Duration,
};

/// Folders that a run writes, each with the file that makes it whole.
const WRITTEN: [(&str, &str); 3] =
    [("observations", "observations.toml"), ("base", "flow.json"), ("results", "numbers/claims.json")];

#[test]
fn behaviour_interrupted_runs_leave_nothing_torn_and_go_on() {
    let folder = scratch("interrupted");
    short::record(&folder.join("whole"));
    copy(&folder.join("whole"), &folder.join("torn"));
    let output = rijke(&folder, &["run", "whole", "--one-start"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let (mut interrupted, mut wait) = (0, 20);
    loop {
        let run = program()
            .args(["run", "torn", "--one-start"])
            .current_dir(&folder)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        thread::sleep(Duration::from_millis(wait));
        let _ = Command::new("kill").args(["-INT", &run.id().to_string()]).stderr(Stdio::null()).status();
        let Output { status: ended, stderr, .. } = run.wait_with_output().unwrap();
        for (name, mark) in WRITTEN {
            let written = folder.join("torn").join(name);
            assert!(!written.exists() || written.join(mark).is_file(), "{name} is torn after {wait} ms");
        }
        if ended.success() {
            break;
        }
        let said = String::from_utf8_lossy(&stderr);
        assert_eq!(ended.signal(), Some(2), "ended by the signal, not by an error, after {wait} ms: {said}");
        (interrupted, wait) = (interrupted + 1, wait + wait / 2);
        assert!(interrupted < 30, "the run never ends");
    }
    assert!(interrupted > 0, "the run was too short to be interrupted");
    for (name, _) in WRITTEN {
        let (whole, torn) = (files(&folder.join("whole").join(name)), files(&folder.join("torn").join(name)));
        assert!(whole == torn, "{name} differs: {:?} and {:?}", whole.keys(), torn.keys());
    }
}

/// A command that goes on from what the one before it left in a study, and the folder or file that it writes.
struct Step {
    words: &'static str,
    writes: &'static str,
    /// What to remove before it is tried again.
    made: &'static str,
}

const STEPS: [Step; 5] = [
    Step {
        words: "process STUDY/records --out STUDY/observations",
        writes: "observations",
        made: "observations",
    },
    Step { words: "flow STUDY --out STUDY/base", writes: "base", made: "base" },
    Step { words: "rank STUDY --one-start", writes: "results", made: "results" },
    // Draws into the folder that the ranking left.
    Step { words: "report STUDY", writes: "results", made: "results/index.html" },
    Step {
        words: "predict STUDY --stage prongs --out STUDY/growth.csv",
        writes: "growth.csv",
        made: "growth.csv",
    },
];

/// Commands whose undisturbed run is quick enough to be made for the comparison: OUT is what they write, a
/// name that a figure may have.
const QUICK: [&str; 8] = [
    "new OUT --template quarter-wave",
    "lab --row C3 --repeats 1 --out OUT",
    "predict whole --stage prongs --map X_h,heater --plot OUT",
    "infer EXAMPLES/ducted-flame/n-tau.toml --data EXAMPLES/ducted-flame/modes.csv --fitted OUT",
    "modes NETWORK --plot OUT",
    "modes NETWORK --along OUT",
    "flow --twin --places 0.25 --out OUT",
    "man --out OUT",
];

/// Every command ended by Ctrl-C, later and later: it dies of the signal (130 in a shell), what it left is
/// what the undisturbed run wrote or nothing, and the run that is left alone writes all of it.
#[test]
fn behaviour_every_interrupted_command_leaves_all_or_nothing() {
    let folder = scratch("interrupted-commands");
    short::record(&folder.join("whole"));
    copy(&folder.join("whole"), &folder.join("torn"));
    for Step { words, writes, made } in STEPS {
        assert!(start(&folder, &words.replace("STUDY", "whole")).wait().unwrap().success(), "{words}");
        let whole = files(&folder.join("whole").join(writes));
        assert!(!whole.is_empty(), "{words} writes nothing");
        let [torn, made] = [writes, made].map(|p| folder.join("torn").join(p));
        let interrupted = interrupt(&folder, &words.replace("STUDY", "torn"), [&torn, &made], &whole);
        assert!(interrupted > 0, "{words} was too short to be interrupted");
    }
    for (k, words) in QUICK.iter().enumerate() {
        let (torn, whole) = (format!("torn-{k}.pdf"), format!("whole-{k}.pdf"));
        assert!(start(&folder, &words.replace("OUT", &whole)).wait().unwrap().success(), "{words}");
        let whole = files(&folder.join(whole));
        assert!(!whole.is_empty(), "{words} writes nothing");
        let made = &*folder.join(&torn);
        interrupt(&folder, &words.replace("OUT", &torn), [made, made], &whole);
    }
}

fn start(folder: &Path, words: &str) -> Child {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let words = words.replace("EXAMPLES", &format!("{root}/examples"));
    let words = words.replace("NETWORK", &format!("{root}/fixtures/networks/rijke-tube.toml"));
    let mut command = program();
    command.args(words.split(' ')).current_dir(folder).stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().unwrap()
}

/// The program as a terminal would start it: a shell that runs tests in the background has them, and all that
/// they start, ignore Ctrl-C.
fn program() -> Command {
    let path = env!("CARGO_BIN_EXE_rijke");
    if !cfg!(target_os = "linux") {
        return Command::new(path);
    }
    let mut command = Command::new("env");
    command.args(["--default-signal=INT", path]);
    command
}

/// How often a command could be interrupted before it was quicker than the signal. On a busy machine it may
/// be quicker at once: then what it `made` is removed, and it is tried again.
fn interrupt(folder: &Path, words: &str, [torn, made]: [&Path; 2], whole: &BTreeMap<String, Vec<u8>>) -> u32 {
    let (mut interrupted, mut wait, mut missed) = (0, 0, 0);
    loop {
        let mut run = start(folder, words);
        thread::sleep(Duration::from_millis(wait));
        let _ = Command::new("kill").args(["-INT", &run.id().to_string()]).stderr(Stdio::null()).status();
        let ended = run.wait().unwrap();
        // A lock or a file that is not yet whole has a hidden name; the next run removes it.
        let hidden = |name: &str| name.contains(".partial") || name.ends_with(".lock");
        for (name, bytes) in files(torn).iter().filter(|(name, _)| !hidden(name)) {
            assert!(whole.get(name) == Some(bytes), "{words}: {name} after {wait} ms");
        }
        if ended.success() && interrupted == 0 && missed < 30 {
            missed += 1;
            let _ = fs::remove_dir_all(made).or_else(|_| fs::remove_file(made));
            continue;
        }
        // Ended by the signal after all was in place: what needs --force to replace that says that it is
        // there.
        let was_whole = interrupted > 0 && ended.code() == Some(2) && files(torn) == *whole;
        if ended.success() || was_whole {
            break;
        }
        assert_eq!(ended.signal(), Some(2), "{words}: ended by the signal, not by an error, after {wait} ms");
        (interrupted, wait) = (interrupted + 1, 1.max(2 * wait));
        assert!(interrupted < 19, "{words} never ends");
    }
    assert!(files(torn) == *whole, "{words}: {:?} and {:?}", files(torn).keys(), whole.keys());
    interrupted
}

/// All files below a folder, or the one file; nothing if there is none.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    if let Ok(bytes) = fs::read(folder) {
        found.insert(String::new(), bytes);
    }
    for entry in fs::read_dir(folder).into_iter().flatten() {
        let (path, name) =
            (entry.as_ref().unwrap().path(), entry.unwrap().file_name().into_string().unwrap());
        if path.is_dir() {
            found.extend(files(&path).into_iter().map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
        } else {
            found.insert(name, fs::read(path).unwrap());
        }
    }
    found
}
