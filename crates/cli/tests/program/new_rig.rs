//! A new user's way: an empty folder, files to fill in, records, ranked models.

use crate::{rijke, scratch};
use std::{fs, path::Path};

/// Runs a command that must succeed; returns what it prints.
fn done(folder: &Path, command: &str) -> String {
    let output = rijke(folder, &command.split(' ').collect::<Vec<_>>());
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "rijke {command}\n{said}");
    String::from_utf8(output.stdout).unwrap() + &said
}

#[test]
fn lab_from_an_empty_folder_to_ranked_models() {
    let folder = scratch("new-rig");
    done(&folder, "new my-rig");
    // Records are still missing: the first one is named.
    let output = rijke(&folder, &["check", "my-rig"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(2) && said.contains("my-rig/P-E/ping-0.wav"), "{said}");
    // What is written by hand is never replaced.
    assert_eq!(rijke(&folder, &["new", "my-rig"]).status.code(), Some(2));

    done(&folder, "lab --rig my-rig/rig.toml --campaign my-rig/campaign.toml --repeats 3 --out records");
    let found = done(&folder, "inspect records/P-E/ping-00.wav");
    assert!(found.contains("WAV, 24 bit integers, 8 channels of 15000 samples at 10000 Hz"), "{found}");
    done(&folder, "run records");
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

    // Nothing is replaced without being asked, and what is finished is kept.
    let again = rijke(&folder, &["run", "records"]);
    let said = String::from_utf8(again.stderr).unwrap();
    assert!(again.status.code() == Some(2) && said.contains("--force"), "{said}");
    fs::remove_dir_all(folder.join("records/results")).unwrap();
    let said = done(&folder, "run records");
    assert!(
        said.contains("records/observations: kept") && said.contains("records/base-flow: kept"),
        "{said}"
    );
}

#[test]
fn exact_candidates_are_checked_before_they_are_trained() {
    let folder = scratch("candidates");
    done(&folder, "new my-rig");
    let found = done(&folder, "candidate my-rig/candidates.toml --campaign my-rig/campaign.toml");
    assert!(found.contains("my-heat-release.2") && found.contains("all in order"), "{found}");
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
