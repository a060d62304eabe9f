//! Studies that train on responses: what every command says of them, and what is refused.

use crate::measured::{model, noise, own_data, parameter, stage, write};
use crate::rijke;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

/// The stage of [`own_data`], with the white noise of its numbers.
const STAGE: &str = "[[responses]]\nid = \"wall\"\nwith = { mouth = \"mouth.unflanged\", head = \"head.perfect\" }\ncompete = [\"wall\"]\n";

/// A study whose data have a noise of 1e-3 on R.
fn noisy(name: &str) -> (PathBuf, Vec<[f64; 3]>) {
    let (folder, mut rows) = own_data(name);
    for (k, row) in rows.iter_mut().enumerate() {
        // dz = (z + 1)^2/2 dR.
        let (re, im) = (row[1] + 1.0, row[2]);
        let square = [re * re - im * im, 2.0 * re * im].map(|v| 0.5e-3 * v);
        let [a, b] = [noise(2 * k), noise(2 * k + 1)];
        row[1] += square[0] * a - square[1] * b;
        row[2] += square[0] * b + square[1] * a;
    }
    write(&folder, &rows);
    (folder, rows)
}

fn plan(folder: &Path, stages: &str) {
    fs::write(folder.join("study.toml"), format!("name = \"n\"\n{stages}")).unwrap();
}

