//! Numbers of an OSCILOS_lite folder that look like another unit.

use super::oscilos::{OscilosTexts, rows};
use rijke_numerics::slips::is_too_long;
use rijke_numerics::words::to_digits;
use std::f64::consts::PI;

/// Delays below this, ms, are those of no flame and no end: in seconds they would be.
const SHORT: f64 = 0.05;

/// What looks like another unit in a folder that can be read.
#[must_use]
pub fn doubts_of_oscilos(texts: &OscilosTexts) -> Vec<String> {
    let first =
        |file, text: &str, columns| rows(file, text, columns).map(|mut rows| rows.swap_remove(0)).ok();
    let mut doubts = of_the_geometry(texts);
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

/// Positions that look like millimetres, and more heat than OSCILOS_lite allows.
fn of_the_geometry(texts: &OscilosTexts) -> Vec<String> {
    let read = |file, text: &str, columns| rows(file, text, columns).ok();
    let Some(sections) = read("Geometry.txt", &texts.geometry, 4) else { return Vec::new() };
    let first = |file, text: &str| read(file, text, 6).and_then(|rows| rows.into_iter().next());
    let mut doubts = Vec::new();
    if let (Some(flow), Some(scan)) =
        (first("Mean_flow.txt", &texts.mean_flow), first("Scan_range.txt", &texts.scan_range))
    {
        let length = sections.iter().map(|row| row[0]).fold(0.0, f64::max);
        let wavelength = (1.4 * 287.0 * flow[1]).sqrt() / scan[1];
        if is_too_long(length, wavelength) {
            doubts.push(format!(
                "Geometry.txt: the rig is {} m long, {:.0} wavelengths at {} Hz, which looks like millimetres: give positions and radii in m, {} m in all",
                to_digits(length, 6),
                length / wavelength,
                scan[1],
                to_digits(1e-3 * length, 6)
            ));
        }
    }
    // The first row is the inlet, whatever its index is.
    let heated = sections.iter().skip(1).filter(|row| matches!(row[2], 10.0 | 11.0)).count();
    if heated > 1 {
        doubts.push(format!(
            "Geometry.txt: {heated} sections are heated (index 10 or 11), each by the whole ratio of temperatures; OSCILOS_lite refuses more than one: write 0 \
             for those that are not"
        ));
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

    #[test]
    fn message_millimetres_and_two_heats_are_said() {
        let of = |geometry: &str| {
            doubts_of_oscilos(&OscilosTexts {
                geometry: geometry.to_owned(),
                mean_flow: "P T\n101325 400 2 4 1 4.5\n".to_owned(),
                scan_range: "f\n40 700 50 -400 300 30\n".to_owned(),
                inlet: "Type\n2 0 0 0\n".to_owned(),
                outlet: "Type\n1 0 0 0\n".to_owned(),
                ..OscilosTexts::default()
            })
        };
        let said = of("x r\n0 50 0 0\n400 45 11 0\n1100 45 0 0\n");
        assert!(
            said.len() == 1 && said[0].contains("1100 m long") && said[0].contains("1.1 m in all"),
            "{said:?}"
        );
        let said = of("x r\n0 0.05 0 0\n0.3 0.04 10 0\n0.4 0.045 11 0\n1.1 0.045 0 0\n");
        assert!(said.len() == 1 && said[0].contains("2 sections are heated"), "{said:?}");
        assert!(of("x r\n0 0.05 11 0\n0.4 0.045 11 0\n1.1 0.045 0 0\n").is_empty());
    }
}
