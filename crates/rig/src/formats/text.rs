//! How a text file of numbers is written: what stands between its columns, its decimal sign, the lines before
//! the numbers, names and units of its columns. Found from the file, or declared.

use super::labview::LabviewHeader;
use super::stamp::seconds_of_day;
use crate::error::RigError;
use crate::problem::Problem;
use crate::units::{Heading, Unit};
use rijke_numerics::{BehindHeadings, without_empty_ends};
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

/// How a text file is written, as far as it shall not be found from the file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TextForm {
    /// Lines to be passed over at the beginning, before the line of names.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub header_lines: Option<usize>,
    /// The decimal sign.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub decimal: Option<Decimal>,
}

/// A decimal sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Decimal {
    /// 1.5
    #[serde(rename = ".")]
    Point,
    /// 1,5
    #[serde(rename = ",")]
    Comma,
}

/// Lines that are looked at to find out how a file is written.
pub(crate) const HEAD: usize = 200;
/// Longest line, bytes. A row of 10 000 columns has 250 000.
const LONGEST: u64 = 1 << 20;

/// What stands between columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Split {
    At(char),
    Blanks,
}

/// How a file was found to be written.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Form {
    pub(crate) split: Split,
    /// None until a number with a decimal sign was seen.
    pub(crate) decimal: Option<Decimal>,
    /// Lines before the first row of numbers.
    pub(crate) before: usize,
    /// Columns.
    pub(crate) width: usize,
    /// Names with units as the file has them, or nothing.
    pub(crate) headings: Vec<String>,
}

/// Line and column, both from 1, and what is wrong there.
pub(crate) type Wrong = (usize, Option<usize>, Problem);

/// The error of something wrong in a text file.
pub(crate) fn refused(path: &Path) -> impl Fn(Wrong) -> RigError {
    let path = path.to_owned();
    move |(line, column, problem)| {
        let place = match column {
            Some(column) => format!("line {line}, column {column}"),
            None => format!("line {line}"),
        };
        RigError::invalid(&path, place, problem)
    }
}

/// The next line without its end; none at the end of the file.
pub(crate) fn next_line(
    file: &mut BufReader<File>,
    path: &Path,
    line: usize,
) -> Result<Option<String>, RigError> {
    let mut bytes = Vec::new();
    let count = file.take(LONGEST).read_until(b'\n', &mut bytes).map_err(RigError::read(path))?;
    if count as u64 == LONGEST && bytes.last() != Some(&b'\n') {
        return Err(refused(path)((line, None, Problem::LongLine { most: LONGEST })));
    }
    let text = String::from_utf8_lossy(&bytes);
    let text = text.trim_end_matches(['\n', '\r']);
    let text = if line == 1 { text.strip_prefix('\u{feff}').unwrap_or(text) } else { text };
    Ok((count > 0).then(|| text.to_owned()))
}

impl Form {
    /// How the file is written whose first lines these are.
    ///
    /// The first row of which every cell is a number is the first row of data. A line before it is passed
    /// over if it is blank, a comment (`#`, `%`, `!`, `//`), without any number, or if it begins with a word
    /// and has another number of cells.
    ///
    /// # Errors
    /// A row before the first good one that is neither; no row of numbers; names that are not as many as
    /// columns.
    pub(crate) fn find(lines: &[String], declared: &TextForm) -> Result<Self, Wrong> {
        let labview = LabviewHeader::of(lines);
        let skip = declared.header_lines.or(labview.as_ref().map(|header| header.lines)).unwrap_or(0);
        let rows = || lines.iter().enumerate().skip(skip);
        let Some((before, (split, width))) =
            rows().find_map(|(k, row)| Some((k, numbers(row, declared.decimal)?)))
        else {
            return match rows().find(|(_, row)| !passed_over(row)) {
                None => Ok(Self::of(Split::At(','), declared, lines.len(), 0)),
                Some((k, row)) => Err(without_numbers(k, row, lines, skip, declared.decimal)),
            };
        };
        let mut form = Self::of(split, declared, before, width);
        let (mut names, mut comment) = (Vec::new(), None);
        for (k, row) in rows().take_while(|(k, _)| *k < before) {
            if passed_over(row) {
                comment = Some(row.trim_start_matches(['#', '%', '!', '/']));
                continue;
            }
            let cells: Vec<&str> = split.cells(row).collect();
            let number = |cell: &&str| number(cell, &mut declared.decimal.clone(), split).is_some();
            if !cells.iter().any(number) {
                let mut own = headings(row, split, width);
                if labview.is_some() && own.len() == width + 1 {
                    // That of the comments, which stand behind some rows.
                    own.pop();
                }
                names.push((k, own));
            } else if number(&cells[0]) || cells.len() == width {
                let column = cells.iter().position(|c| !number(c)).unwrap_or(0);
                let expected = "a number; if the line belongs to the heading, say so with `header_lines`";
                return Err((
                    k + 1,
                    Some(column + 1),
                    Problem::BadCell { text: cells[column].into(), expected },
                ));
            }
        }
        if let Some((k, last)) = names.last()
            && *k + 1 == before
            && last.len() > 1
            && last.len() != width
            && split != Split::Blanks
        {
            let problem = Problem::OtherWidth { have: width, need: last.len() };
            return Err((before + 1, None, problem));
        }
        let mut fitting = names.into_iter().map(|n| n.1).filter(|n| n.len() == width).rev();
        let units = labview.map(|header| header.units).filter(|units| units.len() == width);
        form.headings = match (fitting.next(), fitting.next()) {
            (Some(names), _) if units.is_some() => with_units(&names, &units.unwrap_or_default()),
            (Some(units), Some(names)) if all_units(&units) => with_units(&names, &units),
            (Some(names), _) => names,
            (None, _) => comment
                .map(|row| headings(row, split, width))
                .filter(|n| n.len() == width)
                .unwrap_or_default(),
        };
        Ok(form)
    }

