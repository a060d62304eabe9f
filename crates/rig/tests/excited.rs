//! Manifests of random noise and of blows, and what is said of bad ones.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use rijke_rig::{Excitation, ExcitedRecords, RigError};
use std::path::PathBuf;

const HEAD: &str = "kind = 'measured'\nsource = 'a test'\nrate_hz = 1000\nband_hz = [100, 400]\n";
const RANDOM: &str = "[random]\nsegment = 64\nstraight = 'a.csv'\npoints = { p = 'a.csv' }\n";
const BLOW: &str =
    "[blow]\nstretch_s = [0.0, 0.1]\nfiles = ['a.csv']\n[[blow.state]]\npoint = 'p'\nnear_hz = [150]\n";

/// A folder with this manifest and a record of two channels.
fn folder(name: &str, manifest: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("rijke-excited-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("manifest.toml"), manifest).unwrap();
    std::fs::write(folder.join("a.csv"), "p,q\n1,2\n3,4\n5,6\n").unwrap();
    folder
}

fn told(name: &str, manifest: &str) -> String {
    ExcitedRecords::open(&folder(name, manifest)).unwrap_err().to_string()
}

#[test]
fn exact_manifests_are_read_with_their_records() {
    let random = ExcitedRecords::open(&folder("random", &format!("{HEAD}{RANDOM}"))).unwrap().unwrap();
    assert!(matches!(&random.excitation, Excitation::Random(r) if r.segment == 64 && r.polynomials == 6));
    let record = random.read("a.csv", Some(2)).unwrap();
    assert_eq!(record.channels, [[1.0, 3.0, 5.0], [2.0, 4.0, 6.0]]);
    assert_eq!(random.read("a.csv", None).unwrap(), record);
    assert!(random.read("a.csv", Some(1)).is_err(), "a channel that nobody listed");
    let blow = ExcitedRecords::open(&folder("blow", &format!("{HEAD}{BLOW}"))).unwrap().unwrap();
    assert!(
        matches!(&blow.excitation, Excitation::Blow(b) if b.stretch == [0.0, 0.1] && b.states.len() == 1)
    );
    // Pings and clicks are other readers' work.
    assert_eq!(ExcitedRecords::open(&folder("pings", "kind = 'measured'\n")).unwrap(), None);
    assert_eq!(ExcitedRecords::open(&std::env::temp_dir().join("rijke-no-such-folder")).unwrap(), None);
}

#[test]
fn message_bad_manifests_are_named_with_place_and_remedy() {
    for (name, manifest, parts) in [
        ("both", format!("{HEAD}{RANDOM}{BLOW}"), ["[random], [blow]", "folders of their own"]),
        ("band", format!("{HEAD}{RANDOM}").replace("400]", "600]"), ["`band_hz`", "below half the rate"]),
        ("segment", format!("{HEAD}{RANDOM}").replace("64", "4"), ["[random]", "16 samples"]),
        ("stretch", format!("{HEAD}{BLOW}").replace("0.0, 0.1", "0.1, 0.1"), ["[blow]", "stretch_s"]),
        ("key", format!("{HEAD}{RANDOM}colour = 1\n"), ["colour", "unknown field"]),
        (
            "specimen",
            format!(
                "{HEAD}{RANDOM}[random.transmission]\npoints = ['x']\nbetween = [0, 1]\nplace_sd = 0\nsound_speed_sd = 0\n"
            ),
            ["[random.transmission]", "points that [random.points] lists"],
        ),
    ] {
        let error = told(name, &manifest);
        assert!(error.contains("manifest.toml"), "{error}");
        parts.iter().for_each(|part| assert!(error.contains(part), "{part}: {error}"));
    }
    let elsewhere =
        "[measured]\nvariable = 'RIJKE_NO_SUCH_VARIABLE'\nfolder = 'tube'\nobtain = 'a public place'\n";
    let error = ExcitedRecords::open(&folder("away", &format!("{HEAD}{elsewhere}{RANDOM}"))).unwrap_err();
    assert!(matches!(error, RigError::Elsewhere { .. }), "{error}");
    for part in ["RIJKE_NO_SUCH_VARIABLE", "tube", "a public place"] {
        assert!(error.to_string().contains(part), "{part}: {error}");
    }
}
