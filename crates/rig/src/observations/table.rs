//! Observations as CSV: plain numbers, one header line, units in the names of the columns.
//!
//! `points.csv` says what was measured; `pings.csv` and `clicks.csv` hold one row per operating point (the mean over
//! repeats), `ping-repeats.csv` and `click-repeats.csv` one row per record. Covariances are written as the upper
//! triangle, row by row: `cov_A_B` has the unit of A times the unit of B. Tables that were prepared by hand may have a standard
//! deviation `sd_A` for every number instead, and `points.csv` may lack what counts records.

use super::channels::{ChannelErrors, scaled};
use super::observation::{Click, Observations, Ping, PointObservations, Rejection};
use crate::apparatus::geometry::Rig;
use crate::apparatus::point::OperatingPoint;
use crate::apparatus::ramp::Ramp;
use crate::error::RigError;
use crate::files::{make_folder, parse_toml, read_text, write_through, write_toml};
use crate::problem::Problem;
use crate::records::set::{DataKind, Day};
use rijke_numerics::{Cholesky, Matrix};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// Columns of `points.csv` that may be missing from one prepared by hand, and what then holds.
const MAY_BE_MISSING: [(&str, &str); 4] =
    [("repeats", "1"), ("day", "day"), ("ping_count", "1"), ("click_count", "0")];

/// Written where the calibration of the channels is known; may be absent.
const CHANNELS: &str = "channels.toml";

/// `observations.toml`.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Origin {
    kind: DataKind,
    source: String,
}

const POINTS: [&str; 12] = [
    "point",
    "row",
    "position_m",
    "plates",
    "thermometers",
    "power_W",
    "repeats",
    "day",
    "ambient_temperature_K",
    "ambient_temperature_sd_K",
    "ping_count",
    "click_count",
];

impl Observations {
    /// Writes the folder; the file that makes it a set of observations, `observations.toml`, comes last.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), RigError> {
        make_folder(folder)?;
        write_toml(&self.rig, "# SI units; x = 0 is the bottom of the tube.\n\n", &folder.join("rig.toml"))?;
        let points = self.points.iter().map(point_cells);
        write_csv(&folder.join("points.csv"), &POINTS.map(String::from), points)?;
        let (microphones, reference) = (self.rig.microphones.positions.len(), self.rig.microphones.reference);
        let (pings, clicks) = (ping_columns(microphones, reference), click_columns(microphones));
        let point = |p: &PointObservations| p.point.id.clone();
        let means =
            self.points.iter().filter_map(|p| Some(cells(point(p), None, &ping_values(p.ping.as_ref()?))));
        write_csv(&folder.join("pings.csv"), &header(&pings, false), means)?;
        let all = self.points.iter().flat_map(|p| {
            p.pings.iter().map(move |(repeat, ping)| cells(point(p), Some(*repeat), &ping_values(ping)))
        });
        write_csv(&folder.join("ping-repeats.csv"), &header(&pings, true), all)?;
        let means =
            self.points.iter().filter_map(|p| Some(cells(point(p), None, &click_values(p.click.as_ref()?))));
        write_csv(&folder.join("clicks.csv"), &header(&clicks, false), means)?;
        let all = self.points.iter().flat_map(|p| {
            p.clicks.iter().map(move |(repeat, click)| cells(point(p), Some(*repeat), &click_values(click)))
        });
        write_csv(&folder.join("click-repeats.csv"), &header(&clicks, true), all)?;
        Rejection::write_all(&self.rejections, &folder.join("rejections.csv"))?;
        if let Some(channels) = &self.channels {
            channels.write(&folder.join(CHANNELS))?;
        }
        Ramp::write_within(&self.ramps, folder)?;
        let origin = Origin { kind: self.kind, source: self.source.clone() };
        write_toml(&origin, "", &folder.join("observations.toml"))
    }

    /// Reads a folder that [`Observations::write`] or a laboratory wrote. The files of single repeats, of
    /// rejections and of ramps may be absent.
    ///
    /// # Errors
    /// The file, the row and column, and the remedy.
    pub fn read(folder: &Path) -> Result<Self, RigError> {
        let path = folder.join("observations.toml");
        let Origin { kind, source } = parse_toml(&read_text(&path)?, &path)?;
        let rig = Rig::read(&folder.join("rig.toml"))?;
        let path = folder.join("points.csv");
        let mut points = Vec::new();
        let names = POINTS.map(String::from);
        for row in by_name(&path, &names)? {
            points.push(row.point()?);
        }
        if points.is_empty() {
            return Err(RigError::invalid(&path, "rows", Problem::Empty { need: "one operating point" }));
        }
        let index: BTreeMap<String, usize> = points
            .iter()
            .enumerate()
            .map(|(k, p): (usize, &PointObservations)| (p.point.id.clone(), k))
            .collect();
        let (microphones, reference) = (rig.microphones.positions.len(), rig.microphones.reference);
        let channels = ChannelErrors::read(&folder.join(CHANNELS), microphones.saturating_sub(1))?;
        let columns = ping_columns(microphones, reference);
        let path = folder.join("pings.csv");
        for row in read_csv(&path, &header_of(&path, &columns)?)? {
            let (values, covariance) = row.measured(1, columns.len(), 2)?;
            points[row.known(&index)?].ping = Some(Ping::from_vector(&values, reference, covariance));
        }
        for row in read_csv_if_there(&folder.join("ping-repeats.csv"), &header(&columns, true))? {
            let (values, covariance) = row.measured(2, columns.len(), 2)?;
            let ping = Ping::from_vector(&values, reference, covariance);
            points[row.known(&index)?].pings.push((row.whole(1)?, ping));
        }
        let columns = click_columns(microphones);
        let path = folder.join("clicks.csv");
        for row in read_csv_if_there(&path, &header_of(&path, &columns)?)? {
            let (arrival_times, covariance) = row.measured(1, columns.len(), 0)?;
            points[row.known(&index)?].click = Some(Click { arrival_times, covariance });
        }
        for row in read_csv_if_there(&folder.join("click-repeats.csv"), &header(&columns, true))? {
            let (arrival_times, covariance) = row.measured(2, columns.len(), 0)?;
            points[row.known(&index)?].clicks.push((row.whole(1)?, Click { arrival_times, covariance }));
        }
        let (path, columns) = (folder.join("rejections.csv"), ["record", "reason"].map(String::from));
        let rejected = read_csv_if_there(&path, &columns)?;
        let rejection =
            |row: &Row<'_>| Rejection { record: row.cells[0].clone(), reason: row.cells[1].clone() };
        let rejections = rejected.iter().map(rejection).collect();
        let ramps = Ramp::read_within(folder, points.iter().map(|p| &p.point))?;
        let mut all = Self { rig, kind, source, points, rejections, channels, ramps };
        all.leave_out_the_dead();
        Ok(all)
    }
}

