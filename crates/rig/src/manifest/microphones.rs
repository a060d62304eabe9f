//! What is stated of the microphones: sensitivities, gains and delays with their errors, in the manifest or
//! in a table.

use super::keys::{Each, MicrophoneKeys};
use crate::error::RigError;
use crate::files::in_range;
use crate::formats::columns::Columns;
use crate::problem::Problem;
use crate::records::acquisition::StatedChannels;
use crate::units::{Given, Quantity};
use std::path::Path;

/// What is stated of the channels, for each microphone.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Channels {
    /// V/Pa; empty if not stated.
    pub(crate) sensitivities: Vec<f64>,
    pub(crate) stated: Option<StatedChannels>,
}

/// Names of the keys and of the columns, and what their numbers are.
const KEYS: [(&str, &str); 6] = [
    ("sensitivity", "V/Pa"),
    ("sensitivity_sd", "V/Pa"),
    ("gain", "1"),
    ("gain_sd", "1"),
    ("delay", "s"),
    ("delay_sd", "s"),
];

impl Channels {
    /// Reads `[microphones]` and the table that it names, which may lack the rows of `dead` microphones.
    ///
    /// # Errors
    /// A unit, a number or a list that cannot be; gains or delays without their errors.
    pub(crate) fn read(
        keys: &MicrophoneKeys,
        count: usize,
        dead: &[usize],
        manifest: &Path,
    ) -> Result<Self, RigError> {
        let given =
            [&keys.sensitivity, &keys.sensitivity_sd, &keys.gain, &keys.gain_sd, &keys.delay, &keys.delay_sd];
        let mut values: [Option<Vec<Given>>; 6] = Default::default();
        let mut listed = None;
        for ((slot, each), (key, _)) in values.iter_mut().zip(given).zip(KEYS) {
            let wrong = |problem| RigError::invalid(manifest, format!("microphones.{key}"), problem);
            *slot = each.as_ref().map(|each| spread(each, count)).transpose().map_err(wrong)?;
        }
        if let Some(table) = &keys.table {
            let path = manifest.with_file_name(table);
            let columns = Columns::read(&path)?;
            let order = order(&columns, count, dead)?;
            for (slot, (key, _)) in values.iter_mut().zip(KEYS).filter(|(_, (key, _))| columns.has(key)) {
                if slot.is_some() {
                    let what = "stands in the manifest and in the table; keep one of the two";
                    return Err(RigError::invalid(
                        manifest,
                        format!("microphones.{key}"),
                        Problem::Keys { what },
                    ));
                }
                let (unit, numbers) = columns.as_written(key)?;
                let stated = |row: &usize| match &unit {
                    Some(unit) => Given::Stated(Quantity { value: numbers[*row], unit: unit.clone() }),
                    None => Given::Si(numbers[*row]),
                };
                *slot = Some(order.iter().map(stated).collect());
            }
            listed = Some((columns, order));
        }
        Self::of(&values).map_err(|((key, m), problem)| match &listed {
            Some((columns, order)) if columns.has(key) => columns.wrong(order[m], key, problem),
            _ => RigError::invalid(manifest, format!("microphones.{key}"), problem),
        })
    }

    fn of(values: &[Option<Vec<Given>>; 6]) -> Result<Self, Wrong> {
        let si = |k: usize| -> Result<Option<Vec<f64>>, Wrong> {
            let (key, unit) = KEYS[k];
            let one = |(m, given): (usize, &Given)| {
                given.of(unit).map_err(|error| ((key, m), Problem::Unit(error)))
            };
            values[k].as_ref().map(|all| all.iter().enumerate().map(one).collect()).transpose()
        };
        let sensitivities = si(0)?.unwrap_or_default();
        for (m, sensitivity) in sensitivities.iter().enumerate() {
            within(("sensitivity", m), *sensitivity, 1e-9, 1e3, "V/Pa")?;
        }
        // An error of a sensitivity is one of the gain; it may be stated in per cent.
        let of_sensitivity = match (&values[1], sensitivities.as_slice()) {
            (None, _) => None,
            (Some(_), []) => {
                let what = "is given without `sensitivity`; give both, or `gain_sd`";
                return Err((("sensitivity_sd", 0), Problem::Keys { what }));
            }
            (Some(sds), all) => {
                let relative = |(m, (given, s)): (usize, (&Given, &f64))| {
                    let absolute = || given.of("V/Pa").map(|sd| sd / s);
                    let share = |q: &Quantity| q.of("1");
                    let found = match given {
                        Given::Stated(quantity) => share(quantity).or_else(|_| absolute()),
                        Given::Si(_) => absolute(),
                    };
                    found.map_err(|error| (("sensitivity_sd", m), Problem::Unit(error)))
                };
                Some(sds.iter().zip(all).enumerate().map(relative).collect::<Result<Vec<f64>, _>>()?)
            }
        };
        let (gains, gain_sds, delays, delay_sds) = (si(2)?, si(3)?, si(4)?, si(5)?);
        let spoken = gains.is_some() || gain_sds.is_some() || delays.is_some() || delay_sds.is_some();
        let error_key = if gain_sds.is_none() { "sensitivity_sd" } else { "gain_sd" };
        let gain_sds = match (gain_sds, of_sensitivity) {
            (Some(a), Some(b)) => Some(a.iter().zip(b).map(|(a, b)| a.hypot(b)).collect()),
            (a, b) => a.or(b),
        };
        let (Some(gain_sds), Some(delay_sds)) = (gain_sds, delay_sds) else {
            let what = "gains and delays without errors say nothing; give `delay_sd` and `gain_sd` (or `sensitivity_sd`)";
            return if spoken {
                Err((("delay_sd", 0), Problem::Keys { what }))
            } else {
                Ok(Self { sensitivities, stated: None })
            };
        };
        let count = delay_sds.len();
        let stated = StatedChannels {
            gains: gains.unwrap_or_else(|| vec![1.0; count]),
            gain_sds,
            delays: delays.unwrap_or_else(|| vec![0.0; count]),
            delay_sds,
        };
        for m in 0..count {
            within(("gain", m), stated.gains[m].abs(), 1e-6, 1e6, "")?;
            if stated.gain_sds[m] > 1.0 {
                let what = "is above 1, which is 100 % of the gain; write per cent as text, \"3 %\"";
                return Err(((error_key, m), Problem::Keys { what }));
            }
            within((error_key, m), stated.gain_sds[m], 1e-9, 1.0, "")?;
            within(("delay", m), stated.delays[m], -1.0, 1.0, "s")?;
            within(("delay_sd", m), stated.delay_sds[m], 1e-12, 1.0, "s")?;
        }
        Ok(Self { sensitivities, stated: Some(stated) })
    }

