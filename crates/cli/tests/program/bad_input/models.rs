//! Candidates of the user's own, and trained models.

use super::{Case, case, edit, observations};
use std::{fs, path::Path};

const RANK: &str = "rank data --candidates own.toml --out results";
const PREDICT: &str = "predict model.json --flow base-flow";

/// Observations, and a file of one candidate.
pub(super) fn write(folder: &Path) {
    observations::write(folder);
    let own = "[[candidate]]\nid = \"my-prongs\"\nrole = \"prongs\"\nname = \"drag of a sphere\"\ncite = [\"nobody\"]\n\
               parameters.kd = { symbol = \"k_1\", unit = \"1\", prior = { normal = { mean = 1.0, sd = 1.0 } } }\n\
               [[candidate.effect]]\nacts_at = \"prong-end\"\nmu = \"kd * rho * c\"\n";
    fs::write(folder.join("own.toml"), own).unwrap();
}

fn own(folder: &Path, from: &str, to: &str) {
    edit(folder, "own.toml", from, to);
}

pub(super) const CASES: [Case; 20] = [
    case(
        "no file of candidates",
        |d| fs::remove_file(d.join("own.toml")).unwrap(),
        RANK,
        ["own.toml", "cannot be read", "rijke candidate --symbols"],
    ),
    case(
        "role that does not exist",
        |d| own(d, "\"prongs\"", "\"flame\""),
        RANK,
        ["own.toml, line 2", "the role `flame`", "prongs, heater, heat-release"],
    ),
    case(
        "id of the project",
        |d| own(d, "my-prongs", "prongs.6"),
        RANK,
        ["own.toml, line 2", "another candidate is called `prongs.6`", "Give it another id"],
    ),
    case(
        "parameter of another component",
        |d| {
            own(d, "parameters.kd", "parameters.eta");
            own(d, "kd * rho", "eta * rho");
        },
        RANK,
        ["own.toml, line 2", "the parameter `eta`", "Rename the parameter"],
    ),
    case(
        "symbol that does not exist",
        |d| own(d, "rho * c", "rho * c0"),
        RANK,
        ["own.toml, line 9", "c0", "rijke candidate --symbols"],
    ),
    case(
        "formula that ends too soon",
        |d| own(d, "kd * rho * c", "kd * (rho * c"),
        RANK,
        ["own.toml, line 9", "this parenthesis is never closed", "rijke candidate --symbols"],
    ),
    case(
        "formula that is not analytic",
        |d| own(d, "kd * rho * c", "kd * rho * abs(s)"),
        RANK,
        ["own.toml, line 9", "abs", "analytic"],
    ),
    case(
        "formula that is not finite",
        |d| own(d, "kd * rho * c", "kd * rho * c * (Q_h/Q_h)"),
        RANK,
        ["own.toml, line 2", "not finite at", "rijke candidate own.toml"],
    ),
    case(
        "parameter without effect",
        |d| own(d, "kd * rho * c", "rho * c"),
        RANK,
        ["own.toml, line 6", "`kd` appears in no formula", "use it or remove it"],
    ),
    case(
        "model without a source",
        |d| own(d, "[\"nobody\"]", "[]"),
        RANK,
        ["own.toml, line 5", "`cite` is empty", "own judgement"],
    ),
    case(
        "prior of negative width",
        |d| own(d, "sd = 1.0", "sd = -1.0"),
        RANK,
        ["own.toml, line 6", "the prior of `kd`", "-1"],
    ),
    case(
        "reflection at the heater",
        |d| own(d, "mu = ", "reflection = "),
        RANK,
        ["own.toml, line 9", "`reflection` cannot act at", "ends take `reflection`"],
    ),
    case(
        "place that does not exist",
        |d| own(d, "prong-end", "nozzle"),
        RANK,
        ["own.toml, line 8", "unknown variant `nozzle`", "expected one of"],
    ),
    case(
        "effect on nothing",
        |d| own(d, "mu = \"kd * rho * c\"", ""),
        RANK,
        ["own.toml, line 7", "nothing is affected here", "give at least one of"],
    ),
    case(
        "broken TOML",
        |d| own(d, "role = ", "role "),
        RANK,
        ["own.toml, line 3", "=", "rijke candidate --symbols"],
    ),
    case(
        "parameter that is called like a symbol",
        |d| {
            own(d, "parameters.kd", "parameters.rho");
            own(d, "kd * rho", "rho * rho");
        },
        RANK,
        ["own.toml, line 6", "`rho` has the name of a symbol", "call it something else"],
    ),
    case(
        "the same candidate twice",
        |d| {
            let text = fs::read_to_string(d.join("own.toml")).unwrap();
            fs::write(d.join("own.toml"), text.repeat(2)).unwrap();
        },
        RANK,
        ["own.toml, line 11", "a second candidate is called `my-prongs`", "give it another id"],
    ),
    case(
        "candidates before a run",
        |d| {
            own(d, "rho * c", "rho * c0");
            fs::rename(d.join("own.toml"), d.join("data/candidates.toml")).unwrap();
        },
        "run data",
        ["data/candidates.toml, line 9", "c0", "rijke candidate --symbols"],
    ),
    case("no trained model", |_| (), PREDICT, ["model.json", "No such file", "rijke rank --flow"]),
    case(
        "trained model that is cut off",
        |d| fs::write(d.join("model.json"), "{\"kind\": \"virtual\",\n").unwrap(),
        PREDICT,
        ["model.json", "line 2", "rijke rank --flow"],
    ),
];
