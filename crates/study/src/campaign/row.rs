//! Columns of a campaign, and one operating point from what they have for it, whichever file it stands in.

use super::points::{Factor, Point};
use crate::StudyProblem;
use crate::names;
use rijke_rig::{Day, Heading, Quantity, Unit};

/// Columns with a meaning of their own.
pub(crate) const RESERVED: [&str; 7] =
    ["point", "row", "installation", "day", "repeats", "T_amb", "T_amb_sd"];

/// The lowest and the highest temperature of surroundings, K: what lies beyond is taken for one in another
/// unit.
pub const SURROUNDINGS: [f64; 2] = [COLDEST, 2000.0];
pub(crate) const COLDEST: f64 = 100.0;

/// A column from its heading, `x_g [mm]`.
pub(super) fn column(text: &str) -> Result<Factor, StudyProblem> {
    let heading =
        Heading::parse(text).map_err(|source| StudyProblem::Unit { key: text.to_owned(), source })?;
    let name = heading.name.clone();
    let wanted = match name.as_str() {
        "T_amb" | "T_amb_sd" => "K",
        _ => "",
    };
    let is_stated = heading.unit.is_some();
    let stated = heading.unit.clone().unwrap_or_else(Unit::one);
    let unit = if wanted.is_empty() { si_text(&stated) } else { wanted.to_owned() };
    let shown = if wanted.is_empty() {
        stated
    } else {
        heading.of(wanted).map_err(|source| StudyProblem::Unit { key: name.clone(), source })?
    };
    if !RESERVED.contains(&name.as_str()) {
        let good = |name: &str| {
            name.starts_with(|c: char| c.is_alphabetic())
                && name.chars().all(|c| c.is_alphanumeric() || c == '_')
        };
        if !good(&name) {
            let why = if good(&name.replace(' ', "_")) {
                "formulas name it, so that it has no blanks: write an underscore for each, as in growth_rate and growth_rate_sd"
            } else {
                "formulas name it, so that it must start with a letter and have letters, digits and _ only"
            };
            return Err(StudyProblem::Name { what: "factor", name, why });
        }
        names::free(&names::built_in()?, "factor", &name)?;
    }
    Ok(Factor { name, unit, shown, stated: is_stated })
}

/// Refuses columns of which two have one name, or that nothing would use; `has` says what a file gives.
pub(super) fn checked(columns: &[Factor], has: impl Fn(&str) -> bool) -> Result<(), StudyProblem> {
    for (k, a) in columns.iter().enumerate() {
        if columns[..k].iter().any(|b| b.name == a.name) {
            return Err(StudyProblem::Duplicate { what: "column", name: a.name.clone() });
        }
    }
    if has("T_amb_sd") && !has("T_amb") {
        let need = "a column `T_amb_sd` says how well it is known; correct the name of the column of ambient temperatures, or leave out T_amb_sd";
        return Err(StudyProblem::Missing { key: "T_amb".into(), need });
    }
    let other =
        |c: &Factor| of_which(c, columns).filter(|of| of.unit != c.unit).map(|of| (c.clone(), of.clone()));
    match columns.iter().find_map(other) {
        Some((sd, factor)) => Err(StudyProblem::SdOfFactor {
            factor: factor.name,
            unit: factor.shown.to_string(),
            other: sd.shown.to_string(),
        }),
        None => Ok(()),
    }
}

/// The factors among columns.
pub(super) fn factors(columns: &[Factor]) -> Vec<Factor> {
    let is_one = |c: &&Factor| !RESERVED.contains(&c.name.as_str()) && of_which(c, columns).is_none();
    columns.iter().filter(is_one).cloned().collect()
}

/// The factor of which a column has the standard deviation.
fn of_which<'a>(column: &Factor, columns: &'a [Factor]) -> Option<&'a Factor> {
    let name = column.name.strip_suffix("_sd").filter(|name| !RESERVED.contains(name))?;
    columns.iter().find(|c| c.name == name)
}

/// What a point has for a column.
#[derive(Clone, Debug)]
pub(super) enum Cell {
    /// A label, or a number as text in the unit of the column; empty for none.
    Text(String),
    /// A number in the unit of the column.
    Number(f64),
    /// A number with a unit of its own.
    Quantity(Quantity),
}

/// The cells of a point with their columns.
pub(super) struct Row<'a> {
    pub(super) cells: Vec<(Cell, &'a Factor)>,
}

