//! Observed modes: `modes.csv`, or `pings.csv` as signal processing writes it.

mod impossible;
mod stated;

use crate::rig::Rig;
use crate::source::{Source, listed};
use crate::{Campaign, StudyError, StudyProblem};
use rijke_numerics::{C64, Matrix};
use rijke_rig::{Heading, Unit};
use stated::{Errors, Number, covariance, number, pair, product};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// One mode at one operating point, as far as it was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservedMode {
    /// The operating point, by its place in the campaign.
    pub point: usize,
    /// A label, where a point has several modes.
    pub label: String,
    /// Growth rate, 1/s.
    pub growth_rate: Option<f64>,
    /// Angular frequency, rad/s.
    pub angular_frequency: Option<f64>,
    /// Pressures relative to the reference microphone, by the microphone's place in the rig.
    pub pressures: Vec<(usize, C64)>,
    /// Covariance of [`ObservedMode::numbers`].
    pub covariance: Matrix,
    /// Standard deviation of an error of the angular frequency that all modes of the table have in common,
    /// rad/s: what is not known of a drift during their decays. The covariance contains it.
    pub drift_sd: f64,
}

/// Everything that was observed.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservedModes {
    /// Measured or virtual.
    pub kind: rijke_rig::DataKind,
    /// Where the data come from.
    pub source: String,
    /// The modes, in the order of the file.
    pub modes: Vec<ObservedMode>,
    /// Ambient temperatures that were read with the records, and their standard deviations, K, by operating
    /// point. They count before those of the campaign.
    pub ambient: BTreeMap<usize, [f64; 2]>,
}

impl ObservedMode {
    /// The numbers measured: growth rate and angular frequency as far as they are there, then real and
    /// imaginary part of every pressure.
    #[must_use]
    pub fn numbers(&self) -> Vec<f64> {
        let pressures = self.pressures.iter().flat_map(|(_, p)| [p.re, p.im]);
        self.growth_rate.into_iter().chain(self.angular_frequency).chain(pressures).collect()
    }

    /// A complex frequency near which the mode may be sought; `growth_rate` where none was measured.
    #[must_use]
    pub fn near(&self, growth_rate: f64) -> Option<C64> {
        Some(C64::new(self.growth_rate.unwrap_or(growth_rate), self.angular_frequency?))
    }
}

/// What a column holds.
#[derive(Clone, Debug, PartialEq)]
enum Column {
    Point,
    Mode,
    /// A number, see [`Number`], with its unit.
    Value(Number, Unit),
    Sd(Number, Unit),
    /// Of two numbers, in the order of [`Number`], and what one of its unit is in SI.
    Covariance(Number, Number, f64),
    /// Of the frequency, what all modes have in common of it.
    Drift(Unit),
    Ignored,
}

impl Column {
    /// Whether two columns hold the same, in whatever units.
    fn is_of_the_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Value(a, _), Self::Value(b, _)) | (Self::Sd(a, _), Self::Sd(b, _)) => a == b,
            (Self::Drift(_), Self::Drift(_)) => true,
            (a, b) => a == b,
        }
    }
}

/// Columns that other tables have beside ours.
const IGNORED: [&str; 3] = ["repeat", "comment", "note"];

/// Whether a column, by its heading, holds what was measured of a mode, whatever the microphones are called.
pub(crate) fn is_of_modes(text: &str) -> bool {
    let name = text.split(['[', ' ']).next().unwrap_or_default();
    let word = name.strip_suffix("_sd").unwrap_or(name);
    let of_pressure = |word: &str| ["_re", "_im", "_abs", "_arg"].iter().any(|end| word.ends_with(end));
    // With what is written behind them: a misspelled one is told with the known ones, and is no factor.
    let known = ["growth_rate", "frequency", "angular_frequency"];
    word == "mode"
        || known.iter().any(|k| word.starts_with(k))
        || IGNORED.contains(&word)
        || of_pressure(word)
        || word.starts_with("cov_")
}

