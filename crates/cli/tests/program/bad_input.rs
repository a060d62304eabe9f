//! Bad input: one message that names file, place and remedy, exit status 2, nothing written.

use crate::{records, rijke, scratch};
use std::{fs, path::Path};

/// How a folder of records is spoilt, and what the message must say.
struct Case {
    name: &'static str,
    spoil: fn(&Path),
    /// File, place, remedy.
    says: [&'static str; 3],
}

const fn case(name: &'static str, spoil: fn(&Path), says: [&'static str; 3]) -> Case {
    Case { name, spoil, says }
}

/// Replaces text in a file.
fn edit(folder: &Path, file: &str, from: &str, to: &str) {
    let path = folder.join(file);
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains(from), "{file} has no `{from}`:\n{text}");
    fs::write(path, text.replacen(from, to, 1)).unwrap();
}

/// Writes 32-bit float samples with one value changed.
fn write_float(path: &Path, rate_hz: u32, channels: u16, change: Option<(usize, f32)>) {
    let mut bytes = Vec::new();
    let samples = 200 * usize::from(channels);
    let data = u32::try_from(4 * samples).unwrap();
    bytes.extend(b"RIFF");
    bytes.extend((36 + data).to_le_bytes());
    bytes.extend(b"WAVEfmt ");
    bytes.extend(16u32.to_le_bytes());
    bytes.extend(3u16.to_le_bytes()); // IEEE float
    bytes.extend(channels.to_le_bytes());
    bytes.extend(rate_hz.to_le_bytes());
    bytes.extend((rate_hz * 4 * u32::from(channels)).to_le_bytes());
    bytes.extend((4 * channels).to_le_bytes());
    bytes.extend(32u16.to_le_bytes());
    bytes.extend(b"data");
    bytes.extend(data.to_le_bytes());
    for k in 0..samples {
        let value = change.filter(|(at, _)| *at == k).map_or((k % 97) as f32 * 0.01, |(_, value)| value);
        bytes.extend(value.to_le_bytes());
    }
    fs::write(path, bytes).unwrap();
}

const RECORDS: [Case; 16] = [
    case(
        "missing channel",
        |d| write_float(&d.join(records::PING), 10_000, 7, None),
        [records::PING, "7 channels", "record all channels"],
    ),
    case(
        "truncated WAV",
        |d| {
            let path = d.join(records::PING);
            let bytes = fs::read(&path).unwrap();
            fs::write(path, &bytes[..bytes.len() / 2]).unwrap();
        },
        [records::PING, "truncated", "copy or record it again"],
    ),
    case(
        "empty WAV",
        |d| fs::write(d.join(records::PING), b"").unwrap(),
        [records::PING, "not a WAV file", "use 16, 24 or 32 bit"],
    ),
    case(
        "text instead of WAV",
        |d| fs::write(d.join(records::PING), b"time,pressure\n0,1\n").unwrap(),
        [records::PING, "not a WAV file", "use 16, 24 or 32 bit"],
    ),
    case(
        "wrong sampling rate",
        |d| write_float(&d.join(records::PING), 44_100, 8, None),
        [records::PING, "sampled at 44100 Hz, expected 10000 Hz", "correct the rate"],
    ),
    case(
        "NaN",
        |d| write_float(&d.join(records::PING), 10_000, 8, Some((8 * 50 + 3, f32::NAN))),
        [records::PING, "sample 50 is NaN", "export it again"],
    ),
    case(
        "infinite sample",
        |d| write_float(&d.join(records::PING), 10_000, 8, Some((8 * 7, f32::INFINITY))),
        [records::PING, "sample 7 is inf", "export it again"],
    ),
    case(
        "absent file",
        |d| fs::remove_file(d.join("C3-E/click-1.wav")).unwrap(),
        ["manifest.toml", "`C3-E/click-1.wav`", "copy it there"],
    ),
    case(
        "no manifest",
        |d| fs::remove_file(d.join("manifest.toml")).unwrap(),
        ["manifest.toml", "not a record set", "rijke lab"],
    ),
    case(
        "unknown key",
        |d| edit(d, "manifest.toml", "\nfull_scale_pa", "\nful_scale_pa"),
        ["manifest.toml:", "ful_scale_pa", "full_scale_pa"],
    ),
    case(
        "broken TOML",
        |d| edit(d, "manifest.toml", "kind = ", "kind == "),
        ["manifest.toml:8:7:", "extra `=`", "expected"],
    ),
    case(
        "microphone outside the tube",
        |d| edit(d, "rig.toml", "0.95]", "1.95]"),
        ["rig.toml", "microphones.positions", "positions are metres"],
    ),
    case(
        "reference microphone that does not exist",
        |d| edit(d, "rig.toml", "reference = 5", "reference = 8"),
        ["rig.toml", "microphones.reference", "counted from 0"],
    ),
    case(
        "empty campaign",
        |d| fs::write(d.join("campaign.toml"), "name = \"none\"\nrow = []\n").unwrap(),
        ["campaign.toml", "is empty", "give at least one [[row]]"],
    ),
    case(
        "unknown operating point",
        |d| edit(d, "manifest.toml", "id = \"C3-E\"", "id = \"C9-E\""),
        ["manifest.toml", "C9-E", "known: C3-E"],
    ),
    case(
        "day that is not declared",
        |d| edit(d, "manifest.toml", "day = \"one\"", "day = \"two\""),
        ["manifest.toml", "`two` is not known", "known: one"],
    ),
];

