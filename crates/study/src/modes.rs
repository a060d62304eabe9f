//! Observed modes: `modes.csv`, or `pings.csv` as signal processing writes it.

use crate::rig::Rig;
use crate::source::{Source, listed};
use crate::{Campaign, StudyError, StudyProblem};
use rijke_numerics::{C64, Cholesky, Matrix};
use rijke_rig::{Heading, Unit};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::Path;

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
    Covariance(Number, Number),
    Ignored,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Number {
    GrowthRate,
    Frequency,
    /// Microphone, and 0 real, 1 imaginary part, 2 modulus, 3 argument.
    Pressure(usize, usize),
}

/// Columns that other tables have beside ours.
const IGNORED: [&str; 3] = ["repeat", "comment", "note"];

/// Reads the modes of a table.
///
/// # Errors
/// File, line and remedy.
pub fn read_modes(path: &Path, rig: &Rig, campaign: &Campaign) -> Result<Vec<ObservedMode>, StudyError> {
    parse(&Source::read_table(path)?, rig, campaign)
}

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

pub(crate) fn parse(
    source: &Source,
    rig: &Rig,
    campaign: &Campaign,
) -> Result<Vec<ObservedMode>, StudyError> {
    let mut reader = source.table();
    let wrong = |error: csv::Error| source.csv(&error);
    let header = reader.headers().map_err(wrong)?.clone();
    let top = source.header_line();
    let mut columns = Vec::new();
    for text in &header {
        columns.push(column(text, rig).map_err(|problem| source.at_line(top, problem))?);
    }
    for (k, a) in columns.iter().enumerate() {
        if *a != Column::Ignored && columns[..k].contains(a) {
            let problem = StudyProblem::Duplicate { what: "column", name: header[k].to_owned() };
            return Err(source.at_line(top, problem));
        }
    }
    if !columns.contains(&Column::Point) {
        let need = "say in a column `point` to which operating point a row belongs";
        return Err(source.at_line(top, StudyProblem::Missing { key: "point".into(), need }));
    }
    let mut modes: Vec<ObservedMode> = Vec::new();
    for record in reader.records() {
        let record = record.map_err(wrong)?;
        let line = source.line_of(&record);
        let fail = |problem| source.at_line(line, problem);
        let mode = row(&record, &header, &columns, campaign).map_err(fail)?;
        let [low, high] = rig.search[1];
        if let Some(f) = mode.angular_frequency.map(hertz).filter(|f| !(low..=high).contains(f))
            && rig.search_is_stated
        {
            let (key, value) = ("frequency".to_owned(), format!("{f:.2} Hz"));
            return Err(fail(StudyProblem::Value {
                key,
                value,
                need: "within frequency_hz of [search] in the rig's file; correct the \
             number or its unit, or widen the search",
            }));
        }
        if modes.iter().any(|m| m.point == mode.point && m.label == mode.label) {
            let id = campaign.points[mode.point].id.clone();
            let name = if mode.label.is_empty() { id } else { format!("{id}, mode {}", mode.label) };
            return Err(fail(StudyProblem::Duplicate { what: "row (operating point and mode)", name }));
        }
        modes.push(mode);
    }
    if modes.is_empty() {
        return Err(source.at_line(top, StudyProblem::Empty { what: "mode", need: "add a row" }));
    }
    Ok(modes)
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
    if let Some((a, b)) = name.strip_prefix("cov_").and_then(|rest| pair(rest, rig)) {
        return Ok(Column::Covariance(a, b));
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

fn number(word: &str, rig: &Rig) -> Option<Number> {
    match word {
        "growth_rate" => return Some(Number::GrowthRate),
        "frequency" | "angular_frequency" => return Some(Number::Frequency),
        _ => {}
    }
    let (microphone, part) = word.rsplit_once('_')?;
    let part = ["re", "im", "abs", "arg"].iter().position(|p| *p == part)?;
    let microphone = rig.microphones.names.iter().position(|n| n == microphone)?;
    Some(Number::Pressure(microphone, part))
}

/// `A_B`, where both are names of numbers.
fn pair(text: &str, rig: &Rig) -> Option<(Number, Number)> {
    text.match_indices('_').find_map(|(k, _)| Some((number(&text[..k], rig)?, number(&text[k + 1..], rig)?)))
}

fn row(
    record: &csv::StringRecord,
    header: &csv::StringRecord,
    columns: &[Column],
    campaign: &Campaign,
) -> Result<ObservedMode, StudyProblem> {
    let (mut point, mut label) = (None, String::new());
    let mut values: BTreeMap<Number, f64> = BTreeMap::new();
    let mut sds: BTreeMap<Number, f64> = BTreeMap::new();
    let mut covariances: Vec<(Number, Number, f64)> = Vec::new();
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
                let found = campaign.point(cell).map(|(k, _)| k);
                point = Some(found.ok_or_else(|| StudyProblem::Unknown {
                    what: "operating point",
                    name: cell.to_owned(),
                    known: listed(campaign.points.iter().take(8).map(|p| p.id.as_str())) + ", ...",
                })?);
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
                    sds.insert(*number, unit.difference_to_si(v));
                }
            }
            Column::Covariance(a, b) => {
                if let Some(v) = float()? {
                    covariances.push((*a, *b, v));
                }
            }
            Column::Ignored => {}
        }
    }
    let Some(point) = point else {
        return Err(StudyProblem::Missing { key: "point".into(), need: "an operating point" });
    };
    assemble(point, label, &values, &sds, &covariances, &campaign.points[point].id)
}

