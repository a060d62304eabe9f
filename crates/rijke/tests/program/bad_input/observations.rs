//! Observations that were prepared by hand, and what is asked of them.

use super::{Case, case, edit};
use crate::short;
use rijke_flow::{HeatedTube, TubeCampaign, TubeRig};
use rijke_numerics::{C64, Matrix};
use rijke_rig::{DataKind, Day, Observations, Ping, PointObservations};
use std::{fs, path::Path};

const RANK: &str = "rank data --until empty-tube --one-start";

/// The study of the paper with four cold points without heater, as plain as possible, in `data/observations`.
pub(crate) fn write(folder: &Path) {
    short::paper(&folder.join("data"));
    edit(folder, "data/study.toml", "[base.states]\npoints = { where = { Q_h = { above = 0 } } }", "");
    let rig = TubeRig::juniper_yoko_2022().apparatus();
    let size = 2 * rig.microphones.positions.len();
    let ping = |k: f64| {
        let pressures = rig.microphones.positions.iter().map(|x| C64::new((3.0 * x).sin(), 0.0));
        Ping {
            s: C64::new(-6.0 - k, 1040.0 - k),
            pressures: pressures.collect(),
            reference: rig.microphones.reference,
            covariance: Matrix::from_fn(size, size, |i, j| if i == j { 1e-4 } else { 0.0 }),
        }
    };
    let points = TubeCampaign::juniper_yoko_2022().points.into_iter().filter(|p| p.row == "C3").take(4);
    let observations = Observations {
        kind: DataKind::Virtual,
        source: "a test".into(),
        points: points
            .enumerate()
            .map(|(k, point)| PointObservations {
                point: (&point).into(),
                ambient: Day { id: "one".into(), ambient_temperature: 293.0, ambient_temperature_sd: 0.1 },
                ping: Some(ping(k as f64)),
                drift_sd: 0.0,
                ping_count: 4,
                click: None,
                click_count: 0,
                pings: Vec::new(),
                clicks: Vec::new(),
            })
            .collect(),
        rejections: Vec::new(),
        channels: None,
        rig,
    };
    fs::create_dir_all(folder.join("data/observations")).unwrap();
    observations.write(&folder.join("data/observations")).unwrap();
    let tube = include_str!("../../../../flow/data/rigs/juniper-yoko-2022.toml");
    fs::write(folder.join("data/observations").join(HeatedTube::FILE), tube).unwrap();
}

/// Changes the `n`-th cell of the second line of a table.
fn cell(folder: &Path, file: &str, n: usize, value: &str) {
    let path = folder.join("data/observations").join(file);
    let text = fs::read_to_string(&path).unwrap();
    let mut lines: Vec<String> = text.lines().map(String::from).collect();
    let mut cells: Vec<&str> = lines[1].split(',').collect();
    cells[n] = value;
    lines[1] = cells.join(",");
    fs::write(path, lines.join("\n") + "\n").unwrap();
}

