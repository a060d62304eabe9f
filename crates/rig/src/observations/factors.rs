//! Columns of factors in tables of operating points: `x_g [m]`, `gauze [1]`.

use crate::apparatus::point::{FactorValue, OperatingPoint};
use crate::problem::Problem;
use crate::units::{Heading, Unit};
use std::collections::BTreeMap;

/// A column with a factor.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FactorColumn {
    /// The heading as the file has it.
    pub(crate) heading: String,
    name: String,
    unit: Unit,
}

impl FactorColumn {
    /// The column of a heading, which must have a unit: one without could be another column misspelt.
    pub(crate) fn parse(heading: &str) -> Result<Self, Problem> {
        match Heading::parse(heading).map_err(Problem::Unit)? {
            Heading { name, unit: Some(unit) } => Ok(Self { heading: heading.into(), name, unit }),
            Heading { unit: None, .. } => {
                let what = "is no column of this table; a factor has its unit in the heading, as in `x [m]`, and a number `[1]`";
                Err(Problem::Keys { what })
            }
        }
    }

    /// Adds what a cell holds to the factors of a point: nothing if it is empty.
    pub(crate) fn add(&self, text: &str, factors: &mut BTreeMap<String, FactorValue>) -> Result<(), Problem> {
        let value = match text {
            "" | "-" => return Ok(()),
            "true" | "yes" => 1.0,
            "false" | "no" => 0.0,
            text => text.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or(Problem::BadCell {
                text: text.into(),
                expected: "a finite number, true, false, or empty where there is none",
            })?,
        };
        let factor = FactorValue { value: self.unit.to_si(value), unit: self.unit.in_si() };
        match factors.insert(self.name.clone(), factor) {
            Some(_) => Err(Problem::Duplicate { name: self.name.clone() }),
            None => Ok(()),
        }
    }
}

/// Headings of all factors that any of the points has, and the cells of a point under them.
pub(crate) fn headings<'a>(
    points: impl Iterator<Item = &'a OperatingPoint>,
) -> (Vec<String>, impl Fn(&OperatingPoint) -> Vec<String>) {
    let mut all: BTreeMap<(String, String), ()> = BTreeMap::new();
    for point in points {
        all.extend(point.factors.iter().map(|(name, f)| ((name.clone(), f.unit.clone()), ())));
    }
    let all: Vec<(String, String)> = all.into_keys().collect();
    let headings = all.iter().map(|(name, unit)| format!("{name} [{unit}]")).collect();
    let cells = move |point: &OperatingPoint| {
        let cell = |(name, unit): &(String, String)| {
            let own = point.factors.get(name).filter(|f| f.unit == *unit);
            own.map_or_else(String::new, |f| f.value.to_string())
        };
        all.iter().map(cell).collect()
    };
    (headings, cells)
}
