//! The folder of OSCILOS_lite as the tables of a network file: Geometry, Mean_flow, Flame, Inlet and Outlet.
//! Must not know what a rig adds.
//!
//! Sections are called `duct-1`, `duct-2`, ... from upstream to downstream, and the fluctuating heat source
//! `flame`. The gas of ducts before the heat has the ambient temperature. What the folder cannot say here is
//! refused.

use crate::source::Source;
use crate::{StudyError, StudyProblem};
use std::path::Path;
use toml::{Table, Value};

/// Universal gas constant over the molar mass of air as that program has them, J/(kg K).
const AIR: f64 = 8.3145 / 28.965_12 * 1000.0;

/// Delays that are no slip of the pen, ms.
const DELAYS: [f64; 2] = [0.0, 1e4];

/// The tables `gas`, `upstream` and `downstream`, and the elements.
pub(super) struct Folder {
    pub(super) gas: Table,
    pub(super) ends: [Table; 2],
    pub(super) elements: Vec<Table>,
}

/// A file whose first line is a title.
struct Numbers {
    source: Source,
    /// Number of the line, from 1, and its numbers.
    rows: Vec<(usize, Vec<f64>)>,
}

impl Numbers {
    fn read(folder: &Path, name: &str, columns: usize) -> Result<Self, StudyError> {
        let source = Source::read(&folder.join(name))?;
        let number = |word: &str| if word == "-" { Some(0.0) } else { word.parse::<f64>().ok() };
        let numbers = |line: &str| {
            let all: Option<Vec<f64>> = line.split_whitespace().map(number).collect();
            all.filter(|n| n.len() >= columns)
        };
        let title = source.text.lines().next().unwrap_or_default().trim();
        if numbers(title).is_some() {
            let (key, value) = ("the first line".to_owned(), title.to_owned());
            let need = "a title, which OSCILOS_lite passes over: put one above the numbers";
            return Err(source.at_line(1, StudyProblem::Value { key, value, need }));
        }
        let mut rows = Vec::new();
        for (k, line) in source.text.lines().enumerate().skip(1).filter(|(_, l)| !l.trim().is_empty()) {
            let Some(numbers) = numbers(line) else {
                let (key, value) = ("the line".to_owned(), line.trim().to_owned());
                let need = "the numbers of OSCILOS_lite, as its manual lists them";
                return Err(source.at_line(k + 1, StudyProblem::Value { key, value, need }));
            };
            rows.push((k + 1, numbers));
        }
        if rows.is_empty() {
            return Err(source.at_line(2, StudyProblem::Empty { what: "line of numbers", need: "add one" }));
        }
        Ok(Self { source, rows })
    }

    fn first(&self) -> &[f64] {
        &self.rows[0].1
    }

    /// Refuses a number of the first row that is beyond what any rig has: most often one in another unit.
    fn within(
        &self,
        key: &str,
        value: f64,
        [low, high]: [f64; 2],
        need: &'static str,
    ) -> Result<(), StudyError> {
        if (low..=high).contains(&value) {
            return Ok(());
        }
        let (key, value) = (key.to_owned(), value.to_string());
        Err(self.source.at_line(self.rows[0].0, StudyProblem::Value { key, value, need }))
    }

    fn unknown(&self, row: usize, what: &'static str, value: f64, known: &str) -> StudyError {
        let (name, known) = (value.to_string(), known.to_owned());
        self.source.at_line(self.rows[row].0, StudyProblem::Unknown { what, name, known })
    }
}

fn table<const N: usize>(entries: [(&str, Value); N]) -> Table {
    entries.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
}

fn text(value: &str) -> Value {
    Value::String(value.to_owned())
}