pub(super) const CASES: [Case; 24] = [
    case(
        "another tube beside the observations",
        |d| edit(d, "data/observations/rig.toml", "inner_diameter = 0.0474", "inner_diameter = 0.05"),
        RANK,
        [
            "data/rig.toml: the inner diameter is 0.0474 m",
            "data/observations/rig.toml says 0.05 m",
            "correct the file",
        ],
    ),
    case(
        "another heated tube beside the observations",
        |d| edit(d, "data/observations/tube.toml", "inner_diameter = 0.0474", "inner_diameter = 0.05"),
        "check data",
        [
            "data/rig.toml: the inner diameter is 0.0474 m",
            "data/observations/tube.toml says 0.05 m",
            "correct the file",
        ],
    ),
    case(
        "another length beside the observations",
        |d| edit(d, "data/observations/rig.toml", "length = 1.0", "length = 1.1"),
        "check data",
        [
            "data/rig.toml: the length of the rig is 1 m",
            "data/observations/rig.toml says 1.1 m",
            "correct the file",
        ],
    ),
    case(
        "other microphones beside the observations",
        |d| edit(d, "data/observations/rig.toml", "0.45", "0.46"),
        RANK,
        [
            "data/rig.toml: the rig is 8 microphones at [0.25, 0.35, 0.45,",
            "says 8 microphones at [0.25, 0.35, 0.46,",
            "correct the file",
        ],
    ),
    case(
        "point of a ramp whose state would be taken for settled",
        |d| {
            let text = "ramp,time [s],power [W],point\nup,0,0,\nup,90,0,C3-E\n";
            fs::write(d.join("data/observations/ramps.csv"), text).unwrap();
        },
        RANK,
        [
            "ramps.csv, line 3",
            "`point` is `C3-E`, but must be a point whose state",
            "add it to `points` of [base.states]",
        ],
    ),
    case(
        "no observations",
        |d| fs::remove_dir_all(d.join("data/observations")).unwrap(),
        RANK,
        ["data/observations/observations.toml", "there is no such file", "with `rijke process`"],
    ),
    case(
        "unknown kind of data",
        |d| edit(d, "data/observations/observations.toml", "\"virtual\"", "\"guessed\""),
        RANK,
        ["observations.toml, line 1", "`guessed` is not known", "known here: measured, virtual"],
    ),
    case(
        "no modes",
        |d| {
            let path = d.join("data/observations/pings.csv");
            let text = fs::read_to_string(&path).unwrap();
            fs::write(path, text.lines().next().unwrap()).unwrap();
        },
        RANK,
        ["pings.csv", "no mode", "add a row"],
    ),
    case(
        "other columns",
        |d| edit(d, "data/observations/pings.csv", "growth_rate [1/s]", "growth"),
        RANK,
        ["pings.csv, line 1", "no column called `growth`", "growth_rate, frequency"],
    ),
    case(
        "word in the place of a number",
        |d| cell(d, "pings.csv", 1, "fast"),
        RANK,
        ["pings.csv, line 2", "`growth_rate [1/s]` is `fast`", "a finite number"],
    ),
    case(
        "infinite frequency",
        |d| cell(d, "pings.csv", 2, "inf"),
        RANK,
        ["pings.csv, line 2", "`angular_frequency [rad/s]` is `inf`", "a finite number"],
    ),
    case(
        "variance of zero",
        |d| cell(d, "pings.csv", 17, "0"),
        RANK,
        ["pings.csv, line 2", "the covariance of", "is not positive definite"],
    ),
    case(
        "correlation beyond one",
        |d| cell(d, "pings.csv", 18, "1"),
        RANK,
        ["pings.csv, line 2", "is not positive definite", "check the sizes and signs"],
    ),
    case(
        "operating point that the campaign does not list",
        |d| cell(d, "pings.csv", 0, "C9-05"),
        RANK,
        ["pings.csv, line 2", "no operating point called `C9-05`", "known: C1-15"],
    ),
    case(
        "the same point twice",
        |d| {
            let path = d.join("data/observations/pings.csv");
            let text = fs::read_to_string(&path).unwrap();
            let again = text.lines().nth(1).unwrap();
            fs::write(path, format!("{text}{again}\n")).unwrap();
        },
        RANK,
        ["pings.csv, line 6", "`mode of", "give each a label in the column `mode`"],
    ),
    case(
        "line that is too short",
        |d| {
            let path = d.join("data/observations/pings.csv");
            let text = fs::read_to_string(&path).unwrap();
            fs::write(path, text + "C3-E,1\n").unwrap();
        },
        RANK,
        ["pings.csv, line 6", "2 cells", "the heading has 154"],
    ),
    case(
        "no point of a stage",
        |d| {
            let path = d.join("data/observations/pings.csv");
            let text = fs::read_to_string(&path).unwrap();
            let kept: Vec<&str> = text.lines().filter(|l| !l.starts_with("C3-E")).collect();
            fs::write(path, kept.join("\n") + "\n").unwrap();
        },
        RANK,
        ["data", "stage `empty-tube`: none of its points was observed", "correct its `points`"],
    ),
    case(
        "clicks of other microphones",
        |d| {
            let path = d.join("data/observations/clicks.csv");
            fs::write(path, "point,arrival1 [s],arrival3 [s]\n").unwrap();
        },
        "flow data --out base-flow",
        ["clicks.csv", "column 3 is `arrival3 [s]`, expected `arrival2 [s]`", "keep the header"],
    ),
    case(
        "no flow to infer",
        |_| (),
        "flow data --out base-flow",
        ["data/observations", "no heated operating point with clicks", "flow.toml"],
    ),
    case(
        "flow of nothing",
        |_| (),
        "flow elsewhere --out base-flow",
        ["elsewhere", "there is no such folder", "Name a folder of observations"],
    ),
    case(
        "closures that do not exist",
        |d| fs::write(d.join("closures.toml"), "convection = 2\n").unwrap(),
        "flow data --closures closures.toml --out base-flow",
        ["closures.toml", "there is no key `convection`", "nown here: "],
    ),
    case(
        "results in the place of something else",
        |d| {
            fs::create_dir_all(d.join("data/results")).unwrap();
            fs::write(d.join("data/results/thesis.tex"), "").unwrap();
        },
        "rank data --until empty-tube --force",
        ["data/results", "holds no numbers/claims.json", "remove this one yourself"],
    ),
    case(
        "results that exist",
        |d| {
            fs::create_dir_all(d.join("data/results/numbers")).unwrap();
            fs::write(d.join("data/results/numbers/claims.json"), "[]").unwrap();
        },
        RANK,
        ["data/results", "exists already", "--force"],
    ),
    case(
        "negative error of the sampler",
        |_| (),
        "rank data --sampler nested --sampler-error=-1",
        ["--sampler-error", "-1", "--help"],
    ),
];
