//! Pressures at several microphones, of sources of unknown strength: a table with a row for every frequency
//! and excitation.

use super::columns::{unit_of, without_path};
use super::doubts::{self, Angle, Rows};
use crate::source::listed;
use crate::{StudyError, StudyProblem};
use rijke_numerics::C64;
use rijke_rig::{Columns, RigError};
use std::path::Path;
use toml::Value as Toml;

/// Which column of a file is what.
pub(super) struct Table {
    frequency: Column,
    excitation: Option<String>,
    /// Microphone, its columns, and that of its standard deviation; of all microphones or of none.
    microphones: Vec<(usize, Pressure, Option<Column>)>,
}

/// A column, the factor to its SI unit, and that unit if the study states one.
struct Column {
    name: String,
    factor: f64,
    stated: Option<&'static str>,
}

enum Pressure {
    Complex(Column),
    Parts([Column; 2]),
    Polar([Column; 2]),
}

impl Pressure {
    /// The unit of its phase, where that is in radians.
    fn radians(&self) -> Option<Angle> {
        let Self::Polar([_, angle]) = self else { return None };
        Some(Angle::of(angle.factor)).filter(|unit| *unit == Angle::Radians)
    }
}

/// What the microphones heard of one excitation, each row over its root mean square.
pub(super) struct Heard {
    pub(super) excitation: String,
    /// Rows in the file, within the band or not.
    pub(super) of: usize,
    pub(super) frequency_hz: Vec<f64>,
    /// Root mean square of each row, in the unit of the file.
    pub(super) level: Vec<f64>,
    /// Microphone, its pressures, and the standard deviation of both parts of each; empty if none was
    /// measured.
    pub(super) pressures: Vec<(usize, Vec<C64>, Vec<f64>)>,
}

/// Reads the key `columns`: headings, and their names in the file. `names` are the microphones of the rig;
/// `sources` how many waves are unknown.
pub(super) fn declared(value: &Toml, names: &[String], sources: usize) -> Result<Table, StudyProblem> {
    let need = "a table as { \"f [Hz]\" = \"frequency\", excitation = \"case\", p1 = \"Mic1\", ... } with p1, or p1_re and p1_im, or \
                p1_abs and p1_arg [deg], of more microphones than waves are unknown; p1_sd of all of them or of none";
    let wrong = || StudyProblem::Value { key: "columns".into(), value: value.to_string(), need };
    let table = value.as_table().ok_or_else(wrong)?;
    let (mut frequency, mut excitation) = (None, None);
    // By microphone: the whole, its parts re, im, abs, arg, and its standard deviation.
    let mut found: Vec<[Option<Column>; 6]> = names.iter().map(|_| Default::default()).collect();
    for (text, name) in table {
        let name = name.as_str().ok_or_else(wrong)?.to_owned();
        let bare = text.split('[').next().unwrap_or(text).trim();
        if bare == "excitation" {
            excitation = Some(name);
            continue;
        }
        if bare == "f" {
            frequency = Some(column(text, name, "Hz", true)?);
            continue;
        }
        let part = |(k, end): (usize, &str)| {
            let microphone = names.iter().position(|n| bare.strip_suffix(end) == Some(n))?;
            Some((microphone, k))
        };
        let known = ["", "_re", "_im", "_abs", "_arg", "_sd"].into_iter().enumerate().find_map(part);
        let (microphone, k) = known.ok_or_else(|| StudyProblem::Unknown {
            what: "column of pressures",
            name: text.clone(),
            known: listed(["f", "excitation"].into_iter().chain(names.iter().map(String::as_str))),
        })?;
        let unit = if k == 4 { "rad" } else { "Pa" };
        found[microphone][k] = Some(column(text, name, unit, k == 4)?);
    }
    let mut microphones = Vec::new();
    for (microphone, cells) in found.into_iter().enumerate() {
        let [whole, re, im, modulus, angle, sd] = cells;
        let pressure = match (whole, re, im, modulus, angle) {
            (None, None, None, None, None) if sd.is_none() => continue,
            (Some(whole), None, None, None, None) => Pressure::Complex(whole),
            (None, Some(re), Some(im), None, None) => Pressure::Parts([re, im]),
            (None, None, None, Some(r), Some(a)) => Pressure::Polar([r, a]),
            _ => return Err(wrong()),
        };
        microphones.push((microphone, pressure, sd));
    }
    let with_sd = microphones.iter().filter(|(_, _, sd)| sd.is_some()).count();
    if with_sd != 0 && with_sd != microphones.len() {
        return Err(wrong());
    }
    match frequency {
        Some(frequency) if microphones.len() > sources => Ok(Table { frequency, excitation, microphones }),
        _ => Err(wrong()),
    }
}

