//! `cargo xtask watch`: how fast `rijke watch` is beside a campaign of the size of the paper's, and whether
//! it keeps up.

use crate::child::{Ending, peak_memory_mib};
use crate::reproduce::copy_study;
use crate::workspace::{Outcome, at, built, files, program, root, succeed, write};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use std::{fs, thread};

const HEAD: &str = "<!-- The table is written by `cargo xtask watch`. -->
| what | files | median, s | 95 %, s | longest, s | largest memory, MiB |
|---|---|---|---|---|---|
";

/// Pings and clicks of each point: 7000 records and 32 of calibration.
const REPEATS: &str = "20";
/// How many of them arrive while one measures the time.
const REPLAYED: usize = 400;
/// Files a second: the rig makes a ping of two seconds and waits for three, a file in five seconds; twenty
/// times that is four a second.
const RATE: f64 = 4.0;
/// How long to wait for what never comes.
const PATIENCE: Duration = Duration::from_secs(7200);

/// The watch and its folder.
struct Watch {
    child: Ending,
    study: PathBuf,
}

impl Watch {
    fn begin(study: &Path) -> Result<Self, String> {
        // Of an earlier one.
        let _ = fs::remove_dir_all(study.join("live"));
        let mut command = Command::new(program());
        command.arg("watch").arg(study).args(["--one-start", "--calm", "100000", "--quiet"]);
        let child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn();
        let child = child.map_err(|e| format!("cannot start `rijke watch`: {e}"))?;
        Ok(Self { child: Ending(child), study: study.to_owned() })
    }

    fn status(&self) -> Value {
        let text = fs::read_to_string(self.study.join("live/status.json")).unwrap_or_default();
        serde_json::from_str(&text).unwrap_or_default()
    }

    /// Waits until the status says it.
    fn until(&self, what: &str, is: impl Fn(&Value) -> bool) -> Result<Value, String> {
        let begun = Instant::now();
        loop {
            let status = self.status();
            if is(&status) {
                return Ok(status);
            }
            if begun.elapsed() > PATIENCE {
                return Err(format!("{what} never came: {}", status["said"]));
            }
            thread::sleep(Duration::from_millis(5));
        }
    }

    fn memory(&self) -> u64 {
        peak_memory_mib(self.child.0.id()).unwrap_or(0)
    }

    fn whole(&self) -> usize {
        self.status()["whole"].as_u64().unwrap_or(0) as usize
    }
}

pub(crate) fn run(all: bool) -> Outcome {
    built()?;
    let study = root().join("target/watch");
    let (records, away) = (study.join("records"), study.join("away"));
    // An interrupted run leaves records elsewhere.
    if away.exists() || !records.join("manifest.toml").is_file() {
        let _ = fs::remove_dir_all(&study);
        fs::create_dir_all(&study).map_err(at(&study))?;
        succeed(
            Command::new(program()).args(["lab", "--quiet", "--repeats", REPEATS, "--out"]).arg(&records),
        )?;
    }
    for made in ["observations", "base", "live"] {
        let _ = fs::remove_dir_all(study.join(made));
    }
    copy_study(&study)?;
    let mut text = String::from(HEAD);
    let rows = if all {
        replay(&study, &records, usize::MAX)?
    } else {
        let few = of_few(&study, &records)?;
        few.into_iter().chain(replay(&study, &records, REPLAYED)?).collect()
    };
    for (what, files, mut seconds, memory) in rows {
        seconds.sort_by(f64::total_cmp);
        let at = |share: f64| seconds[((seconds.len() - 1) as f64 * share).round() as usize];
        let row =
            format!("| {what} | {files} | {:.2} | {:.2} | {:.2} | {memory} |", at(0.5), at(0.95), at(1.0));
        println!("{row}");
        let _ = writeln!(text, "{row}");
    }
    // Whatever is left there is empty.
    let _ = fs::remove_dir_all(&away);
    let path = root().join("target/watch.md");
    write(&path, text)
}

/// What was measured, how many files there are, the seconds that each took, and the largest memory.
type Row = (String, usize, Vec<f64>, u64);