impl Rejection {
    /// Writes records with what was said of them as a table (CSV).
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write_all(list: &[Self], path: &Path) -> Result<(), RigError> {
        let rows = list.iter().map(|r| vec![r.record.clone(), r.reason.clone()]);
        write_csv(path, &["record", "reason"].map(String::from), rows)
    }
}

/// Names of the measured numbers of a ping: s, then the relative pressures but the reference's.
fn ping_columns(microphones: usize, reference: usize) -> Vec<String> {
    let mut names = vec!["growth_rate_per_s".to_owned(), "angular_frequency_rad_per_s".to_owned()];
    for m in (0..microphones).filter(|m| *m != reference) {
        names.extend([format!("p{}_re", m + 1), format!("p{}_im", m + 1)]);
    }
    names
}

fn click_columns(microphones: usize) -> Vec<String> {
    (1..=microphones).map(|m| format!("arrival{m}_s")).collect()
}

/// `point[,repeat]`, the values, the covariance.
fn header(columns: &[String], repeats: bool) -> Vec<String> {
    let mut names = vec!["point".to_owned()];
    if repeats {
        names.push("repeat".to_owned());
    }
    names.extend(columns.iter().cloned());
    for (i, a) in columns.iter().enumerate() {
        names.extend(columns[i..].iter().map(|b| format!("cov_{a}_{b}")));
    }
    names
}

/// The header of a table of means as it is meant: with covariances, or with standard deviations if it has the first of them.
fn header_of(path: &Path, columns: &[String]) -> Result<Vec<String>, RigError> {
    let sd = |name: &String| format!("sd_{name}");
    let text = if path.exists() { read_text(path)? } else { String::new() };
    let short = text.lines().next().is_some_and(|line| line.contains(&sd(&columns[0])));
    let all = ["point".to_owned()].into_iter().chain(columns.iter().cloned()).chain(columns.iter().map(sd));
    Ok(if short { all.collect() } else { header(columns, false) })
}