    fn of(split: Split, declared: &TextForm, before: usize, width: usize) -> Self {
        Self { split, decimal: declared.decimal, before, width, headings: Vec::new() }
    }

    /// Whether a line after the first row of numbers holds none.
    pub(crate) fn is_passed_over(row: &str) -> bool {
        passed_over(row)
    }

    /// Calls `take` with column and number of the cells of a row that are wanted.
    ///
    /// # Errors
    /// Column, from 1, and problem: a cell that is no number, another number of cells.
    pub(crate) fn row(
        &mut self,
        row: &str,
        wanted: impl Fn(usize) -> bool,
        mut take: impl FnMut(usize, f64),
    ) -> Result<(), (Option<usize>, Problem)> {
        let have = self.split.cells(row).count();
        if have != self.width {
            return Err((None, Problem::OtherWidth { have, need: self.width }));
        }
        for (column, cell) in self.split.cells(row).enumerate().filter(|(column, _)| wanted(*column)) {
            let plain = number(cell, &mut self.decimal, self.split);
            let value = plain.or_else(|| seconds_of_day(cell)).ok_or_else(|| {
                let expected = match self.decimal {
                    Some(Decimal::Comma) => "a number with a decimal comma",
                    _ => "a number with a decimal point",
                };
                (Some(column + 1), Problem::BadCell { text: cell.to_owned(), expected })
            })?;
            take(column, value);
        }
        Ok(())
    }
}

impl Split {
    /// The cells of a row without blanks and quotes around them. One separator may stand at the end.
    pub(crate) fn cells(self, row: &str) -> impl Iterator<Item = &str> {
        self.every_cell(match self {
            Self::At('\t') => row.strip_suffix('\t').unwrap_or(row),
            Self::At(c) => row.trim_end().strip_suffix(c).unwrap_or(row),
            Self::Blanks => row,
        })
    }

    /// The cells of a row, with an empty one behind a separator at the end.
    fn every_cell(self, row: &str) -> impl Iterator<Item = &str> {
        let between = move |c: char| match self {
            Self::At(at) => c == at,
            Self::Blanks => c.is_whitespace(),
        };
        let cells = row.split(between).map(|cell| cell.trim().trim_matches('"'));
        cells.filter(move |cell| self != Self::Blanks || !cell.is_empty())
    }
}

/// A number; its decimal sign becomes the file's. Between columns a comma is no decimal sign.
pub(crate) fn number(cell: &str, decimal: &mut Option<Decimal>, split: Split) -> Option<f64> {
    let comma = cell.contains(',');
    let sign = if comma { Decimal::Comma } else { Decimal::Point };
    if !comma && !cell.contains('.') {
        return cell.parse().ok();
    }
    if split == Split::At(',') && comma || decimal.is_some_and(|d| d != sign) {
        return None;
    }
    let value = if comma && !cell.contains('.') { cell.replacen(',', ".", 1).parse() } else { cell.parse() };
    let value = value.ok()?;
    *decimal = Some(sign);
    Some(value)
}

/// What stands between the cells of a row, all of which are numbers, and how many there are.
fn numbers(row: &str, decimal: Option<Decimal>) -> Option<(Split, usize)> {
    if passed_over(row) {
        return None;
    }
    let splits = [Split::At(';'), Split::At('\t'), Split::At(','), Split::Blanks];
    splits.into_iter().find_map(|split| {
        if matches!(split, Split::At(c) if !row.contains(c))
            || split == Split::At(',') && decimal == Some(Decimal::Comma)
        {
            return None;
        }
        let mut sign = decimal;
        // What loggers write before their numbers; stamps alone are a heading.
        let (mut plain, mut width) = (0, 0);
        for cell in split.cells(row) {
            width += 1;
            match number(cell, &mut sign, split) {
                Some(_) => plain += 1,
                None if seconds_of_day(cell).is_some() => {}
                None => return None,
            }
        }
        (plain > 0).then_some((split, width))
    })
}

fn passed_over(row: &str) -> bool {
    let row = row.trim_start();
    row.is_empty() || row.starts_with(['#', '%', '!']) || row.starts_with("//")
}

