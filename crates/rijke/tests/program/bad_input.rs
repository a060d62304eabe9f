//! Bad input: one message that names file, place and remedy, exit status 2, nothing written.

mod commands;
mod models;
pub(crate) mod observations;
mod recordings;
mod slips;

use crate::{copy, records, rijke, scratch};
use std::{fs, path::Path};

/// How a folder is spoilt, which command must refuse it, and what its message must say.
struct Case {
    name: &'static str,
    spoil: fn(&Path),
    command: &'static str,
    /// File, place, remedy.
    says: [&'static str; 3],
}

const fn case(name: &'static str, spoil: fn(&Path), command: &'static str, says: [&'static str; 3]) -> Case {
    Case { name, spoil, command, says }
}

/// Replaces text in a file.
fn edit(folder: &Path, file: &str, from: &str, to: &str) {
    let path = folder.join(file);
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains(from), "{file} has no `{from}`:\n{text}");
    fs::write(path, text.replacen(from, to, 1)).unwrap();
}

#[test]
fn message_bad_input_is_refused_with_file_place_and_remedy() {
    type Table = (fn(&Path), &'static [Case]);
    let tables: [Table; 5] = [
        (|d| records::write(&d.join("records")), &recordings::CASES),
        (observations::write, &observations::CASES),
        (models::write, &models::CASES),
        (|_| (), &commands::CASES),
        (slips::write, &slips::CASES),
    ];
    let (mut found, mut count) = (Vec::new(), 0);
    for (prepare, cases) in tables {
        let clean = scratch("bad-input-clean");
        prepare(&clean);
        for Case { name, spoil, command, says } in cases {
            let folder = scratch("bad-input");
            copy(&clean, &folder);
            spoil(&folder);
            let words: Vec<&str> = command.split(' ').collect();
            found.extend(faults(&folder, &words, says).map(|fault| format!("{name}: {fault}")));
            count += 1;
        }
    }
    assert!(found.is_empty(), "{} of {count}\n{}", found.len(), found.join("\n\n"));
    assert!(count >= 60, "{count} kinds");
}

#[test]
fn exact_good_records_pass_and_clipping_is_told() {
    let folder = scratch("good-records");
    records::write(&folder.join("records"));
    let output = rijke(&folder, &["check", "records"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(text.contains("2 operating points on 1 day: 4 pings at 10000 Hz, 4 clicks"), "{text}");
    assert!(!text.contains("clipped"), "{text}");

    let path = folder.join("records/C3-E/ping-1.wav");
    let mut bytes = fs::read(&path).unwrap();
    let end = bytes.len();
    bytes[end - 3..].copy_from_slice(&[0xff, 0xff, 0x7f]);
    fs::write(&path, bytes).unwrap();
    let text = String::from_utf8(rijke(&folder, &["check", "records"]).stdout).unwrap();
    assert!(text.contains("clipped: C3-E/ping-1.wav (1 sample at full scale)"), "{text}");
}

/// What is wrong with how a command refuses its input: it must end with 2, say all that it must in one
/// message, and leave the folder as it was.
fn faults(folder: &Path, arguments: &[&str], says: &[&str]) -> Option<String> {
    let before = listing(folder);
    let output = rijke(folder, arguments);
    let text = String::from_utf8(output.stderr).unwrap();
    let mut faults: Vec<_> =
        says.iter().filter(|part| !text.contains(**part)).map(|p| format!("no `{p}`")).collect();
    if output.status.code() != Some(2) {
        faults.push(format!("{}", output.status));
    }
    if text.lines().filter(|line| line.starts_with("error:")).count() != 1 || text.contains("panicked") {
        faults.push("not one message".to_owned());
    }
    if listing(folder) != before {
        faults.push("files were left behind".to_owned());
    }
    (!faults.is_empty()).then(|| format!("{} in\n{text}", faults.join(", ")))
}

/// All paths under a folder.
fn listing(folder: &Path) -> Vec<std::path::PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(listing(&path));
        }
        found.push(path);
    }
    found.sort();
    found
}