fn assemble(
    point: usize,
    label: String,
    values: &BTreeMap<Number, f64>,
    sds: &BTreeMap<Number, f64>,
    covariances: &[(Number, Number, f64)],
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
        let p = match (part(0), part(1), part(2), part(3)) {
            (Some(re), Some(im), None, None) => C64::new(re, im),
            (None, None, Some(modulus), Some(argument)) => {
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
    let mut covariance = Matrix::zeros(n, n);
    if covariances.is_empty() {
        for (i, number) in numbers.iter().enumerate() {
            let sd = sds.get(number).copied().ok_or_else(|| StudyProblem::Missing {
                key: "sd".into(),
                need: "every number needs a standard deviation X_sd, or covariances cov_A_B",
            })?;
            covariance[(i, i)] = sd * sd;
        }
    } else {
        let place = |n: &Number| numbers.iter().position(|m| m == n);
        for (a, b, value) in covariances {
            if let (Some(i), Some(j)) = (place(a), place(b)) {
                covariance[(i, j)] = *value;
                covariance[(j, i)] = *value;
            }
        }
    }
    if polar {
        // dp = e^{i a} (dr + i r da), to first order.
        let jacobian = Matrix::from_fn(n, n, |i, j| match (numbers[i], numbers[j]) {
            (Number::Pressure(a, k), Number::Pressure(b, l)) if a == b && k > 1 && l > 1 => {
                let p = pressures.iter().find(|(m, _)| *m == a).map_or(C64::ONE, |p| p.1);
                let unit = p / p.norm();
                let column = if l == 2 { unit } else { C64::I * p };
                if k == 2 { column.re } else { column.im }
            }
            _ => f64::from(u8::from(i == j)),
        });
        covariance = jacobian.product(&covariance).product(&jacobian.transpose());
    }
    // Units far apart make a covariance look singular that is not.
    let size: Vec<f64> = (0..n).map(|i| covariance[(i, i)].sqrt()).collect();
    let scaled = Matrix::from_fn(n, n, |i, j| covariance[(i, j)] / (size[i] * size[j]));
    if size.iter().any(|s| !(*s > 0.0 && s.is_finite())) || Cholesky::new(&scaled).is_err() {
        return Err(StudyProblem::Covariance { of: id.to_owned() });
    }
    Ok(ObservedMode {
        point,
        label,
        growth_rate: get(Number::GrowthRate),
        angular_frequency: get(Number::Frequency),
        pressures,
        covariance,
    })
}

/// A frequency for people.
#[must_use]
pub fn hertz(angular_frequency: f64) -> f64 {
    angular_frequency / (2.0 * PI)
}
