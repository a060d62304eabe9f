//! Rows of a CSV file that know where they stand.

use super::channels::scaled;
use super::observation::PointObservations;
use crate::apparatus::point::OperatingPoint;
use crate::error::RigError;
use crate::files::read_text;
use crate::problem::Problem;
use crate::records::set::Day;
use rijke_numerics::{Cholesky, Matrix};
use std::collections::BTreeMap;
use std::path::Path;

/// Columns of `points.csv` that may be missing from one prepared by hand, and what then holds.
const MAY_BE_MISSING: [(&str, &str); 4] =
    [("repeats", "1"), ("day", "day"), ("ping_count", "1"), ("click_count", "0")];

/// One row of a CSV file that knows where it stands.
pub(super) struct Row<'a> {
    pub(super) path: &'a Path,
    pub(super) header: &'a [String],
    pub(super) line: u64,
    pub(super) cells: Vec<String>,
}

pub(super) fn read_csv_if_there<'a>(path: &'a Path, header: &'a [String]) -> Result<Vec<Row<'a>>, RigError> {
    if path.exists() { read_csv(path, header) } else { Ok(Vec::new()) }
}

/// All rows of a CSV file whose header is exactly `header`.
pub(super) fn read_csv<'a>(path: &'a Path, header: &'a [String]) -> Result<Vec<Row<'a>>, RigError> {
    let text = read_text(path)?;
    let syntax = |error: csv::Error| RigError::Syntax {
        path: path.to_owned(),
        line: error.position().map_or(1, |p| p.line() as usize),
        column: 1,
        message: error.to_string(),
    };
    // A spreadsheet may put a byte-order mark in front and blanks around cells.
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_reader(text.strip_prefix('\u{feff}').unwrap_or(&text).as_bytes());
    let found: Vec<String> = reader.headers().map_err(syntax)?.iter().map(String::from).collect();
    for (k, need) in header.iter().enumerate() {
        let have = found.get(k).cloned().unwrap_or_default();
        if have != *need {
            let problem = Problem::BadHeader { column: k + 1, have, need: need.clone() };
            return Err(RigError::invalid(path, "line 1", problem));
        }
    }
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(syntax)?;
        let line = record.position().map_or(0, csv::Position::line);
        rows.push(Row { path, header, line, cells: record.iter().map(String::from).collect() });
    }
    Ok(rows)
}

/// All rows of a CSV file whose columns may stand in any order, without those that may be missing.
pub(super) fn by_name<'a>(path: &'a Path, names: &'a [String]) -> Result<Vec<Row<'a>>, RigError> {
    let text = read_text(path)?;
    let first = text.strip_prefix('\u{feff}').unwrap_or(&text).lines().next().unwrap_or("");
    let found: Vec<String> = first.split(',').map(|cell| cell.trim().to_owned()).collect();
    let default = |name: &str| MAY_BE_MISSING.iter().find(|(n, _)| *n == name).map(|(_, value)| *value);
    let mut rows = read_csv(path, &[])?;
    let missing = |(_, name): &(usize, &String)| !found.contains(name) && default(name).is_none();
    if let Some((k, need)) = names.iter().enumerate().find(missing) {
        let have = found.get(k).cloned().unwrap_or_default();
        let problem = Problem::BadHeader { column: k + 1, have, need: need.clone() };
        return Err(RigError::invalid(path, "line 1", problem));
    }
    for row in &mut rows {
        let cell = |name: &String| {
            let place = found.iter().position(|n| n == name).and_then(|k| row.cells.get(k).cloned());
            place.unwrap_or_else(|| default(name).unwrap_or_default().to_owned())
        };
        row.cells = names.iter().map(cell).collect();
        row.header = names;
    }
    Ok(rows)
}