    /// Without some microphones.
    pub(super) fn without(mut self, dead: &[usize]) -> Self {
        let keep = |values: &mut Vec<f64>| {
            let mut m = 0..;
            values.retain(|_| m.next().is_none_or(|m| !dead.contains(&m)));
        };
        keep(&mut self.sensitivities);
        if let Some(StatedChannels { gains, gain_sds, delays, delay_sds }) = &mut self.stated {
            [gains, gain_sds, delays, delay_sds].into_iter().for_each(keep);
        }
        self
    }

    /// The keys that say the same.
    pub(super) fn keys(sensitivities: &[f64], stated: Option<&StatedChannels>) -> MicrophoneKeys {
        let list = |values: &[f64]| Some(Each::List(values.iter().map(|v| Given::Si(*v)).collect()));
        MicrophoneKeys {
            table: None,
            sensitivity: if sensitivities.is_empty() { None } else { list(sensitivities) },
            sensitivity_sd: None,
            gain: stated.and_then(|s| list(&s.gains)),
            gain_sd: stated.and_then(|s| list(&s.gain_sds)),
            delay: stated.and_then(|s| list(&s.delays)),
            delay_sd: stated.and_then(|s| list(&s.delay_sds)),
        }
    }
}

/// A key and the number of a microphone, and what is wrong there.
type Wrong = ((&'static str, usize), Problem);

fn within(
    place: (&'static str, usize),
    value: f64,
    low: f64,
    high: f64,
    unit: &'static str,
) -> Result<(), Wrong> {
    in_range(place.0, value, low, high, unit).map_err(|(_, problem)| (place, problem))
}

fn spread(each: &Each, count: usize) -> Result<Vec<Given>, Problem> {
    match each {
        Each::All(given) => Ok(vec![given.clone(); count]),
        Each::List(all) if all.len() == count => Ok(all.clone()),
        Each::List(all) => Err(Problem::OtherCount { have: all.len(), need: count }),
    }
}

/// For each microphone its row: each once, by its number from 0. A dead one without a row gets that of
/// another: nobody asks for its numbers.
fn order(columns: &Columns, count: usize, dead: &[usize]) -> Result<Vec<usize>, RigError> {
    let numbers = columns.numbers("microphone", "1")?;
    let mut rows = vec![None; count];
    for (row, number) in numbers.iter().enumerate() {
        let known = (0..count).find(|m| *m as f64 == *number);
        let Some(m) = known else {
            let (name, known) = (number.to_string(), (0..count).map(|m| m.to_string()).collect());
            return Err(columns.wrong(row, "microphone", Problem::UnknownName { name, known }));
        };
        if rows[m].replace(row).is_some() {
            return Err(columns.wrong(row, "microphone", Problem::Duplicate { name: m.to_string() }));
        }
    }
    let any = rows.iter().flatten().next().copied();
    let row = |(m, row): (usize, &Option<usize>)| row.or(any.filter(|_| dead.contains(&m)));
    let found: Option<Vec<usize>> = rows.iter().enumerate().map(row).collect();
    found.ok_or_else(|| {
        columns.whole(Problem::OtherCount { have: rows.iter().flatten().count(), need: count })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn message_a_dead_microphone_needs_no_row_in_the_table() {
        let folder = std::env::temp_dir().join(format!("rijke-dead-row-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let text =
            "microphone,gain [1],gain_sd [1],delay [s],delay_sd [s]\n0,1,0.01,0,1e-6\n2,1.1,0.02,0,1e-6\n";
        std::fs::write(folder.join("table.csv"), text).unwrap();
        let keys = MicrophoneKeys { table: Some("table.csv".into()), ..MicrophoneKeys::default() };
        let read = |dead: &[usize]| Channels::read(&keys, 3, dead, &folder.join("manifest.toml"));
        let stated = read(&[1]).unwrap().without(&[1]).stated.unwrap();
        assert_eq!((stated.gains, stated.gain_sds), (vec![1.0, 1.1], vec![0.01, 0.02]));
        let said = read(&[]).unwrap_err().to_string();
        assert!(said.contains("2 values for 3 microphones"), "{said}");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
