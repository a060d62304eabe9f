//! Ramps: runs of the rig in which the power changes, and pings are taken before the flow has settled.

use super::point::TubePoint;
use rijke_numerics::csv_without_empty_ends;
use rijke_rig::files::{read_text, write_through};
use rijke_rig::{Problem, RigError};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// One run of the rig, from the settled state without power: the log of its power, and which operating points
/// were measured when.
#[derive(Clone, Debug, PartialEq)]
pub struct Ramp {
    /// Its name.
    pub id: String,
    /// The log, in the order of time.
    pub log: Vec<Logged>,
}

/// One row of the log.
#[derive(Clone, Debug, PartialEq)]
pub struct Logged {
    /// Time on the clock of the run, s.
    pub time: f64,
    /// Electrical power from this time until the next row, W. Before the first row there was none.
    pub power: f64,
    /// The operating point whose records were taken at this time, if any.
    pub point: Option<String>,
}

/// A row of the file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    ramp: String,
    #[serde(rename = "time [s]")]
    time: f64,
    #[serde(rename = "power [W]")]
    power: f64,
    point: Option<String>,
}

/// Longest run, s: more than four days. The flow is followed through all of it.
const LONGEST: f64 = 4e5;

/// Difference of two powers that a table in print may have, relative.
const ROUNDED: f64 = 1e-3;

impl Ramp {
    /// Name of the file, beside `points.csv` or `campaign.toml`.
    pub const FILE: &'static str = "ramps.csv";

    /// When the records of the operating point `id` were taken, s; none if it is no point of this run.
    #[must_use]
    pub fn time_of(&self, id: &str) -> Option<f64> {
        self.log.iter().find(|row| row.point.as_deref() == Some(id)).map(|row| row.time)
    }

    /// Reads the runs of the file [`Ramp::FILE`] in `folder`; there are none without it.
    ///
    /// # Errors
    /// As [`Ramp::read`].
    pub fn read_within<'a>(
        folder: &Path,
        points: impl Iterator<Item = &'a TubePoint>,
    ) -> Result<Vec<Self>, RigError> {
        let path = folder.join(Self::FILE);
        if path.exists() { Self::read(&path, &points.collect::<Vec<_>>()) } else { Ok(Vec::new()) }
    }

    /// Reads the runs of a file (CSV: `ramp`, `time [s]`, `power [W]`, `point`), whose points are among
    /// `points`. The rows of one run are in the order of time.
    ///
    /// # Errors
    /// The file, the line and the remedy.
    pub fn read(path: &Path, points: &[&TubePoint]) -> Result<Vec<Self>, RigError> {
        let text = read_text(path)?;
        let wrong = |line: u64, message: String| RigError::Syntax {
            path: path.to_owned(),
            line: line as usize,
            column: 1,
            message,
        };
        let text =
            csv_without_empty_ends(&text).map_err(|behind| wrong(behind.line as u64, behind.to_string()))?;
        let syntax = |e: csv::Error| wrong(e.position().map_or(1, csv::Position::line), e.to_string());
        let mut reader =
            csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(text.as_bytes());
        let header = reader.headers().map_err(syntax)?.clone();
        let (mut ramps, mut first): (Vec<Self>, Vec<Option<&TubePoint>>) = (Vec::new(), Vec::new());
        for record in reader.records() {
            let record = record.map_err(syntax)?;
            let line = record.position().map_or(1, csv::Position::line);
            let row: Row = record.deserialize(Some(&header)).map_err(syntax)?;
            let known = ramps.iter().position(|ramp| ramp.id == row.ramp).unwrap_or_else(|| {
                ramps.push(Self { id: row.ramp.clone(), log: Vec::new() });
                first.push(None);
                ramps.len() - 1
            });
            let taken = |id: &str| ramps.iter().any(|ramp| ramp.time_of(id).is_some());
            if let Some(id) = &row.point {
                let point = points.iter().find(|p| p.id == *id).copied();
                let first = &mut first[known];
                let problem = match (point, *first) {
                    (None, _) => Some(format!(
                        "no operating point is called `{id}`; list it beside the others, or correct the name"
                    )),
                    _ if taken(id) => {
                        Some(format!("`{id}` was measured before; give every time a point of its own"))
                    }
                    (Some(p), first) => unlike(p, first, row.power),
                };
                if let Some(problem) = problem {
                    return Err(wrong(line, problem));
                }
                *first = first.or(point);
            }
            let ramp = &mut ramps[known];
            let Row { time, power, point, .. } = row;
            if !(time.is_finite() && (0.0..=1e6).contains(&power)) {
                let message =
                    format!("{time} s, {power} W: give a finite time in s and a power from 0 to 1e6 W");
                return Err(wrong(line, message));
            }
            if let Some(before) = ramp.log.last().filter(|before| before.time >= time) {
                let message = format!(
                    "{time} s follows {} s in ramp `{}`; put its rows in the order of time, each time once",
                    before.time, ramp.id
                );
                return Err(wrong(line, message));
            }
            if let Some(begin) = ramp.log.first().filter(|first| time - first.time > LONGEST) {
                let message = format!(
                    "{time:e} s is {:.3e} s after the first row of ramp `{}`, and a run lasts no longer than {LONGEST:.0e} s: check the unit of the times",
                    time - begin.time,
                    ramp.id
                );
                return Err(wrong(line, message));
            }
            ramp.log.push(Logged { time, power, point });
        }
        if let Some(k) = first.iter().position(Option::is_none) {
            let need = "one row with a `point` that was measured in it";
            return Err(RigError::invalid(path, format!("ramp `{}`", ramps[k].id), Problem::Empty { need }));
        }
        Ok(ramps)
    }

    /// Writes the file [`Ramp::FILE`] in `folder`, if records were taken in a run.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write_within(list: &[Self], folder: &Path) -> Result<(), RigError> {
        let measured: Vec<&Self> = list.iter().filter(|ramp| ramp.is_measured()).collect();
        if measured.is_empty() {
            return Ok(());
        }
        let row = |ramp: &Self, row: &Logged| Row {
            ramp: ramp.id.clone(),
            time: row.time,
            power: row.power,
            point: row.point.clone(),
        };
        write_through(&folder.join(Self::FILE), |file| {
            let mut writer = csv::Writer::from_writer(file);
            let mut rows =
                measured.iter().flat_map(|ramp| ramp.log.iter().map(move |logged| row(ramp, logged)));
            rows.try_for_each(|row| writer.serialize(row))?;
            writer.flush()
        })
    }

    /// Whether records were taken in it.
    #[must_use]
    pub fn is_measured(&self) -> bool {
        self.log.iter().any(|row| row.point.is_some())
    }

    /// The runs with those of their points for which `there` holds.
    #[must_use]
    pub fn restricted(list: &[Self], there: &dyn Fn(&str) -> bool) -> Vec<Self> {
        let mut list = list.to_vec();
        for row in list.iter_mut().flat_map(|ramp| &mut ramp.log) {
            row.point = row.point.take().filter(|id| there(id));
        }
        list
    }
}