/// The modes of a table, each with its line.
///
/// # Errors
/// File, line and remedy.
pub(crate) fn parse(
    source: &Source,
    rig: &Rig,
    campaign: &Campaign,
) -> Result<Vec<(usize, ObservedMode)>, StudyError> {
    let mut reader = source.table();
    let wrong = |error: csv::Error| source.csv(&error);
    let header = reader.headers().map_err(wrong)?.clone();
    let top = source.header_line();
    let mut columns = Vec::new();
    for text in &header {
        columns.push(column(text, rig).map_err(|problem| source.at_line(top, problem))?);
    }
    for (k, a) in columns.iter().enumerate() {
        if *a != Column::Ignored && columns[..k].iter().any(|b| a.is_of_the_same(b)) {
            let problem = StudyProblem::Duplicate { what: "column", name: header[k].to_owned() };
            return Err(source.at_line(top, problem));
        }
    }
    if !columns.contains(&Column::Point) {
        let need = "say in a column `point` to which operating point a row belongs";
        return Err(source.at_line(top, StudyProblem::Missing { key: "point".into(), need }));
    }
    let named = named(&header, &mut columns, rig).map_err(|problem| source.at_line(top, problem))?;
    let mut modes: Vec<(usize, ObservedMode)> = Vec::new();
    for record in reader.records() {
        let record = record.map_err(wrong)?;
        let line = source.line_of(&record);
        let fail = |problem| source.at_line(line, problem);
        let mode = row(&record, &header, &columns, &named, campaign).map_err(fail)?;
        let numbers = [mode.growth_rate, mode.angular_frequency.map(hertz)];
        let problem = impossible::problem(numbers, &mode.pressures, rig);
        problem.map_or(Ok(()), |problem| Err(fail(problem)))?;
        if modes.iter().any(|(_, m)| m.point == mode.point && m.label == mode.label) {
            let id = campaign.points[mode.point].id.clone();
            if mode.label.is_empty() {
                let need = "the point has several rows: give each a label in the column `mode`; of repeats give one row with their mean and its standard deviation; delete a copy";
                return Err(fail(StudyProblem::Missing { key: format!("mode of {id}"), need }));
            }
            let name = format!("{id}, mode {}", mode.label);
            return Err(fail(StudyProblem::SecondRow { name }));
        }
        modes.push((line, mode));
    }
    let problem = impossible::silent(modes.iter().map(|(_, mode)| &mode.pressures[..]), rig);
    problem.map_or(Ok(()), |problem| Err(source.at_line(top, problem)))?;
    if modes.is_empty() {
        return Err(source.at_line(top, StudyProblem::Empty { what: "mode", need: "add a row" }));
    }
    side_by_side(&mut modes, |(_, mode)| mode);
    Ok(modes)
}

/// Puts the modes of one point side by side, in the order in which the points appear.
pub(crate) fn side_by_side<T>(modes: &mut [T], mode: impl Fn(&T) -> &ObservedMode) {
    let order: Vec<usize> = modes.iter().map(|m| mode(m).point).collect();
    modes.sort_by_key(|m| order.iter().position(|p| *p == mode(m).point));
}

fn column(text: &str, rig: &Rig) -> Result<Column, StudyProblem> {
    let heading =
        Heading::parse(text).map_err(|source| StudyProblem::Unit { key: text.to_owned(), source })?;
    let name = heading.name.as_str();
    match name {
        "point" => return Ok(Column::Point),
        "mode" => return Ok(Column::Mode),
        name if IGNORED.contains(&name) => return Ok(Column::Ignored),
        _ => {}
    }
    let unit = |number: Number, angular: bool| {
        let wanted = match number {
            Number::GrowthRate => "1/s",
            Number::Frequency => "rad/s",
            Number::Pressure(_, 3) => "rad",
            Number::Pressure(..) => "1",
        };
        let given = heading.unit.clone().or_else(|| {
            // A frequency without unit is in Hz, as its name says.
            (number == Number::Frequency && !angular).then(|| Unit::parse("Hz").ok()).flatten()
        });
        let unit = match given {
            Some(unit) => unit.of(wanted),
            None => Unit::parse(wanted).and_then(|u| u.of(wanted)),
        };
        unit.map_err(|source| StudyProblem::Unit { key: text.to_owned(), source })
    };
    if let Some([a, b]) = name.strip_prefix("cov_").and_then(|rest| pair(rest, rig)) {
        return Ok(Column::Covariance(a.0.min(b.0), a.0.max(b.0), 1.0));
    }
    if let Some(word) = name.strip_suffix("_drift_sd")
        && number(word, rig) == Some(Number::Frequency)
    {
        return Ok(Column::Drift(unit(Number::Frequency, word.starts_with("angular"))?));
    }
    let (word, is_sd) = name.strip_suffix("_sd").map_or((name, false), |word| (word, true));
    let Some(number) = number(word, rig) else {
        let microphones = rig.microphones.names.iter().map(|m| format!("{m}_re, {m}_im"));
        let all: Vec<String> = ["point", "mode", "growth_rate", "frequency", "angular_frequency"]
            .map(str::to_owned)
            .into_iter()
            .chain(microphones)
            .collect();
        let known = format!("{}; each with _sd, or cov_A_B", listed(all.iter().map(String::as_str)));
        return Err(StudyProblem::Unknown { what: "column", name: name.to_owned(), known });
    };
    let unit = unit(number, word.starts_with("angular"))?;
    Ok(if is_sd { Column::Sd(number, unit) } else { Column::Value(number, unit) })
}

