//! Records of somebody's own in a study: where the mode is sought, how warm it was, which files count, and
//! what is kept.

use crate::{rijke, scratch};
use std::{
    fs,
    path::{Path, PathBuf},
};

const MANIFEST: &str = "kind = \"measured\"\nsource = \"a test\"\nchannels = [0, 1, 2, 3, 4]\n\
    ping = { rate_hz = 5000, quiet_samples = 1000 }\n[microphones]\ngain_sd = \"2 %\"\ndelay_sd = \"5 us\"\n\
    [[day]]\nid = \"1\"\nambient_temperature_k = 293.15\nambient_temperature_sd_k = 0.4\n\
    [[point]]\nid = \"e-0\"\nday = \"1\"\npings = [\"a.csv\", \"b.csv\"]\n\
    [[point]]\nid = \"e-40\"\nday = \"1\"\npings = [\"c.csv\"]\n";

/// A ring-down at 67.5 Hz with -4 1/s after steady forcing, in noise of a congruence; a column of time first.
fn record(seed: u32) -> String {
    let mut state = seed;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        0.02 * (f64::from(state) / f64::from(u32::MAX) - 0.5)
    };
    let mut text = String::from("time [s],p1,p2,p3,p4,p5\n");
    for n in 0..9000 {
        let t = f64::from(n) / 5000.0;
        let size = if t < 0.2 { 0.0 } else { (-4.0 * (t - 0.8).max(0.0)).exp() };
        let row: Vec<String> = (0..5)
            .map(|m| {
                let shape = (1.5 - 0.25 * f64::from(m)).sin();
                (shape * size * (std::f64::consts::TAU * 67.5 * t).sin() + noise()).to_string()
            })
            .collect();
        text += &format!("{t},{}\n", row.join(","));
    }
    text
}

pub(crate) fn study(name: &str) -> PathBuf {
    let folder = scratch(name);
    let output = rijke(&folder, &["new", "study", "--template", "quarter-wave"]);
    assert!(output.status.success());
    let folder = folder.join("study");
    fs::create_dir(folder.join("records")).unwrap();
    for (k, name) in ["a", "b", "c"].iter().enumerate() {
        fs::write(folder.join(format!("records/{name}.csv")), record(7 + k as u32)).unwrap();
    }
    let campaign = fs::read_to_string(folder.join("campaign.csv")).unwrap();
    let warmer = campaign.replace("e-0,empty,,0,0,0,10,empty,1,293.15", "e-0,empty,,0,0,0,10,empty,1,291.5");
    fs::write(folder.join("campaign.csv"), warmer).unwrap();
    manifest(&folder, MANIFEST);
    fs::create_dir(folder.join("observations")).unwrap();
    fs::copy(folder.join("draft/observations/readings.csv"), folder.join("observations/readings.csv"))
        .unwrap();
    folder
}

fn manifest(folder: &Path, text: &str) {
    fs::write(folder.join("records/manifest.toml"), text).unwrap();
}

/// Exit status and what was said.
fn process(folder: &Path, more: &[&str]) -> (Option<i32>, String) {
    let words: Vec<&str> =
        ["process", "records", "--out", "observations"].iter().chain(more).copied().collect();
    let output = rijke(folder, &words);
    let said = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    (output.status.code(), said.concat())
}

/// A cell of a table of observations: the row of a point, the column of a name.
fn cell(folder: &Path, file: &str, point: &str, name: &str) -> f64 {
    let text = fs::read_to_string(folder.join("observations").join(file)).unwrap();
    let header: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let row = text.lines().find(|line| line.starts_with(&format!("{point},"))).unwrap();
    row.split(',').nth(header.iter().position(|c| *c == name).unwrap()).unwrap().parse().unwrap()
}

