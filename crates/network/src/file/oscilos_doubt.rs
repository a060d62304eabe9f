//! Numbers of an OSCILOS_lite folder that look like another unit.

use super::oscilos::{OscilosTexts, rows};
use std::f64::consts::PI;

/// Delays below this, ms, are those of no flame and no end: in seconds they would be.
const SHORT: f64 = 0.05;

/// What looks like another unit in a folder that can be read.
#[must_use]
pub fn doubts_of_oscilos(texts: &OscilosTexts) -> Vec<String> {
    let first =
        |file, text: &str, columns| rows(file, text, columns).map(|mut rows| rows.swap_remove(0)).ok();
    let mut doubts = Vec::new();
    let mut delay = |file: &str, ms: f64| {
        if ms > 0.0 && ms < SHORT {
            doubts.push(format!(
                "{file}: the delay is {ms} ms, which looks like seconds: write {} for {ms} s",
                1e3 * ms
            ));
        }
    };
    if let Some(row) = texts.flame.as_ref().and_then(|text| first("Flame.txt", text, 3)) {
        delay("Flame.txt", row[2]);
    }
    let ends = [("Inlet.txt", &texts.inlet), ("Outlet.txt", &texts.outlet)];
    let ends = ends.map(|(file, text)| Some((file, first(file, text, 4)?)));
    for (file, row) in ends.iter().flatten().filter(|(_, row)| row[0] == 4.0) {
        delay(file, row[2]);
    }
    for (file, row) in ends.iter().flatten().filter(|(_, row)| row[0] == 5.0) {
        if row[3] == 0.0 && row[2].abs() > 2.0 * PI {
            doubts.push(format!(
                "{file}: the phase is {} rad, more than a turn, which looks like degrees: write 1 in the next column \
                 for degrees",
                row[2]
            ));
        }
    }
    doubts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn message_a_delay_in_seconds_and_a_phase_in_degrees_are_said() {
        let of = |delay: &str, phase: &str| {
            doubts_of_oscilos(&OscilosTexts {
                flame: Some(format!("Type a tau\n1 1 {delay}\n")),
                inlet: format!("Type\n5 0.9 {phase}\n"),
                outlet: format!("Type\n4 0.9 {delay} 0\n"),
                ..OscilosTexts::default()
            })
        };
        let said = of("0.003", "28.6 0");
        assert_eq!(said.len(), 3, "{said:?}");
        assert!(said[0].starts_with("Flame.txt") && said[0].contains("looks like seconds"), "{said:?}");
        assert!(said[1].starts_with("Outlet.txt"), "{said:?}");
        assert!(said[2].starts_with("Inlet.txt") && said[2].contains("looks like degrees"), "{said:?}");
        assert!(of("3", "28.6 1").is_empty() && of("0", "0.5 0").is_empty());
    }
}