fn ping_values(ping: &Ping) -> Vec<f64> {
    ping.vector().into_iter().chain(upper(&ping.covariance)).collect()
}

fn click_values(click: &Click) -> Vec<f64> {
    click.arrival_times.iter().copied().chain(upper(&click.covariance)).collect()
}

/// Upper triangle, row by row.
fn upper(covariance: &Matrix) -> Vec<f64> {
    (0..covariance.rows()).flat_map(|i| covariance.row(i)[i..].to_vec()).collect()
}

fn cells(point: String, repeat: Option<u32>, values: &[f64]) -> Vec<String> {
    let head = [Some(point), repeat.map(|r| r.to_string())];
    let cell = |v: &f64| if v.is_nan() { String::new() } else { format!("{v:e}") };
    head.into_iter().flatten().chain(values.iter().map(cell)).collect()
}

fn point_cells(p: &PointObservations) -> Vec<String> {
    let (point, day) = (&p.point, &p.ambient);
    vec![
        point.id.clone(),
        point.row.clone(),
        point.position.map_or(String::new(), |x| x.to_string()),
        u8::from(point.plates).to_string(),
        u8::from(point.thermometers).to_string(),
        point.power.to_string(),
        point.repeats.to_string(),
        day.id.clone(),
        day.ambient_temperature.to_string(),
        day.ambient_temperature_sd.to_string(),
        p.ping_count.to_string(),
        p.click_count.to_string(),
    ]
}

/// Writes rows as they come: those of a campaign's repeats need not fit into memory as text.
fn write_csv(
    path: &Path,
    header: &[String],
    rows: impl IntoIterator<Item = Vec<String>>,
) -> Result<(), RigError> {
    write_through(path, |file| {
        let mut writer = csv::Writer::from_writer(file);
        writer.write_record(header)?;
        rows.into_iter().try_for_each(|row| writer.write_record(row))?;
        writer.flush()
    })
}

/// One row of a CSV file that knows where it stands.
struct Row<'a> {
    path: &'a Path,
    header: &'a [String],
    line: u64,
    cells: Vec<String>,
}

fn read_csv_if_there<'a>(path: &'a Path, header: &'a [String]) -> Result<Vec<Row<'a>>, RigError> {
    if path.exists() { read_csv(path, header) } else { Ok(Vec::new()) }
}

/// All rows of a CSV file whose header is exactly `header`.
fn read_csv<'a>(path: &'a Path, header: &'a [String]) -> Result<Vec<Row<'a>>, RigError> {
    let text = read_text(path)?;
    let syntax = |error: csv::Error| RigError::Syntax {
        path: path.to_owned(),
        line: error.position().map_or(1, |p| p.line() as usize),
        column: 1,
        message: error.to_string(),
    };
    // A spreadsheet may put a byte-order mark in front and blanks around cells.
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_reader(text.strip_prefix('\u{feff}').unwrap_or(&text).as_bytes());
    let found: Vec<String> = reader.headers().map_err(syntax)?.iter().map(String::from).collect();
    for (k, need) in header.iter().enumerate() {
        let have = found.get(k).cloned().unwrap_or_default();
        if have != *need {
            let problem = Problem::BadHeader { column: k + 1, have, need: need.clone() };
            return Err(RigError::invalid(path, "line 1", problem));
        }
    }
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(syntax)?;
        let line = record.position().map_or(0, csv::Position::line);
        rows.push(Row { path, header, line, cells: record.iter().map(String::from).collect() });
    }
    Ok(rows)
}

/// All rows of a CSV file whose columns may stand in any order, without those that may be missing.
fn by_name<'a>(path: &'a Path, names: &'a [String]) -> Result<Vec<Row<'a>>, RigError> {
    let text = read_text(path)?;
    let first = text.strip_prefix('\u{feff}').unwrap_or(&text).lines().next().unwrap_or("");
    let found: Vec<String> = first.split(',').map(|cell| cell.trim().to_owned()).collect();
    let default = |name: &str| MAY_BE_MISSING.iter().find(|(n, _)| *n == name).map(|(_, value)| *value);
    let mut rows = read_csv(path, &[])?;
    let missing = |(_, name): &(usize, &String)| !found.contains(name) && default(name).is_none();
    if let Some((k, need)) = names.iter().enumerate().find(missing) {
        let have = found.get(k).cloned().unwrap_or_default();
        let problem = Problem::BadHeader { column: k + 1, have, need: need.clone() };
        return Err(RigError::invalid(path, "line 1", problem));
    }
    for row in &mut rows {
        let cell = |name: &String| {
            let place = found.iter().position(|n| n == name).and_then(|k| row.cells.get(k).cloned());
            place.unwrap_or_else(|| default(name).unwrap_or_default().to_owned())
        };
        row.cells = names.iter().map(cell).collect();
        row.header = names;
    }
    Ok(rows)
}