fn told(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = rijke(folder, arguments);
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

/// The command ends with exit status 2 and names all of `parts`.
fn refused(folder: &Path, arguments: &[&str], parts: &[&str]) {
    let (code, _, error) = told(folder, arguments);
    assert_eq!(code, Some(2), "{arguments:?}: {error}");
    parts.iter().for_each(|part| assert!(error.contains(part), "{part}: {error}"));
}

#[test]
fn behaviour_check_and_report_know_responses() {
    let (folder, _) = noisy("responses-commands");
    let (code, said, error) = told(&folder, &["check", "."]);
    assert_eq!(code, Some(0), "{error}");
    for part in [
        "1 stage of responses",
        "reflection at plain: 59 of 59",
        "59 of the 59 complex numbers",
        "wall.bessel",
        "bore",
        "extra",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let answer: Value = serde_json::from_str(&told(&folder, &["check", ".", "--json"]).1).unwrap();
    let widths = &answer["stages"][0]["models"][0]["widths"];
    assert!(widths[0][1].as_f64().unwrap() < 0.1, "{widths}");
    // Before anything is ranked there is nothing to draw.
    refused(&folder, &["report", "."], &["results", "rijke rank"]);
    assert!(told(&folder, &["rank", "."]).0 == Some(0));
    let page = folder.join("results/index.html");
    let before = fs::read(&page).unwrap();
    fs::remove_file(&page).unwrap();
    let (code, _, error) = told(&folder, &["report", "."]);
    assert_eq!(code, Some(0), "{error}");
    assert!(fs::read(&page).unwrap() == before, "the page differs");
    let (code, said, error) = told(&folder, &["predict", ".", "--at-hz", "400", "1000:1200:100", "9000"]);
    assert_eq!((code, said.lines().count()), (Some(0), 11), "{said}{error}");
    let head: Vec<&str> = said.lines().next().unwrap().split(',').collect();
    let row: Vec<&str> = said.lines().nth(1).unwrap().split(',').collect();
    assert_eq!(
        (head[11], row[0], row[1], row[2]),
        ("absorption", "plain", "reflection at upstream", "400"),
        "{said}"
    );
    assert!(error.contains("1 of the frequencies lie beyond those that the stage was trained on"), "{error}");
    refused(&folder, &["predict", ".", "--at-hz", "99999"], &["study.toml", "no reflection", "99999"]);
    refused(&folder, &["predict", ".", "--map", "x,y"], &["--map", "trains on responses"]);
    refused(&folder, &["predict", ".", "--at-hz", "400:100:1"], &["--at-hz 400:100:1", "from:to:step"]);
    refused(&folder, &["predict", ".", "--stage", "none"], &["no stage called `none`", "wall"]);
    for arguments in [&["next", "."][..], &["modes", ".", "--point", "plain"]] {
        refused(
            &folder,
            arguments,
            &["study.toml", "train on responses", "for studies of modes", "rijke rank"],
        );
    }
}

#[test]
fn message_options_of_rank_are_obeyed_or_refused() {
    let (folder, _) = noisy("responses-options");
    let two =
        format!("{STAGE}noise = 1e-3\n{}noise = 1e-3\n", STAGE.replace("id = \"wall\"", "id = \"second\""));
    plan(&folder, &two);
    refused(
        &folder,
        &["rank", ".", "--until", "nope"],
        &["study.toml", "no stage called `nope`", "wall, second"],
    );
    refused(&folder, &["rank", ".", "--sampler", "nested"], &["--sampler", "responses", "Leave it out"]);
    assert!(!folder.join("results").exists());
    let (code, said, error) = told(&folder, &["rank", ".", "--until", "wall", "--json"]);
    assert_eq!(code, Some(0), "{error}");
    let answer: Value = serde_json::from_str(&said).unwrap();
    assert_eq!(answer["stages"].as_array().unwrap().len(), 1, "{answer}");
}

#[test]
fn message_noise_and_priors_that_the_data_contradict_are_said() {
    let (folder, _) = noisy("responses-doubts");
    plan(&folder, &format!("{STAGE}noise = 2e-4\n"));
    let (_, said, error) = told(&folder, &["rank", ".", "--json"]);
    let answer: Value = serde_json::from_str(&said).unwrap();
    let remark = &model(stage(&answer, "wall"), "wall.bessel")["remark"];
    let text = remark.as_str().unwrap_or_default();
    assert!(
        text.contains("times as large as the stated noise") && text.contains("state a larger noise"),
        "{answer}"
    );
    // Of noise that is inferred already nobody is told to infer it.
    plan(&folder, &format!("{STAGE}noise = {{ median = 2e-4, ln_sd = 0.01 }}\n"));
    let (_, said, _) = told(&folder, &["rank", ".", "--json", "--force"]);
    let answer: Value = serde_json::from_str(&said).unwrap();
    let remark = &model(stage(&answer, "wall"), "wall.bessel")["remark"];
    let text = remark.as_str().unwrap_or_default();
    assert!(
        text.contains("the inferred noise lets expect") && !text.contains("let it be inferred"),
        "{answer}"
    );
    assert!(!error.contains("prior"), "{error}");
    let rig = fs::read_to_string(folder.join("rig.toml")).unwrap();
    fs::write(folder.join("rig.toml"), rig.replace("mean = 1.95e-3, sd = 1e-4", "mean = 1.95e-3, sd = 5e-6"))
        .unwrap();
    plan(&folder, &format!("{STAGE}noise = 1e-3\n"));
    let (code, _, error) = told(&folder, &["rank", ".", "--force"]);
    assert_eq!(code, Some(0), "{error}");
    assert!(
        error.contains("warning: bore lies") && error.contains("sd of its prior from the prior mean"),
        "{error}"
    );
}

#[test]
fn message_data_count_once() {
    let (folder, _) = noisy("responses-twice");
    let path = folder.join("observations/observations.toml");
    let text = fs::read_to_string(&path).unwrap();
    let entry = &text[text.find("[[response]]").unwrap()..];
    fs::write(&path, format!("{text}{entry}")).unwrap();
    refused(
        &folder,
        &["rank", "."],
        &["observations.toml, line 9", "z.txt", "plain", "100 Hz", "declared already", "remove one"],
    );
    // Two halves of a band are two data.
    let half = |band: &str| entry.replace("files =", &format!("band_hz = {band}\nfiles ="));
    let head = &text[..text.find("[[response]]").unwrap()];
    fs::write(&path, format!("{head}{}{}", half("[0, 1500]"), half("[1501, 9000]"))).unwrap();
    assert_eq!(told(&folder, &["check", "."]).0, Some(0));
    fs::write(&path, &text).unwrap();
    let second = STAGE.replace("id = \"wall\"", "id = \"again\"\non = [\"wall\"]");
    plan(&folder, &format!("{STAGE}noise = 1e-3\n{second}noise = 1e-3\n"));
    for command in ["check", "rank"] {
        refused(
            &folder,
            &[command, "."],
            &["stage `again`", "stands on `wall`", "59 of its 59", "count once"],
        );
    }
    plan(
        &folder,
        &format!("{STAGE}band_hz = [0, 1500]\nnoise = 1e-3\n{second}band_hz = [1501, 9000]\nnoise = 1e-3\n"),
    );
    let (code, _, error) = told(&folder, &["rank", "."]);
    assert_eq!(code, Some(0), "{error}");
}

#[test]
fn message_bands_transfers_and_sds_that_cannot_be_meant_are_refused() {
    let (folder, rows) = noisy("responses-meant");
    let path = folder.join("observations/observations.toml");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, text.replace("files =", "band_hz = [100, 500]\nfiles =")).unwrap();
    let (code, said, error) = told(&folder, &["rank", "."]);
    assert_eq!(code, Some(0), "{error}");
    assert!(error.contains("leaves 9 of 59 frequencies") && error.contains("f [rad/s]"), "{error}");
    assert!(said.contains("9 of the 59 complex numbers"), "{said}");
    plan(&folder, &format!("{STAGE}band_hz = [5000, 6000]\nnoise = 1e-3\n"));
    refused(
        &folder,
        &["check", "."],
        &["study.toml", "stage `wall`", "no frequency of its responses", "band_hz"],
    );
    plan(&folder, &format!("{STAGE}noise = 0\n"));
    refused(&folder, &["check", "."], &["study.toml", "`noise = 0`", "column `sd`"]);
    plan(&folder, &format!("base = \"states\"\n{STAGE}noise = 1e-3\n"));
    refused(&folder, &["check", "."], &["study.toml", "gas at rest", "base = \"rig\""]);
    plan(&folder, &format!("{STAGE}noise = 1e-3\n"));
    // One complex number is less than three parameters.
    fs::write(&path, text.replace("files =", "band_hz = [100, 149]\nfiles =")).unwrap();
    let rig = fs::read_to_string(folder.join("rig.toml")).unwrap();
    let further = "length = \"$l\"\n[unknown.l]\nunit = \"m\"\nprior = { normal = { mean = 0.436, sd = 1e-3 } }\n[unknown.bore]";
    let (before, after) = rig.split_once("[unknown.bore]").unwrap();
    let three = format!("{}{}{after}", before.replace("length = \"436 mm\"\n", ""), "[unknown.bore]");
    let three = three.replace("type = \"duct\"\n", "type = \"duct\"\nlength = \"$l\"\n");
    let three = format!("{three}\n{}", further.split_once('\n').unwrap().1.replace("[unknown.bore]", ""));
    fs::write(folder.join("rig.toml"), three).unwrap();
    refused(
        &folder,
        &["rank", ".", "--force"],
        &["stage `wall`", "3 free parameters", "2 real numbers", "take more frequencies"],
    );
    fs::write(folder.join("rig.toml"), format!("{rig}\n[microphones]\nat = [0.1, 0.2]\n")).unwrap();
    let transfer = "kind = \"virtual\"\nsource = \"s\"\n[[response]]\nkind = \"transfer\"\nat = \"p1\"\nover = \"p1\"\n\
                    columns = [\"f [Hz]\", \"re [1]\", \"im [1]\"]\nfiles = { plain = \"z.txt\" }\n";
    fs::write(&path, transfer).unwrap();
    refused(&folder, &["check", "."], &["observations.toml, line 3", "`over` is `p1`", "another microphone"]);
    fs::write(&path, text.replace("\"im [1]\"", "\"im [1]\", \"sd [1]\"")).unwrap();
    let lines: String = rows.iter().map(|[f, a, b]| format!("{f} {a} {b} 0\n")).collect();
    fs::write(folder.join("observations/z.txt"), lines).unwrap();
    refused(&folder, &["check", "."], &["z.txt, line 1", "`sd` is `0`", "above zero"]);
}

#[test]
fn behaviour_stated_errors_count_and_are_said() {
    let (folder, _) = noisy("responses-stated");
    let found = |sd: f64| {
        let table = format!("point,row,session,T_amb [K],T_amb_sd [K]\nplain,plain,1,293.15,{sd}\n");
        fs::write(folder.join("campaign.csv"), table).unwrap();
        let (_, checked, _) = told(&folder, &["check", "."]);
        let (code, ranked, error) = told(&folder, &["rank", ".", "--force"]);
        assert_eq!(code, Some(0), "{error}");
        let numbers = fs::read_to_string(folder.join("results/numbers/wall.json")).unwrap();
        let numbers: Value = serde_json::from_str(&numbers).unwrap();
        let [_, sd_of_extra] = parameter(model(&numbers, "wall.bessel"), "extra");
        let page = fs::read_to_string(folder.join("results/index.html")).unwrap();
        (checked, ranked, page, sd_of_extra)
    };
    let exact = found(0.0);
    assert!(!exact.0.contains("counted along") && !exact.2.contains("in their stated standard deviations"));
    let stated = found(2.0);
    assert!(stated.0.contains("counted along: error of T_amb (plain)"), "{}", stated.0);
    let said = ["error of T_amb (plain)", "1 stated error is counted"];
    assert!(said.iter().any(|part| stated.1.contains(part)), "{}", stated.1);
    assert!(stated.2.contains("in their stated standard deviations"), "{}", stated.2);
    // 2 K are 1.5 mm of a tube of 436 mm.
    assert!(stated.3 > 3.0 * exact.3 && stated.3 < 1.6e-3, "{} {}", stated.3, exact.3);
}

#[test]
fn behaviour_check_without_the_data_says_that_they_are_not_here() {
    let folder = crate::scratch("responses-elsewhere");
    crate::copy(&crate::example("plain-tube"), &folder);
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_rijke"))
        .args(["check", "."])
        .current_dir(&folder)
        .env_remove("RIJKE_MEASURED")
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{error}");
    assert!(
        error.contains("warning")
            && error.contains("RIJKE_MEASURED")
            && error.contains("https://github.com/"),
        "{error}"
    );
}

#[test]
fn behaviour_a_law_may_be_measured_at_a_part_whose_numbers_its_factor_does_not_name() {
    let folder = crate::scratch("responses-numbers");
    for sub in ["candidates", "observations"] {
        fs::create_dir_all(folder.join(sub)).unwrap();
    }
    let write = |file: &str, text: &str| fs::write(folder.join(file), text).unwrap();
    write(
        "rig.toml",
        "name = \"t\"\n[gas]\ntemperature = 293.15\n[search]\nfrequency_hz = [50, 150]\n[upstream]\ntype = \"closed\"\n[downstream]\n\
         type = \"open\"\n[[element]]\nname = \"tube\"\ntype = \"duct\"\nlength = 1.0\ndiameter = 0.05\n[[element]]\nname = \"flame\"\n\
         type = \"device\"\nat = 0.4\nnumbers = { width = \"10 mm\", theta = 5.3 }\n",
    );
    write("campaign.csv", "point,row\nalone,flame\n");
    write(
        "candidates/all.toml",
        "[[candidate]]\nid = \"one\"\nrole = \"flame\"\nname = \"one\"\ncite = [\"a test\"]\n\
         parameters.n = { unit = \"1\", prior = { normal = { mean = 0.4, sd = 4.0 } } }\n\
         [[candidate.effect]]\nacts_at = \"flame\"\neu = \"n\"\n",
    );
    write(
        "study.toml",
        "name = \"t\"\nbase = \"rig\"\n[[responses]]\nid = \"alone\"\npoints = {}\ncompete = [\"flame\"]\nnoise = 0.03\n",
    );
    let rows: String =
        (1..9).map(|k: i32| format!("{} -0.5 {}\n", 50 * k, 0.01 * (f64::from(k) - 4.5))).collect();
    write("observations/law.txt", &rows);
    // The factor times the law is what was measured, -0.5.
    for (factor, law) in [("", 0.5), ("factor = \"-1/theta\"\n", 0.5 * 5.3), ("factor = \"-2\"\n", 0.25)] {
        let head = "kind = \"virtual\"\nsource = \"a test\"\n[[response]]\nkind = \"flame-transfer-function\"\nat = \"flame\"\n";
        let tail = "columns = [\"f [Hz]\", \"re [1]\", \"im [1]\"]\nband_hz = [10, 500]\nfiles = { alone = \"law.txt\" }\n";
        write("observations/observations.toml", &format!("{head}{factor}{tail}"));
        let (code, _, error) = told(&folder, &["rank", ".", "--force"]);
        assert_eq!(code, Some(0), "{factor}: {error}");
        let numbers = fs::read_to_string(folder.join("results/numbers/alone.json")).unwrap();
        let numbers: Value = serde_json::from_str(&numbers).unwrap();
        let [n, sd] = parameter(model(&numbers, "one"), "n");
        assert!((n - law).abs() < 6.0 * sd, "{factor}: {n} +- {sd} for {law}");
    }
}
