//! Ctrl-C leaves no torn file, and the next run goes on where it was.

use crate::{rijke, scratch};
use std::{
    collections::BTreeMap,
    fs,
    os::unix::process::ExitStatusExt,
    path::Path,
    process::{Command, Stdio},
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
const WRITTEN: [(&str, &str); 3] =
    [("observations", "observations.toml"), ("base-flow", "flow.json"), ("results", "numbers/prongs.json")];

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
    let (mut interrupted, mut wait) = (0, 40);
    loop {
        let mut run = Command::new(env!("CARGO_BIN_EXE_rijke"))
            .args(["run", "torn"])
            .current_dir(&folder)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        thread::sleep(Duration::from_millis(wait));
        let _ = Command::new("kill").args(["-INT", &run.id().to_string()]).stderr(Stdio::null()).status();
        let ended = run.wait().unwrap();
        for (name, mark) in WRITTEN {
            let written = folder.join("torn").join(name);
            assert!(!written.exists() || written.join(mark).is_file(), "{name} is torn after {wait} ms");
        }
        if ended.success() {
            break;
        }
        assert_eq!(ended.code(), None, "ended by the signal, not by an error, after {wait} ms");
        (interrupted, wait) = (interrupted + 1, wait + wait / 2);
        assert!(interrupted < 30, "the run never ends");
    }
    assert!(interrupted > 2, "the run was too short to be interrupted");
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
}

const STEPS: [Step; 5] = [
    Step {
        words: "process whole --out torn-observations",
        writes: ["torn-observations", "whole/observations"],
    },
    Step { words: "flow whole --out torn-flow", writes: ["torn-flow", "whole/base-flow"] },
    Step {
        words: "rank whole --out torn-results --flow whole/base-flow",
        writes: ["torn-results/numbers", "whole/results/numbers"],
    },
    // Draws into the folder that the ranking left.
    Step { words: "report torn-results", writes: ["torn-results", "whole/results"] },
    Step { words: "predict MODEL --out torn.csv", writes: ["torn.csv", "whole.csv"] },
];

const MODEL: &str = "whole/results/model.json --flow whole/base-flow --campaign campaign.toml";

/// Every command ended by Ctrl-C, later and later: it dies of the signal (130 in a shell), what it left is what the undisturbed run
/// wrote or nothing, and the run that is left alone writes all of it.
fn each_command(folder: &Path) {
    let start = |words: &str| {
        let words = words.replace("MODEL", MODEL);
        let mut command = Command::new(env!("CARGO_BIN_EXE_rijke"));
        command.args(words.split(' ')).current_dir(folder).stdout(Stdio::null()).stderr(Stdio::null());
        command.spawn().unwrap()
    };
    assert!(start("predict MODEL --out whole.csv").wait().unwrap().success());
    for Step { words, writes: [torn, whole] } in STEPS {
        let (torn, whole) = (folder.join(torn), files(&folder.join(whole)));
        let (mut interrupted, mut wait) = (0, 2);
        loop {
            let mut run = start(words);
            thread::sleep(Duration::from_millis(wait));
            let _ = Command::new("kill").args(["-INT", &run.id().to_string()]).stderr(Stdio::null()).status();
            let ended = run.wait().unwrap();
            for (name, bytes) in files(&torn).iter().filter(|(name, _)| !name.ends_with(".partial")) {
                assert!(whole.get(name) == Some(bytes), "{words}: {name} after {wait} ms");
            }
            if ended.success() {
                break;
            }
            assert_eq!(
                ended.signal(),
                Some(2),
                "{words}: ended by the signal, not by an error, after {wait} ms"
            );
            (interrupted, wait) = (interrupted + 1, 2 * wait);
            assert!(interrupted < 18, "{words} never ends");
        }
        assert!(interrupted > 0, "{words} was too short to be interrupted");
        assert!(files(&torn) == whole, "{words}: {:?} and {:?}", files(&torn).keys(), whole.keys());
    }
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