impl Row<'_> {
    fn wrong(&self, column: usize, problem: Problem) -> RigError {
        let name = self.header.get(column).map_or("", String::as_str);
        RigError::invalid(self.path, format!("line {}, column `{name}`", self.line), problem)
    }

    fn bad(&self, column: usize, expected: &'static str) -> RigError {
        self.wrong(column, Problem::BadCell { text: self.cells[column].clone(), expected })
    }

    fn number(&self, column: usize) -> Result<f64, RigError> {
        let value = self.cells[column].parse::<f64>().ok().filter(|v| v.is_finite());
        value.ok_or_else(|| self.bad(column, "a finite number"))
    }

    fn whole(&self, column: usize) -> Result<u32, RigError> {
        self.cells[column].parse().map_err(|_| self.bad(column, "a whole number"))
    }

    fn flag(&self, column: usize) -> Result<bool, RigError> {
        match self.cells[column].to_ascii_lowercase().as_str() {
            "0" | "false" => Ok(false),
            "1" | "true" => Ok(true),
            _ => Err(self.bad(column, "0 or 1")),
        }
    }

    /// Index of the operating point this row speaks of.
    fn known(&self, index: &BTreeMap<String, usize>) -> Result<usize, RigError> {
        let (name, known) = (self.cells[0].clone(), || index.keys().cloned().collect());
        index.get(&name).copied().ok_or_else(|| self.wrong(0, Problem::UnknownName { name, known: known() }))
    }

    /// `count` values from column `first` on, and their covariance. Of a dead microphone, from number `may_lack` on, cells are empty.
    fn measured(&self, first: usize, count: usize, may_lack: usize) -> Result<(Vec<f64>, Matrix), RigError> {
        let lacks = |i: usize| i >= may_lack && self.cells[first + i].is_empty();
        let value = |i: usize| if lacks(i) { Ok(f64::NAN) } else { self.number(first + i) };
        let values = (0..count).map(value).collect::<Result<Vec<_>, _>>()?;
        let there: Vec<usize> = (0..count).filter(|i| !lacks(*i)).collect();
        let (mut covariance, mut column) = (Matrix::zeros(count, count), first + count);
        if self.header.get(first + count).is_some_and(|name| name.starts_with("sd_")) {
            for &i in &there {
                let sd = self.number(first + count + i)?;
                if sd <= 0.0 {
                    return Err(self.bad(first + count + i, "a positive standard deviation"));
                }
                covariance[(i, i)] = sd * sd;
            }
            return Ok((values, covariance));
        }
        for i in 0..count {
            for j in i..count {
                let value = if lacks(i) || lacks(j) { f64::NAN } else { self.number(column)? };
                (covariance[(i, j)], covariance[(j, i)]) = (value, value);
                column += 1;
            }
        }
        match Cholesky::new(&scaled(&covariance.select(&there))) {
            Ok(_) => Ok((values, covariance)),
            Err(_) => Err(self.wrong(first + count, Problem::NotPositiveDefinite)),
        }
    }

    fn point(&self) -> Result<PointObservations, RigError> {
        let position = if self.cells[2].is_empty() { None } else { Some(self.number(2)?) };
        let point = OperatingPoint {
            id: self.cells[0].clone(),
            row: self.cells[1].clone(),
            position,
            plates: self.flag(3)?,
            thermometers: self.flag(4)?,
            power: self.number(5)?,
            repeats: self.whole(6)?,
        };
        let ambient = Day {
            id: self.cells[7].clone(),
            ambient_temperature: self.number(8)?,
            ambient_temperature_sd: self.number(9).and_then(|sd| {
                if (0.0..=50.0).contains(&sd) { Ok(sd) } else { Err(self.bad(9, "from 0 to 50 K")) }
            })?,
        };
        Ok(PointObservations {
            point,
            ambient,
            ping: None,
            ping_count: self.whole(10)?,
            click: None,
            click_count: self.whole(11)?,
            pings: Vec::new(),
            clicks: Vec::new(),
        })
    }
}
