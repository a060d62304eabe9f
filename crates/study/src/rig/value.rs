//! A number of a rig: known, or a formula of factors and of other numbers, or a table over a factor.

use crate::StudyProblem;
use crate::names::{factor_of, factors};
use crate::source::{Outcome, listed};
use rijke_formula::{Context, Formula, Kind, Scope};
use rijke_rig::{Quantity, Unit};
use std::ops::Range;
use toml::Value as Toml;

/// A number that may depend on the operating point.
#[derive(Clone, Debug)]
pub enum Value {
    /// Known, SI.
    Number(f64),
    /// A formula of factors and numbers of parts.
    Formula(Formula),
    /// A formula of unknowns too, and the same with every unknown at the median of its prior.
    Unknown(Formula, Formula),
    /// A factor, and rows of its value and that of the number: linear between them, and constant beyond.
    Table(usize, Vec<[f64; 2]>),
}

impl Value {
    /// Its formula, if it names unknowns.
    #[must_use]
    pub fn unknown(&self) -> Option<&Formula> {
        if let Self::Unknown(formula, _) = self { Some(formula) } else { None }
    }

    /// Its value, given those of all names, unknowns at the medians of their priors; NaN where a factor has
    /// none.
    #[must_use]
    pub fn at(&self, numbers: &[f64]) -> f64 {
        match self {
            Self::Number(value) => *value,
            Self::Formula(formula) | Self::Unknown(_, formula) => formula.real(numbers),
            Self::Table(factor, rows) => interpolate(rows, numbers.get(*factor).copied().unwrap_or(f64::NAN)),
        }
    }
}

/// A plain number, whole or not.
pub(crate) fn number(value: &Toml) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|i| i as f64))
}

/// The numbers x and y of the rows of a table.
pub(crate) fn pairs(rows: &[Toml]) -> Option<Vec<[f64; 2]>> {
    let row = |row: &Toml| match row.as_array().map(Vec::as_slice) {
        Some([x, y]) => Some([number(x)?, number(y)?]),
        _ => None,
    };
    rows.iter().map(row).collect()
}

/// y at x between the rows of a table, and that of the nearest row beyond them.
pub(crate) fn interpolate(rows: &[[f64; 2]], x: f64) -> f64 {
    if x.is_nan() || rows.is_empty() {
        return f64::NAN;
    }
    let upper = rows.partition_point(|row| row[0] <= x).clamp(1, rows.len().max(2) - 1);
    let ([x0, y0], [x1, y1]) = (rows[upper - 1], *rows.get(upper).unwrap_or(&rows[upper - 1]));
    if x1 > x0 { y0 + ((x - x0) / (x1 - x0)).clamp(0.0, 1.0) * (y1 - y0) } else { y0 }
}

/// What stands at a key that wants a number.
pub(super) enum Given {
    /// A number of the operating point.
    Value(Value),
    /// A formula that needs more than that: an unknown, or what is only known where a law acts.
    Law(String),
}

/// What reading a value may need.
pub(super) struct Reader<'a> {
    pub(super) scope: &'a Scope,
    /// Numbers of the part by their bare names.
    pub(super) own: &'a [(String, String)],
    /// Names of unknowns.
    pub(super) unknowns: &'a [String],
    pub(super) at: Range<usize>,
}

