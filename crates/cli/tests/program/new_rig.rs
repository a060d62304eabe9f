//! A new user's way: an empty folder, files to fill in, records, ranked models.

use crate::{book::follow, rijke, scratch};
use std::{fs, path::Path};

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
    // What is written by hand is never replaced.
    assert_eq!(rijke(&folder, &["new", "my-rig"]).status.code(), Some(2));
    own_candidates_compete(&folder);
    let page = fs::read_to_string(folder.join("records/results/index.html")).unwrap();
    for item in ["Table 1", "Figure 2", "Figure 4", "Table 4", "Figure 10"] {
        assert!(page.contains(item), "the page lacks {item}");
    }
    let rows = done(
        &folder,
        "predict records/results/model.json --flow records/base-flow --campaign my-rig/campaign.toml",
    );
    assert!(
        rows.starts_with("point,position_m,power_w,growth_rate_per_s")
            && rows.contains("\nH130-85,0.85,130,")
    );
    // Probabilities are in [0, 1], and these stable points are not called unstable.
    let probability = |line: &str| line.rsplit_once(',').unwrap().1.parse::<f64>().unwrap();
    assert!(rows.lines().skip(1).all(|line| (0.0..0.5).contains(&probability(line))), "{rows}");

    design(&folder);

    // What is finished is kept.
    fs::remove_dir_all(folder.join("records/results")).unwrap();
    let said = done(&folder, "run records");
    assert!(
        said.contains("records/observations: kept") && said.contains("records/base-flow: kept"),
        "{said}"
    );
}

/// The stability map, and what would make the rig more stable.
fn design(folder: &Path) {
    let model = "records/results/model.json --flow records/base-flow --campaign my-rig/campaign.toml";
    let svg = fs::read_to_string(folder.join("stability.svg")).unwrap();
    assert!(
        svg.contains("probability of instability") && svg.contains("virtual data") && !svg.contains("NaN")
    );
    assert_eq!(fs::read_to_string(folder.join("stability.csv")).unwrap().lines().count(), 15);
    let said =
        done(folder, &format!("sensitivity {model} --point H130-25,H50-75 --plot s.svg --along s.csv"));
    assert!(
        said.contains("H130-25: growth rate -") && said.contains("a screen that takes 0.01 rho c u"),
        "{said}"
    );
    assert!(fs::read_to_string(folder.join("s.csv")).unwrap().contains("\nH50-75,"));
    let output = rijke(folder, &format!("sensitivity {model} --point H9-99").split(' ').collect::<Vec<_>>());
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        output.status.code() == Some(2) && said.contains("H9-99") && said.contains("Give one of H50-15"),
        "{said}"
    );
}

/// The file that `rijke new` writes: its first candidate is model 2 of Table 4 under another name, and must get the same evidence.
fn own_candidates_compete(folder: &Path) {
    let text = fs::read_to_string(folder.join("records/results/numbers/heat_release.json")).unwrap();
    let table: rijke_studies::HeatRelease = serde_json::from_str(&text).unwrap();
    let evidence = |id: &str| table.models.iter().find(|m| m.id == id).unwrap().evidence.unwrap();
    assert_eq!(evidence("my-heat-release.1"), evidence("heat-release.2"));
    assert!(evidence("my-heat-release.2") != evidence("heat-release.2"));
    // Beside it, what the project adds to a heat release.
    let combined = table.models.iter().find(|m| m.id.starts_with("my-heat-release.1 + mean-flow")).unwrap();
    assert!(combined.evidence.unwrap().ln_marginal > evidence("my-heat-release.1").ln_marginal);
}

#[test]
fn exact_candidates_are_checked_before_they_are_trained() {
    let folder = scratch("candidates");
    done(&folder, "new my-rig");
    let found = done(&folder, "candidate my-rig/candidates.toml --campaign my-rig/campaign.toml");
    assert!(found.contains("my-heat-release.2") && found.contains("all in order"), "{found}");
    assert_eq!(
        done(&folder, "candidate check my-rig/candidates.toml --campaign my-rig/campaign.toml"),
        found
    );
    assert!(done(&folder, "candidate --symbols").contains("U_h"));
    // The catalogue of the paper passes its own check.
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/candidates");
    for entry in fs::read_dir(fixtures).unwrap() {
        done(&folder, &format!("candidate {}", entry.unwrap().path().display()));
    }

    let spoil = |from: &str, to: &str, says: &[&str]| {
        let text = fs::read_to_string(folder.join("my-rig/candidates.toml")).unwrap();
        assert!(text.contains(from));
        fs::write(folder.join("bad.toml"), text.replacen(from, to, 1)).unwrap();
        let output = rijke(&folder, &["candidate", "bad.toml"]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{said}");
        for part in says {
            assert!(said.contains(part), "no `{part}` in\n{said}");
        }
    };
    spoil("exp(-s * k2)", "exp(-s * k3)", &["bad.toml", "k3"]);
    spoil("k1 * Q_h * exp(-s * k2)", "k1 * Q_h", &["bad.toml", "my-heat-release.1", "k2"]);
    spoil("-k1 * Q_h * exp", "-k1 / Q_h ^ 400 * exp", &["bad.toml", "not finite"]);
    spoil("-k1 * Q_h * exp", "-k1 * Q_h * s * exp", &["bad.toml", "its unit is s^-1, where 1 is wanted"]);
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