/// One repeat of every point, trained; then further files one by one, with nothing else to do and while
/// models are trained.
fn of_few(study: &Path, records: &Path) -> Result<Vec<Row>, String> {
    let away = study.join("away");
    // The flow of the hot points must be known before they count.
    succeed(
        Command::new(program())
            .args(["process", "--quiet", "--out"])
            .arg(study.join("observations"))
            .arg(study),
    )?;
    succeed(Command::new(program()).args(["flow", "--quiet", "--out"]).arg(study.join("base")).arg(study))?;
    let all = recorded(records)?;
    let later: Vec<&String> = all.iter().filter(|f| !f.contains("-00.") && !f.starts_with("calib")).collect();
    for file in &later {
        moved(&records.join(file), &away.join(file))?;
    }
    let watch = Watch::begin(study)?;
    watch.until("the first training", |s| s["said"].as_str().is_some_and(|s| s.contains("trained on")))?;
    let mut rows = Vec::new();
    for kind in ["ping", "click"] {
        let mut seconds = Vec::new();
        for file in later.iter().filter(|f| f.contains(kind)).step_by(331) {
            let before = watch.whole();
            let begun = Instant::now();
            moved(&away.join(file), &records.join(file))?;
            watch.until(file, |s| s["whole"].as_u64().unwrap_or(0) as usize > before)?;
            seconds.push(begun.elapsed().as_secs_f64());
            thread::sleep(Duration::from_millis(500));
        }
        rows.push((format!("a {kind}, 175 points trained"), watch.whole(), seconds, watch.memory()));
    }
    drop(watch);
    for file in later.iter().filter(|f| away.join(f).is_file()) {
        moved(&away.join(file), &records.join(file))?;
    }
    Ok(rows)
}

/// `count` of the records, or all, come at the rate of the replay; the others are there before.
fn replay(study: &Path, records: &Path, count: usize) -> Result<Vec<Row>, String> {
    let away = study.join("away");
    let all: Vec<String> = recorded(records)?.into_iter().filter(|f| !f.starts_with("calib")).collect();
    let count = count.min(all.len());
    let coming: Vec<&String> = all.iter().step_by(all.len() / count).take(count).collect();
    for file in &coming {
        moved(&records.join(file), &away.join(file))?;
    }
    let watch = Watch::begin(study)?;
    // Where all come, those of calibration alone are there.
    let looked = if count == all.len() { "whole" } else { "points" };
    watch.until("the first look", |s| s[looked].as_u64().unwrap_or(0) > 0)?;
    let (first, begun) = (watch.whole(), Instant::now());
    let (mut sent, mut seen) = (Vec::new(), Vec::new());
    let (mut middle, mut behind) = (0, 0);
    while seen.len() < coming.len() {
        let now = begun.elapsed().as_secs_f64();
        while sent.len() < coming.len() && now >= sent.len() as f64 / RATE {
            let file = coming[sent.len()];
            moved(&away.join(file), &records.join(file))?;
            sent.push(begun.elapsed().as_secs_f64());
        }
        while seen.len() < sent.len() && seen.len() < watch.whole() - first {
            seen.push(begun.elapsed().as_secs_f64() - sent[seen.len()]);
        }
        behind = behind.max(sent.len() - seen.len());
        if seen.len() < coming.len() / 2 {
            middle = watch.memory();
        }
        if begun.elapsed() > PATIENCE {
            return Err("the replay never ended".to_owned());
        }
        thread::sleep(Duration::from_millis(5));
    }
    let what =
        format!("replay, {RATE} files a second: at most {behind} behind, {middle} MiB after half of them");
    Ok(vec![(what, watch.whole(), seen, watch.memory())])
}

fn moved(from: &Path, to: &Path) -> Outcome {
    let made = to.parent().map_or(Ok(()), fs::create_dir_all);
    made.and_then(|()| fs::rename(from, to)).map_err(at(from))
}

/// The records below a folder, in order.
fn recorded(folder: &Path) -> Result<Vec<String>, String> {
    let all = files(folder).map_err(at(folder))?.into_iter().map(|f| f.to_string_lossy().into_owned());
    Ok(all.filter(|name| name.ends_with(".wav")).collect())
}