/// What the numbers of the table are called. Gives every covariance its unit: the one of its heading, or that
/// of the columns that it names.
fn named(
    header: &csv::StringRecord,
    columns: &mut [Column],
    rig: &Rig,
) -> Result<BTreeMap<Number, String>, StudyProblem> {
    let (mut named, mut units) = (BTreeMap::new(), BTreeMap::new());
    for (text, column) in header.iter().zip(&*columns) {
        if let (Column::Value(number, unit), Ok(heading)) = (column, Heading::parse(text)) {
            named.insert(*number, heading.name);
            units.insert(*number, unit.difference_to_si(1.0));
        }
    }
    for (text, column) in header.iter().zip(columns) {
        let (Column::Covariance(a, b, scale), Ok(heading)) = (column, Heading::parse(text)) else { continue };
        let rest = heading.name.strip_prefix("cov_").and_then(|rest| pair(rest, rig));
        for (number, word) in rest.into_iter().flatten() {
            if named.get(&number).is_none_or(|name| name != word) {
                let known = listed(named.values().map(String::as_str));
                return Err(StudyProblem::Covaries { column: text.to_owned(), name: word.to_owned(), known });
            }
        }
        let wrong = |source| StudyProblem::Unit { key: text.to_owned(), source };
        *scale = match &heading.unit {
            Some(unit) => unit.of(&product(*a, *b)).map_err(wrong)?.difference_to_si(1.0),
            None => [a, b].iter().filter_map(|number| units.get(*number)).product(),
        };
    }
    Ok(named)
}

fn row(
    record: &csv::StringRecord,
    header: &csv::StringRecord,
    columns: &[Column],
    named: &BTreeMap<Number, String>,
    campaign: &Campaign,
) -> Result<ObservedMode, StudyProblem> {
    let (mut point, mut label) = (None, String::new());
    let mut values: BTreeMap<Number, f64> = BTreeMap::new();
    let mut errors = Errors::default();
    let mut drift = None;
    for ((cell, column), name) in record.iter().zip(columns).zip(header) {
        let float = || match cell {
            "" | "nan" | "NaN" | "-" => Ok(None),
            text => match text.parse::<f64>() {
                Ok(v) if v.is_finite() => Ok(Some(v)),
                _ => Err(StudyProblem::Value {
                    key: name.to_owned(),
                    value: text.to_owned(),
                    need: "a finite number with a decimal point, or empty",
                }),
            },
        };
        match column {
            Column::Point => {
                point = Some(campaign.known_point(cell)?);
            }
            Column::Mode => label = cell.to_owned(),
            Column::Value(number, unit) => {
                if let Some(v) = float()? {
                    values.insert(*number, unit.to_si(v));
                }
            }
            Column::Sd(number, unit) => {
                if let Some(v) = float()? {
                    if v < 0.0 {
                        let (key, value) = (name.to_owned(), v.to_string());
                        return Err(StudyProblem::Value { key, value, need: "zero or more" });
                    }
                    errors.sds.insert(*number, (name.to_owned(), unit.difference_to_si(v)));
                }
            }
            Column::Covariance(a, b, scale) => {
                if let Some(v) = float()? {
                    errors.covariances.push((*a, *b, name.to_owned(), v * scale));
                }
            }
            Column::Drift(unit) => {
                drift = float()?.map(|v| (name, v, unit.difference_to_si(v)));
            }
            Column::Ignored => {}
        }
    }
    let Some(point) = point else {
        return Err(StudyProblem::Missing { key: "point".into(), need: "an operating point" });
    };
    let mut mode = assemble(point, label, &values, &errors, named, &campaign.points[point].id)?;
    let Some((name, given, sd)) = drift else { return Ok(mode) };
    let own = usize::from(mode.growth_rate.is_some());
    let variance = if mode.angular_frequency.is_some() { mode.covariance[(own, own)] } else { 0.0 };
    if sd < 0.0 || sd * sd > variance * (1.0 - 1e-9) {
        let (key, value) = (name.to_owned(), given.to_string());
        let need = "zero or more, and less than the standard deviation of the frequency, which contains it";
        return Err(StudyProblem::Value { key, value, need });
    }
    mode.drift_sd = sd;
    Ok(mode)
}

