//! Ctrl-C leaves no torn file, and the next run goes on where it was.

use crate::{rijke, scratch};
use std::{
    collections::BTreeMap,
    fs,
    os::unix::process::ExitStatusExt,
    path::Path,
    process::{Child, Command, Output, Stdio},
    thread,
    time::Duration,
};

const CAMPAIGN: &str = "name = \"short\"
[[row]]
id = \"P\"
heater = false
thermocouples = false
power_w = 0.0
repeats = 2
empty_tube = true
positions_cm = [25, 45, 60, 75]
[[row]]
id = \"C\"
heater = true
thermocouples = false
power_w = 0.0
repeats = 2
positions_cm = [25, 45, 60, 75]
[[row]]
id = \"T\"
heater = true
thermocouples = true
power_w = 0.0
repeats = 2
positions_cm = [25, 45, 60, 75]
[[row]]
id = \"H50\"
heater = true
thermocouples = true
power_w = 50.0
repeats = 2
positions_cm = [25, 45, 60, 75]
";

/// Folders that a run writes, each with the file that makes it whole.
const WRITTEN: [(&str, &str); 4] = [
    ("observations", "observations.toml"),
    ("base-flow", "flow.json"),
    ("results", "numbers/prongs.json"),
    ("results/priors", "index.html"),
];

#[test]
fn exact_interrupted_runs_leave_nothing_torn_and_go_on() {
    let folder = scratch("interrupted");
    fs::write(folder.join("campaign.toml"), CAMPAIGN).unwrap();
    let done = |words: &str| {
        let output = rijke(&folder, &words.split(' ').collect::<Vec<_>>());
        assert!(output.status.success(), "{words}: {}", String::from_utf8_lossy(&output.stderr));
    };
    done("lab --campaign campaign.toml --out whole");
    done("lab --campaign campaign.toml --out torn");
    done("run whole");
    each_command(&folder);
    let (mut interrupted, mut wait) = (0, 20);
    loop {
        let run = program()
            .args(["run", "torn"])
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

/// A command and what it writes beside `whole`, which is what it writes undisturbed.
struct Step {
    words: &'static str,
    /// File or folder written, and the same from the undisturbed run.
    writes: [&'static str; 2],
    /// What to remove before it is tried again.
    made: &'static str,
}

const STEPS: [Step; 5] = [
    Step {
        words: "process whole --out torn-observations",
        writes: ["torn-observations", "whole/observations"],
        made: "torn-observations",
    },
    Step { words: "flow whole --out torn-flow", writes: ["torn-flow", "whole/base-flow"], made: "torn-flow" },
    Step {
        words: "rank whole --out torn-results --flow whole/base-flow",
        writes: ["torn-results/numbers", "whole/results/numbers"],
        made: "torn-results",
    },
    // Draws into the folder that the ranking left.
    Step {
        words: "report torn-results",
        writes: ["torn-results", "whole/results"],
        made: "torn-results/index.html",
    },
    Step { words: "predict MODEL --out torn.csv", writes: ["torn.csv", "whole.csv"], made: "torn.csv" },
];

const MODEL: &str = "whole/results/model.json --flow whole/base-flow --campaign campaign.toml";

/// Commands whose undisturbed run is quick enough to be made for the comparison: OUT is what they write.
const QUICK: [&str; 11] = [
    "new OUT",
    "lab --campaign campaign.toml --row P --repeats 1 --out OUT",
    "check whole --plots OUT",
    "check-model whole --sets 0 --record OUT",
    "check-model whole --sets 0 --draws OUT",
    "infer EXAMPLES/ducted-flame/n-tau.toml --data EXAMPLES/ducted-flame/modes.csv --fitted OUT",
    "modes NETWORK --plot OUT",
    "modes NETWORK --along OUT",
    "sensitivity MODEL --plot OUT",
    "sensitivity MODEL --along OUT",
    "man --out OUT",
];

/// Every command ended by Ctrl-C, later and later: it dies of the signal (130 in a shell), what it left is what the undisturbed run
/// wrote or nothing, and the run that is left alone writes all of it.
fn each_command(folder: &Path) {
    assert!(start(folder, "predict MODEL --out whole.csv").wait().unwrap().success());
    for Step { words, writes: [torn, whole], made } in STEPS {
        let mut whole = files(&folder.join(whole));
        // Of `rijke run` alone.
        whole.retain(|name, _| !name.starts_with("priors/"));
        let interrupted =
            interrupt(folder, words, [torn, made].map(|p| folder.join(p)).each_ref().map(|p| &**p), &whole);
        assert!(interrupted > 0, "{words} was too short to be interrupted");
    }
    for (k, words) in QUICK.iter().enumerate() {
        let (torn, whole) = (format!("torn-{k}"), format!("whole-{k}"));
        assert!(start(folder, &words.replace("OUT", &whole)).wait().unwrap().success(), "{words}");
        let whole = files(&folder.join(whole));
        assert!(!whole.is_empty(), "{words} writes nothing");
        let made = &*folder.join(&torn);
        interrupt(folder, &words.replace("OUT", &torn), [made, made], &whole);
    }
}

fn start(folder: &Path, words: &str) -> Child {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let words = words.replace("MODEL", MODEL).replace("EXAMPLES", &format!("{root}/examples"));
    let words = words.replace("NETWORK", &format!("{root}/fixtures/networks/rijke-tube.toml"));
    let mut command = program();
    command.args(words.split(' ')).current_dir(folder).stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().unwrap()
}

/// The program as a terminal would start it: a shell that runs tests in the background has them, and all that they start, ignore
/// Ctrl-C.
fn program() -> Command {
    let path = env!("CARGO_BIN_EXE_rijke");
    if !cfg!(target_os = "linux") {
        return Command::new(path);
    }
    let mut command = Command::new("env");
    command.args(["--default-signal=INT", path]);
    command
}

/// How often a command could be interrupted before it was quicker than the signal. On a busy machine it may be quicker at once:
/// then what it `made` is removed, and it is tried again.
fn interrupt(folder: &Path, words: &str, [torn, made]: [&Path; 2], whole: &BTreeMap<String, Vec<u8>>) -> u32 {
    let (mut interrupted, mut wait, mut missed) = (0, 0, 0);
    loop {
        let mut run = start(folder, words);
        thread::sleep(Duration::from_millis(wait));
        let _ = Command::new("kill").args(["-INT", &run.id().to_string()]).stderr(Stdio::null()).status();
        let ended = run.wait().unwrap();
        for (name, bytes) in files(torn).iter().filter(|(name, _)| !name.contains(".partial")) {
            assert!(whole.get(name) == Some(bytes), "{words}: {name} after {wait} ms");
        }
        if ended.success() && interrupted == 0 && missed < 30 {
            missed += 1;
            let _ = fs::remove_dir_all(made).or_else(|_| fs::remove_file(made));
            continue;
        }
        // Ended by the signal after all was in place: what needs --force to replace that says that it is there.
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
