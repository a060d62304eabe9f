//! Observations that were prepared by hand, and what is asked of them.

use super::{Case, case, edit};
use rijke_numerics::{C64, Matrix};
use rijke_rig::{Campaign, DataKind, Day, Observations, Ping, PointObservations, Rig};
use std::{fs, path::Path};

const RANK: &str = "rank data --out results";

/// Four cold points without heater, as plain as possible, in `data/observations`.
pub(crate) fn write(folder: &Path) {
    let rig = Rig::juniper_yoko_2022();
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
    let points = Campaign::juniper_yoko_2022().points.into_iter().filter(|p| p.row == "C3").take(4);
    let observations = Observations {
        kind: DataKind::Virtual,
        source: "a test".into(),
        points: points
            .enumerate()
            .map(|(k, point)| PointObservations {
                point,
                ambient: Day { id: "one".into(), ambient_temperature: 293.0, ambient_temperature_sd: 0.1 },
                ping: Some(ping(k as f64)),
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

pub(super) const CASES: [Case; 23] = [
    case(
        "no observations",
        |d| fs::remove_dir_all(d.join("data/observations")).unwrap(),
        RANK,
        ["data/observations.toml", "cannot be read", "Run `rijke process data` first."],
    ),
    case(
        "unknown kind of data",
        |d| edit(d, "data/observations/observations.toml", "\"virtual\"", "\"guessed\""),
        RANK,
        ["observations.toml:1:8", "unknown variant `guessed`", "expected `measured` or `virtual`"],
    ),
    case(
        "no operating points",
        |d| {
            let path = d.join("data/observations/points.csv");
            let text = fs::read_to_string(&path).unwrap();
            fs::write(path, text.lines().next().unwrap()).unwrap();
        },
        RANK,
        ["points.csv", "rows: is empty", "give at least one operating point"],
    ),
    case(
        "heater that is neither there nor not",
        |d| cell(d, "points.csv", 3, "maybe"),
        RANK,
        ["points.csv", "line 2, column `heater`: `maybe`", "0 or 1"],
    ),
    case(
        "power with its unit",
        |d| cell(d, "points.csv", 5, "30 W"),
        RANK,
        ["points.csv", "line 2, column `power_W`: `30 W`", "a finite number"],
    ),
    case(
        "other columns",
        |d| edit(d, "data/observations/pings.csv", "growth_rate_per_s", "growth_rate"),
        RANK,
        ["pings.csv", "line 1: column 2 is `growth_rate`, expected `growth_rate_per_s`", "keep the header"],
    ),
    case(
        "word in the place of a number",
        |d| cell(d, "pings.csv", 1, "fast"),
        RANK,
        ["pings.csv", "line 2, column `growth_rate_per_s`: `fast`", "a finite number"],
    ),
    case(
        "infinite frequency",
        |d| cell(d, "pings.csv", 2, "inf"),
        RANK,
        ["pings.csv", "column `angular_frequency_rad_per_s`: `inf`", "a finite number"],
    ),
    case(
        "variance of zero",
        |d| cell(d, "pings.csv", 17, "0"),
        RANK,
        [
            "pings.csv",
            "line 2, column `cov_growth_rate_per_s_growth_rate_per_s`",
            "give variances above zero",
        ],
    ),
    case(
        "correlation beyond one",
        |d| cell(d, "pings.csv", 18, "1"),
        RANK,
        ["pings.csv", "the covariance is not positive definite", "correlations inside -1 to 1"],
    ),
    case(
        "operating point that no table lists",
        |d| cell(d, "pings.csv", 0, "C9-05"),
        RANK,
        ["pings.csv", "line 2, column `point`: `C9-05` is not known", "known: C3-05"],
    ),
    case(
        "line that is too short",
        |d| {
            let path = d.join("data/observations/pings.csv");
            let text = fs::read_to_string(&path).unwrap();
            fs::write(path, text + "C3-E,1\n").unwrap();
        },
        RANK,
        ["pings.csv:6:", "2 fields", "the previous record has 153 fields"],
    ),
    case(
        "clicks of other microphones",
        |d| {
            let path = d.join("data/observations/clicks.csv");
            fs::write(path, "point,arrival1_s,arrival3_s\n").unwrap();
        },
        RANK,
        ["clicks.csv", "column 3 is `arrival3_s`, expected `arrival2_s`", "keep the header"],
    ),
    case(
        "no empty tube",
        |d| {
            for file in ["points.csv", "pings.csv"] {
                let path = d.join("data/observations").join(file);
                let text = fs::read_to_string(&path).unwrap();
                let kept: Vec<&str> = text.lines().filter(|l| !l.starts_with("C3-E")).collect();
                fs::write(path, kept.join("\n") + "\n").unwrap();
            }
        },
        RANK,
        ["data/observations", "no operating point with the empty tube", "measure it"],
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
        ["elsewhere", "flow.toml", "`rijke process` makes observations of records"],
    ),
    case(
        "closures that do not exist",
        |d| fs::write(d.join("closures.toml"), "convection = 2\n").unwrap(),
        "flow data --closures closures.toml --out base-flow",
        ["closures.toml", "unknown field `convection`", "expected"],
    ),
    case(
        "hot points without a cold heater",
        |_| (),
        "rank data --flow elsewhere --out results",
        ["data/observations", "a cold heater without and with thermocouples", "Leave out --flow"],
    ),
    case(
        "results in the place of something else",
        |d| {
            fs::create_dir_all(d.join("results")).unwrap();
            fs::write(d.join("results/thesis.tex"), "").unwrap();
        },
        "rank data --out results --force",
        ["results", "holds no numbers/prongs.json", "remove this one yourself"],
    ),
    case(
        "results that exist",
        |d| {
            fs::create_dir_all(d.join("results/numbers")).unwrap();
            fs::write(d.join("results/numbers/prongs.json"), "{}").unwrap();
        },
        RANK,
        ["results", "exists already", "--force"],
    ),
    case(
        "model of a candidate that does not exist",
        |_| (),
        "check-model data --model wall.rayleigh,prongs.99",
        ["--model", "no candidate 'prongs.99'", "fixtures/candidates"],
    ),
    case(
        "two candidates of one role",
        |_| (),
        "check-model data --model wall.rayleigh,wall.kirchhoff",
        ["`wall.rayleigh` and `wall.kirchhoff`", "both model the wall", "choose one"],
    ),
    case(
        "negative error of the referee",
        |_| (),
        "check-model data --referee-error=-1",
        ["--referee-error", "-1", "--help"],
    ),
];