/// Why `point` cannot have been measured at `power` in the run in which `first` was.
fn unlike(point: &TubePoint, first: Option<&TubePoint>, power: f64) -> Option<String> {
    let id = &point.id;
    if !point.plates || point.position.is_none() {
        return Some(format!(
            "`{id}` has no plates to heat; take it out of the ramp, or give it plates and a position"
        ));
    }
    if (point.power - power).abs() > ROUNDED * power.abs() {
        let own = point.power;
        return Some(format!(
            "`{id}` is a point at {own} W, but the power is {power} W; correct one of the two"
        ));
    }
    let first = first.filter(|f| (f.position, f.thermometers) != (point.position, point.thermometers))?;
    Some(format!(
        "`{id}` has the plates or the thermometers elsewhere than `{}`; a ramp is one run of one assembly, so give them ramps of their own",
        first.id
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::apparatus::campaign::TubeCampaign;

    fn read(text: &str, name: &str) -> Result<Vec<Ramp>, String> {
        let campaign = TubeCampaign::juniper_yoko_2022();
        let folder = std::env::temp_dir().join(format!("rijke-ramps-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join(Ramp::FILE), text).unwrap();
        let read = || Ramp::read_within(&folder, campaign.points.iter());
        let found = read();
        if let Ok(ramps) = &found {
            Ramp::write_within(ramps, &folder).unwrap();
            assert_eq!(*ramps, read().unwrap());
        }
        std::fs::remove_dir_all(&folder).unwrap();
        found.map_err(|e| e.to_string().replace(&format!("{}/", folder.display()), ""))
    }

    const HEAD: &str = "ramp,time [s],power [W],point\na,0,7,\na,900,7,H7-25\n";

    #[test]
    fn exact_runs_are_read_as_logged_and_survive_the_disk() {
        let ramps =
            read(&format!("# up\n{HEAD}b,5,30,H30-40\na,901,30,\na,1800.5,30,H30-25\n"), "good").unwrap();
        assert_eq!(
            ramps.iter().map(|r| (r.id.as_str(), r.log.len())).collect::<Vec<_>>(),
            [("a", 4), ("b", 1)]
        );
        assert_eq!((ramps[0].time_of("H30-25"), ramps[0].time_of("H30-40")), (Some(1800.5), None));
        let some = Ramp::restricted(&ramps, &|id| id == "H7-25");
        assert_eq!((some[0].log.len(), some[0].time_of("H30-25"), some[1].is_measured()), (4, None, false));
    }

    #[test]
    fn message_of_wrong_runs_names_line_and_remedy() {
        for (name, rows, words) in [
            ("order", "a,900,30,\n", "ramps.csv:4:1: 900 s follows 900 s in ramp `a`; put its rows"),
            ("unknown", "a,950,30,H30\n", "ramps.csv:4:1: no operating point is called `H30`; list it"),
            ("twice", "a,950,7,H7-25\n", "`H7-25` was measured before; give every time"),
            ("power", "a,950,15,H30-25\n", "`H30-25` is a point at 30 W, but the power is 15 W; correct"),
            ("place", "a,950,30,H30-40\n", "elsewhere than `H7-25`; a ramp is one run"),
            ("plates", "a,950,0,C2-25\n", "`C2-25`"),
            ("watts", "a,950,-3,\n", "950 s, -3 W: give a finite time"),
            ("late", "a,1e95,30,\n", "ramps.csv:4:1: 1e95 s is 1.000e95 s after the first row of ramp `a`"),
            ("days", "a,400001,30,\n", "a run lasts no longer than 4e5 s: check the unit"),
            ("number", "a,noon,30,\n", "ramps.csv:4:1: "),
            ("empty", "b,950,30,\n", "ramps.csv: ramp `b`: is empty; give at least one row with a `point`"),
        ] {
            let said = read(&format!("{HEAD}{rows}"), name).unwrap_err();
            assert!(said.contains(words), "{name}: {said}");
        }
        let said = read("ramp,time,power [W],point\na,0,7,H7-25\n", "header").unwrap_err();
        assert!(said.contains("time [s]"), "{said}");
    }
}
