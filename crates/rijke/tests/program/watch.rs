//! `rijke watch`: what it ends with is what one run makes, whatever came late, twice, half written or not at
//! all.

use crate::{own_records, rijke, scratch};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;
use std::{fs, thread};

/// The first stage of the study, whose records are three.
fn study(name: &str) -> PathBuf {
    let folder = own_records::study(name);
    let plan = fs::read_to_string(folder.join("study.toml")).unwrap();
    let first: String = plan.split("[[stage]]").take(2).collect::<Vec<_>>().join("[[stage]]");
    fs::write(folder.join("study.toml"), first.split("[cost]").next().unwrap()).unwrap();
    folder
}

/// A program that is ended when the test is.
struct Watching(Child);

impl Watching {
    fn new(folder: &Path, more: &[&str]) -> Self {
        let words = [&["watch", ".", "--calm", "0.3"], more].concat();
        let mut command = Command::new(env!("CARGO_BIN_EXE_rijke"));
        command.args(words).current_dir(folder).stderr(Stdio::null()).stdout(Stdio::null());
        Self(command.spawn().unwrap())
    }
}

impl Drop for Watching {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn status(folder: &Path) -> serde_json::Value {
    let text = fs::read_to_string(folder.join("live/status.json")).unwrap_or_default();
    serde_json::from_str(&text).unwrap_or_default()
}

/// Waits until the status says it; how long that takes is nobody's business here.
fn until(folder: &Path, what: impl Fn(&serde_json::Value) -> bool) -> serde_json::Value {
    loop {
        let status = status(folder);
        if what(&status) {
            return status;
        }
        thread::sleep(Duration::from_millis(20));
    }
}

/// All files below a folder, with their bytes.
fn bytes(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut all = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all.extend(bytes(&path));
        } else {
            all.push((path.display().to_string(), fs::read(&path).unwrap()));
        }
    }
    all.sort();
    all
}

fn same(a: &Path, b: &Path, folder: &str) {
    let [x, y] = [a, b].map(|root| {
        let strip =
            |(name, content): (String, Vec<u8>)| (name.replace(&root.display().to_string(), ""), content);
        bytes(&root.join(folder)).into_iter().map(strip).collect::<Vec<_>>()
    });
    let names = |all: &[(String, Vec<u8>)]| all.iter().map(|f| f.0.clone()).collect::<Vec<_>>();
    assert_eq!(names(&x), names(&y));
    assert!(!x.is_empty());
    // A file of no record may stand among those of one, and is in the list of what was there.
    for (one, two) in x.iter().zip(&y).filter(|(one, _)| !one.0.ends_with("/made_of.json")) {
        assert!(one.1 == two.1, "{} differs", one.0);
    }
}

