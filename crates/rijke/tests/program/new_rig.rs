//! A new user's way: an empty folder, files to fill in, records or numbers, ranked models.

use crate::{book::follow, copy, example, rijke, scratch};
use std::{fs, path::Path};

const TEMPLATES: [&str; 4] = ["heated-tube", "quarter-wave", "burner", "kundt-tube"];

/// Runs a command that must succeed; returns what it prints.
fn done(folder: &Path, command: &str) -> String {
    let output = rijke(folder, &command.split(' ').collect::<Vec<_>>());
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "rijke {command}\n{said}");
    String::from_utf8(output.stdout).unwrap() + &said
}

/// The tutorial as it stands, and then what it does not say.
#[test]
fn lab_the_tutorial_leads_from_an_empty_folder_to_ranked_models() {
    let folder = scratch("tutorial");
    follow(include_str!("../../../../docs/tutorial.md"), &folder);
    // Its pictures are those of this run.
    for name in ["cold", "heat-release"] {
        let drawn = fs::read_to_string(folder.join(format!("my-rig/results/figures/{name}.svg"))).unwrap();
        let shown = format!("{}/../../docs/images/tutorial-{name}.svg", env!("CARGO_MANIFEST_DIR"));
        if std::env::var_os("RIJKE_WRITE").is_some() {
            fs::write(&shown, &drawn).unwrap();
        }
        assert!(fs::read_to_string(&shown).unwrap_or_default() == drawn, "{shown} is of another run");
    }
    // What is written by hand is never replaced.
    assert_eq!(rijke(&folder, &["new", "my-rig", "--template", "burner"]).status.code(), Some(2));
    let page = fs::read_to_string(folder.join("my-rig/results/index.html")).unwrap();
    for item in ["Virtual data", "The rods: drag and blockage", "my-heat-release", "All cold points"] {
        assert!(page.contains(item), "the page lacks {item}");
    }
    // Every hot point was stable, and none is called unstable.
    let rows = fs::read_to_string(folder.join("growth.csv")).unwrap();
    let head = rows.lines().next().unwrap().split(',');
    let at = head.into_iter().position(|name| name.starts_with("probability_of_instability")).unwrap();
    let probability = |line: &str| line.split(',').nth(at).unwrap().parse::<f64>().unwrap();
    assert!(rows.contains("\nH130-85,0.85,") && rows.lines().count() > 14, "{rows}");
    assert!(rows.lines().skip(1).all(|line| (0.0..0.5).contains(&probability(line))), "{rows}");

    // Between places of the heater the flow is foreseen: the mode is near those of the neighbours, and its
    // frequency is known less well.
    let asked =
        done(&folder, "predict my-rig --at X_h=0.30,Q_h=130 --at X_h=0.25,Q_h=130 --at X_h=0.35,Q_h=130");
    let numbers =
        |line: &str| -> Vec<f64> { line.split(',').skip(5).map_while(|cell| cell.parse().ok()).collect() };
    let lines: Vec<Vec<f64>> = asked.lines().filter(|l| l.contains(",130,")).map(numbers).collect();
    let [between, low, high] = lines.as_slice() else { panic!("{asked}") };
    for k in [0, 3] {
        let off = between[k] - 0.5 * (low[k] + high[k]);
        assert!(off.abs() < 2.0 * between[k + 2], "{asked}");
    }
    assert!(between[5] > low[5].max(high[5]), "{asked}");

    // What is finished is kept.
    fs::remove_dir_all(folder.join("my-rig/results")).unwrap();
    let [observations, base] =
        ["observations/pings.csv", "base/states.json"].map(|f| folder.join("my-rig").join(f));
    let before = [&observations, &base].map(|f| fs::metadata(f).unwrap().modified().unwrap());
    done(&folder, "run my-rig --one-start");
    assert_eq!(before, [&observations, &base].map(|f| fs::metadata(f).unwrap().modified().unwrap()));
}

#[test]
fn behaviour_every_template_passes_its_check() {
    let folder = scratch("templates");
    for name in TEMPLATES {
        let said = done(&folder, &format!("new {name} --template {name}"));
        assert!(said.contains("then: rijke check"), "{said}");
        let said = done(&folder, &format!("check {name}"));
        assert!(said.contains("nothing is measured yet"), "{name}: {said}");
        // Comments say what to do, and every stage has points.
        for file in ["rig.toml", "campaign.csv", "study.toml"] {
            let text = fs::read_to_string(folder.join(name).join(file)).unwrap();
            assert!(text.lines().filter(|line| line.contains('#')).count() > 1, "{name}/{file}");
        }
        assert!(!said.contains("(0 operating points)"), "{name}: {said}");
    }
}

#[test]
fn behaviour_drafts_are_read_where_they_belong() {
    let folder = scratch("drafts");
    for name in TEMPLATES {
        done(&folder, &format!("new {name} --template {name}"));
        let study = folder.join(name);
        // The manifest is sound: what it misses is the first file that it names.
        copy(&study.join("draft/records"), &study.join("records"));
        let output = rijke(&folder, &["check", name]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(
            said.contains("records/manifest.toml") && said.contains("there is no file"),
            "{name}: {said}"
        );
        fs::remove_dir_all(study.join("records")).unwrap();
        if study.join("draft/observations").is_dir() {
            copy(&study.join("draft/observations"), &study.join("observations"));
            let said = done(&folder, &format!("check {name}"));
            assert!(said.contains("observations: ") && said.contains(" modes"), "{name}: {said}");
        }
    }
}

/// A tube of this kind, its files filled in with what was measured on another.
#[test]
fn lab_the_quarter_wave_template_runs_on_the_data_of_the_example() {
    let folder = scratch("quarter-wave-template");
    done(&folder, "new rig --template quarter-wave");
    let (from, to) = (example("quarter-wave"), folder.join("rig"));
    fs::copy(from.join("campaign.csv"), to.join("campaign.csv")).unwrap();
    copy(&from.join("observations"), &to.join("observations"));
    let said = done(&folder, "run rig --one-start");
    assert!(said.contains("heat.king-lighthill  <- goes on"), "{said}");
    let delay = said.lines().rfind(|line| line.trim_start().starts_with("k2 = ")).unwrap();
    // examples/quarter-wave/truth.toml expects 2.48.
    let value: f64 = delay.split_whitespace().nth(2).unwrap().parse().unwrap();
    assert!((value - 2.48).abs() < 0.2, "{delay}");
}

#[test]
fn exact_manual_pages_name_every_command() {
    let folder = scratch("manual");
    done(&folder, "man --out man");
    let page = fs::read_to_string(folder.join("man/rijke.1")).unwrap();
    for name in ["rijke\\-rank(1)", "rijke\\-predict(1)", "rijke\\-new(1)"] {
        assert!(page.contains(name), "{name} is missing in\n{page}");
    }
    assert!(folder.join("man/rijke-run.1").is_file());
}
