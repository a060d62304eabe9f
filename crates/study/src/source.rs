//! The text of a file, and where in it something stands.

use crate::{StudyError, StudyProblem};
use rijke_numerics::csv_without_empty_ends;
use rijke_numerics::words::{line_of, of_toml};
use serde::de::DeserializeOwned;
use std::borrow::Cow;
use std::ops::Range;
use std::path::Path;

/// A file that was read; every error names it and the line.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    pub(crate) file: String,
    pub(crate) text: String,
}

/// What is wrong, and where in the text.
pub(crate) type Outcome<T> = Result<T, (Range<usize>, StudyProblem)>;

impl Source {
    pub(crate) fn read(path: &Path) -> Result<Self, StudyError> {
        let file = path.display().to_string();
        match rijke_numerics::read_text(path) {
            Ok(text) => Ok(Self { file, text }),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                let of_every_study =
                    path.file_name().is_some_and(|name| name == "rig.toml" || name == "campaign.csv");
                let problem = Box::new(StudyProblem::Absent { of_every_study });
                Err(StudyError { file, line: None, problem })
            }
            Err(error) => {
                let cause = std::io::Error::other(error.to_string());
                Err(StudyError { file, line: None, problem: Box::new(StudyProblem::Unreadable(cause)) })
            }
        }
    }

    /// A table. Spreadsheets write tabs, or in countries with a decimal comma semicolons, between cells:
    /// these become commas, and that a point. Empty columns at the end and empty rows are left out.
    pub(crate) fn read_table(path: &Path) -> Result<Self, StudyError> {
        let mut source = Self::read(path)?;
        let header = source.text.lines().nth(source.header_line() - 1).unwrap_or_default();
        let between = [';', '\t'].into_iter().find(|c| header.contains(*c));
        if let Some(between) = between.filter(|_| !header.contains(',')) {
            source.text = with_commas(&source.text, between);
        }
        match csv_without_empty_ends(&source.text) {
            Ok(Cow::Borrowed(_)) => Ok(source),
            Ok(Cow::Owned(text)) => Ok(Self { text, ..source }),
            Err(behind) => Err(source.at_line(behind.line, StudyProblem::Csv(behind.to_string()))),
        }
    }

    pub(crate) fn toml<T: DeserializeOwned>(&self) -> Result<T, StudyError> {
        toml::from_str(&self.text).map_err(|error| self.wrong(&error))
    }

    /// What is wrong with the text as TOML.
    pub(crate) fn wrong(&self, error: &toml::de::Error) -> StudyError {
        let at = error.span().map_or(0, |span| span.start);
        self.fail(at, StudyProblem::Toml(self.with_key(at, of_toml(error.message()))))
    }

    /// What is wrong with a value, with the key before it on its line. A message that names the key stays as
    /// it is.
    pub(crate) fn with_key(&self, at: usize, said: String) -> String {
        let before = self.text.get(..at).unwrap_or_default().rsplit('\n').next().unwrap_or_default();
        let name = before.rsplit_once('=').map(|(left, _)| left.trim_end());
        let name = name.and_then(|left| left.rsplit([' ', ',', '{']).next()).unwrap_or_default();
        if name.is_empty() || said.contains(" key `") { said } else { format!("`{name}`: {said}") }
    }

    /// Line of an offset in bytes, from 1.
    pub(crate) fn line(&self, at: usize) -> usize {
        line_of(&self.text, at)
    }

    /// The first place behind `at` where a line gives `key`, or `at`.
    pub(crate) fn key_after(&self, at: usize, key: &str) -> usize {
        let mut place = at;
        for line in self.text.get(at..).unwrap_or_default().split_inclusive('\n') {
            let mut words = line.split('=').map(str::trim);
            if words.next() == Some(key) && words.next().is_some() {
                return place;
            }
            place += line.len();
        }
        at
    }

    pub(crate) fn fail(&self, at: usize, problem: StudyProblem) -> StudyError {
        let (file, line) = (self.file.clone(), Some(self.line(at)));
        StudyError { file, line, problem: Box::new(problem) }
    }

    pub(crate) fn at_line(&self, line: usize, problem: StudyProblem) -> StudyError {
        StudyError { file: self.file.clone(), line: Some(line), problem: Box::new(problem) }
    }

    /// Line of the first row of a table that is no comment, from 1.
    pub(crate) fn header_line(&self) -> usize {
        1 + self.text.lines().position(|l| !l.starts_with('#') && !l.trim().is_empty()).unwrap_or(0)
    }

    /// The rows of a table of comma-separated values; lines that begin with `#` are comments.
    pub(crate) fn table(&self) -> csv::Reader<&[u8]> {
        csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(self.text.as_bytes())
    }

    /// Line of a row of such a table, from 1. A reader is still before the comments that stand above the row.
    pub(crate) fn line_of(&self, record: &csv::StringRecord) -> usize {
        self.line(self.row_from(record.position().map_or(0, |p| p.byte() as usize)))
    }

    /// Where the first row at or behind an offset begins that is no comment.
    fn row_from(&self, mut at: usize) -> usize {
        for line in self.text.get(at..).unwrap_or_default().split_inclusive('\n') {
            if !line.starts_with('#') && !line.trim().is_empty() {
                break;
            }
            at += line.len();
        }
        at
    }

    /// A fault of such a table, at its line.
    pub(crate) fn csv(&self, error: &csv::Error) -> StudyError {
        let at = error.position().map(|p| self.row_from(p.byte() as usize));
        let line = at.map_or_else(|| self.header_line(), |at| self.line(at));
        let csv::ErrorKind::UnequalLengths { expected_len, len, .. } = error.kind() else {
            return self.at_line(line, StudyProblem::Csv(error.to_string()));
        };
        let said = format!(
            "the row has {len} cells, but the heading has {expected_len}: give the row a cell for every column, an empty one where there is no value; a \
             decimal sign is a point where commas stand between cells"
        );
        self.at_line(line, StudyProblem::Csv(said))
    }

    pub(crate) fn located<T>(&self, outcome: Outcome<T>) -> Result<T, StudyError> {
        outcome.map_err(|(at, problem)| self.fail(at.start, problem))
    }
}

/// The text with commas for what stands `between` cells, and points for commas between digits. Every
/// character keeps its place.
fn with_commas(text: &str, between: char) -> String {
    let digit = |c: Option<char>| c.is_some_and(|c| c.is_ascii_digit());
    let before = std::iter::once(None).chain(text.chars().map(Some));
    let after = text.chars().skip(1).map(Some).chain([None]);
    text.chars()
        .zip(before.zip(after))
        .map(|(c, (left, right))| match c {
            c if c == between => ',',
            ',' if digit(left) && digit(right) => '.',
            _ => c,
        })
        .collect()
}

/// `a, b, c`, or `none`.
pub(crate) fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let all: Vec<&str> = names.into_iter().collect();
    if all.is_empty() { "none".to_owned() } else { all.join(", ") }
}
