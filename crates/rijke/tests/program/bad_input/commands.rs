//! What is asked of commands that read nothing prepared, or little.

use super::{Case, case, edit};
use std::{fs, path::Path};

fn network(folder: &Path, text: &str) {
    fs::write(folder.join("tube.toml"), text).unwrap();
}

/// A study that was ranked as far as this.
fn ranked(folder: &Path, numbers: Option<&str>) {
    crate::copy(&crate::example("quarter-wave"), &folder.join("study"));
    if let Some(text) = numbers {
        fs::create_dir_all(folder.join("study/results/numbers")).unwrap();
        fs::write(folder.join("study/results/numbers/claims.json"), text).unwrap();
    }
}

/// The quarter-wave tube, whose observed modes are these.
fn wave(folder: &Path, table: &str) {
    crate::copy(&crate::example("quarter-wave"), &folder.join("wave"));
    fs::write(folder.join("wave/observations/modes.csv"), table).unwrap();
}

pub(super) const CASES: [Case; 40] = [
    case(
        "results that do not exist",
        |d| ranked(d, None),
        "report study",
        ["study/results/numbers/claims.json", "No such file", "Run `rijke rank study` first"],
    ),
    case(
        "numbers that are damaged",
        |d| ranked(d, Some("[{\"provenance\":\n [}")),
        "report study",
        ["study/results/numbers/claims.json", "line 2", "Run `rijke rank study` first"],
    ),
    case(
        "table of results with a number too many",
        |d| {
            ranked(d, Some("[]"));
            let frame = "{\"columns\": [{\"name\": \"Q\", \"label\": \"Q\", \"unit\": \"W\"}], \
                         \"rows\": [{\"label\": \"h1\", \"series\": \"\", \"values\": [25.0, 1.0]}]}";
            let answer = format!(
                "{{\"id\": \"heat\", \"title\": \"\", \"caption\": \"\", \"parameters\": [], \"frames\": [{frame}], \"panels\": []}}"
            );
            fs::write(d.join("study/results/numbers/answer-heat.json"), answer).unwrap();
        },
        "report study",
        [
            "study/results/numbers/answer-heat.json",
            "row `h1` has 2 values for 1 columns",
            "Run `rijke rank study` first",
        ],
    ),
    case(
        "factor of measured modes that no rig can have",
        |d| {
            crate::copy(&crate::example("ducted-flame"), &d.join("flame"));
            edit(d, "flame/modes.csv", "0.40,-70.75", "-0.40,-70.75");
        },
        "infer flame/n-tau.toml --data flame/modes.csv",
        ["flame/modes.csv, line 5", "`chamber: length` is `-0.4`", "Correct that row, or flame/n-tau.toml"],
    ),
    case(
        "pressure of the reference over another microphone",
        |d| {
            crate::copy(&crate::example("quarter-wave"), &d.join("wave"));
            edit(
                d,
                "wave/observations/modes.csv",
                "p2_re,p2_re_sd,p2_im,p2_im_sd",
                "p1_re,p1_re_sd,p1_im,p1_im_sd",
            );
        },
        "check wave",
        ["modes.csv, line 2", "`pressure of p1` is `0.9020 +0.0066i`", "name the microphone over which"],
    ),
    case(
        "modulus below zero",
        |d| {
            let head = "point,frequency [Hz],frequency_sd [Hz],p2_abs,p2_abs_sd,p2_arg [deg],p2_arg_sd [deg]";
            wave(d, &format!("{head}\ne1-0,104.6,0.04,-3.1,0.1,2,1\n"));
        },
        "check wave",
        ["modes.csv, line 2", "`p2_abs of e1-0` is `-3.1`", "10^(dB/20)"],
    ),
    case(
        "number that stands for none",
        |d| wave(d, "point,growth_rate,growth_rate_sd,frequency,frequency_sd\ne1-0,-999,1,104.6,0.04\n"),
        "check wave",
        ["modes.csv, line 2", "`growth_rate` is `-999`", "leave a cell empty where nothing was"],
    ),
    case(
        "repeats of one mode in rows of their own",
        |d| {
            let head = "point,mode,growth_rate,growth_rate_sd,frequency,frequency_sd";
            wave(d, &format!("{head}\ne1-0,1,-5.0,0.2,104.6,0.04\ne1-0,1,-5.1,0.2,104.7,0.04\n"));
        },
        "check wave",
        ["modes.csv, line 3", "`e1-0, mode 1` has a second row", "one row with their mean"],
    ),
    case(
        "dead microphone that reads zero",
        |d| {
            let head = "point,frequency,frequency_sd,p2_re,p2_re_sd,p2_im,p2_im_sd";
            wave(d, &format!("{head}\ne1-0,104.6,0.04,0,0.1,0,0.1\ne1-40,104.6,0.04,0,0.1,0,0.1\n"));
        },
        "check wave",
        [
            "modes.csv, line 1",
            "`pressure of p2` is `0 in every row`",
            "leave the cells of a dead microphone empty",
        ],
    ),
    case(
        "measured mode whose growth rate has no error",
        |d| {
            crate::copy(&crate::example("ducted-flame"), &d.join("flame"));
            edit(d, "flame/modes.csv", "-57.31,1,", "-57.31,0,");
        },
        "infer flame/n-tau.toml --data flame/modes.csv",
        ["flame/modes.csv, line 3", "`growth_rate_sd [1/s]` is `0`", "above zero"],
    ),
    case(
        "measured mode without a frequency",
        |d| {
            crate::copy(&crate::example("ducted-flame"), &d.join("flame"));
            let table = "chamber_length [m],growth_rate [1/s],growth_rate_sd [1/s]\n0.4,-70,1\n0.5,-60,1\n";
            std::fs::write(d.join("flame/modes.csv"), table).unwrap();
        },
        "infer flame/n-tau.toml --data flame/modes.csv",
        ["flame/modes.csv, line 3", "in the region of the search; give a frequency", "Correct that row"],
    ),
    case(
        "cone where a length is unknown",
        |d| {
            let rig = "name = 'cone'\n[upstream]\ntype = 'closed'\n[downstream]\ntype = 'open'\n[[element]]\n\
                       type = 'duct'\nlength = '$reach'\ndiameter = 0.05\ndiameter_end = 0.08\n[unknown.reach]\n\
                       unit = 'm'\nprior = { normal = { mean = 0.8, sd = 0.1 } }\n";
            fs::write(d.join("cone.toml"), rig).unwrap();
            let table = "growth_rate,growth_rate_sd,frequency,frequency_sd\n-3,1,107,1\n-4,1,108,1\n";
            fs::write(d.join("cone.csv"), table).unwrap();
        },
        "infer cone.toml --data cone.csv",
        ["at operating point line-2", "straight ducts, 40 say", "both ends of the cone one of 1e-6 m"],
    ),
    case(
        "prediction before the ranking",
        |d| ranked(d, None),
        "predict study --at x_g=0.3",
        ["study/results/models/heat.json", "No such file", "Run `rijke rank study` first"],
    ),
    case(
        "report of no study",
        |_| (),
        "report elsewhere",
        ["elsewhere", "there is no such folder", "`rijke new DIR --template NAME`"],
    ),
    case(
        "file that does not exist",
        |_| (),
        "inspect run.wav",
        ["run.wav", "cannot be read", "check the name"],
    ),
    case(
        "empty file",
        |d| fs::write(d.join("run.csv"), "").unwrap(),
        "inspect run.csv",
        ["run.csv", "0 samples", "export it again"],
    ),
    case(
        "file of unknown format",
        |d| fs::write(d.join("run.gif"), "GIF89a").unwrap(),
        "inspect run.gif",
        ["run.gif", "not a WAV file", "use 16, 24 or 32 bit"],
    ),
    case(
        "file of NI TDMS",
        |d| fs::write(d.join("run.tdms"), b"TDSm\x0e\0\0\0\x69\x12\0\0").unwrap(),
        "inspect run.tdms",
        ["run.tdms", "NI TDMS, which is not read", "save it as HDF5"],
    ),
    case(
        "noise that is none",
        |_| (),
        "check . --sd 0 1 0.001",
        ["invalid value '0' for '--sd <GROWTH> <OMEGA> <PRESSURE>'", "must be positive", "--help"],
    ),
    case(
        "band of no numbers",
        |_| (),
        "process records --band nan nan",
        ["invalid value 'nan' for '--band <LOW> <HIGH>'", "must be finite", "--help"],
    ),
    case(
        "band upside down",
        |_| (),
        "process records --band 300 80",
        ["--band 300 80", "must be the lower one", "such as --band 80 300"],
    ),
    case(
        "mains of no frequency",
        |_| (),
        "process records --mains inf",
        ["invalid value 'inf' for '--mains <HZ>'", "must be finite", "--help"],
    ),
    case(
        "negative mains",
        |_| (),
        "process records --mains -50",
        ["invalid value '-50' for '--mains <HZ>'", "must be positive", "--help"],
    ),
    case(
        "mains at zero",
        |_| (),
        "process records --mains 0",
        ["invalid value '0' for '--mains <HZ>'", "must be positive", "--help"],
    ),
    case(
        "heater of a virtual record nowhere",
        |_| (),
        "flow --twin --places nan --out clicks",
        ["invalid value 'nan' for '--places <PLACES>'", "must be finite", "--help"],
    ),
    case(
        "negative frequency",
        |_| (),
        "modes tube.toml --min-hz -100",
        ["invalid value '-100' for '--min-hz <F>'", "must not be negative", "--help"],
    ),
    case(
        "negative seed",
        |_| (),
        "lab --seed -1 --out records",
        ["invalid value '-1' for '--seed <N>'", "invalid digit", "--help"],
    ),
    case("check of nothing", |_| (), "check .", [".", "holds no study.toml", "docs/study-folder.md"]),
    case(
        "template that does not exist",
        |_| (),
        "new my-rig --template trumpet",
        [
            "invalid value 'trumpet' for '--template",
            "heated-tube, quarter-wave, burner, kundt-tube",
            "--help",
        ],
    ),
    case("row that the campaign does not have", |_| (), "lab --row C9 --out records", ["C9", "C3", "H180"]),
    case(
        "rig of the laboratory that does not exist",
        |_| (),
        "lab --rig rig.toml --out records",
        ["rig.toml", "cannot be read", "check the name"],
    ),
    case(
        "campaign of another rig in the laboratory",
        |d| fs::write(d.join("campaign.csv"), "point,x_g [mm],Q [W]\na,120,0\n").unwrap(),
        "lab --campaign campaign.csv --out records",
        ["campaign.csv: factors of the heated tube", "no column `X_h`", "`x_g`, `Q`"],
    ),
    case(
        "place in the laboratory that lies outside its tube",
        |d| fs::write(d.join("campaign.csv"), "point,X_h [mm],Q_h [W]\na,1200,0\n").unwrap(),
        "lab --campaign campaign.csv --out records",
        ["campaign.csv: point `a`", "x = 1.2 m is outside the tube (0 to 1 m)", "from the bottom"],
    ),
    case(
        "truth that is none",
        |d| fs::write(d.join("truth.toml"), "gravity = 9.81\n").unwrap(),
        "lab --truth truth.toml --out records",
        ["truth.toml", "gravity", "known here: ends"],
    ),
    case(
        "laboratory for a folder of records",
        |_| (),
        "process records --seed 3 --out observations",
        ["records", "describe a virtual rig", "--virtual-rig"],
    ),
    case(
        "sweep that falls",
        |_| (),
        "lab --out made --sweep 800 80",
        ["--sweep [800.0, 80.0]", "from a lower to a higher frequency", "such as --sweep 80 800"],
    ),
    case(
        "folder that is not empty",
        |d| {
            fs::create_dir(d.join("my-rig")).unwrap();
            fs::write(d.join("my-rig/rig.toml"), "").unwrap();
        },
        "new my-rig --template heated-tube",
        ["my-rig", "exists already", "Move it away, or give another name"],
    ),
    case(
        "network without segments",
        |d| network(d, "name = \"nothing\"\n"),
        "modes tube.toml",
        ["tube.toml", "line 1", "the key `upstream` is missing"],
    ),
    case(
        "network that is no TOML",
        |d| network(d, "[[segment\n"),
        "modes tube.toml",
        ["tube.toml", "line 1", "expected"],
    ),
    case(
        "nothing to run",
        |_| (),
        "run elsewhere",
        ["elsewhere", "there is no such folder", "`rijke new DIR --template NAME`"],
    ),
];
