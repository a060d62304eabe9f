//! Observations as CSV: plain numbers, one header line, units in the headings: `growth_rate [1/s]`.
//!
//! `points.csv` says what was measured; `pings.csv` and `clicks.csv` hold one row per operating point (the
//! mean over repeats), `ping-repeats.csv` and `click-repeats.csv` one row per record. Covariances are written
//! as the upper triangle, row by row: `cov_A_B` has the unit of A times the unit of B. Tables that were
//! prepared by hand may have a standard deviation `A_sd` for every number instead, and `points.csv` may lack
//! what counts records.

use super::channels::ChannelErrors;
use super::factors::headings;
use super::observation::{Click, Observations, Ping, PointObservations, Rejection};
use super::row::{CAMPAIGN, Row, by_name, first_line, read_csv_if_there};
use crate::apparatus::geometry::{Apparatus, Microphones};
use crate::apparatus::point::OperatingPoint;
use crate::error::RigError;
use crate::files::{make_folder, parse_toml, read_text, write_through, write_toml};
use crate::problem::Problem;
use crate::records::set::DataKind;
use rijke_numerics::Matrix;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// Written where the calibration of the channels is known; may be absent.
const CHANNELS: &str = "channels.toml";

/// Last column of `pings.csv`; tables that were prepared by hand may lack it.
const DRIFT: &str = "angular_frequency_drift_sd [rad/s]";

/// Opening words of a file of the apparatus.
pub(crate) const APPARATUS: &str = "# SI units; x = 0 is the lower (upstream) end of the duct.\n\n";

/// `observations.toml`.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Origin {
    kind: DataKind,
    source: String,
}

/// Columns of `points.csv` beside those of factors.
const POINTS: [&str; 8] =
    ["point", "row", "repeats", "day", "T_amb [K]", "T_amb_sd [K]", "ping_count", "click_count"];

