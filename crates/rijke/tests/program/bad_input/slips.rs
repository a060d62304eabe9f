//! Slips of the pen in a study of the template `kundt-tube`: numbers that nothing has, each of which a
//! mutation test once got through.

use super::{Case, case, edit};
use crate::rijke;
use std::{fs, path::Path};

const CHECK: &str = "check data";

pub(super) fn write(folder: &Path) {
    let made = rijke(folder, &["new", "data", "--template", "kundt-tube", "-q"]);
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
}

/// A manifest of random noise or of blows.
fn manifest(folder: &Path, text: &str) {
    fs::create_dir_all(folder.join("data/records")).unwrap();
    let head = "kind = \"measured\"\nsource = \"a test\"\nrate_hz = 8000\nband_hz = [100, 900]\n";
    fs::write(folder.join("data/records/manifest.toml"), format!("{head}{text}")).unwrap();
}

const NOISE: &str = "[random]\nsegment = 1024\n[random.points]\np70 = \"a.wav\"\n\
                     [random.transmission]\npoints = [\"p70\"]\nplace_sd = 0.001\n";

pub(super) const CASES: [Case; 21] = [
    case(
        "diameter below zero",
        |d| edit(d, "data/rig.toml", "diameter = \"100 mm\"", "diameter = -0.1"),
        CHECK,
        ["rig.toml, line 25", "`diameter` is `-0.1`", "positive"],
    ),
    case(
        "length that is true",
        |d| edit(d, "data/rig.toml", "length = \"length\"", "length = true"),
        CHECK,
        ["rig.toml, line 25", "`length` is `true`", "a number, a quantity"],
    ),
    case(
        "unit of a parameter that is none",
        |d| edit(d, "data/candidates/sample.toml", "unit = \"1\"", "unit = \"furlong\""),
        CHECK,
        ["sample.toml, line 10", "`unit of r`", "not a unit"],
    ),
    case(
        "stage whose name is a path",
        |d| edit(d, "data/study.toml", "id = \"tube\"", "id = \"a/b\""),
        CHECK,
        ["study.toml, line 8", "a/b", "the name of files"],
    ),
    case(
        "sd of the ambient temperature below zero",
        |d| edit(d, "data/campaign.csv", "293.15,0.2", "293.15,-0.2"),
        CHECK,
        ["campaign.csv, line 4", "`T_amb_sd` is `-0.2 K`", "from 0 to 50 K"],
    ),
    case(
        "heat capacity below zero",
        |d| edit(d, "data/rig.toml", "[28.11,", "[-28.11,"),
        CHECK,
        ["rig.toml", "gas.heat_capacity at 250 K", "outside 20 to 500 J/(mol K)"],
    ),
    case(
        "one heat capacity for four coefficients",
        |d| {
            edit(
                d,
                "data/rig.toml",
                "heat_capacity = [28.11, 0.1967e-2, 0.4802e-5, -1.966e-9]",
                "heat_capacity = [20.786]",
            )
        },
        CHECK,
        ["rig.toml", "`heat_capacity` is `[20.786]`", "four numbers"],
    ),
    case(
        "viscosity below zero",
        |d| edit(d, "data/rig.toml", "1.716e-5", "-1.0"),
        CHECK,
        ["rig.toml", "gas.viscosity[0]", "outside"],
    ),
    case(
        "T_amb ten times as high",
        |d| edit(d, "data/campaign.csv", "293.15", "2931.5"),
        CHECK,
        ["campaign.csv, line 4", "2931.5 K", "below 2000 K"],
    ),
    case(
        "id too long for a file",
        |d| {
            let text = fs::read_to_string(d.join("data/study.toml")).unwrap();
            let id = text.lines().find_map(|l| l.strip_prefix("id = ")).unwrap().to_owned();
            edit(d, "data/study.toml", &format!("id = {id}"), &format!("id = \"{}\"", "x".repeat(300)));
        },
        CHECK,
        ["study.toml", "xxx...", "1 to 100 letters, digits"],
    ),
    case(
        "specimen that ends before it begins",
        |d| manifest(d, &format!("{NOISE}between = [1.0, -1.5]\nsound_speed_sd = 0.005\n")),
        "process data",
        ["manifest.toml", "[random.transmission]", "the first not beyond the second"],
    ),
    case(
        "speed of sound that is not known at all",
        |d| manifest(d, &format!("{NOISE}between = [0.3, 0.4]\nsound_speed_sd = inf\n")),
        "process data",
        ["manifest.toml", "[random.transmission]", "`sound_speed_sd` must lie from 0 to 0.5"],
    ),
    case(
        "mode beyond the band",
        |d| {
            let blow =
                "[blow]\nstretch_s = [0.0, 0.2]\nfiles = [\"a.wav\"]\n[[blow.state]]\npoint = \"p70\"\n";
            manifest(d, &format!("{blow}near_hz = [-150]\n"));
        },
        "process data",
        ["manifest.toml", "[[blow.state]]", "near_hz within `band_hz`"],
    ),
    case(
        "blow at a point that is not there",
        |d| {
            let blow =
                "[blow]\nstretch_s = [0.0, 0.2]\nfiles = [\"a.wav\"]\n[[blow.state]]\npoint = \"nowhere\"\n";
            manifest(d, &format!("{blow}near_hz = [150]\n"));
        },
        "process data",
        ["manifest.toml", "no operating point `nowhere`", "Correct the name in [[blow.state]]"],
    ),
    case(
        "sweep without a resolution",
        |d| manifest(d, "[sweep]\n[sweep.points]\np70 = \"a.wav\"\n"),
        "process data",
        ["manifest.toml", "[sweep]", "must have a `resolution_hz`"],
    ),
    case(
        "sweeps that nobody hears",
        |d| sweeps(d, "", "[\"a.csv\", \"b.csv\"]"),
        "process data",
        [
            "manifest.toml",
            "a.csv, b.csv: no frequency has a coherence of 0.8",
            "holds the frequencies of the sweep",
        ],
    ),
    case(
        "period longer than half a record",
        |d| sweeps(d, "period = 400", "\"a.csv\""),
        "process data",
        ["manifest.toml", "a.csv: the record of two periods is too short", "change `band_hz`"],
    ),
    case(
        "sweep at a point that is not there",
        |d| {
            sweeps(d, "", "\"a.csv\"");
            edit(d, "data/records/manifest.toml", "p70", "nowhere");
        },
        "process data",
        ["manifest.toml", "no operating point `nowhere`", "Correct the name in [sweep.points]"],
    ),
    case(
        "OSCILOS: a flame that answers before",
        |d| {
            oscilos(d);
            edit(d, "oscilos/Flame.txt", "3.0", "-3.0");
        },
        "modes --oscilos oscilos",
        ["Flame.txt", "the delay (ms) is -3", "0 to 10 000 ms"],
    ),
    case(
        "OSCILOS: a temperature in degrees C",
        |d| {
            oscilos(d);
            edit(d, "oscilos/Mean_flow.txt", "293.15", "20");
        },
        "modes --oscilos oscilos",
        ["Mean_flow.txt", "the temperature (K) is 20", "100 to 4000 K"],
    ),
    case(
        "OSCILOS in a rig: a delay in microseconds",
        |d| {
            oscilos(d);
            edit(d, "oscilos/Flame.txt", "3.0", "30000");
            fs::write(d.join("data/rig.toml"), "name = \"combustor\"\noscilos = \"../oscilos\"\n").unwrap();
        },
        CHECK,
        ["Flame.txt, line 2", "`delay` is `30000`", "0 to 10 000 ms"],
    ),
];

