//! Measured modes: a CSV file with a row per mode.

use crate::failure::{Classify, Failure};
use std::path::Path;

/// The file.
pub(super) struct Measured {
    /// Names of the columns beside the four of every mode.
    pub(super) columns: Vec<String>,
    pub(super) rows: Vec<Row>,
}

/// One mode.
pub(super) struct Row {
    /// Growth rate, 1/s, and frequency, Hz.
    pub(super) mode: [f64; 2],
    /// Their standard deviations.
    pub(super) sd: [f64; 2],
    /// The other columns, in the order of [`Measured::columns`].
    pub(super) setting: Vec<f64>,
}

const NAMES: [&str; 4] = ["growth_rate_per_s", "growth_rate_sd_per_s", "frequency_hz", "frequency_sd_hz"];

impl Measured {
    pub(super) fn read(path: &Path) -> Result<Self, Failure> {
        let remedy =
            format!("Give a line of names, {} among them, and a row of numbers per mode.", NAMES.join(", "));
        let bad = |message: String| Failure::bad_input(message).at(path).remedy(&remedy);
        let text = std::fs::read_to_string(path).or_bad_input().map_err(|f| f.at(path).remedy(&remedy))?;
        let mut lines = text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty() && !l.starts_with('#'));
        let (_, head) = lines.next().ok_or_else(|| bad("is empty".into()))?;
        let names: Vec<&str> = head.trim_start_matches('\u{feff}').split(',').map(str::trim).collect();
        let place = |name: &&str| names.iter().position(|n| n == name);
        if let Some(missing) = NAMES.iter().find(|n| place(n).is_none()) {
            return Err(bad(format!("line 1: there is no column {missing}")));
        }
        let mut rows = Vec::new();
        for (k, line) in lines {
            let cells: Vec<&str> = line.split(',').map(str::trim).collect();
            if cells.len() != names.len() {
                return Err(bad(format!(
                    "line {}: {} cells under {} names",
                    k + 1,
                    cells.len(),
                    names.len()
                )));
            }
            let number = |c: usize| {
                let value = cells[c].parse::<f64>().ok().filter(|v| v.is_finite());
                value.ok_or_else(|| {
                    bad(format!("line {}, column {}: `{}` is no number", k + 1, names[c], cells[c]))
                })
            };
            let [growth, growth_sd, frequency, frequency_sd] =
                NAMES.map(|n| place(&n).map_or(Ok(f64::NAN), number));
            let (mode, sd) = ([growth?, frequency?], [growth_sd?, frequency_sd?]);
            if sd.iter().any(|sd| *sd <= 0.0) || mode[1] <= 0.0 {
                return Err(bad(format!(
                    "line {}: frequency and standard deviations must be positive",
                    k + 1
                )));
            }
            let others = (0..names.len()).filter(|c| !NAMES.contains(&names[*c]));
            rows.push(Row { mode, sd, setting: others.map(number).collect::<Result<_, _>>()? });
        }
        if rows.is_empty() {
            return Err(bad("holds no mode".into()));
        }
        let columns = names.iter().filter(|n| !NAMES.contains(n)).map(|n| (*n).to_owned()).collect();
        Ok(Self { columns, rows })
    }
}