fn column(text: &str, name: String, wanted: &'static str, needed: bool) -> Result<Column, StudyProblem> {
    let need = needed.then_some("write it in brackets behind the name: f [Hz], p1_arg [deg]");
    let unit = unit_of(text, wanted, need)?;
    let factor = unit.as_ref().map_or(1.0, |unit| unit.to_si(1.0));
    Ok(Column { name, factor, stated: unit.map(|_| wanted) })
}

/// Reads a file: the excitations in the order of the file, and what is doubtful, also of frequencies far from
/// those in which modes are sought, if the study says these. Rows outside of the band are passed over.
pub(super) fn read(
    path: &Path,
    table: &Table,
    band: [f64; 2],
    search: Option<[f64; 2]>,
) -> Result<(Vec<Heard>, Vec<String>), StudyError> {
    let file = Sheet::of(path)?;
    let frequency_hz = file.numbers(&table.frequency)?;
    let excitations: Vec<String> = match &table.excitation {
        None => vec![String::new(); frequency_hz.len()],
        Some(name) => file.words(name)?,
    };
    let pressures = table.microphones.iter().map(|(_, p, _)| file.pressures(p));
    let sds = table.microphones.iter().filter_map(|(.., sd)| sd.as_ref()).map(|sd| file.deviations(sd));
    let columns = Read {
        frequency_hz,
        pressures: pressures.collect::<Result<_, _>>()?,
        sds: sds.collect::<Result<_, _>>()?,
        phases: table.microphones.iter().find_map(|(_, p, _)| p.radians()),
    };
    let mut names: Vec<&String> = Vec::new();
    for name in &excitations {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let (mut all, mut doubtful) = (Vec::new(), None);
    for name in names {
        let rows: Vec<usize> = (0..excitations.len()).filter(|k| excitations[*k] == *name).collect();
        let (of, [low, high]) = (rows.len(), band);
        let keep: Vec<usize> =
            rows.into_iter().filter(|k| (low..=high).contains(&columns.frequency_hz[*k])).collect();
        let (heard, doubt) = file.excitation(&columns, table, &keep)?;
        doubtful = doubtful.or(doubt);
        all.push(Heard { excitation: name.clone(), of, ..heard });
    }
    all.retain(|heard| !heard.frequency_hz.is_empty());
    let far = search.and_then(|search| doubts::far(&columns.frequency_hz, search));
    Ok((all, doubtful.into_iter().chain(far).collect()))
}

/// The columns of a file in SI units.
struct Read {
    frequency_hz: Vec<f64>,
    /// Of each microphone.
    pressures: Vec<Vec<C64>>,
    /// Of each microphone; empty if none are given.
    sds: Vec<Vec<f64>>,
    phases: Option<Angle>,
}

/// A file of pressures.
struct Sheet<'a> {
    path: &'a Path,
    columns: Columns,
}

impl<'a> Sheet<'a> {
    fn of(path: &'a Path) -> Result<Self, StudyError> {
        let columns = Columns::read(path).map_err(|error| unreadable(path, &error))?;
        Ok(Self { path, columns })
    }

    fn fail(&self, row: Option<usize>, problem: StudyProblem) -> StudyError {
        fault(self.path, row.map(|k| self.columns.line(k)), problem)
    }

    fn told<T>(&self, outcome: Result<T, RigError>) -> Result<T, StudyError> {
        outcome.map_err(|error| unreadable(self.path, &error))
    }

    /// Refuses a heading whose unit is not the one that the study states.
    fn agrees(&self, column: &Column) -> Result<(), StudyError> {
        let (Some(wanted), Some(unit)) = (column.stated, self.told(self.columns.unit(&column.name))?) else {
            return Ok(());
        };
        let of = unit
            .of(wanted)
            .map_err(|source| self.fail(None, StudyProblem::Unit { key: column.name.clone(), source }))?;
        if (of.to_si(1.0) / column.factor - 1.0).abs() > 1e-9 {
            let (key, value) = (format!("heading `{}`", column.name), unit.text().to_owned());
            let need = "the unit that `columns` of the study states for it";
            return Err(self.fail(None, StudyProblem::Value { key, value, need }));
        }
        Ok(())
    }

    fn numbers(&self, column: &Column) -> Result<Vec<f64>, StudyError> {
        self.agrees(column)?;
        let cells = self.told(self.columns.complex(&column.name))?;
        if let Some(k) = cells.iter().position(|z| z.im != 0.0) {
            let (key, value) = (column.name.clone(), cells[k].to_string());
            return Err(self.fail(Some(k), StudyProblem::Value { key, value, need: "real" }));
        }
        Ok(cells.iter().map(|z| z.re * column.factor).collect())
    }