impl Row<'_> {
    fn cell(&self, name: &str) -> Option<(&Cell, &Factor)> {
        let found = self.cells.iter().find(|(_, column)| column.name == name)?;
        Some((&found.0, found.1)).filter(|(cell, _)| !matches!(cell, Cell::Text(text) if is_empty(text)))
    }

    fn label(&self, name: &str) -> Result<Option<&str>, StudyProblem> {
        match self.cell(name) {
            None => Ok(None),
            Some((Cell::Text(text), _)) if !text.eq_ignore_ascii_case("nan") => Ok(Some(text)),
            Some((cell, _)) => {
                let need = "a label, or empty: `nan` would be one that all such points share";
                Err(StudyProblem::Value { key: name.to_owned(), value: cell.to_string(), need })
            }
        }
    }

    /// The number in a column, in SI.
    fn number(&self, name: &str, difference: bool) -> Result<Option<f64>, StudyProblem> {
        let Some((cell, column)) = self.cell(name) else { return Ok(None) };
        let wrong = || StudyProblem::Value {
            key: name.to_owned(),
            value: cell.to_string(),
            need: "a finite number with a decimal point, true, false, or empty where there is none",
        };
        let value = match cell {
            Cell::Number(value) => *value,
            Cell::Quantity(quantity) => return self::quantity(quantity, column, difference).map(Some),
            Cell::Text(text) => match text.as_str() {
                "true" | "yes" => 1.0,
                "false" | "no" => 0.0,
                text => text.parse::<f64>().map_err(|_| wrong())?,
            },
        };
        if !value.is_finite() {
            return Err(wrong());
        }
        let unit = &column.shown;
        Ok(Some(if difference { unit.difference_to_si(value) } else { unit.to_si(value) }))
    }

    /// The operating point of this row.
    pub(super) fn point(&self, factors: &[Factor]) -> Result<Point, StudyProblem> {
        let id = self.label("point")?.unwrap_or_default().to_owned();
        let good = |c: char| c.is_alphanumeric() || "-_.+".contains(c);
        if id.is_empty() || !id.chars().all(good) {
            let why = "it is also a folder name, so give letters, digits and - _ . +";
            return Err(StudyProblem::Name { what: "point", name: id, why });
        }
        let values = factors
            .iter()
            .map(|f| Ok(self.number(&f.name, false)?.unwrap_or(f64::NAN)))
            .collect::<Result<Vec<_>, StudyProblem>>()?;
        let factor_sds = factors
            .iter()
            .map(|f| {
                let key = format!("{}_sd", f.name);
                let sd = self.number(&key, true)?.unwrap_or(0.0);
                if sd >= 0.0 {
                    return Ok(sd);
                }
                Err(StudyProblem::Value {
                    key,
                    value: sd.to_string(),
                    need: "a standard deviation, zero or more",
                })
            })
            .collect::<Result<Vec<_>, _>>()?;
        let repeats = self.number("repeats", false)?.unwrap_or(1.0);
        if !(repeats >= 0.0 && repeats.fract() == 0.0 && repeats <= 1e9) {
            let (key, value) = ("repeats".to_owned(), repeats.to_string());
            return Err(StudyProblem::Value { key, value, need: "a whole number of repeats" });
        }
        let ambient = self.number("T_amb", false)?;
        if let Some(t) = ambient.filter(|t| !(SURROUNDINGS[0]..=SURROUNDINGS[1]).contains(t)) {
            let (key, value) = ("T_amb".to_owned(), format!("{t} K"));
            return Err(StudyProblem::Value {
                key,
                value,
                need: "an ambient temperature above 100 K and below 2000 K; say its unit in the heading, as in T_amb [degC]",
            });
        }
        let sd = self.number("T_amb_sd", true)?.unwrap_or(0.0);
        if !(0.0..=Day::LARGEST_SD).contains(&sd) {
            let need = "a standard deviation from 0 to 50 K";
            return Err(StudyProblem::Value { key: "T_amb_sd".into(), value: format!("{sd} K"), need });
        }
        Ok(Point {
            row: self.label("row")?.unwrap_or_default().to_owned(),
            installation: self.label("installation")?.unwrap_or(&id).to_owned(),
            day: self.label("day")?.unwrap_or_default().to_owned(),
            repeats: repeats as u32,
            ambient: ambient.map(|t| [t, sd]),
            factors: values,
            factor_sds,
            id,
        })
    }
}

/// What stands for the empty cell.
fn is_empty(text: &str) -> bool {
    text.is_empty() || text == "-"
}

/// A number with a unit of its own, in SI, which must be one of the column.
fn quantity(given: &Quantity, column: &Factor, difference: bool) -> Result<f64, StudyProblem> {
    let wrong = |source| StudyProblem::Unit { key: column.name.clone(), source };
    let shown = given.unit.of(column.shown.text()).map_err(wrong)?;
    let value = if difference { shown.difference_to_si(given.value) } else { shown.to_si(given.value) };
    Ok(if difference { column.shown.difference_to_si(value) } else { column.shown.to_si(value) })
}

impl std::fmt::Display for Cell {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Text(text) => write!(f, "{text}"),
            Self::Number(value) => write!(f, "{value}"),
            Self::Quantity(quantity) => write!(f, "{} {}", quantity.value, quantity.unit),
        }
    }
}

/// A unit in base units, as formulas read it: `kg m^2 s^-3`.
pub(crate) fn si_text(unit: &Unit) -> String {
    unit.in_base_units()
}
