//! A table of a file by its line and the name that messages call it, and the checks of its numbers.

use super::error::FileError;
use super::problem::ElementProblem;
use rijke_numerics::words::of_toml;
use serde::Deserialize;

/// An element or an end, as messages call it.
#[derive(Clone)]
pub(super) struct Item {
    pub(super) line: usize,
    pub(super) place: String,
}

impl Item {
    pub(super) fn fail(&self, problem: ElementProblem) -> FileError {
        FileError::Element { line: self.line, place: self.place.clone(), problem }
    }

    pub(super) fn positive(&self, key: &'static str, value: f64) -> Result<f64, FileError> {
        if value.is_finite() && value > 0.0 {
            Ok(value)
        } else {
            Err(self.fail(ElementProblem::NotPositive { key, value }))
        }
    }

    pub(super) fn not_negative(&self, key: &'static str, value: f64) -> Result<f64, FileError> {
        if value.is_finite() && value >= 0.0 {
            Ok(value)
        } else {
            Err(self.fail(ElementProblem::Negative { key, value }))
        }
    }

    /// A part of an area.
    pub(super) fn part(&self, key: &'static str, value: f64) -> Result<f64, FileError> {
        let fault = || self.fail(ElementProblem::Part { key, value });
        if value > 0.0 && value <= 1.0 { Ok(value) } else { Err(fault()) }
    }

    pub(super) fn polynomial(&self, key: &'static str, value: &[f64]) -> Result<Vec<f64>, FileError> {
        if value.iter().any(|k| *k != 0.0) && value.iter().all(|k| k.is_finite()) {
            Ok(value.to_vec())
        } else {
            Err(self.fail(ElementProblem::Polynomial { key }))
        }
    }

    pub(super) fn parse<'de, T: Deserialize<'de>>(&self, table: toml::Table) -> Result<T, FileError> {
        let texts: Vec<(String, String)> =
            table.iter().filter_map(|(key, value)| Some((key.clone(), value.as_str()?.to_owned()))).collect();
        T::deserialize(toml::Value::Table(table)).map_err(|error| {
            let mut message = of_toml(error.message());
            if message.starts_with("the text ") && message.ends_with("where a number is needed") {
                let of = |(_, text): &&(String, String)| message.contains(&format!("{text:?}"));
                if let Some((key, _)) = texts.iter().find(of) {
                    message = format!("{key}: {message}");
                }
                message += "; this reader takes plain numbers in SI units";
            }
            self.fail(ElementProblem::Keys { message })
        })
    }
}

/// The line where a table of the file begins, 1 if it is written in some other way.
pub(super) fn line_of_table(text: &str, name: &str) -> usize {
    let header = format!("[{name}]");
    1 + text.lines().position(|line| line.trim_start().starts_with(&header)).unwrap_or(0)
}