    /// Names of excitations, which may be numbers.
    fn words(&self, name: &str) -> Result<Vec<String>, StudyError> {
        if let Ok(cells) = self.columns.complex(name) {
            return Ok(cells.iter().map(|z| z.re.to_string()).collect());
        }
        Ok(self.told(self.columns.words(name))?.into_iter().map(str::to_owned).collect())
    }

    /// Numbers of which `holds`, else what they need to be.
    fn all(
        &self,
        column: &Column,
        holds: impl Fn(f64) -> bool,
        need: &'static str,
    ) -> Result<Vec<f64>, StudyError> {
        let cells = self.numbers(column)?;
        if let Some(k) = cells.iter().position(|v| !holds(*v)) {
            let (key, value) = (column.name.clone(), cells[k].to_string());
            return Err(self.fail(Some(k), StudyProblem::Value { key, value, need }));
        }
        Ok(cells)
    }

    fn deviations(&self, column: &Column) -> Result<Vec<f64>, StudyError> {
        self.all(column, |sd| sd.is_finite() && sd > 0.0, "above zero")
    }

    fn pressures(&self, pressure: &Pressure) -> Result<Vec<C64>, StudyError> {
        Ok(match pressure {
            Pressure::Complex(whole) => {
                self.agrees(whole)?;
                self.told(self.columns.complex(&whole.name))?.iter().map(|z| z * whole.factor).collect()
            }
            Pressure::Parts([re, im]) => {
                let (re, im) = (self.numbers(re)?, self.numbers(im)?);
                re.into_iter().zip(im).map(|(re, im)| C64::new(re, im)).collect()
            }
            Pressure::Polar([modulus, angle]) => {
                let moduli = self.all(modulus, |r| r >= 0.0 || r.is_nan(), "zero or more")?;
                let angles = self.numbers(angle)?;
                moduli.into_iter().zip(angles).map(|(r, a)| C64::from_polar(r, a)).collect()
            }
        })
    }

    /// The rows `keep` of one excitation, and what is doubtful of their phases.
    fn excitation(
        &self,
        read: &Read,
        table: &Table,
        keep: &[usize],
    ) -> Result<(Heard, Option<String>), StudyError> {
        let level = |k: usize| {
            let square: f64 = read.pressures.iter().map(|p| p[k].norm_sqr()).sum();
            (square / read.pressures.len() as f64).sqrt()
        };
        if let Some(k) = keep.iter().find(|k| level(**k) == 0.0) {
            let need = "of some microphone other than zero";
            let problem = StudyProblem::Value { key: "pressure".into(), value: "0".into(), need };
            return Err(self.fail(Some(*k), problem));
        }
        let of_microphone = |p: &Vec<C64>| -> Vec<C64> { keep.iter().map(|&k| p[k] / level(k)).collect() };
        let heard: Vec<Vec<C64>> = read.pressures.iter().map(of_microphone).collect();
        let frequency_hz: Vec<f64> = keep.iter().map(|&k| read.frequency_hz[k]).collect();
        // The sources are unknown: what varies smoothly with frequency is the pressure over that of another
        // microphone.
        let relative = |p: &Vec<C64>| Rows {
            frequency_hz: frequency_hz.clone(),
            values: p.iter().zip(&heard[0]).map(|(a, b)| a / b).collect(),
            sd: Vec::new(),
            lines: keep.iter().map(|&k| self.columns.line(k)).collect(),
            phases: read.phases,
        };
        doubts::refuse(&relative(&heard[0]))
            .map_err(|(line, problem)| fault(self.path, Some(line), problem))?;
        let doubt = heard[1..].iter().find_map(|p| doubts::phase(&relative(p)));
        let spread = |m: usize| -> Vec<f64> {
            read.sds.get(m).map_or_else(Vec::new, |sd| keep.iter().map(|&k| sd[k] / level(k)).collect())
        };
        let named = table.microphones.iter().map(|(microphone, ..)| *microphone).zip(heard).enumerate();
        let pressures = named.map(|(m, (microphone, p))| (microphone, p, spread(m))).collect();
        let level = keep.iter().map(|&k| level(k)).collect();
        Ok((Heard { excitation: String::new(), of: 0, frequency_hz, level, pressures }, doubt))
    }
}

fn fault(path: &Path, line: Option<usize>, problem: StudyProblem) -> StudyError {
    StudyError { file: path.display().to_string(), line, problem: Box::new(problem) }
}

fn unreadable(path: &Path, error: &RigError) -> StudyError {
    fault(path, None, StudyProblem::Csv(without_path(error, path)))
}
