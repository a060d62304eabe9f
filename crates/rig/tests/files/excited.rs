//! Manifests of random noise, of sweeps and of blows, and what is said of bad ones.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

use rijke_rig::{Excitation, ExcitedRecords, RigError, SpectraKind};
use std::path::PathBuf;

const HEAD: &str = "kind = 'measured'\nsource = 'a test'\nrate_hz = 1000\nband_hz = [100, 400]\n";
const RANDOM: &str = "[random]\nsegment = 64\npoints = { p = 'a.csv' }\n";
const SWEEP: &str = "[sweep]\nresolution_hz = 2\npoints = { p = ['a.csv', 'b.csv'] }\n";
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
fn exact_volts_of_a_sweep_are_divided_by_their_gains() {
    let stated = "[microphones]\nsensitivity = ['50 mV/Pa', '2 mV/Pa']\ngain_sd = '1 %'\ndelay_sd = '5 us'\n";
    let (with, without) =
        (folder("volts", &format!("{HEAD}{SWEEP}{stated}")), folder("bare", &format!("{HEAD}{SWEEP}")));
    let text = "p [mV],q [V]\n50,0.004\n100,0.006\n";
    for folder in [&with, &without] {
        std::fs::write(folder.join("v.csv"), text).unwrap();
    }
    let sweep = ExcitedRecords::open(&with).unwrap().unwrap();
    let Excitation::Driven(driven) = &sweep.excitation else { panic!("{sweep:?}") };
    let (gains, record) =
        (driven.stated(2, &sweep.path).unwrap().unwrap().gains, sweep.read("v.csv", Some(2)).unwrap());
    let pascals =
        |m: usize| record.channels[m].iter().map(|v| (v / gains[m] * 1e9).round() / 1e9).collect::<Vec<_>>();
    assert_eq!([pascals(0), pascals(1)], [[1.0, 2.0], [2.0, 3.0]]);
    let bare = ExcitedRecords::open(&without).unwrap().unwrap();
    let said = bare.read("v.csv", Some(2)).unwrap_err().to_string();
    assert!(said.contains("the numbers are volts, and microphone 0 has no `sensitivity`"), "{said}");
}

#[test]
fn exact_manifests_are_read_with_their_records() {
    let random = ExcitedRecords::open(&folder("random", &format!("{HEAD}{RANDOM}"))).unwrap().unwrap();
    assert!(
        matches!(&random.excitation, Excitation::Driven(r) if r.spectra == SpectraKind::Segments { segment: 64 } && r.polynomials == 6)
    );
    let record = random.read("a.csv", Some(2)).unwrap();
    assert_eq!(record.channels, [[1.0, 3.0, 5.0], [2.0, 4.0, 6.0]]);
    assert_eq!(random.read("a.csv", None).unwrap(), record);
    assert!(random.read("a.csv", Some(1)).is_err(), "a channel that nobody listed");
    let stated = "[microphones]\ngain = [1, 1.1]\ngain_sd = '1 %'\ndelay_sd = '5 us'\n";
    let sweep = ExcitedRecords::open(&folder("sweep", &format!("{HEAD}{SWEEP}{stated}"))).unwrap().unwrap();
    let Excitation::Driven(driven) = &sweep.excitation else { panic!("{sweep:?}") };
    let spectra = SpectraKind::Whole { resolution_hz: 2.0, period: None, coherence: 0.8 };
    assert!(
        driven.spectra == spectra && driven.points["p"] == ["a.csv", "b.csv"] && driven.straight.is_empty()
    );
    let stated = driven.stated(2, &sweep.path).unwrap().unwrap();
    assert_eq!((stated.gains, stated.gain_sds), (vec![1.0, 1.1], vec![0.01, 0.01]));
    assert!(driven.stated(3, &sweep.path).is_err(), "gains of two microphones of three");
    let blow = ExcitedRecords::open(&folder("blow", &format!("{HEAD}{BLOW}"))).unwrap().unwrap();
    assert!(
        matches!(&blow.excitation, Excitation::Blow(b) if b.stretch == [0.0, 0.1] && b.states.len() == 1)
    );
    // Pings and clicks are other readers' work.
    assert_eq!(ExcitedRecords::open(&folder("pings", "kind = 'measured'\n")).unwrap(), None);
    assert_eq!(ExcitedRecords::open(&std::env::temp_dir().join("rijke-no-such-folder")).unwrap(), None);
}