#[test]
fn exact_bad_records_are_refused_with_file_place_and_remedy() {
    let mut found = Vec::new();
    for Case { name, spoil, says } in RECORDS {
        let folder = scratch("bad-records");
        records::write(&folder.join("records"));
        spoil(&folder.join("records"));
        found.extend(faults(&folder, &["check", "records"], &says).map(|fault| format!("{name}: {fault}")));
    }
    assert!(found.is_empty(), "{}", found.join("\n\n"));
}

#[test]
fn exact_good_records_pass_and_clipping_is_told() {
    let folder = scratch("good-records");
    records::write(&folder.join("records"));
    let output = rijke(&folder, &["check", "records"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(text.contains("2 operating points on 1 days: 4 pings at 10000 Hz, 4 clicks"), "{text}");
    assert!(!text.contains("clipped"), "{text}");

    let path = folder.join("records/C3-E/ping-1.wav");
    let mut bytes = fs::read(&path).unwrap();
    let end = bytes.len();
    bytes[end - 3..].copy_from_slice(&[0xff, 0xff, 0x7f]);
    fs::write(&path, bytes).unwrap();
    let text = String::from_utf8(rijke(&folder, &["check", "records"]).stdout).unwrap();
    assert!(text.contains("clipped: C3-E/ping-1.wav (1 samples)"), "{text}");
}

#[test]
fn exact_bad_numbers_are_refused_with_file_place_and_remedy() {
    let folder = scratch("bad-numbers");
    let report = |says: &[&str]| faults(&folder, &["report", "results"], says);
    assert_eq!(report(&["results/numbers", "cannot be read", "rijke rank"]), None);
    let numbers = folder.join("results/numbers");
    fs::create_dir_all(&numbers).unwrap();
    assert_eq!(report(&["results/numbers", "no numbers", "rijke rank"]), None);
    fs::write(numbers.join("prongs.json"), "{\"provenance\":\n [}").unwrap();
    assert_eq!(report(&["prongs.json", "line 2, column 3", "rijke rank"]), None);
}

/// What is wrong with how a command refuses its input: it must end with 2, say all that it must in one message, and
/// leave the folder as it was.
fn faults(folder: &Path, arguments: &[&str], says: &[&str]) -> Option<String> {
    let before = listing(folder);
    let output = rijke(folder, arguments);
    let text = String::from_utf8(output.stderr).unwrap();
    let mut faults: Vec<_> =
        says.iter().filter(|part| !text.contains(**part)).map(|p| format!("no `{p}`")).collect();
    if output.status.code() != Some(2) {
        faults.push(format!("{}", output.status));
    }
    if text.matches("error:").count() != 1 || text.contains("panicked") {
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
