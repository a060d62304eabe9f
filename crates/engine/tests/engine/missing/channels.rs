//! Errors of microphones among the terms.

use super::variants::{QUARTER_WAVE, Variant};
use std::fs;

/// A microphone that shows a twentieth too much is told as that, not as a force that nobody put into the rig.
#[test]
fn exact_a_wrong_gain_is_asked_for_by_the_name_of_its_microphone() {
    let with = "with = { heat-release = \"heat.king-lighthill\" }\n";
    let wrong = Variant::new("wrong-gain", &QUARTER_WAVE).stage(with);
    let path = wrong.path("observations/modes.csv");
    let text = fs::read_to_string(&path).unwrap();
    let head: Vec<String> = text.lines().next().unwrap().split(',').map(str::to_owned).collect();
    let scaled = |line: &str| {
        let cells = line.split(',').zip(&head).map(|(cell, name)| match cell.parse::<f64>() {
            Ok(v) if ["p2_re", "p2_im"].contains(&name.as_str()) => (1.05 * v).to_string(),
            _ => cell.to_owned(),
        });
        cells.collect::<Vec<_>>().join(",")
    };
    let rows: Vec<String> = text.lines().skip(1).map(scaled).collect();
    fs::write(&path, format!("{}\n{}\n", head.join(","), rows.join("\n"))).unwrap();
    for stage in wrong.run() {
        let missing = stage.missing.unwrap();
        let first = &missing.families[0].first;
        assert_eq!(
            (first.effect.as_str(), first.place.as_str()),
            ("gain error", "microphone p2"),
            "{first:?}"
        );
        assert!((first.strength[0] - 0.05).abs() < 5.0 * first.strength[1] + 0.005, "{first:?}");
    }
}