#[test]
fn exact_a_channel_that_is_no_microphone_is_left_out() {
    // By place, and by name; the drive is no microphone.
    for (name, listed) in [("place", "[1, -1, 0]"), ("name", "{ p = 1, drive = -1, q = 0 }")] {
        let manifest = format!("{HEAD}channels = {listed}\n{SWEEP}").replace("'b.csv'", "'c.csv'");
        let folder = folder(&format!("drive-{name}"), &manifest);
        std::fs::write(folder.join("a.csv"), "p,drive,q\n1,9,2\n3,9,4\n5,9,6\n").unwrap();
        let sweep = ExcitedRecords::open(&folder).unwrap().unwrap();
        for count in [None, Some(2)] {
            let record = sweep.read("a.csv", count).unwrap();
            assert_eq!(record.channels, [[2.0, 4.0, 6.0], [1.0, 3.0, 5.0]], "{name} {count:?}");
        }
        let error = sweep.read("a.csv", Some(3)).unwrap_err().to_string();
        assert!(error.contains("manifest.toml") && error.contains("channels"), "{error}");
    }
    // A thin specimen, in a pipe whose wall is stated or not.
    let thin =
        "[random.transmission]\npoints = ['p']\nbetween = [1.0, 1.0]\nplace_sd = 0\nsound_speed_sd = 0\n";
    for (name, more, wall) in
        [("smooth", "", [1.0, 0.2]), ("rough", "wall_factor = 1.5\nwall_factor_sd = 0.0\n", [1.5, 0.0])]
    {
        let manifest = format!("{HEAD}{RANDOM}{thin}{more}");
        let random = ExcitedRecords::open(&folder(name, &manifest)).unwrap().unwrap();
        let Excitation::Driven(driven) = &random.excitation else { panic!("{random:?}") };
        let specimen = driven.transmission.as_ref().unwrap();
        assert_eq!([specimen.wall_factor, specimen.wall_factor_sd], wall);
    }
}

#[test]
fn message_bad_manifests_are_named_with_place_and_remedy() {
    for (name, manifest, parts) in [
        ("both", format!("{HEAD}{RANDOM}{BLOW}"), ["[random], [sweep], [blow]", "folders of their own"]),
        ("band", format!("{HEAD}{RANDOM}").replace("400]", "600]"), ["`band_hz`", "below half the rate"]),
        ("segment", format!("{HEAD}{RANDOM}").replace("64", "4"), ["[random]", "16 samples"]),
        (
            "two records",
            format!("{HEAD}{RANDOM}").replace("{ p = 'a.csv' }", "{ p = ['a.csv', 'b.csv'] }"),
            ["[random]", "one record"],
        ),
        ("segments of a sweep", format!("{HEAD}{SWEEP}segment = 64\n"), ["[sweep]", "no `segment`"]),
        ("period of noise", format!("{HEAD}{RANDOM}period = 64\n"), ["[random]", "no `resolution_hz`"]),
        (
            "no resolution",
            format!("{HEAD}{SWEEP}").replace("= 2", "= 0"),
            ["[sweep]", "resolution_hz above 0"],
        ),
        (
            "all coherence",
            format!("{HEAD}{SWEEP}coherence = 1.0\n"),
            ["[sweep]", "coherence from 0 to below 1"],
        ),
        (
            "no record",
            format!("{HEAD}{SWEEP}").replace("['a.csv', 'b.csv']", "[]"),
            ["[sweep]", "points with their records"],
        ),
        (
            "noise that is not switched",
            format!("{HEAD}{RANDOM}straight = 'a.csv'\n"),
            ["[random]", "`[microphones]` may state the gains"],
        ),
        (
            "sweep twice",
            format!("{HEAD}{SWEEP}").replace("'b.csv'", "'./a.csv'"),
            ["point `p`: files[1] `./a.csv`", "is the same file as point `p`: files[0] `a.csv`"],
        ),
        (
            "blow twice",
            format!("{HEAD}{BLOW}").replace("['a.csv']", "['a.csv', 'a.csv']"),
            ["[blow]: files[1] `a.csv`", "list every record once"],
        ),
        (
            "specimen backwards",
            format!(
                "{HEAD}{RANDOM}[random.transmission]\npoints = ['p']\nbetween = [2, 1]\nplace_sd = 0\nsound_speed_sd = 0\n"
            ),
            ["[random.transmission]", "`between` must have two places from 0 m on"],
        ),
        (
            "place of a microphone",
            format!(
                "{HEAD}{RANDOM}[random.transmission]\npoints = ['p']\nbetween = [1, 1]\nplace_sd = 2\nsound_speed_sd = 0\n"
            ),
            ["[random.transmission]", "`place_sd` must lie from 0 to 1 m"],
        ),
        (
            "not switched",
            format!("{HEAD}{SWEEP}straight = 'a.csv'\n"),
            ["[sweep]", "`switched` records, or none"],
        ),
        ("ends", format!("{HEAD}{SWEEP}sources = ['above']\n"), ["[sweep]", "upstream, downstream"]),
        (
            "gains twice",
            format!(
                "{HEAD}{SWEEP}straight = 'a.csv'\nswitched = [{{ file = 'b.csv', channel = 1 }}]\n[microphones]\ngain_sd = 0.1\ndelay_sd = '1 us'\n"
            ),
            ["[microphones]", "keep one of the two"],
        ),
        (
            "gains of a blow",
            format!("{HEAD}{BLOW}[microphones]\ngain = 1\n"),
            ["[microphones]", "leave it out"],
        ),
        ("stretch", format!("{HEAD}{BLOW}").replace("0.0, 0.1", "0.1, 0.1"), ["[blow]", "stretch_s"]),
        ("key", format!("{HEAD}{RANDOM}colour = 1\n"), ["colour", "there is no key"]),
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
