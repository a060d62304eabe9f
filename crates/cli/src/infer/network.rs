//! A network file with names in the place of numbers.

use super::modes::{Measured, Row};
use crate::failure::{Classify, Failure};
use rijke_inference::{Parameter, Parameters, Prior};
use rijke_network::{Newton, Workspace, file::read};
use rijke_numerics::C64;
use serde::Deserialize;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// The file.
pub(super) struct Template {
    pub(super) path: PathBuf,
    pub(super) unknowns: Vec<Parameter>,
    /// The network, with `"$name"` where numbers will be.
    table: Table,
    columns: Vec<String>,
}

/// `[unknown.name]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unknown {
    #[serde(default = "one")]
    unit: String,
    prior: Prior,
}

fn one() -> String {
    "1".to_owned()
}

impl Template {
    /// Reads a file whose names are unknowns or columns of `measured`, and tries it at the middle of its priors.
    pub(super) fn read(path: &Path, measured: &Measured) -> Result<Self, Failure> {
        let text = std::fs::read_to_string(path).or_bad_input();
        let text = text
            .map_err(|f| f.at(path).remedy("Name a network file, as docs/network-file.md describes it."))?;
        let mut table: Table =
            toml::from_str(&text).or_bad_input().map_err(|f| f.at(path).remedy("Correct the TOML."))?;
        let remedy = "Give each unknown as [unknown.name] with prior = { normal = { mean = ..., sd = ... } } and a unit.";
        let unknowns = table.remove("unknown").unwrap_or_else(|| Value::Table(Table::new()));
        let unknowns: std::collections::BTreeMap<String, Unknown> =
            unknowns.try_into().or_bad_input().map_err(|f| f.at(path).remedy(remedy))?;
        let parameter = |(name, u): (String, Unknown)| Parameter::new(name.clone(), name, u.unit, u.prior);
        let unknowns: Vec<Parameter> = unknowns.into_iter().map(parameter).collect();
        let template = Self { path: path.to_owned(), unknowns, table, columns: measured.columns.clone() };
        template.parameters()?;
        let bad = |message: String| Failure::bad_input(message).at(path).remedy(remedy);
        if template.unknowns.is_empty() {
            return Err(bad("has no unknown".into()));
        }
        let mut used = Vec::new();
        names(&Value::Table(template.table.clone()), &mut used);
        let known = |name: &String| {
            template.unknowns.iter().any(|u| u.name == *name) || template.columns.contains(name)
        };
        if let Some(name) = used.iter().find(|n| !known(n)) {
            let columns =
                if template.columns.is_empty() { "none".to_owned() } else { template.columns.join(", ") };
            return Err(bad(format!(
                "`${name}` is neither an unknown nor a column of the data (columns: {columns})"
            )));
        }
        if let Some(idle) = template.unknowns.iter().find(|u| !used.contains(&u.name)) {
            return Err(bad(format!("the unknown `{0}` appears nowhere as \"${0}\"", idle.name)));
        }
        let middle: Vec<f64> = template.unknowns.iter().map(|u| u.prior.quantile(0.5)).collect();
        for (k, row) in measured.rows.iter().enumerate() {
            template.mode(&middle, row).or_bad_input().map_err(|f| {
                f.at(path).remedy(format!("At the middle of the priors the network must have a mode near that of row {} of the data.", k + 1))
            })?;
        }
        Ok(template)
    }

    pub(super) fn parameters(&self) -> Result<Parameters, Failure> {
        Parameters::new(self.unknowns.clone())
            .or_bad_input()
            .map_err(|f| f.at(&self.path).remedy("Correct the prior."))
    }

    /// The network file with numbers in all places.
    pub(super) fn text(&self, values: &[f64], row: &Row) -> Result<String, Failure> {
        toml::to_string(&self.filled(values, row)).or_failed()
    }

    fn filled(&self, values: &[f64], row: &Row) -> Table {
        let number = |name: &str| {
            let unknown = self.unknowns.iter().position(|u| u.name == name).map(|k| values[k]);
            unknown.or_else(|| self.columns.iter().position(|c| c == name).map(|k| row.setting[k]))
        };
        let mut table = self.table.clone();
        table.iter_mut().for_each(|(_, value)| fill(value, &number));
        table
    }

    /// Growth rate and frequency (Hz) of the mode next to that of `row`.
    pub(super) fn mode(&self, values: &[f64], row: &Row) -> Result<[f64; 2], Problem> {
        let text = toml::to_string(&self.filled(values, row)).map_err(|e| Problem(e.to_string()))?;
        let built = read(&text).map_err(|e| Problem(e.to_string()))?;
        if built.flow.is_some() {
            return Err(Problem("[flow] is not inferred with: the gas must be at rest".into()));
        }
        let guess = C64::new(row.mode[0], 2.0 * PI * row.mode[1]);
        let root = built.network.solve(&built.laws, guess, &Newton::default(), &mut Workspace::default());
        let s = root.map_err(|e| Problem(e.to_string()))?.s;
        Ok([s.re, s.im / (2.0 * PI)])
    }
}

/// Why a network has no mode.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(super) struct Problem(String);

/// Puts numbers in the place of `"$name"`.
fn fill(value: &mut Value, number: &impl Fn(&str) -> Option<f64>) {
    match value {
        Value::String(text) => {
            if let Some(found) = text.strip_prefix('$').and_then(number) {
                *value = Value::Float(found);
            }
        }
        Value::Array(list) => list.iter_mut().for_each(|v| fill(v, number)),
        Value::Table(table) => table.iter_mut().for_each(|(_, v)| fill(v, number)),
        _ => {}
    }
}

/// Every `"$name"`.
fn names(value: &Value, into: &mut Vec<String>) {
    match value {
        Value::String(text) => into.extend(text.strip_prefix('$').map(String::from)),
        Value::Array(list) => list.iter().for_each(|v| names(v, into)),
        Value::Table(table) => table.iter().for_each(|(_, v)| names(v, into)),
        _ => {}
    }
}