/// No argument of a pressure is larger, rad, but for rounding.
const TURN: f64 = std::f64::consts::TAU * 1.001;

fn assemble(
    point: usize,
    label: String,
    values: &BTreeMap<Number, f64>,
    errors: &Errors,
    named: &BTreeMap<Number, String>,
    id: &str,
) -> Result<ObservedMode, StudyProblem> {
    let get = |n: Number| values.get(&n).copied();
    let microphones: std::collections::BTreeSet<usize> =
        values.keys().filter_map(|n| if let Number::Pressure(m, _) = n { Some(*m) } else { None }).collect();
    let mut numbers = Vec::new();
    numbers.extend([Number::GrowthRate, Number::Frequency].into_iter().filter(|n| values.contains_key(n)));
    let mut pressures = Vec::new();
    // Columns of the Jacobian from what the table has to real and imaginary parts.
    let mut polar = false;
    for &m in &microphones {
        let part = |k: usize| get(Number::Pressure(m, k));
        let key = |k: usize| {
            let column = named.get(&Number::Pressure(m, k)).map_or("", |name| name);
            format!("{column} of {id}")
        };
        let p = match (part(0), part(1), part(2), part(3)) {
            (Some(re), Some(im), None, None) => C64::new(re, im),
            (None, None, Some(modulus), Some(argument)) => {
                if argument.abs() > TURN {
                    let need = "within a turn, from -2 pi to 2 pi rad: write [deg] in the heading if it is in degrees";
                    return Err(StudyProblem::Value {
                        key: key(3),
                        value: format!("{argument:.4} rad"),
                        need,
                    });
                }
                if modulus < 0.0 {
                    let need = "zero or more: a reversed microphone has its phase turned by half a turn, and a level in dB is 10^(dB/20)";
                    return Err(StudyProblem::Value { key: key(2), value: modulus.to_string(), need });
                }
                polar = true;
                C64::from_polar(modulus, argument)
            }
            _ => {
                let need = "real and imaginary part, or modulus and argument, of every pressure";
                return Err(StudyProblem::Missing { key: format!("pressures of {id}"), need });
            }
        };
        let first = if part(2).is_some() { 2 } else { 0 };
        numbers.extend([Number::Pressure(m, first), Number::Pressure(m, first + 1)]);
        pressures.push((m, p));
    }
    let n = numbers.len();
    if n == 0 {
        return Err(StudyProblem::Empty {
            what: "number in this row",
            need: "give a growth rate, a frequency or pressures",
        });
    }
    let covariance = covariance(&numbers, &pressures, polar, errors, named, id)?;
    Ok(ObservedMode {
        point,
        label,
        growth_rate: get(Number::GrowthRate),
        angular_frequency: get(Number::Frequency),
        pressures,
        covariance,
        drift_sd: 0.0,
    })
}

/// A frequency for people.
#[must_use]
pub fn hertz(angular_frequency: f64) -> f64 {
    angular_frequency / (2.0 * PI)
}
