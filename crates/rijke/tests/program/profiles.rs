//! Temperatures along the tube in the place of clicks: what is given is what acoustics gets.

use crate::{bad_input::observations, rijke, scratch};
use rijke_flow::BaseStates;
use std::fs;

#[test]
fn exact_profiles_become_base_states() {
    let folder = scratch("profiles");
    observations::write(&folder);
    let files = folder.join("data/observations");
    let rows = "point,at [m],temperature [K],sd [K]\nC3-05,0.2,300,0.5\nC3-05,0.8,320,0.5\n";
    fs::write(files.join("profiles.csv"), rows).unwrap();
    let output = rijke(&folder, &["flow", "data", "--out", "base-flow"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let states = BaseStates::read(&folder.join("base-flow")).unwrap();
    assert_eq!((states.points.len(), states.points["C3-05"].temperature(0.5)), (1, 310.0));

    fs::write(files.join("profiles.csv"), rows.replace("300,", "27,")).unwrap();
    let output = rijke(&folder, &["flow", "data", "--out", "other"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{said}");
    for part in ["profiles.csv", "line 2", "give kelvin"] {
        assert!(said.contains(part), "{said}");
    }
}
