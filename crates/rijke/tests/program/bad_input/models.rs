//! Candidates of the user's own, stages, questions, and trained models.

use super::{Case, case, edit, observations};
use std::{fs, path::Path};

const RANK: &str = "rank data --until prongs --one-start";
const PREDICT: &str = "predict data --stage prongs";

/// Observations, and a candidate beside those of the paper.
pub(super) fn write(folder: &Path) {
    observations::write(folder);
    let own = "[[candidate]]\nid = \"my-prongs\"\nrole = \"prongs\"\nname = \"drag of a sphere\"\ncite = [\"nobody\"]\n\
               parameters.kd = { symbol = \"k_1\", unit = \"1\", prior = { normal = { mean = 1.0, sd = 1.0 } } }\n\
               [[candidate.effect]]\nacts_at = \"prongs.end\"\nmu = \"kd * rho * c\"\n";
    fs::write(folder.join("data/candidates/own.toml"), own).unwrap();
}

fn own(folder: &Path, from: &str, to: &str) {
    edit(folder, "data/candidates/own.toml", from, to);
}

fn plan(folder: &Path, from: &str, to: &str) {
    edit(folder, "data/study.toml", from, to);
}

pub(super) const CASES: [Case; 31] = [
    case("no study", |_| (), "rank elsewhere", ["elsewhere", "there is no such folder", "`rijke new"]),
    case(
        "no rig",
        |d| fs::remove_file(d.join("data/rig.toml")).unwrap(),
        RANK,
        ["data/rig.toml", "there is no such file", "`rijke new DIR"],
    ),
    case(
        "id of another candidate",
        |d| own(d, "my-prongs", "prongs.6"),
        RANK,
        ["candidates/prongs.toml", "a second candidate is called `prongs.6`", "every name must be different"],
    ),
    case(
        "name that does not exist",
        |d| own(d, "rho * c", "rho * c0"),
        RANK,
        ["own.toml, line 9", "`c0` is not known", "did you mean `c`"],
    ),
    case(
        "extension of no candidate",
        |d| own(d, "role = ", "extends = \"rods\"\nrole = "),
        RANK,
        ["own.toml, line 2", "there is no candidate for `extends` called `rods`", "known: "],
    ),
    case(
        "formula that ends too soon",
        |d| own(d, "kd * rho * c", "kd * (rho * c"),
        RANK,
        ["own.toml, line 9", "`mu`", "this parenthesis is never closed"],
    ),
    case(
        "formula that is not analytic",
        |d| own(d, "kd * rho * c", "kd * rho * abs(s)"),
        RANK,
        ["own.toml, line 9", "abs", "analytic"],
    ),
    case(
        "formula of another unit",
        |d| own(d, "kd * rho * c", "kd * rho"),
        "check data",
        ["data/candidates", "own.toml, line 9: `mu` at prongs.end", "correct the formula"],
    ),
    case(
        "parameter without effect",
        |d| own(d, "kd * rho * c", "rho * c"),
        RANK,
        ["own.toml, line 6", "`kd` is used nowhere", "use it or remove it"],
    ),
    case(
        "model without a source",
        |d| own(d, "[\"nobody\"]", "[]"),
        RANK,
        ["own.toml", "cite", "own judgement"],
    ),
    case(
        "prior of negative width",
        |d| own(d, "sd = 1.0", "sd = -1.0"),
        RANK,
        ["own.toml, line 6", "the prior of parameter 'kd' is impossible", "sd = -1"],
    ),
    case(
        "reflection inside",
        |d| own(d, "mu = ", "reflection = "),
        RANK,
        ["own.toml, line 9", "`reflection` cannot act at", "ends take `reflection`"],
    ),
    case(
        "place that does not exist",
        |d| own(d, "prongs.end", "nozzle"),
        RANK,
        ["own.toml, line 8", "`nozzle`", "prongs.end"],
    ),
    case(
        "effect on nothing",
        |d| own(d, "mu = \"kd * rho * c\"", ""),
        RANK,
        ["own.toml, line 2", "there is no effect", "add a [[candidate.effect]]"],
    ),
    case("broken TOML", |d| own(d, "role = ", "role "), RANK, ["own.toml, line 3", "=", "expected"]),
    case(
        "unknown key",
        |d| own(d, "cite = ", "cited = "),
        RANK,
        ["own.toml, line 5", "there is no key `cited`; did you mean `cite`?", "Known here: "],
    ),
    case(
        "parameter that is called like a symbol",
        |d| {
            own(d, "parameters.kd", "parameters.rho");
            own(d, "kd * rho", "rho * rho");
        },
        RANK,
        [
            "own.toml, line 6",
            "`rho` cannot be the name of a parameter",
            "formulas already know it as density",
        ],
    ),
    case(
        "the same candidate twice",
        |d| {
            let path = d.join("data/candidates/own.toml");
            let text = fs::read_to_string(&path).unwrap();
            fs::write(path, text.repeat(2)).unwrap();
        },
        RANK,
        ["own.toml, line 11", "a second candidate is called `my-prongs`", "every name must be different"],
    ),
    case(
        "stage of no role",
        |d| plan(d, "compete = \"prongs\"", "compete = \"rods\""),
        RANK,
        ["study.toml, line", "no role called `rods`", "known: "],
    ),
    case(
        "stage on a stage that does not come before",
        |d| plan(d, "on = \"empty-tube\"", "on = \"heater\""),
        RANK,
        ["study.toml, line", "stage `heater` does not come before this one", "an earlier stage: empty-tube"],
    ),
    case(
        "condition on a factor that is none",
        |d| plan(d, "X_h = \"absent\"", "X_m = \"absent\""),
        RANK,
        ["study.toml, line", "no factor called `X_m`", "X_h, heater, thermometers, Q_h"],
    ),
    case(
        "stage to stop at that does not exist",
        |_| (),
        "rank data --until rods",
        ["data/study.toml", "no stage called `rods`", "Give one of: empty-tube"],
    ),
    case(
        "question of another kind",
        |d| plan(d, "ask = \"contours\"", "ask = \"contour\""),
        RANK,
        ["study.toml, line", "contour", "contours"],
    ),
    case(
        "published row of no candidate",
        |d| edit(d, "data/paper.toml", "\"prongs.1\" = ", "\"prongs.99\" = "),
        RANK,
        ["paper.toml, line", "prongs.99", "known: "],
    ),
    case(
        "statement that is no comparison",
        |d| edit(d, "data/paper.toml", "holds = \"sd < 0.02\"", "holds = \"sd\""),
        RANK,
        ["paper.toml, line", "sd", "<"],
    ),
    case(
        "position with another unit",
        |d| edit(d, "data/campaign.csv", "Q_h [W]", "Q_h [Wh/]"),
        RANK,
        ["campaign.csv, line 3", "Q_h [Wh/]", "unit"],
    ),
    case(
        "power with its unit",
        |d| edit(d, "data/campaign.csv", "C1-15,C1,0.15,1,0,0,", "C1-15,C1,0.15,1,0,0 W,"),
        RANK,
        ["campaign.csv, line 4", "`Q_h` is `0 W`", "a finite number"],
    ),
    case(
        "part without a place",
        |d| edit(d, "data/rig.toml", "to = \"X_h\"", "to = \"Y_h\""),
        RANK,
        ["rig.toml, line", "`Y_h` is not known", "did you mean `X_h`"],
    ),
    case(
        "length in seconds",
        |d| edit(d, "data/rig.toml", "\"47.4 mm\"", "\"47.4 ms\""),
        RANK,
        ["rig.toml, line", "`diameter`", "in m"],
    ),
    case(
        "no trained model",
        |_| (),
        PREDICT,
        ["models/prongs.json", "No such file", "Run `rijke rank data`"],
    ),
    case(
        "trained model that is cut off",
        |d| {
            fs::create_dir_all(d.join("data/results/models")).unwrap();
            fs::write(d.join("data/results/models/prongs.json"), "{\"candidates\":\n").unwrap();
        },
        PREDICT,
        ["models/prongs.json", "line 2", "Run `rijke rank data`"],
    ),
];
