//! Pressures at several microphones, of sources of unknown strength: a table with a row for every frequency
//! and excitation.

use super::doubts::{self, Angle, Rows};
use crate::source::listed;
use crate::{StudyError, StudyProblem};
use rijke_numerics::C64;
use rijke_rig::{Columns, Heading, RigError};
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

/// What the microphones heard of one excitation, each row over its root mean square.
pub(super) struct Heard {
    pub(super) excitation: String,
    /// Rows in the file, within the band or not.
    pub(super) of: usize,
    pub(super) frequency_hz: Vec<f64>,
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
    let fail = |source| StudyProblem::Unit { key: text.to_owned(), source };
    let (factor, stated) = match Heading::parse(text).map_err(fail)?.unit {
        Some(unit) => (unit.of(wanted).map_err(fail)?.to_si(1.0), Some(wanted)),
        None if needed => {
            let need = "write it in brackets behind the name: f [Hz], p1_arg [deg]";
            return Err(StudyProblem::Missing { key: format!("unit of `{text}`"), need });
        }
        None => (1.0, None),
    };
    Ok(Column { name, factor, stated })
}

/// Reads a file: the excitations in the order of the file, and what is doubtful. Rows outside of the band are
/// passed over.
pub(super) fn read(
    path: &Path,
    table: &Table,
    band: [f64; 2],
) -> Result<(Vec<Heard>, Vec<String>), StudyError> {
    let fail = |line: Option<usize>, problem: StudyProblem| StudyError {
        file: path.display().to_string(),
        line,
        problem: Box::new(problem),
    };
    let told = |error: RigError| fail(None, StudyProblem::Csv(error.to_string()));
    let file = Columns::read(path).map_err(told)?;
    let agrees = |column: &Column| {
        let (Some(wanted), Some(unit)) = (column.stated, file.unit(&column.name).map_err(told)?) else {
            return Ok(());
        };
        let factor = unit
            .of(wanted)
            .map_err(|source| fail(None, StudyProblem::Unit { key: column.name.clone(), source }))?
            .to_si(1.0);
        if (factor / column.factor - 1.0).abs() > 1e-9 {
            let (key, value) = (format!("heading `{}`", column.name), unit.text().to_owned());
            return Err(fail(
                None,
                StudyProblem::Value {
                    key,
                    value,
                    need: "the unit that `columns` of the study states for it",
                },
            ));
        }
        Ok(())
    };
    let number = |column: &Column| {
        agrees(column)?;
        let cells = file.complex(&column.name).map_err(told)?;
        if let Some(k) = cells.iter().position(|z| z.im != 0.0) {
            let problem =
                StudyProblem::Value { key: column.name.clone(), value: cells[k].to_string(), need: "real" };
            return Err(fail(Some(file.line(k)), problem));
        }
        Ok(cells.iter().map(|z| z.re * column.factor).collect::<Vec<f64>>())
    };
    let frequency_hz = number(&table.frequency)?;
    let of: Vec<String> = match &table.excitation {
        None => vec![String::new(); frequency_hz.len()],
        Some(name) => match file.complex(name) {
            Ok(cells) => cells.iter().map(|z| z.re.to_string()).collect(),
            Err(_) => file.words(name).map_err(told)?.into_iter().map(str::to_owned).collect(),
        },
    };
    let mut phases = None;
    let mut pressures: Vec<Vec<C64>> = Vec::new();
    let mut sds: Vec<Vec<f64>> = Vec::new();
    for (_, pressure, sd) in &table.microphones {
        if let Some(column) = sd {
            let cells = number(column)?;
            if let Some(k) = cells.iter().position(|sd| !(sd.is_finite() && *sd > 0.0)) {
                let (key, value) = (column.name.clone(), cells[k].to_string());
                return Err(fail(Some(file.line(k)), StudyProblem::Value { key, value, need: "above zero" }));
            }
            sds.push(cells);
        }
        pressures.push(match pressure {
            Pressure::Complex(whole) => {
                agrees(whole)?;
                let cells = file.complex(&whole.name).map_err(told)?;
                cells.iter().map(|z| z * whole.factor).collect()
            }
            Pressure::Parts([re, im]) => {
                number(re)?.into_iter().zip(number(im)?).map(|(re, im)| C64::new(re, im)).collect()
            }
            Pressure::Polar([modulus, angle]) => {
                phases = Some(Angle::of(angle.factor)).filter(|unit| *unit == Angle::Radians).or(phases);
                let (r, a) = (number(modulus)?, number(angle)?);
                if let Some(k) = r.iter().position(|r| *r < 0.0) {
                    let (key, value) = (modulus.name.clone(), r[k].to_string());
                    return Err(fail(
                        Some(file.line(k)),
                        StudyProblem::Value { key, value, need: "zero or more" },
                    ));
                }
                r.into_iter().zip(a).map(|(r, a)| C64::from_polar(r, a)).collect()
            }
        });
    }
    let mut names: Vec<&String> = Vec::new();
    for name in &of {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let (mut all, mut doubtful) = (Vec::new(), None);
    for name in names {
        let rows: Vec<usize> = (0..of.len()).filter(|k| of[*k] == *name).collect();
        let [low, high] = band;
        let keep: Vec<usize> =
            rows.iter().copied().filter(|k| (low..=high).contains(&frequency_hz[*k])).collect();
        let level = |k: usize| {
            let square: f64 = pressures.iter().map(|p| p[k].norm_sqr()).sum();
            (square / pressures.len() as f64).sqrt()
        };
        if let Some(k) = keep.iter().find(|k| level(**k) == 0.0) {
            let need = "of some microphone other than zero";
            let problem = StudyProblem::Value { key: "pressure".into(), value: "0".into(), need };
            return Err(fail(Some(file.line(*k)), problem));
        }
        let of_microphone = |p: &Vec<C64>| -> Vec<C64> { keep.iter().map(|&k| p[k] / level(k)).collect() };
        let heard: Vec<Vec<C64>> = pressures.iter().map(of_microphone).collect();
        // The sources are unknown: what varies smoothly with frequency is the pressure over that of another
        // microphone.
        let relative = |p: &Vec<C64>| Rows {
            frequency_hz: keep.iter().map(|&k| frequency_hz[k]).collect(),
            values: p.iter().zip(&heard[0]).map(|(a, b)| a / b).collect(),
            sd: Vec::new(),
            lines: keep.iter().map(|&k| file.line(k)).collect(),
            phases,
        };
        doubts::refuse(&relative(&heard[0])).map_err(|(line, problem)| fail(Some(line), problem))?;
        doubtful = doubtful.or_else(|| heard[1..].iter().find_map(|p| doubts::phase(&relative(p))));
        let spread = |m: usize| -> Vec<f64> {
            sds.get(m).map_or_else(Vec::new, |sd| keep.iter().map(|&k| sd[k] / level(k)).collect())
        };
        let microphones = table.microphones.iter().map(|(microphone, ..)| *microphone);
        all.push(Heard {
            excitation: name.clone(),
            of: rows.len(),
            frequency_hz: keep.iter().map(|&k| frequency_hz[k]).collect(),
            pressures: microphones
                .zip(heard)
                .enumerate()
                .map(|(m, (name, p))| (name, p, spread(m)))
                .collect(),
        });
    }
    all.retain(|heard| !heard.frequency_hz.is_empty());
    Ok((all, doubtful.into_iter().collect()))
}