impl Observations {
    /// Writes the folder; the file that makes it a set of observations, `observations.toml`, comes last.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), RigError> {
        make_folder(folder)?;
        write_toml(&self.rig, APPARATUS, &folder.join(Apparatus::FILE))?;
        let (factors, cells_of) = headings(self.points.iter().map(|p| &p.point));
        let points = self.points.iter().map(|p| [point_cells(p), cells_of(&p.point)].concat());
        let columns: Vec<String> = POINTS.map(String::from).into_iter().chain(factors).collect();
        write_csv(&folder.join("points.csv"), &columns, points)?;
        let microphones = &self.rig.microphones;
        let (pings, clicks) = (ping_columns(microphones), click_columns(microphones.positions.len()));
        let point = |p: &PointObservations| p.point.id.clone();
        let mean = |p: &PointObservations| {
            let values = [ping_values(p.ping.as_ref()?), vec![p.drift_sd]].concat();
            Some(cells(point(p), None, &values))
        };
        let columns = [header(&pings, false), vec![DRIFT.to_owned()]].concat();
        write_csv(&folder.join("pings.csv"), &columns, self.points.iter().filter_map(mean))?;
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
        let origin = Origin { kind: self.kind, source: self.source.clone() };
        write_toml(&origin, "", &folder.join("observations.toml"))
    }

    /// Reads a folder that [`Observations::write`] or a laboratory wrote. The files of single repeats and
    /// of rejections may be absent.
    ///
    /// # Errors
    /// The file, the row and column, and the remedy.
    pub fn read(folder: &Path) -> Result<Self, RigError> {
        let path = folder.join("observations.toml");
        let Origin { kind, source } = parse_toml(&read_text(&path)?, &path)?;
        let rig = Apparatus::read(&folder.join(Apparatus::FILE))?;
        let path = folder.join("points.csv");
        let mut points = Vec::new();
        let names = POINTS.map(String::from);
        let (factors, rows) = by_name(&path, &names)?;
        for row in rows {
            let point: PointObservations = row.point(&factors)?;
            if points.iter().any(|p: &PointObservations| p.point.id == point.point.id) {
                return Err(row.wrong(0, Problem::Duplicate { name: point.point.id }));
            }
            points.push(point);
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
        let columns = ping_columns(&rig.microphones);
        let path = folder.join("pings.csv");
        let mut meant = header_of(&path, &columns)?;
        let drift = meant.len();
        let drifts = path.exists() && first_line(&read_text(&path)?).contains(DRIFT);
        meant.extend(drifts.then(|| DRIFT.to_owned()));
        for row in read_csv_if_there(&path, &meant)? {
            let (values, covariance) = row.measured(1, columns.len(), 2)?;
            let point = &mut points[row.known(&index)?];
            if point.ping.is_some() {
                return Err(row.wrong(0, Problem::Duplicate { name: point.point.id.clone() }));
            }
            point.ping = Some(Ping::from_vector(&values, reference, covariance));
            point.drift_sd = if drifts { row.number(drift)? } else { 0.0 };
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
            let point = &mut points[row.known(&index)?];
            if point.click.replace(Click { arrival_times, covariance }).is_some() {
                return Err(row.wrong(0, Problem::Duplicate { name: point.point.id.clone() }));
            }
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
        let mut all = Self { rig, kind, source, points, rejections, channels };
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

/// A measured number: its name, and its SI unit, none of a ratio.
struct Number(String, &'static str);

impl Number {
    /// `growth_rate [1/s]`, with `end` behind the name.
    fn heading(&self, end: &str) -> String {
        with_unit(format!("{}{end}", self.0), self.1)
    }

    /// That of the covariance with another.
    fn covariance(&self, other: &Self) -> String {
        let unit = match (self.1, other.1) {
            ("1/s", "1/s") => "1/s^2",
            ("1/s", "rad/s") => "rad/s^2",
            ("rad/s", "rad/s") => "rad^2/s^2",
            ("s", "s") => "s^2",
            (unit, _) => unit,
        };
        with_unit(format!("cov_{}_{}", self.0, other.0), unit)
    }
}

fn with_unit(name: String, unit: &str) -> String {
    if unit.is_empty() { name } else { format!("{name} [{unit}]") }
}

/// The measured numbers of a ping: s, then the relative pressures but the reference's.
fn ping_columns(microphones: &Microphones) -> Vec<Number> {
    let mut all = vec![Number("growth_rate".into(), "1/s"), Number("angular_frequency".into(), "rad/s")];
    let others = microphones.called().into_iter().enumerate().filter(|(m, _)| *m != microphones.reference);
    for (_, name) in others {
        all.extend(["re", "im"].map(|part| Number(format!("{name}_{part}"), "")));
    }
    all
}

fn click_columns(microphones: usize) -> Vec<Number> {
    (1..=microphones).map(|m| Number(format!("arrival{m}"), "s")).collect()
}

/// `point[,repeat]`, the values, the covariance.
fn header(columns: &[Number], repeats: bool) -> Vec<String> {
    let mut names = vec!["point".to_owned()];
    if repeats {
        names.push("repeat".to_owned());
    }
    names.extend(columns.iter().map(|c| c.heading("")));
    for (i, a) in columns.iter().enumerate() {
        names.extend(columns[i..].iter().map(|b| a.covariance(b)));
    }
    names
}

/// The header of a table of means as it is meant: with covariances, or with standard deviations if it has the
/// first of them.
fn header_of(path: &Path, columns: &[Number]) -> Result<Vec<String>, RigError> {
    let text = if path.exists() { read_text(path)? } else { String::new() };
    let short = first_line(&text).contains(&columns[0].heading("_sd"));
    let values = columns.iter().map(|c| c.heading(""));
    let all = ["point".to_owned()].into_iter().chain(values).chain(columns.iter().map(|c| c.heading("_sd")));
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
        point.repeats.to_string(),
        day.id.clone(),
        day.ambient_temperature.to_string(),
        day.ambient_temperature_sd.to_string(),
        p.ping_count.to_string(),
        p.click_count.to_string(),
    ]
}

/// Writes the operating points of a set of records: the columns [`CAMPAIGN`], and factors.
pub(crate) fn write_points<'a>(
    points: impl Iterator<Item = &'a OperatingPoint> + Clone,
    path: &Path,
) -> Result<(), RigError> {
    let (factors, cells_of) = headings(points.clone());
    let columns: Vec<String> = CAMPAIGN.map(String::from).into_iter().chain(factors).collect();
    let own = |p: &OperatingPoint| vec![p.id.clone(), p.row.clone(), p.repeats.to_string()];
    write_csv(path, &columns, points.map(|p| [own(p), cells_of(p)].concat()))
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
