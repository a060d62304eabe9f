//! Records over time: what is refused, and what is drawn.

use crate::{rijke, scratch};
use std::fs;
use std::path::Path;

const SAMPLES: &str = "clicks/heater-250mm.csv";

/// A virtual record with its first `keep` samples.
fn clicks(folder: &Path, keep: usize) -> Vec<String> {
    let output = rijke(folder, &["flow", "--twin", "--places", "0.25", "--out", "clicks"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = fs::read_to_string(folder.join(SAMPLES)).unwrap();
    text.lines().take(1 + keep).map(String::from).collect()
}

#[test]
fn exact_bad_samples_are_refused() {
    let folder = scratch("flow-over-time");
    let lines = clicks(&folder, 300);
    let with = |line: usize, column: usize, value: &str| {
        let mut lines = lines.clone();
        let mut fields: Vec<&str> = lines[line].split(',').collect();
        fields[column] = value;
        lines[line] = fields.join(",");
        lines.join("\n") + "\n"
    };
    let first_lines = lines[..3].join("\n") + "\n";
    // A row that was repeated by a slip, more often than there are samples of three days.
    let many = format!("{}\n{}", lines[0], format!("{}\n", lines[1]).repeat(20_001));
    let cases = [
        (many, [SAMPLES, "20001 samples are more than the 20000", "check whether a row was repeated"]),
        (with(1, 0, "7"), [SAMPLES, "the first sample was taken at 7 W", "start with samples at 0 W"]),
        (
            with(5, 1, "-20"),
            [SAMPLES, "line 6: the ambient temperature is -20 K", "give kelvin, not Celsius"],
        ),
        (
            with(5, 1, "180"),
            [SAMPLES, "line 6: the ambient temperature is 180 K", "air hold from 210 to 1800 K"],
        ),
        (with(5, 1, "2000"), [SAMPLES, "line 6: the ambient temperature is 2000 K", "Correct the file"]),
        (with(5, 1, "NaN"), [SAMPLES, "line 6: the ambient temperature is NaN K", "give kelvin"]),
        (with(260, 0, "-30"), [SAMPLES, "line 261: the heater power is -30 W", "zero or positive"]),
        (first_lines, [SAMPLES, "16 readings cannot fix 18 unknowns", "add samples or sensors"]),
        (with(7, 3, ""), [SAMPLES, "line 8, column arrival_1_s", "is not a number"]),
        (with(251, 0, "1e9"), ["clicks", "no mass flow balances buoyancy and losses", "Compare powers"]),
    ];
    for (text, says) in cases {
        fs::write(folder.join(SAMPLES), text).unwrap();
        let output = rijke(&folder, &["flow", "clicks", "--out", "base-flow"]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{said}");
        for part in says {
            assert!(said.contains(part), "`{part}` is not in: {said}");
        }
        assert!(!folder.join("base-flow").exists(), "{said}");
    }
    // The file that is missing is named once.
    let path = folder.join("clicks/flow.toml");
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains("\"tube.toml\""));
    fs::write(path, text.replace("\"tube.toml\"", "\"none.toml\"")).unwrap();
    let output = rijke(&folder, &["flow", "clicks", "--out", "base-flow"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.starts_with("error: clicks/none.toml: cannot be read"), "{said}");
}

#[test]
fn exact_a_filter_is_drawn_beside_the_batch_fit() {
    let folder = scratch("flow-plot");
    let lines = clicks(&folder, 300);
    fs::write(folder.join(SAMPLES), lines.join("\n") + "\n").unwrap();
    let output = rijke(&folder, &["flow", "clicks", "--method", "paper", "--plot", "--out", "base-flow"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let read = |name: &str| fs::read_to_string(folder.join("base-flow/plots").join(name)).unwrap();
    let (page, figure) = (read("index.html"), read("filter-25.svg"));
    for part in ["figure-2.svg", "filter-25.svg", "batch, 200 twins", "<tr><td>U_h</td>"] {
        assert!(page.contains(part), "{part}");
    }
    for part in [", heater drag", "batch fit, two standard deviations", "of innovations", "(h)"] {
        assert!(figure.contains(part), "{part}");
    }
    assert!(!figure.contains("NaN"));
    assert!(folder.join("base-flow/plots/filter-25.pdf").is_file());
}
