//! A table of numbers by the names of its columns: text, or the arrays of a MATLAB or HDF5 file. Of
//! impedances, transfer functions, profiles, sensitivities, and whatever else a laboratory has as columns.

use super::arrays::{is_file_of_arrays, named_columns};
use super::headings::named;
use super::text::{Decimal, Split, number, table_rows};
use crate::error::RigError;
use crate::problem::Problem;
use crate::units::{Heading, Unit};
use rijke_numerics::C64;
use std::path::{Path, PathBuf};

/// Columns of a file, read as a whole. Numbers become SI where they are asked for.
///
/// Text has one row per line, with comma, semicolon, tab or blanks between columns, a decimal point or comma,
/// comments behind `#` or `%` in lines of their own, and names in the first other line: `frequency [Hz];
/// real; imaginary`. Cells may be words.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns {
    path: PathBuf,
    headings: Vec<String>,
    rows: Rows,
}

#[derive(Clone, Debug, PartialEq)]
enum Rows {
    /// Line of each row, and its cells.
    Text { split: Split, decimal: Option<Decimal>, rows: Vec<(usize, Vec<String>)> },
    /// Column by column.
    Numbers(Vec<Vec<f64>>),
}

impl Columns {
    /// Reads a file. A name that ends in .mat, .h5, .hdf5 or .hdf, or a file that begins like one, is read as
    /// arrays; else it is text.
    ///
    /// # Errors
    /// The file is absent, no file, larger than 1 GiB, or damaged; a text without names or rows, or with a
    /// row of another width; arrays of several lengths are all taken, see [`Columns::numbers`].
    pub fn read(path: &Path) -> Result<Self, RigError> {
        if is_file_of_arrays(path)? {
            let (headings, values) = named_columns(path)?.into_iter().unzip();
            return Ok(Self { path: path.to_owned(), headings, rows: Rows::Numbers(values) });
        }
        Self::parse(&crate::files::read_text(path)?, path)
    }