/// Reads a folder.
///
/// # Errors
/// File, line, and the kinds that are read.
pub(super) fn read(folder: &Path) -> Result<Folder, StudyError> {
    let flow = Numbers::read(folder, "Mean_flow.txt", 6)?;
    let [pressure, temperature, _, _, gamma, ratio] = flow.first()[..6] else {
        return Err(flow.unknown(0, "mean flow", 0.0, "six numbers"));
    };
    if gamma != 1.0 {
        return Err(flow.unknown(0, "Choice_gamma", gamma, "1 (constant)"));
    }
    flow.within("pressure", pressure, [1e2, 1e9], "100 to 1e9 Pa")?;
    flow.within("temperature", temperature, [100.0, 4000.0], "100 to 4000 K")?;
    flow.within("ratio of temperatures", ratio, [0.1, 20.0], "0.1 to 20")?;
    let float = Value::Float;
    let gas = table([
        ("pressure", float(pressure)),
        ("temperature", float(temperature)),
        ("gamma", float(1.4)),
        ("gas_constant", float(AIR)),
    ]);
    let geometry = Numbers::read(folder, "Geometry.txt", 4)?;
    let mut elements = Vec::new();
    let mut heated = 1.0;
    for (k, pair) in geometry.rows.windows(2).enumerate() {
        let ([x, r, section, tube], [x_end, r_end]) =
            ([0, 1, 2, 3].map(|i| pair[0].1[i]), [0, 1].map(|i| pair[1].1[i]));
        if x_end <= x {
            let (key, value) = ("x".to_owned(), x_end.to_string());
            let problem = StudyProblem::Value { key, value, need: "larger than in the line before" };
            return Err(geometry.source.at_line(pair[1].0, problem));
        }
        match section {
            10.0 | 11.0 if k > 0 => heated *= ratio,
            0.0 | 10.0 | 11.0 => {}
            other => return Err(geometry.unknown(k, "SectionIndex", other, "0, 10 and 11")),
        }
        if section == 11.0 && k > 0 {
            let flame = Numbers::read(folder, "Flame.txt", 3)?;
            let [kind, gain, delay] = [0, 1, 2].map(|i| flame.first()[i]);
            if kind != 1.0 {
                return Err(flame.unknown(0, "type of flame", kind, "1 (n-tau)"));
            }
            flame.within("delay", delay, DELAYS, "0 to 10 000 ms")?;
            let law = [("n", float(gain)), ("delay", float(delay * 1e-3))];
            let named = table([("name", text("flame")), ("type", text("flame"))]);
            elements.push(named.into_iter().chain(table(law)).collect());
        }
        let mut duct = table([
            ("name", text(&format!("duct-{}", k + 1))),
            ("type", text("duct")),
            ("length", float(x_end - x)),
            ("diameter", float(2.0 * r)),
        ]);
        if tube >= 1.0 && r_end != r {
            duct.insert("diameter_end".into(), float(2.0 * r_end));
        }
        if heated != 1.0 {
            duct.insert("temperature".into(), float(heated * temperature));
        }
        elements.push(duct);
    }
    if elements.is_empty() {
        let problem = StudyProblem::Empty { what: "section", need: "give at least two positions" };
        return Err(geometry.source.at_line(geometry.rows[0].0, problem));
    }
    let ends = [end(folder, "Inlet.txt")?, end(folder, "Outlet.txt")?];
    Ok(Folder { gas, ends, elements })
}

fn end(folder: &Path, name: &str) -> Result<Table, StudyError> {
    let file = Numbers::read(folder, name, 4)?;
    let [kind, one, two, three] = [0, 1, 2, 3].map(|i| file.first()[i]);
    let float = Value::Float;
    if kind == 4.0 || kind == 5.0 {
        // An active end may exceed 1, but not by far.
        file.within("modulus of the reflection", one, [-2.0, 2.0], "-2 to 2")?;
    }
    if kind == 4.0 {
        file.within("delay", two, DELAYS, "0 to 10 000 ms")?;
    }
    Ok(match kind {
        1.0 => table([("type", text("open"))]),
        2.0 => table([("type", text("closed"))]),
        4.0 => table([("type", text("delayed")), ("factor", float(one)), ("delay", float(two * 1e-3))]),
        5.0 => {
            // The phase is a lag, in rad, or in degrees where the third number says so.
            let phase = if three == 0.0 { two } else { two.to_radians() };
            table([("type", text("constant")), ("modulus", float(one)), ("angle", float(-phase))])
        }
        11.0 => table([("type", text("unflanged"))]),
        12.0 => table([("type", text("flanged"))]),
        other => return Err(file.unknown(0, "type of end", other, "1, 2, 4, 5, 11 and 12")),
    })
}