/// A manifest of sweeps with records of noise: two of 600 samples at the three microphones of the rig.
fn sweeps(folder: &Path, keys: &str, files: &str) {
    manifest(folder, &format!("[sweep]\nresolution_hz = 50\n{keys}\n[sweep.points]\np70 = {files}\n"));
    let mut state = 7_u32;
    for name in ["a", "b"] {
        let mut row = || {
            let mut cell = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                format!("{}", f64::from(state >> 8) / f64::from(1 << 24) - 0.5)
            };
            [cell(), cell(), cell()].join(",")
        };
        let rows: Vec<String> = (0..600).map(|_| row()).collect();
        fs::write(folder.join(format!("data/records/{name}.csv")), format!("p,q,r\n{}\n", rows.join("\n")))
            .unwrap();
    }
}

/// The inputs of an OSCILOS folder with a flame.
fn oscilos(folder: &Path) {
    let to = folder.join("oscilos");
    fs::create_dir_all(&to).unwrap();
    let files = [
        ("Geometry.txt", "x r section tube\n0 0.05 0 0\n0.5 0.05 11 0\n1.5 0.05 0 0\n"),
        ("Mean_flow.txt", "p T choice M gamma ratio\n101325 293.15 2 0.5 1 4.6\n"),
        ("Flame.txt", "type gain delay\n1 1.0 3.0\n"),
        ("Inlet.txt", "type a b c\n2 0 0 0\n"),
        ("Outlet.txt", "type a b c\n1 0 0 0\n"),
        ("Scan_range.txt", "f0 f1 n g0 g1 n\n0 500 10 -200 200 10\n"),
    ];
    files.iter().for_each(|(name, text)| fs::write(to.join(name), text).unwrap());
}