impl Reader<'_> {
    fn fail<T>(&self, problem: StudyProblem) -> Outcome<T> {
        Err((self.at.clone(), problem))
    }

    /// As [`Reader::value`], where unknowns may stand too: of a length, a temperature or a place. `medians`
    /// are those of the unknowns' priors.
    pub(super) fn extent(&self, key: &str, value: &Toml, unit: &str, medians: &[f64]) -> Outcome<Value> {
        let text = match self.given(key, value, unit)? {
            Given::Value(value) => return Ok(value),
            Given::Law(text) => text,
        };
        let here = |name: usize| self.scope.names()[name].kind == Kind::Global;
        let medians = self.unknowns.iter().zip(medians).map(|(name, m)| (name.clone(), format!("({m:e})")));
        let known = crate::law::named_in(&text, &medians.collect::<Vec<_>>());
        let read = |parameters: &[String], definitions: &[(String, String)]| {
            let context = Context { scope: self.scope, here: &here, parameters, definitions };
            let fail = |source| (self.at.clone(), StudyProblem::Formula { key: key.to_owned(), source });
            Formula::parse(&text, &context).map_err(fail)
        };
        Ok(Value::Unknown(read(self.unknowns, &[])?, read(&[], &known)?))
    }

    /// A number, a quantity, a formula or a table, in the SI unit `unit`; any unit if that is empty.
    pub(super) fn given(&self, key: &str, value: &Toml, unit: &str) -> Outcome<Given> {
        match value {
            Toml::Integer(v) => Ok(Given::Value(Value::Number(*v as f64))),
            Toml::Float(v) if v.is_finite() => Ok(Given::Value(Value::Number(*v))),
            // A hole is open or closed.
            Toml::Boolean(v) if key == "open" => Ok(Given::Value(Value::Number(f64::from(u8::from(*v))))),
            Toml::String(text) => self.text(key, text, unit),
            Toml::Table(table) => self.table(key, table).map(Given::Value),
            other => self.fail(StudyProblem::Value {
                key: key.to_owned(),
                value: other.to_string(),
                need: "a number, a quantity such as \"12 mm\", a formula, \"$unknown\", or { over = ..., rows = ... }",
            }),
        }
    }

    /// As [`Reader::given`], where nothing but a number of the operating point will do.
    pub(super) fn value(&self, key: &str, value: &Toml, unit: &str) -> Outcome<Value> {
        match self.given(key, value, unit)? {
            Given::Value(value) => Ok(value),
            Given::Law(text) => self.fail(StudyProblem::Value {
                key: key.to_owned(),
                value: text,
                need: "known at every operating point: a number, or a formula of factors and of numbers of parts",
            }),
        }
    }

    fn text(&self, key: &str, text: &str, unit: &str) -> Outcome<Given> {
        if let Ok(quantity) = Quantity::parse(text) {
            let plain = quantity.unit == Unit::one();
            let si = match unit {
                "" => Ok(quantity.unit.to_si(quantity.value)),
                _ if plain => Ok(quantity.value),
                unit => quantity.of(unit),
            };
            let wrong = |source| (self.at.clone(), StudyProblem::Unit { key: key.to_owned(), source });
            return si.map(|v| Given::Value(Value::Number(v))).map_err(wrong);
        }
        // A number with a unit that is none would be read as a formula and fail with less of a reason.
        if text.trim_start().starts_with(|c: char| c.is_ascii_digit())
            && let Err(source) = Quantity::parse(text)
            && !text.contains(['*', '/', '+', '-', '^', '('])
        {
            return self.fail(StudyProblem::Unit { key: key.to_owned(), source });
        }
        let plain = self.without_dollars(text)?;
        let unknown = crate::law::words(&plain).any(|w| self.unknowns.iter().any(|u| u == w));
        let here = |name: usize| self.scope.names()[name].kind == Kind::Global;
        let own = crate::law::named_in(&plain, self.own);
        let context = Context { scope: self.scope, here: &here, parameters: &[], definitions: &own };
        match Formula::parse(&plain, &context) {
            Ok(formula) if !unknown => {
                let fault = if unit.is_empty() { None } else { formula.unit_fault(self.scope, &[], unit) };
                match fault {
                    Some(fault) => self.fail(StudyProblem::UnitOfLaw {
                        key: key.to_owned(),
                        place: "this part".into(),
                        fault,
                    }),
                    None => Ok(Given::Value(Value::Formula(formula))),
                }
            }
            _ => Ok(Given::Law(plain)),
        }
    }

    /// `$name` must be an unknown or a factor.
    fn without_dollars(&self, text: &str) -> Outcome<String> {
        for part in text.split('$').skip(1) {
            let name = crate::law::words(part).next().filter(|name| part.starts_with(*name)).unwrap_or("");
            if !self.unknowns.iter().any(|u| u == name) && !factors(self.scope).any(|f| f == name) {
                return self.fail(StudyProblem::Unknown {
                    what: "unknown or factor",
                    name: format!("${name}"),
                    known: listed(self.unknowns.iter().map(String::as_str).chain(factors(self.scope))),
                });
            }
        }
        Ok(text.replace('$', ""))
    }

    fn table(&self, key: &str, table: &toml::Table) -> Outcome<Value> {
        let wrong = |value: String| StudyProblem::Value {
            key: key.to_owned(),
            value,
            need: "{ over = \"factor\", rows = [[x, y], ...] } with x increasing, in SI units",
        };
        let (Some(Toml::String(over)), Some(Toml::Array(rows)), 2) =
            (table.get("over"), table.get("rows"), table.len())
        else {
            return self.fail(wrong(table.to_string().trim().to_owned()));
        };
        let Some(factor) = factor_of(self.scope, over) else {
            let known = listed(factors(self.scope));
            return self.fail(StudyProblem::Unknown { what: "factor", name: over.clone(), known });
        };
        match pairs(rows) {
            Some(rows) if !rows.is_empty() && rows.windows(2).all(|w| w[0][0] < w[1][0]) => {
                Ok(Value::Table(factor, rows))
            }
            _ => self.fail(wrong("not such a table".to_owned())),
        }
    }
}