    /// As [`Columns::read`], from text; `path` appears in messages only.
    ///
    /// # Errors
    /// As [`Columns::read`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, RigError> {
        let (split, headings, rows) = table_rows(text).map_err(super::text::refused(path))?;
        Ok(Self { path: path.to_owned(), headings, rows: Rows::Text { split, decimal: None, rows } })
    }

    /// The headings as the file has them.
    #[must_use]
    pub fn headings(&self) -> &[String] {
        &self.headings
    }

    /// Number of rows of a text; of arrays the length of the longest.
    #[must_use]
    pub fn len(&self) -> usize {
        match &self.rows {
            Rows::Text { rows, .. } => rows.len(),
            Rows::Numbers(values) => values.iter().map(Vec::len).max().unwrap_or(0),
        }
    }

    /// Whether there are no rows.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether there is a column of this name, with or without a unit behind it.
    #[must_use]
    pub fn has(&self, name: &str) -> bool {
        !matches!(named(&self.headings, name), Err(Problem::NoSuchHeading { .. }))
    }

    /// A column in the SI unit `wanted` ([`Unit::of`]); numbers without a unit are taken to be in it.
    ///
    /// # Errors
    /// No such column, or two; a cell that is no finite number; another quantity.
    pub fn numbers(&self, name: &str, wanted: &str) -> Result<Vec<f64>, RigError> {
        let (unit, values) = self.as_written(name)?;
        let Some(unit) = unit else { return Ok(values) };
        let unit = unit.of(wanted).map_err(|e| self.invalid(format!("column `{name}`"), Problem::Unit(e)))?;
        Ok(values.into_iter().map(|v| unit.to_si(v)).collect())
    }

    /// A column of standard deviations or other differences in the SI unit `wanted`: 1 degC is 1 K.
    ///
    /// # Errors
    /// Those of [`Columns::numbers`].
    pub fn differences(&self, name: &str, wanted: &str) -> Result<Vec<f64>, RigError> {
        let (unit, values) = self.as_written(name)?;
        let Some(unit) = unit else { return Ok(values) };
        let unit = unit.of(wanted).map_err(|e| self.invalid(format!("column `{name}`"), Problem::Unit(e)))?;
        Ok(values.into_iter().map(|v| unit.difference_to_si(v)).collect())
    }

    /// Refuses columns that nobody reads: a column too many is one misspelt, or of another kind of table.
    ///
    /// # Errors
    /// A column that is none of `names`, which may have units behind them.
    pub fn only(&self, names: &[&str]) -> Result<(), RigError> {
        let read: Vec<usize> = names.iter().filter_map(|name| named(&self.headings, name).ok()).collect();
        let strange = (0..self.headings.len()).find(|k| !read.contains(k));
        strange.map_or(Ok(()), |k| {
            let known = names.iter().map(|name| (*name).to_owned()).collect();
            let problem = Problem::UnknownName { name: self.headings[k].clone(), known };
            Err(self.invalid("header".into(), problem))
        })
    }

    /// A column of complex numbers, as programs write them: `(1.5e-3-2j)`, `1.5+2i`, or a plain number, with
    /// a decimal point or comma.
    ///
    /// # Errors
    /// Those of [`Columns::numbers`], but for units, which are not looked at.
    pub fn complex(&self, name: &str) -> Result<Vec<C64>, RigError> {
        let column = self.column(name)?;
        let Rows::Text { split, decimal, rows } = &self.rows else {
            return Ok(self.as_written(name)?.1.into_iter().map(C64::from).collect());
        };
        let mut decimal = *decimal;
        let cell = |(row, (_, cells)): (usize, &(usize, Vec<String>))| {
            complex_cell(&cells[column], &mut decimal, *split)
                .ok_or_else(|| self.bad(row, name, cells[column].clone()))
        };
        rows.iter().enumerate().map(cell).collect()
    }

    /// A column as [`Columns::numbers`] gives it, whose numbers must ascend, each once: a key.
    ///
    /// # Errors
    /// Those of [`Columns::numbers`]; a number that stands twice, with both lines; one that is smaller than
    /// the one before.
    pub fn keys(&self, name: &str, wanted: &str) -> Result<Vec<f64>, RigError> {
        let keys = self.numbers(name, wanted)?;
        let mut order: Vec<usize> = (0..keys.len()).collect();
        order.sort_by(|a, b| keys[*a].total_cmp(&keys[*b]));
        if let Some(pair) = order.windows(2).find(|pair| keys[pair[0]] == keys[pair[1]]) {
            let (first, second) = (pair[0].min(pair[1]), pair[0].max(pair[1]));
            let problem = Problem::DuplicateKey { key: keys[first].to_string(), first: self.line(first) };
            return Err(self.wrong(second, name, problem));
        }
        match keys.windows(2).position(|pair| pair[1] < pair[0]) {
            Some(k) => {
                Err(self.wrong(k + 1, name, Problem::Unsorted { first: keys[k], second: keys[k + 1] }))
            }
            None => Ok(keys),
        }
    }

    /// A column of words.
    ///
    /// # Errors
    /// No such column, or two; arrays, which have no words.
    pub fn words(&self, name: &str) -> Result<Vec<&str>, RigError> {
        let column = self.column(name)?;
        match &self.rows {
            Rows::Text { rows, .. } => Ok(rows.iter().map(|(_, cells)| cells[column].as_str()).collect()),
            Rows::Numbers(_) => {
                let known = self.headings.clone();
                Err(self.whole(Problem::NoSuchHeading { name: name.into(), known }))
            }
        }
    }

    /// The unit that the heading of a column states, also where the column is asked for by the whole of it.
    ///
    /// # Errors
    /// No such column, or two.
    pub fn unit(&self, name: &str) -> Result<Option<Unit>, RigError> {
        let heading = &self.headings[self.column(name)?];
        Ok(Heading::parse(heading).ok().and_then(|h| h.unit))
    }

    /// A column with its unit, not converted.
    pub(crate) fn as_written(&self, name: &str) -> Result<(Option<Unit>, Vec<f64>), RigError> {
        let column = self.column(name)?;
        let heading = &self.headings[column];
        // A column asked for by the whole of its heading has no unit that could be known.
        let unit = if heading == name { None } else { Heading::parse(heading).ok().and_then(|h| h.unit) };
        let finite = |row: usize, value: f64| match value.is_finite() {
            true => Ok(value),
            false => Err(self.bad(row, name, value.to_string())),
        };
        let values: Result<Vec<f64>, RigError> = match &self.rows {
            Rows::Numbers(values) => {
                values[column].iter().enumerate().map(|(row, v)| finite(row, *v)).collect()
            }
            Rows::Text { split, decimal, rows } => {
                let mut decimal = *decimal;
                let cells = rows.iter().enumerate().map(|(row, (_, cells))| (row, &cells[column]));
                cells
                    .map(|(row, cell)| {
                        let value = number(cell, &mut decimal, *split);
                        value.ok_or_else(|| self.bad(row, name, cell.clone())).and_then(|v| finite(row, v))
                    })
                    .collect()
            }
        };
        Ok((unit, values?))
    }

    /// The error of a cell.
    #[must_use]
    pub fn wrong(&self, row: usize, name: &str, problem: Problem) -> RigError {
        let what = if matches!(self.rows, Rows::Text { .. }) { "line" } else { "row" };
        self.invalid(format!("{what} {}, column `{name}`", self.line(row)), problem)
    }

    /// The error of the table.
    #[must_use]
    pub fn whole(&self, problem: Problem) -> RigError {
        self.invalid("columns".into(), problem)
    }

    fn bad(&self, row: usize, name: &str, text: String) -> RigError {
        self.wrong(row, name, Problem::BadCell { text, expected: "a finite number" })
    }

    fn column(&self, name: &str) -> Result<usize, RigError> {
        named(&self.headings, name).map_err(|problem| self.invalid("header".into(), problem))
    }

    /// Line of a row, from 1; of arrays its number.
    #[must_use]
    pub fn line(&self, row: usize) -> usize {
        match &self.rows {
            Rows::Text { rows, .. } => rows.get(row).map_or(0, |(line, _)| *line),
            Rows::Numbers(_) => row + 1,
        }
    }

    fn invalid(&self, place: String, problem: Problem) -> RigError {
        RigError::invalid(&self.path, place, problem)
    }
}

