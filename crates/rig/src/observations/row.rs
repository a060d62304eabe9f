//! Rows of a CSV file that know where they stand.

use super::channels::scaled;
use super::factors::FactorColumn;
use super::observation::PointObservations;
use crate::apparatus::point::OperatingPoint;
use crate::error::RigError;
use crate::files::read_text;
use crate::problem::Problem;
use crate::records::set::Day;
use rijke_numerics::{Cholesky, Matrix, csv_without_empty_ends};
use std::collections::BTreeMap;
use std::path::Path;

/// Columns of `points.csv` that may be missing from one prepared by hand, and what then holds.
const MAY_BE_MISSING: [(&str, &str); 4] =
    [("repeats", "1"), ("day", "day"), ("ping_count", "1"), ("click_count", "0")];

/// One row of a CSV file that knows where it stands.
pub(crate) struct Row<'a> {
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
    let text = table(path)?;
    let syntax = |error: csv::Error| RigError::Syntax {
        path: path.to_owned(),
        line: error.position().map_or(1, |p| p.line() as usize),
        column: 1,
        message: error.to_string(),
    };
    // A spreadsheet may put blanks around cells.
    let mut reader =
        csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(text.as_bytes());
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

/// The text of a table without the byte-order mark, the empty columns at the end and the empty rows of a
/// spreadsheet.
pub(super) fn table(path: &Path) -> Result<String, RigError> {
    let text = read_text(path)?;
    let cut = csv_without_empty_ends(&text).map_err(|behind| RigError::Syntax {
        path: path.to_owned(),
        line: behind.line,
        column: behind.column,
        message: behind.to_string(),
    })?;
    Ok(cut.into_owned())
}

/// The line of a table that heads its columns.
pub(super) fn first_line(text: &str) -> &str {
    let mut lines = text.strip_prefix('\u{feff}').unwrap_or(text).lines();
    lines.find(|line| !line.starts_with('#')).unwrap_or("")
}

/// All rows of a table of operating points, whose columns may stand in any order, without those that may be
/// missing. The cells of a row are those of `names`, then those of the columns of factors.
pub(crate) fn by_name<'a>(
    path: &'a Path,
    names: &'a [String],
) -> Result<(Vec<FactorColumn>, Vec<Row<'a>>), RigError> {
    let text = table(path)?;
    let first = first_line(&text);
    let found: Vec<String> = first.split(',').map(|cell| cell.trim().to_owned()).collect();
    let default = |name: &str| MAY_BE_MISSING.iter().find(|(n, _)| *n == name).map(|(_, value)| *value);
    let mut rows = read_csv(path, &[])?;
    let missing = |name: &&String| !found.contains(name) && default(name).is_none();
    if let Some(name) = names.iter().find(missing) {
        let problem = Problem::NoSuchHeading { name: name.clone(), known: found };
        return Err(RigError::invalid(path, "line 1", problem));
    }
    let mut others = Vec::new();
    for (k, heading) in found.iter().enumerate() {
        let wrong = |problem| RigError::invalid(path, format!("line 1, column `{heading}`"), problem);
        if found[..k].contains(heading) {
            return Err(wrong(Problem::Duplicate { name: heading.clone() }));
        }
        if !names.contains(heading) {
            others.push((k, FactorColumn::parse(heading).map_err(wrong)?));
        }
    }
    for row in &mut rows {
        let cell = |name: &String| {
            let place = found.iter().position(|n| n == name).and_then(|k| row.cells.get(k).cloned());
            place.unwrap_or_else(|| default(name).unwrap_or_default().to_owned())
        };
        let factors = others.iter().map(|(k, _)| row.cells.get(*k).cloned().unwrap_or_default());
        row.cells = names.iter().map(cell).chain(factors).collect();
        row.header = names;
    }
    Ok((others.into_iter().map(|(_, column)| column).collect(), rows))
}

/// Columns of a table of operating points that a set of records has.
pub(crate) const CAMPAIGN: [&str; 3] = ["point", "row", "repeats"];

/// Reads a table of operating points: the columns [`CAMPAIGN`], and factors.
pub(crate) fn read_points(path: &Path) -> Result<Vec<OperatingPoint>, RigError> {
    let names = CAMPAIGN.map(String::from);
    let (factors, rows) = by_name(path, &names)?;
    let point = |row: &Row<'_>| row.operating_point(2, &factors, CAMPAIGN.len());
    let points = rows.iter().map(point).collect::<Result<Vec<_>, _>>()?;
    if points.is_empty() {
        return Err(RigError::invalid(path, "rows", Problem::Empty { need: "one operating point" }));
    }
    for (k, point) in points.iter().enumerate() {
        if points[..k].iter().any(|p| p.id == point.id) {
            return Err(rows[k].wrong(0, Problem::Duplicate { name: point.id.clone() }));
        }
    }
    Ok(points)
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
        if self.header.get(first + count).is_some_and(|name| !name.starts_with("cov_")) {
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

    /// The operating point of a row: name, row, repeats in the column of this number, and `factors` in those
    /// from `first` on.
    fn operating_point(
        &self,
        repeats: usize,
        factors: &[FactorColumn],
        first: usize,
    ) -> Result<OperatingPoint, RigError> {
        let mut values = BTreeMap::new();
        for (column, cell) in factors.iter().zip(&self.cells[first..]) {
            column.add(cell, &mut values).map_err(|problem| {
                let place = format!("line {}, column `{}`", self.line, column.heading);
                RigError::invalid(self.path, place, problem)
            })?;
        }
        let (id, row) = (self.cells[0].clone(), self.cells[1].clone());
        if id.is_empty() || id.len() > OperatingPoint::LONGEST {
            return Err(self.bad(0, "a name of 1 to 100 letters"));
        }
        Ok(OperatingPoint { id, row, repeats: self.whole(repeats)?, factors: values })
    }

    /// What a row of `points.csv` says.
    pub(super) fn point(&self, factors: &[FactorColumn]) -> Result<PointObservations, RigError> {
        let point = self.operating_point(2, factors, 8)?;
        let ambient = Day {
            id: self.cells[3].clone(),
            ambient_temperature: self.number(4)?,
            ambient_temperature_sd: self.sd_of_the_day(5)?,
        };
        let [ping_count, click_count] = [self.whole(6)?, self.whole(7)?];
        Ok(PointObservations { ping_count, click_count, ..PointObservations::unmeasured(point, ambient) })
    }
}