impl Row<'_> {
    pub(super) fn wrong(&self, column: usize, problem: Problem) -> RigError {
        let name = self.header.get(column).map_or("", String::as_str);
        RigError::invalid(self.path, format!("line {}, column `{name}`", self.line), problem)
    }

    pub(super) fn bad(&self, column: usize, expected: &'static str) -> RigError {
        self.wrong(column, Problem::BadCell { text: self.cells[column].clone(), expected })
    }

    pub(super) fn number(&self, column: usize) -> Result<f64, RigError> {
        let value = self.cells[column].parse::<f64>().ok().filter(|v| v.is_finite());
        value.ok_or_else(|| self.bad(column, "a finite number"))
    }

    /// From 0 to 50 K.
    pub(super) fn sd_of_the_day(&self, column: usize) -> Result<f64, RigError> {
        let sd = self.number(column)?;
        (0.0..=Day::LARGEST_SD).contains(&sd).then_some(sd).ok_or_else(|| self.bad(column, "from 0 to 50 K"))
    }

    pub(super) fn whole(&self, column: usize) -> Result<u32, RigError> {
        self.cells[column].parse().map_err(|_| self.bad(column, "a whole number"))
    }

    pub(super) fn flag(&self, column: usize) -> Result<bool, RigError> {
        match self.cells[column].to_ascii_lowercase().as_str() {
            "0" | "false" => Ok(false),
            "1" | "true" => Ok(true),
            _ => Err(self.bad(column, "0 or 1")),
        }
    }

    /// Index of the operating point this row speaks of.
    pub(super) fn known(&self, index: &BTreeMap<String, usize>) -> Result<usize, RigError> {
        let (name, known) = (self.cells[0].clone(), || index.keys().cloned().collect());
        index.get(&name).copied().ok_or_else(|| self.wrong(0, Problem::UnknownName { name, known: known() }))
    }

    /// `count` values from column `first` on, and their covariance. Of a dead microphone, from number
    /// `may_lack` on, cells are empty.
    pub(super) fn measured(
        &self,
        first: usize,
        count: usize,
        may_lack: usize,
    ) -> Result<(Vec<f64>, Matrix), RigError> {
        let lacks = |i: usize| i >= may_lack && self.cells[first + i].is_empty();
        let value = |i: usize| if lacks(i) { Ok(f64::NAN) } else { self.number(first + i) };
        let values = (0..count).map(value).collect::<Result<Vec<_>, _>>()?;
        let there: Vec<usize> = (0..count).filter(|i| !lacks(*i)).collect();
        let (mut covariance, mut column) = (Matrix::zeros(count, count), first + count);
        if self.header.get(first + count).is_some_and(|name| name.starts_with("sd_")) {
            for &i in &there {
                let sd = self.number(first + count + i)?;
                if sd <= 0.0 {
                    return Err(self.bad(first + count + i, "a positive standard deviation"));
                }
                covariance[(i, i)] = sd * sd;
            }
            return Ok((values, covariance));
        }
        for i in 0..count {
            for j in i..count {
                let value = if lacks(i) || lacks(j) { f64::NAN } else { self.number(column)? };
                (covariance[(i, j)], covariance[(j, i)]) = (value, value);
                column += 1;
            }
        }
        match Cholesky::new(&scaled(&covariance.select(&there))) {
            Ok(_) => Ok((values, covariance)),
            Err(_) => Err(self.wrong(first + count, Problem::NotPositiveDefinite)),
        }
    }

    pub(super) fn point(&self) -> Result<PointObservations, RigError> {
        let position = if self.cells[2].is_empty() { None } else { Some(self.number(2)?) };
        let point = OperatingPoint {
            id: self.cells[0].clone(),
            row: self.cells[1].clone(),
            position,
            plates: self.flag(3)?,
            thermometers: self.flag(4)?,
            power: self.number(5)?,
            repeats: self.whole(6)?,
        };
        let ambient = Day {
            id: self.cells[7].clone(),
            ambient_temperature: self.number(8)?,
            ambient_temperature_sd: self.sd_of_the_day(9)?,
        };
        let [ping_count, click_count] = [self.whole(10)?, self.whole(11)?];
        Ok(PointObservations { ping_count, click_count, ..PointObservations::unmeasured(point, ambient) })
    }
}
