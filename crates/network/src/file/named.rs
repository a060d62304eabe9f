//! The numbers of a network file by name: other values of them, and derivatives of eigenvalues in them.
//!
//! An eigenvalue is F(s, theta) = 0, so that ds/dtheta = -F_theta/F_s. F_s is exact. F_theta is the central
//! difference of fourth order of F at s held, with steps of 1e-3 theta: its remainder is about 1e-12 of
//! F'''''/F', rounding 1e-13 of F/(theta F'). In a mean flow a diameter that is that of
//! the neighbour has 5e-5: expansion and contraction meet there, and agree to first order. Reading the file
//! again at other values is the only way on which every element, end and table is seen as it is.

use super::build::Built;
use super::error::FileError;
use super::read::read;
use super::schema::Gas;
use crate::chain::workspace::Workspace;
use crate::error::NetworkError;
use rijke_numerics::C64;
use toml::{Table, Value};

/// A network file whose numbers are asked for by name: the path of keys, with the element's name or its place
/// from 1: `gas.temperature`, `gauze.gain`, `element.3.length`, `upstream.modulus`, `gauze.mu.0`.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedNumbers {
    table: Table,
}

/// What is wrong with a name or with the network at other values.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NumberError {
    /// No number of the file is called so.
    #[error("no number of the file is called `{name}`; known: {known}")]
    Unknown {
        /// The name.
        name: String,
        /// The names that there are.
        known: String,
    },
    /// A number that is a count, or that the file cannot change by little.
    #[error("`{name}` has no derivative: {source}")]
    Rigid {
        /// The name.
        name: String,
        /// What the file says beside its value.
        source: Box<FileError>,
    },
    /// The network is refused at the values given.
    #[error(transparent)]
    File(#[from] FileError),
    /// The derivative is not a number.
    #[error(transparent)]
    Network(#[from] NetworkError),
}

/// Step of the differences, of a number's modulus.
const STEP: f64 = 1e-3;

impl Gas {
    /// Its numbers by key.
    pub(super) fn numbers(&self) -> [(&'static str, f64); 6] {
        [
            ("temperature", self.temperature),
            ("pressure", self.pressure),
            ("gamma", self.gamma),
            ("gas_constant", self.gas_constant),
            ("viscosity", self.viscosity),
            ("prandtl", self.prandtl),
        ]
    }
}

impl NamedNumbers {
    /// Takes a network file apart.
    ///
    /// # Errors
    /// [`FileError::Syntax`].
    pub fn of(text: &str) -> Result<Self, FileError> {
        let mut table: Table = toml::from_str(text).map_err(|error| FileError::syntax(&error))?;
        // NamedNumbers that a file may leave out can be asked for, too.
        if let Value::Table(given) = table.entry("gas").or_insert_with(|| Value::Table(Table::new())) {
            for (key, value) in Gas::default().numbers() {
                given.entry(key).or_insert(Value::Float(value));
            }
        }
        Ok(Self { table })
    }

    /// Names and values, in the order of the file's tables.
    #[must_use]
    pub fn list(&self) -> Vec<(String, f64)> {
        let mut found = Vec::new();
        for (key, value) in &self.table {
            let elements = value.as_array().filter(|_| key == "element");
            match elements {
                Some(elements) => elements.iter().enumerate().for_each(|(k, element)| {
                    collect(&self.called(k, element), element, &mut found);
                }),
                None => collect(key, value, &mut found),
            }
        }
        found
    }

    /// An element's own name if no other has it, else `element.K`.
    fn called(&self, k: usize, element: &Value) -> String {
        let name = |e: &Value| e.get("name").and_then(Value::as_str).map(String::from);
        let alone = name(element).filter(|own| {
            let elements = self.table.get("element").and_then(Value::as_array).into_iter().flatten();
            elements.filter(|e| name(e).as_ref() == Some(own)).count() == 1 && !self.table.contains_key(own)
        });
        alone.unwrap_or_else(|| format!("element.{}", k + 1))
    }

    fn place(&mut self, name: &str) -> Option<&mut Value> {
        let elements = self.table.get("element").and_then(Value::as_array).cloned().unwrap_or_default();
        let element = elements.iter().enumerate().find_map(|(k, e)| {
            let by_name = name.strip_prefix(&self.called(k, e)).and_then(|rest| rest.strip_prefix('.'));
            let by_place = || name.strip_prefix(&format!("element.{}.", k + 1));
            by_name.or_else(by_place).map(|rest| (k, rest))
        });
        let (mut value, path) = match element {
            Some((k, rest)) => (self.table.get_mut("element")?.get_mut(k)?, rest),
            None => {
                let (key, rest) = name.split_once('.')?;
                (self.table.get_mut(key)?, rest)
            }
        };
        for key in path.split('.') {
            value = match value {
                Value::Array(list) => list.get_mut(key.parse::<usize>().ok()?)?,
                value => value.get_mut(key)?,
            };
        }
        matches!(value, Value::Float(_) | Value::Integer(_)).then_some(value)
    }

    /// The value of a number.
    ///
    /// # Errors
    /// [`NumberError::Unknown`].
    pub fn value(&self, name: &str) -> Result<f64, NumberError> {
        let mut numbers = self.clone();
        match numbers.place(name) {
            Some(Value::Float(value)) => Ok(*value),
            Some(Value::Integer(value)) => Ok(*value as f64),
            _ => Err(self.unknown(name)),
        }
    }

    /// The same file with another value of one number.
    ///
    /// # Errors
    /// [`NumberError::Unknown`].
    pub fn set(&mut self, name: &str, value: f64) -> Result<(), NumberError> {
        let unknown = self.unknown(name);
        let place = self.place(name).ok_or(unknown)?;
        let count = matches!(place, Value::Integer(_)) && value.fract() == 0.0;
        *place = if count { Value::Integer(value as i64) } else { Value::Float(value) };
        Ok(())
    }

    fn unknown(&self, name: &str) -> NumberError {
        let known = self.list().into_iter().map(|(name, _)| name).collect::<Vec<_>>().join(", ");
        NumberError::Unknown { name: name.to_owned(), known }
    }

    /// The text of the file as it now is.
    #[must_use]
    pub fn text(&self) -> String {
        // A table that was read can be written.
        toml::to_string(&self.table).unwrap_or_default()
    }

    /// The network as it now is.
    ///
    /// # Errors
    /// [`FileError`]; lines are those of [`NamedNumbers::text`].
    pub fn build(&self) -> Result<Built, FileError> {
        read(&self.text())
    }

    /// ds/dtheta of the eigenvalue `s` of this network, theta being the number called `name`: 1/s and rad/s
    /// per its unit.
    ///
    /// # Errors
    /// [`NumberError::Unknown`], [`NumberError::Rigid`] for a number that cannot change by a part in a
    /// thousand, [`NetworkError::NotFinite`].
    pub fn derivative(&self, s: C64, name: &str) -> Result<C64, NumberError> {
        let work = &mut Workspace::default();
        let value = self.value(name)?;
        let step = STEP * if value == 0.0 { 1.0 } else { value.abs() };
        let [_, slope] = self.build()?.characteristic(s, work);
        let mut at = |k: f64| -> Result<C64, NumberError> {
            let mut other = self.clone();
            other.set(name, value + k * step)?;
            let rigid = |source| NumberError::Rigid { name: name.to_owned(), source: Box::new(source) };
            Ok(other.build().map_err(rigid)?.characteristic(s, work)[0])
        };
        let difference = 8.0 * (at(1.0)? - at(-1.0)?) - (at(2.0)? - at(-2.0)?);
        let derivative = -difference / (12.0 * step * slope);
        if derivative.is_finite() { Ok(derivative) } else { Err(NetworkError::NotFinite { s }.into()) }
    }
}

fn collect(name: &str, value: &Value, into: &mut Vec<(String, f64)>) {
    let inner = |key: &str| format!("{name}.{key}");
    match value {
        Value::Float(number) => into.push((name.to_owned(), *number)),
        Value::Integer(number) => into.push((name.to_owned(), *number as f64)),
        Value::Array(list) => {
            list.iter().enumerate().for_each(|(k, value)| collect(&inner(&k.to_string()), value, into));
        }
        Value::Table(table) => table.iter().for_each(|(key, value)| collect(&inner(key), value, into)),
        _ => {}
    }
}

#[cfg(test)]
mod tests;