#[test]
fn behaviour_the_study_says_where_the_mode_lies_and_how_warm_it_was() {
    let folder = study("own-records");
    // What the user puts there stays, before and after.
    let mine = fs::read_to_string(folder.join("observations/readings.csv")).unwrap();
    assert!(rijke(&folder, &["check", "."]).status.success());
    let (code, said) = process(&folder, &[]);
    assert_eq!(code, Some(0), "{said}");
    for part in [
        "sought from 60 to 460 Hz, as [search] of rig.toml says",
        "gains and delays from [microphones] of the manifest, known to 2.0 % and 5 us",
        "2 of 2 points have the ambient temperature of the campaign (T_amb)",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let omega = cell(&folder, "pings.csv", "e-0", "angular_frequency [rad/s]");
    assert!((omega - std::f64::consts::TAU * 67.5).abs() < 0.1, "{omega}");
    assert_eq!(cell(&folder, "points.csv", "e-0", "T_amb [K]"), 291.5);
    assert_eq!(cell(&folder, "points.csv", "e-0", "T_amb_sd [K]"), 0.2);
    assert!(folder.join("observations/channels.toml").is_file());
    let (code, said) = process(&folder, &[]);
    assert!(code == Some(2) && said.contains("--force"), "{said}");
    manifest(&folder, &format!("band_hz = [50, 90]\nmains_hz = 60\n{MANIFEST}"));
    let (code, said) = process(&folder, &["--force"]);
    assert!(
        code == Some(0) && said.contains("from 50 to 90 Hz, as `band_hz` of the manifest says"),
        "{said}"
    );
    assert_eq!(fs::read_to_string(folder.join("observations/readings.csv")).unwrap(), mine);
    // It may stand beside study.toml as well, but must be somewhere.
    fs::rename(folder.join("observations/readings.csv"), folder.join("readings.csv")).unwrap();
    let checked = || {
        let output = rijke(&folder, &["check", "."]);
        (output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (good, said) = checked();
    assert!(good && !said.contains("will reject"), "{said}");
    // What rejects all records is said before all are fitted.
    manifest(&folder, &format!("band_hz = [80, 300]\n{MANIFEST}"));
    let (good, said) = checked();
    assert!(good && said.contains("`rijke process` will reject a.csv") && said.contains("67.5 Hz"), "{said}");
    manifest(&folder, MANIFEST);
    fs::remove_file(folder.join("readings.csv")).unwrap();
    let output = rijke(&folder, &["check", "."]);
    let missing = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2));
    assert!(missing.contains("readings.csv: is missing, and [base.heated-flow]"), "{missing}");
    let (code, said) = process(&folder, &["--force", "--band", "80", "300"]);
    assert!(code == Some(2) && said.contains("the loudspeaker drives 67.5 Hz"), "{said}");
    assert!(said.contains("`band_hz` in the manifest or with --band"), "{said}");
}

/// Names that are numbers in another order would be taken for one another.
#[test]
fn behaviour_observations_call_microphones_as_the_rig_does() {
    let folder = study("own-names");
    for name in ["a", "b", "c"] {
        let path = folder.join(format!("records/{name}.csv"));
        let text = fs::read_to_string(&path).unwrap();
        fs::write(path, text.replacen("p1,p2,p3,p4,p5", "a,b,c,d,e", 1)).unwrap();
    }
    let rig = fs::read_to_string(folder.join("rig.toml")).unwrap();
    let (code, said) = process(&folder, &[]);
    assert_eq!(code, Some(0), "{said}");
    let by_number = cell(&folder, "pings.csv", "e-0", "p2_re");
    let names = r#"names = ["p1", "p2", "p3", "p4", "p5"]"#;
    let own = r#"names = ["M1", "p5", "p4", "p3", "top"]"#;
    assert!(rig.contains(names));
    let rig = rig.replace(names, own).replace(r#"reference = "p1""#, r#"reference = "M1""#);
    fs::write(folder.join("rig.toml"), rig).unwrap();
    let (code, said) = process(&folder, &["--force"]);
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(cell(&folder, "pings.csv", "e-0", "p5_re"), by_number);
    assert!(cell(&folder, "ping-repeats.csv", "e-0", "p5_re").is_finite());
    let output = rijke(&folder, &["rank", ".", "--one-start", "--until", "tube"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
}

#[test]
fn behaviour_the_rig_says_how_much_of_a_ring_down_is_fitted() {
    let folder = study("own-window");
    let rig = fs::read_to_string(folder.join("rig.toml")).unwrap();
    let sd = |times: &str| {
        fs::write(folder.join("rig.toml"), format!("{rig}\n[recording]\nping_decay_times = {times}\n"))
            .unwrap();
        let (code, said) = process(&folder, &["--force", "--plot"]);
        assert_eq!(code, Some(0), "{said}");
        let plots = fs::read_dir(folder.join("observations/plots")).unwrap().flatten();
        let of_ping =
            |p: &std::path::PathBuf| p.extension().is_some_and(|e| e == "svg") && !p.ends_with("delays.svg");
        let mut figures: Vec<_> = plots.map(|entry| entry.path()).filter(of_ping).collect();
        figures.sort();
        (cell(&folder, "pings.csv", "e-0", "growth_rate [1/s]"), fs::read(&figures[0]).unwrap())
    };
    let ((short, brief), (usual, long)) = (sd("2.5"), sd("7"));
    assert!(short != usual && (short - usual).abs() < 0.05, "{short} {usual}");
    assert!(brief != long, "the picture of a ping has the window of its fit");
    fs::write(folder.join("rig.toml"), &rig).unwrap();
    assert_eq!(process(&folder, &["--force"]).0, Some(0));
    assert_eq!(cell(&folder, "pings.csv", "e-0", "growth_rate [1/s]"), usual);
    let line = rig.lines().count() + 3;
    for (text, part) in [
        ("ping_decay_times = 0", "ping_decay_times"),
        ("ping_decay_times = 40.0", "from 2 to 16 decay times"),
        ("ping_decay_times = nan", "from 2 to 16 decay times"),
        ("ping_decay_times = \"7 s\"", "`ping_decay_times`: the text \"7 s\" stands"),
        ("ping_decay_time = 7.0", "there is no key `ping_decay_time`"),
        ("band_hz = [300, 80]", "`band_hz` is `[300.0, 80.0]`"),
        ("band_hz = [80]", "two frequencies from 0.001 to 1e6 Hz"),
        ("band_hz = [80, nan]", "two frequencies from 0.001 to 1e6 Hz"),
        ("mains_hz = 0", "from 1 to 1000 Hz"),
    ] {
        fs::write(folder.join("rig.toml"), format!("{rig}\n[recording]\n{text}\n")).unwrap();
        let (code, said) = process(&folder, &["--force"]);
        assert!(code == Some(2) && said.contains(part) && said.contains("rig.toml"), "{text}: {said}");
        assert!(said.contains(&format!("line {line}")), "{text}: {said}");
    }
}

#[test]
fn behaviour_a_dead_microphone_keeps_the_others_names_in_the_study() {
    let folder = study("own-dead");
    manifest(&folder, &format!("dead = [3]\n{MANIFEST}"));
    let (code, said) = process(&folder, &[]);
    assert_eq!(code, Some(0), "{said}");
    let header = fs::read_to_string(folder.join("observations/pings.csv")).unwrap();
    assert!(header.contains(",p4_re,") && header.contains(",p5_re,"));
    // The last of five: 1.5 - 0.25 * 4.
    let p5 = cell(&folder, "pings.csv", "e-0", "p5_re");
    assert!((p5 - 0.5_f64.sin() / 1.5_f64.sin()).abs() < 1e-3, "{p5}");
    // What is written fits the rig of the study.
    let output = rijke(&folder, &["check", "."]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    // On one day only: that microphone is missing there, and nothing is rejected.
    manifest(&folder, &format!("{MANIFEST}[[exception]]\nfiles = [\"c.csv\"]\ndead = [2]\n"));
    let (code, said) = process(&folder, &["--force"]);
    assert!(code == Some(0) && said.contains("0 rejected"), "{said}");
    assert!(said.contains("e-40: without microphone 2 (p3), which is dead"), "{said}");
    let text = fs::read_to_string(folder.join("observations/pings.csv")).unwrap();
    let at = text.lines().next().unwrap().split(',').position(|c| c == "p3_re").unwrap();
    let empty: Vec<bool> = text.lines().skip(1).map(|l| l.split(',').nth(at).unwrap().is_empty()).collect();
    assert_eq!(empty, [false, true]);
}

#[test]
fn message_records_that_count_twice_or_hold_nothing() {
    let folder = study("own-twice");
    for (from, to, place) in [
        (
            "\"b.csv\"",
            "\"./a.csv\"",
            "point `e-0`: pings[1] `./a.csv`: is the same file as point `e-0`: pings[0]",
        ),
        (
            "\"c.csv\"",
            "\"a.csv\"",
            "point `e-40`: pings[0] `a.csv`: is the same file as point `e-0`: pings[0]",
        ),
    ] {
        manifest(&folder, &MANIFEST.replace(from, to));
        let (code, said) = process(&folder, &[]);
        assert!(code == Some(2) && said.contains(place) && said.contains("list every record once"), "{said}");
    }
    manifest(&folder, MANIFEST);
    fs::copy(folder.join("records/a.csv"), folder.join("records/c.csv")).unwrap();
    let (code, said) = process(&folder, &[]);
    assert!(code == Some(0) && said.contains("c.csv holds the same bytes as a.csv"), "{said}");
    // The column of time is no channel of the list.
    let output = rijke(&folder, &["inspect", "records/a.csv"]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let row = |name: &str| said.lines().find(|l| l.contains(name)).unwrap().to_owned();
    assert!(said.contains("5 channels of 9000 samples"), "{said}");
    assert!(
        row("time [s]").trim_start().starts_with("time") && row(" p1 ").trim_start().starts_with('0'),
        "{said}"
    );
    fs::write(folder.join("records/c.csv"), "").unwrap();
    let output = rijke(&folder, &["check", "."]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2));
    for part in ["c.csv", "0 samples: the file holds no record", "export it again"] {
        assert!(said.contains(part), "{part}: {said}");
    }
}

#[test]
fn behaviour_the_rig_says_where_the_mode_and_the_mains_lie() {
    let folder = study("own-band");
    let rig = fs::read_to_string(folder.join("rig.toml")).unwrap();
    let recording = |text: &str| {
        fs::write(folder.join("rig.toml"), format!("{rig}\n[recording]\n{text}\n")).unwrap();
    };
    // Before [search], which is from 60 to 460 Hz.
    recording("band_hz = [65, 70]\nmains_hz = 60");
    let (code, said) = process(&folder, &["--force"]);
    assert!(code == Some(0), "{said}");
    assert!(said.contains("the mode is sought from 65 to 70 Hz, as `band_hz` of rig.toml says"), "{said}");
    // Behind the manifest, and behind the option.
    manifest(&folder, &MANIFEST.replace("ping =", "band_hz = [64, 71]\nping ="));
    let (_, said) = process(&folder, &["--force"]);
    assert!(
        said.contains("the mode is sought from 64 to 71 Hz, as `band_hz` of the manifest says"),
        "{said}"
    );
    let (code, said) = process(&folder, &["--force", "--band", "60", "80"]);
    assert!(code == Some(0) && !said.contains("the mode is sought"), "{said}");
    // Another grid leaves another hum: without one the mains change nothing but what is taken for hum.
    manifest(&folder, MANIFEST);
    let growth = |mains: &str| {
        recording(&format!("band_hz = [65, 70]\nmains_hz = {mains}"));
        let (code, said) = process(&folder, &["--force"]);
        assert!(code == Some(0), "{said}");
        fs::read_to_string(folder.join("observations/pings.csv")).unwrap()
    };
    let [sixty, near] = ["60", "67.5"].map(growth);
    recording("band_hz = [65, 70]");
    assert_eq!(process(&folder, &["--force", "--mains", "67.5"]).0, Some(0));
    assert_eq!(fs::read_to_string(folder.join("observations/pings.csv")).unwrap(), near);
    assert_ne!(sixty, near);
}