#[test]
fn exact_a_finished_watch_is_one_run() {
    let (batch, folder) = (study("watch-batch"), study("watch"));
    let done = rijke(&batch, &["run", "."]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let records = folder.join("records");
    let [a, b, c] = ["a.csv", "b.csv", "c.csv"].map(|f| fs::read(records.join(f)).unwrap());
    ["b.csv", "c.csv"].iter().for_each(|f| fs::remove_file(records.join(f)).unwrap());
    // One is there, one is half written, one is late.
    fs::write(records.join("b.csv"), &b[..b.len() / 3]).unwrap();
    fs::write(records.join("stray.csv"), &a).unwrap();
    let watching = Watching::new(&folder, &[]);
    let first = until(&folder, |s| s["whole"] == 1 && s["points"] == 1 && s["awaited"] == 1);
    let why = first["unusable"]["b.csv"].as_str().unwrap_or_default();
    assert!(why.contains("b.csv"), "{first}");
    // Killed in the middle, and started again.
    drop(watching);
    fs::write(records.join("b.csv"), &b).unwrap();
    let mut watching = Watching::new(&folder, &["--until-complete"]);
    until(&folder, |s| s["whole"] == 2 && s["awaited"] == 1);
    fs::write(records.join("c.csv"), &c).unwrap();
    assert!(watching.0.wait().unwrap().success());
    same(&batch, &folder, "observations");
    same(&batch, &folder, "results");
    assert!(folder.join("live/study/index.html").is_file());
}

/// The same numbers at each run.
struct Draws(u64);

impl Draws {
    fn below(&mut self, most: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % most
    }
}

/// Ended thirty times at random, by three signals, while files are late, half written, unreadable, of another
/// rig, and there twice.
#[test]
#[ignore = "two minutes"]
fn behaviour_a_watch_that_was_killed_thirty_times_ends_as_one_run() {
    let (batch, folder) = (study("watch-kills-batch"), study("watch-kills"));
    let done = rijke(&batch, &["run", "."]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let records = folder.join("records");
    let [b, c] = ["b.csv", "c.csv"].map(|f| fs::read(records.join(f)).unwrap());
    let put = |name: &str, content: &[u8]| fs::write(records.join(name), content).unwrap();
    fs::remove_file(records.join("c.csv")).unwrap();
    put("b.csv", &b[..b.len() / 3]);
    let text = String::from_utf8_lossy(&c);
    let narrow: Vec<String> =
        text.lines().map(|l| l.split(',').take(4).collect::<Vec<_>>().join(",")).collect();
    let (mut draws, mut ended, mut finished) = (Draws(17), [0; 3], 0);
    for kill in 0..30 {
        match kill {
            8 => put("b.csv", &b),
            // Twice: the same bytes under another name of the manifest.
            12 => put("c.csv", &b),
            16 => put("c.csv", b"no record at all\n"),
            20 => put("c.csv", narrow.join("\n").as_bytes()),
            23 => put("c.csv", &c),
            _ => {}
        }
        let more: &[&str] = if kill < 23 { &[] } else { &["--until-complete"] };
        let mut watching = Watching::new(&folder, more);
        // Where all is there, before the study is finished.
        thread::sleep(Duration::from_millis(draws.below(if kill < 23 { 2500 } else { 500 })));
        let signal = draws.below(3) as usize;
        let name = ["-KILL", "-TERM", "-INT"][signal];
        let id = watching.0.id().to_string();
        let _ = Command::new("kill").args([name, &id]).stderr(Stdio::null()).status();
        // Whoever starts the tests may have asked that a signal is ignored.
        for _ in 0..100 {
            if watching.0.try_wait().unwrap().is_some() {
                break;
            }
            thread::sleep(Duration::from_millis(20));
        }
        let _ = watching.0.kill();
        if watching.0.wait().unwrap().success() {
            finished += 1;
        } else {
            ended[signal] += 1;
        }
        for (part, mark) in [("observations", "observations.toml"), ("results", "numbers/claims.json")] {
            let part = folder.join(part);
            // Only readings.csv lies there before.
            let begun = part.join("points.csv").exists() || part.ends_with("results") && part.exists();
            assert!(!begun || part.join(mark).is_file(), "{} is torn after kill {kill}", part.display());
        }
    }
    assert!(ended.iter().all(|n| *n > 0) && finished < 5, "{ended:?} {finished}");
    let mut watching = Watching::new(&folder, &["--until-complete"]);
    assert!(watching.0.wait().unwrap().success());
    same(&batch, &folder, "observations");
    same(&batch, &folder, "results");
    let left = |name: &str| name.contains(".partial-") || name.contains(".replaced");
    let names: Vec<String> = bytes(&folder).into_iter().map(|f| f.0).filter(|name| left(name)).collect();
    assert!(names.is_empty(), "{names:?}");
}

/// A file that is a copy of another is told, and no better one is waited for.
#[test]
fn behaviour_a_copy_is_told_and_not_waited_for() {
    let folder = study("watch-copy");
    fs::copy(folder.join("records/b.csv"), folder.join("records/c.csv")).unwrap();
    let mut watching = Watching::new(&folder, &["--until-complete"]);
    let status = until(&folder, |s| s["unusable"]["c.csv"].is_string());
    assert!(
        status["unusable"]["c.csv"].as_str().unwrap().starts_with("holds the same bytes as b.csv"),
        "{status}"
    );
    assert!(watching.0.wait().unwrap().success());
    assert!(folder.join("results/index.html").is_file());
}

/// What cannot count is listed with the reason, and never stops what can.
#[test]
fn message_files_that_do_not_count_say_why() {
    let folder = study("watch-unusable");
    let records = folder.join("records");
    let [b, c] = ["b.csv", "c.csv"].map(|f| fs::read(records.join(f)).unwrap());
    let text = String::from_utf8_lossy(&c);
    let narrow: Vec<String> =
        text.lines().map(|l| l.split(',').take(4).collect::<Vec<_>>().join(",")).collect();
    let _watching = Watching::new(&folder, &[]);
    until(&folder, |s| s["whole"] == 3);
    let counted = |s: &serde_json::Value| s["whole"] == 2 && s["unusable"]["c.csv"].is_string();
    for (content, reason) in [
        (&b[..], "holds the same bytes as b.csv"),
        (&b"no record at all\n"[..], "c.csv"),
        (narrow.join("\n").as_bytes(), "c.csv"),
        (&c[..c.len() / 2], "c.csv"),
    ] {
        fs::write(records.join("c.csv"), content).unwrap();
        let said = |s: &serde_json::Value| s["unusable"]["c.csv"].as_str().unwrap_or_default().to_owned();
        let status = until(&folder, |s| counted(s) && said(s).contains(reason));
        assert_eq!(status["points"], 1, "{status}");
        fs::write(records.join("c.csv"), &c).unwrap();
        until(&folder, |s| s["whole"] == 3 && s["points"] == 2);
    }
}

#[test]
fn behaviour_the_page_is_shown_to_this_machine_only() {
    let folder = study("watch-page");
    fs::remove_file(folder.join("records/c.csv")).unwrap();
    // A free port: the system gives one, and it is given back.
    let port = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let _watching = Watching::new(&folder, &["--serve", &port.to_string()]);
    until(&folder, |s| s["whole"] == 2);
    let ask = |target: &str, host: &str| {
        let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        write!(stream, "GET {target} HTTP/1.1\r\nHost: {host}\r\n\r\n").unwrap();
        let mut text = String::new();
        stream.read_to_string(&mut text).unwrap();
        text
    };
    let here = format!("127.0.0.1:{port}");
    let page = ask("/", &here);
    assert!(page.starts_with("HTTP/1.1 200") && page.contains("2 of 3 files"), "{page}");
    assert!(ask("/status.json", &here).contains("\"awaited\": 1"));
    for (target, host) in [
        ("/../study.toml", &*here),
        ("//etc/passwd", &here),
        ("/", "example.org"),
        ("/no", &here),
        ("/study/../../study.toml", &here),
        ("/%2e%2e/study.toml", &here),
        ("/.seen/observations/points.csv", &here),
    ] {
        assert!(ask(target, host).starts_with("HTTP/1.1 404"), "{target} {host}");
    }
}

#[test]
fn message_a_watch_needs_a_study_of_modes() {
    let folder = scratch("watch-nothing");
    let output = rijke(&folder, &["watch", "."]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && said.contains("holds no study.toml"), "{said}");
}
