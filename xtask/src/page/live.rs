//! The page of `rijke watch --serve`, opened while a record arrives: it must show what came without being
//! asked, and no script may fail.

use super::browser::{between, command, told};
use crate::child::Ending;
use crate::reproduce::copy_study;
use crate::workspace::{at, built, succeed, write};
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use std::{fs, path::Path, thread};

const HARNESS: &str = include_str!("live.html");

/// The record that comes while the page is open.
const LATE: &str = "C3-50/ping-01.wav";

/// How long the watch may take to train for the first time.
const PATIENCE: Duration = Duration::from_secs(300);

/// What is wrong with it, if anything.
pub(super) fn faults(browser: &str, scratch: &Path) -> Result<Vec<String>, String> {
    let study = scratch.join("watched");
    // Of an earlier run.
    let _ = fs::remove_dir_all(&study);
    fs::create_dir_all(&study).map_err(at(&study))?;
    copy_study(&study)?;
    let records = study.join("records");
    let words = ["lab", "--row", "C3", "--repeats", "2", "--quiet", "--out"];
    succeed(Command::new(built()?).args(words).arg(&records))?;
    let (late, held) = (records.join(LATE), study.join("held.wav"));
    let moved = |from: &Path, to: &Path| fs::rename(from, to).map_err(at(from));
    moved(&late, &held)?;
    let (_watching, address) = watch(&study)?;
    let status = || -> Value {
        let text = fs::read_to_string(study.join("live/status.json")).unwrap_or_default();
        serde_json::from_str(&text).unwrap_or_default()
    };
    let begun = Instant::now();
    while !(status()["next"].as_array().is_some_and(|n| !n.is_empty())
        && study.join("live/next.svg").is_file())
    {
        if begun.elapsed() > PATIENCE {
            return Err(format!("`rijke watch` shows nothing to measure next: {}", status()));
        }
        thread::sleep(Duration::from_millis(100));
    }
    // Of the same origin as the page, so that it may look into it.
    let harness = study.join("live/harness.html");
    write(&harness, HARNESS.replace("@LATE@", LATE))?;
    let mut opened = command(browser, scratch);
    // Time passes as the page asks for it, and stands still while it waits for the server: minutes of it are
    // seconds here.
    opened.args(["--virtual-time-budget=600000", "--dump-dom"]).arg(format!("{address}harness.html"));
    let opened = opened.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let opened = opened.map_err(|e| format!("cannot start {browser}: {e}"))?;
    // The harness asks for this file of the server's folder once it has seen the page as it was.
    thread::sleep(Duration::from_secs(3));
    moved(&held, &late)?;
    let output = opened.wait_with_output().map_err(|e| e.to_string())?;
    let (dom, said) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let found =
        between(&dom).ok_or_else(|| format!("{browser} did not load the page of `rijke watch`\n{said}"))?;
    let found: Value = serde_json::from_str(&found).map_err(|e| format!("rijke watch: {e}"))?;
    let console = said.lines().filter(|l| l.contains("CONSOLE")).map(String::from).collect();
    Ok(told("rijke watch", &found, console))
}

/// Starts it; the address of its page.
fn watch(study: &Path) -> Result<(Ending, String), String> {
    let mut command = Command::new(built()?);
    command.arg("watch").arg(study).args(["--serve", "0", "--one-start", "--calm", "100000"]);
    let child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn();
    let mut watching = Ending(child.map_err(|e| format!("cannot start `rijke watch`: {e}"))?);
    let said = watching.0.stderr.take().ok_or("`rijke watch` says nothing")?;
    let mut lines = BufReader::new(said).lines().map_while(Result::ok);
    let address = lines.find_map(|line| line.strip_prefix("page: ").map(str::to_owned));
    let address = address.ok_or("`rijke watch` does not say where its page is")?;
    // What it says must be read, or it waits for a reader.
    thread::spawn(move || lines.for_each(drop));
    Ok((watching, address))
}