/// What is wrong with a file without a row of numbers: the first row that has some, else all of it.
fn without_numbers(
    first: usize,
    row: &str,
    lines: &[String],
    skip: usize,
    decimal: Option<Decimal>,
) -> Wrong {
    let split_of = |row: &str| {
        let split = [';', '\t', ','].into_iter().find(|c| row.contains(*c));
        split.map_or(Split::Blanks, Split::At)
    };
    for (k, row) in lines.iter().enumerate().skip(skip).filter(|(_, row)| !passed_over(row)) {
        let split = split_of(row);
        let is_number = |cell: &str| number(cell, &mut decimal.clone(), split).is_some();
        let bad = split.cells(row).position(|cell| !is_number(cell));
        if let Some(column) = bad.filter(|_| split.cells(row).any(is_number)) {
            let text = split.cells(row).nth(column).unwrap_or_default().to_owned();
            return (
                k + 1,
                Some(column + 1),
                Problem::BadCell { text, expected: "a number with a decimal point" },
            );
        }
    }
    (first + 1, None, Problem::NoNumbers { text: row.chars().take(40).collect(), lines: lines.len() })
}

/// The cells of a row of names. Where blanks stand between columns, a unit in brackets belongs to the name
/// before it.
fn headings(row: &str, split: Split, width: usize) -> Vec<String> {
    // The last name may be empty, too.
    let mut cells: Vec<String> = split.every_cell(row).map(str::to_owned).collect();
    if split == Split::Blanks {
        cells = cells.into_iter().fold(Vec::new(), |mut all: Vec<String>, cell| {
            match all.last_mut() {
                Some(last) if cell.starts_with(['[', '(']) => *last = format!("{last} {cell}"),
                _ => all.push(cell),
            }
            all
        });
    }
    if cells.len() == width + 1 && cells.last().is_some_and(String::is_empty) {
        cells.pop();
    }
    cells
}

/// Whether a row holds units alone.
fn all_units(cells: &[String]) -> bool {
    let unit = |cell: &String| blank(cell) || Unit::parse(bare(cell)).is_ok();
    cells.iter().all(unit) && !cells.iter().all(|cell| blank(cell))
}

fn blank(cell: &str) -> bool {
    matches!(bare(cell), "" | "-")
}

fn bare(cell: &str) -> &str {
    let inside = |open, close| cell.strip_prefix(open).and_then(|c| c.strip_suffix(close));
    inside('[', ']').or_else(|| inside('(', ')')).unwrap_or(cell)
}

fn with_units(names: &[String], units: &[String]) -> Vec<String> {
    let both = |(name, unit): (&String, &String)| match blank(unit)
        || Heading::parse(name).is_ok_and(|h| h.unit.is_some())
    {
        true => name.clone(),
        false => format!("{name} [{}]", bare(unit)),
    };
    names.iter().zip(units).map(both).collect()
}

/// What stands between columns, the headings, and line and cells of each row of a table that has names and
/// may have words.
type Table = (Split, Vec<String>, Vec<(usize, Vec<String>)>);

/// Takes a table apart.
pub(crate) fn table_rows(text: &str) -> Result<Table, Wrong> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let Some((at, names)) = text.lines().enumerate().find(|(_, row)| !passed_over(row)) else {
        return Err((1, None, Problem::Empty { need: "a line of names and a row" }));
    };
    // The names tell what stands between columns, unless they are words between blanks.
    let split = [';', '\t', ','].into_iter().find(|c| names.contains(*c)).map_or(Split::Blanks, Split::At);
    let text = match split {
        Split::At(between) => without_empty_ends(text, between, true, passed_over).map_err(
            |BehindHeadings { line, column, cell }| {
                (line, Some(column), Problem::BadCell { text: cell, expected: BehindHeadings::EXPECTED })
            },
        )?,
        Split::Blanks => text.into(),
    };
    let mut lines = text.lines().enumerate().filter(|(_, row)| !passed_over(row));
    let names = lines.next().map_or("", |(_, names)| names);
    let headings = headings(names, split, split.cells(names).count());
    let sign = &mut None;
    if headings.iter().all(|h| number(h, sign, split).is_some()) {
        let text = names.chars().take(40).collect();
        return Err((
            at + 1,
            None,
            Problem::BadCell { text, expected: "a line of names, such as `frequency [Hz], gain`" },
        ));
    }
    let mut rows = Vec::new();
    for (k, row) in lines {
        let mut cells: Vec<String> = split.every_cell(row).map(str::to_owned).collect();
        if cells.len() == headings.len() + 1 && cells.last().is_some_and(String::is_empty) {
            cells.pop();
        }
        if cells.len() != headings.len() {
            return Err((k + 1, None, Problem::OtherWidth { have: cells.len(), need: headings.len() }));
        }
        rows.push((k + 1, cells));
    }
    if rows.is_empty() {
        return Err((at + 1, None, Problem::Empty { need: "one row below the names" }));
    }
    Ok((split, headings, rows))
}