/// A finite complex number, in brackets or not; its decimal sign becomes the column's.
fn complex_cell(text: &str, decimal: &mut Option<Decimal>, split: Split) -> Option<C64> {
    let mut finite = |text: &str| number(text.trim(), decimal, split).filter(|v| v.is_finite());
    let bare = text.trim().trim_start_matches('(').trim_end_matches(')').trim();
    let Some(body) = bare.strip_suffix(['i', 'j']) else { return finite(bare).map(C64::from) };
    // The sign between the parts is the last one that belongs to no exponent.
    let between =
        |(k, c): &(usize, char)| *k > 0 && matches!(c, '+' | '-') && !body[..*k].ends_with(['e', 'E']);
    let (re, im) = match body.char_indices().rfind(between) {
        Some((k, _)) => (finite(&body[..k])?, &body[k..]),
        None => (0.0, body),
    };
    let im = match im {
        "+" | "" => 1.0,
        "-" => -1.0,
        im => finite(im)?,
    };
    Some(C64::new(re, im))
}

#[cfg(test)]
mod tests {
    use super::{Decimal, Split, complex_cell};
    use rijke_numerics::C64;

    #[test]
    fn exact_complex_numbers_as_programs_write_them() {
        for (text, re, im) in [
            (" (5.0e+00-7.9e-01j)", 5.0, -0.79),
            ("-1e-3-2E-2i", -1e-3, -2e-2),
            ("3", 3.0, 0.0),
            ("-2.5j", 0.0, -2.5),
            ("1+j", 1.0, 1.0),
        ] {
            assert_eq!(complex_cell(text, &mut None, Split::At(',')), Some(C64::new(re, im)), "{text}");
        }
        for text in ["", "j+", "1+2", "nan+1j", "1,5+2j", "(1 + two j)"] {
            assert_eq!(complex_cell(text, &mut None, Split::At(',')), None, "{text}");
        }
        // Where other characters stand between cells a comma is a decimal sign, of the whole column.
        let mut sign = None;
        let cell = |text, sign: &mut _| complex_cell(text, sign, Split::At(';'));
        assert_eq!(cell("1,5-2,25e-1j", &mut sign), Some(C64::new(1.5, -0.225)));
        assert_eq!((sign, cell("1.5", &mut sign)), (Some(Decimal::Comma), None));
    }
}
