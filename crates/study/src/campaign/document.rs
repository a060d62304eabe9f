//! `campaign.toml`: a table for every operating point.

use super::points::{Campaign, Factor, Point};
use super::row::{Cell, RESERVED, Row, checked, column, factors};
use crate::source::{Source, listed};
use crate::{StudyError, StudyProblem};
use rijke_rig::Quantity;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::ops::Range;
use toml::{Spanned, Table, Value};

/// The campaign of a document.
pub(super) fn parse(source: &Source) -> Result<Campaign, StudyError> {
    let File { units, defaults, point: tables } = source.toml()?;
    let columns = columns(source, units)?;
    let top = defaults.as_ref().map_or(0, |table| table.span().start);
    let defaults = defaults.map_or_else(Table::new, Spanned::into_inner);
    known(source, &columns, &defaults, top..top)?;
    if defaults.contains_key("id") {
        let problem = StudyProblem::Duplicate { what: "point", name: defaults["id"].to_string() };
        return Err(source.fail(source.key_after(top, "id"), problem));
    }
    let has = |key: &str| {
        defaults.contains_key(key) || tables.iter().any(|table| table.get_ref().contains_key(key))
    };
    checked(&columns, has).map_err(|problem| source.fail(0, problem))?;
    let factors = factors(&columns);
    let mut points: Vec<Point> = Vec::with_capacity(tables.len());
    for table in tables {
        let at = table.span();
        let own = table.into_inner();
        known(source, &columns, &own, at.clone())?;
        let mut cells = Vec::new();
        for column in &columns {
            let key = if column.name == "point" { "id" } else { &column.name };
            let (from, value) = match (own.get(key), defaults.get(key)) {
                (Some(value), _) => (at.start, value),
                (None, Some(value)) => (top, value),
                (None, None) => continue,
            };
            let fail = |problem| source.fail(source.key_after(from, key), problem);
            cells.push((cell(key, value).map_err(fail)?, column));
        }
        let fail = |problem: StudyProblem| source.fail(place_of(source, &own, &at, &problem), problem);
        if !own.contains_key("id") {
            let need = "give every [[point]] a name, as id = \"a-1\"";
            return Err(fail(StudyProblem::Missing { key: "id".into(), need }));
        }
        let point = Row { cells }.point(&factors).map_err(fail)?;
        if points.iter().any(|p| p.id == point.id) {
            return Err(fail(StudyProblem::Duplicate { what: "point", name: point.id }));
        }
        points.push(point);
    }
    if points.is_empty() {
        let problem =
            StudyProblem::Empty { what: "operating point", need: "add a table [[point]] with an id" };
        return Err(source.fail(0, problem));
    }
    Ok(Campaign { factors, points, file: "campaign.toml".into() })
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    /// The factors and the units of their numbers.
    #[serde(default)]
    units: BTreeMap<String, Spanned<String>>,
    /// What every point has that does not say otherwise.
    defaults: Option<Spanned<Table>>,
    #[serde(default)]
    point: Vec<Spanned<Table>>,
}

/// The factors in the order of the file, and the names with a meaning of their own.
fn columns(source: &Source, units: BTreeMap<String, Spanned<String>>) -> Result<Vec<Factor>, StudyError> {
    let mut units: Vec<(String, Spanned<String>)> = units.into_iter().collect();
    units.sort_by_key(|(_, unit)| unit.span().start);
    let mut columns = Vec::new();
    for (name, unit) in units {
        let (at, unit) = (unit.span().start, unit.into_inner());
        let heading = if unit.is_empty() { name } else { format!("{name} [{unit}]") };
        columns.push(column(&heading).map_err(|problem| source.fail(at, problem))?);
    }
    for name in RESERVED {
        if !columns.iter().any(|c: &Factor| c.name == name) {
            columns.push(column(name).map_err(|problem| source.fail(0, problem))?);
        }
    }
    Ok(columns)
}

/// Refuses a key that is no factor and has no meaning of its own.
fn known(source: &Source, columns: &[Factor], table: &Table, at: Range<usize>) -> Result<(), StudyError> {
    let is_known =
        |key: &&String| *key == "id" || columns.iter().any(|c| c.name == **key && c.name != "point");
    let Some(key) = table.keys().find(|key| !is_known(key)) else { return Ok(()) };
    let names = columns.iter().map(|c| if c.name == "point" { "id" } else { &c.name });
    let (what, known) = ("factor (factors stand in [units], each with its unit)", listed(names));
    let problem = StudyProblem::Unknown { what, name: key.clone(), known };
    Err(source.fail(source.key_after(at.start, key), problem))
}

/// What a key holds.
fn cell(key: &str, value: &Value) -> Result<Cell, StudyProblem> {
    let is_label = ["id", "row", "installation", "day"].contains(&key);
    match value {
        Value::String(text) if is_label => Ok(Cell::Text(text.clone())),
        Value::Integer(_) | Value::Float(_) | Value::Datetime(_) if is_label => {
            Ok(Cell::Text(value.to_string()))
        }
        Value::Integer(v) => Ok(Cell::Number(*v as f64)),
        Value::Float(v) => Ok(Cell::Number(*v)),
        Value::Boolean(v) => Ok(Cell::Number(f64::from(u8::from(*v)))),
        // A number without unit is one of the column.
        Value::String(text) if text.parse::<f64>().is_ok() || !begins_number(text) => {
            Ok(Cell::Text(text.clone()))
        }
        Value::String(text) => match Quantity::parse(text) {
            Ok(quantity) => Ok(Cell::Quantity(quantity)),
            Err(source) => Err(StudyProblem::Unit { key: key.to_owned(), source }),
        },
        other => {
            let need = "a number, a quantity such as \"25 mm\", true or false, or a label";
            Err(StudyProblem::Value { key: key.to_owned(), value: other.to_string(), need })
        }
    }
}

fn begins_number(text: &str) -> bool {
    text.trim_start_matches(['+', '-', '.', ' ']).starts_with(|c: char| c.is_ascii_digit())
}

/// Where the key that a problem names stands: in the point, or where the point begins.
fn place_of(source: &Source, own: &Table, at: &Range<usize>, problem: &StudyProblem) -> usize {
    let key = match problem {
        StudyProblem::Value { key, .. } | StudyProblem::Unit { key, .. } => key.as_str(),
        StudyProblem::Name { .. } | StudyProblem::Duplicate { .. } => "id",
        _ => return at.start,
    };
    if own.contains_key(key) { source.key_after(at.start, key) } else { at.start }
}
