//! Base states on disk: `base/states.json`.

use crate::base::{BaseError, PointState};
use crate::cause::Cause;
use crate::rig::Rig;
use crate::source::{Source, listed};
use crate::{StudyError, StudyProblem};
use rijke_rig::{ErrorRecord, StateRecord};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// The file before its points are read, so that faults can name them.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Whole {
    points: BTreeMap<String, serde_json::Value>,
}

/// Reads the states of operating points.
///
/// # Errors
/// File, operating point and remedy.
pub fn read_states(path: &Path, rig: &Rig) -> Result<BTreeMap<String, PointState>, StudyError> {
    let source = Source::read(path)?;
    let file: Whole = serde_json::from_str(&source.text)
        .map_err(|e| source.at_line(e.line(), StudyProblem::Toml(e.to_string())))?;
    let mut states = BTreeMap::new();
    for (id, record) in file.points {
        // Written by machines, all points may stand on one line: their names say where.
        let fail = |problem: StudyProblem| {
            source.at_line(
                line_of(&source, &id),
                StudyProblem::Toml(format!("operating point `{id}`: {problem}")),
            )
        };
        let record = StateRecord::deserialize(record).map_err(|e| fail(StudyProblem::Toml(e.to_string())))?;
        let state = PointState::of(record, &id, rig).map_err(fail)?;
        states.insert(id, state);
    }
    Ok(states)
}

impl PointState {
    /// The state of the operating point called `id`, as a file has it.
    ///
    /// # Errors
    /// A number that the rig does not declare, or a state that cannot be.
    pub fn of(record: StateRecord, id: &str, rig: &Rig) -> Result<Self, StudyProblem> {
        let place = |name: &String| {
            let of = |p: &&usize| rig.scope.names()[**p].name == *name;
            rig.brought.iter().find(of).copied().ok_or_else(|| {
                let known = listed(rig.brought.iter().map(|p| rig.scope.names()[*p].name.as_str()));
                StudyProblem::Unknown {
                    what: "number of the base state (see [base.numbers] of rig.toml)",
                    name: name.clone(),
                    known,
                }
            })
        };
        let names: Vec<&String> = record.numbers.keys().collect();
        let places = record.numbers.keys().map(place).collect::<Result<Vec<_>, _>>()?;
        let error = |e: &ErrorRecord| BaseError {
            cause: Cause::Inferred(e.cause.clone()),
            mass_flow: e.mass_flow,
            numbers: names.iter().map(|n| e.numbers.get(*n).copied().unwrap_or(0.0)).collect(),
            temperature: e.temperature.clone(),
        };
        let state = Self {
            gas: rig.gas.clone(),
            other_gases: Vec::new(),
            pressure: rig.pressure,
            mass_flow: record.mass_flow,
            numbers: places.into_iter().zip(record.numbers.values().copied()).collect(),
            errors: record.errors.iter().map(error).collect(),
            places: record.places,
            temperature: record.temperature,
            kinks: record.kinks,
            moved: Vec::new(),
        };
        state.checked(id)
    }
}

/// Line on which the state of a point begins.
fn line_of(source: &Source, id: &str) -> usize {
    let key = serde_json::Value::from(id).to_string();
    let begins = |at: &usize| source.text[at + key.len()..].trim_start().starts_with(':');
    source.line(source.text.match_indices(&key).map(|(at, _)| at).find(begins).unwrap_or(0))
}
