//! The tables `[microphones]` and `[thermometers]` of a rig.

use super::Reading;
use crate::StudyProblem;
use crate::rig::part::Instruments;
use crate::rig::value::{Reader, Value};
use crate::source::{Outcome, listed};
use toml::{Spanned, Table, Value as Toml};

impl Reading<'_> {
    /// `[microphones]` or `[thermometers]`; `letter` is p or T.
    pub(super) fn instruments(&self, table: Option<Spanned<Table>>, letter: &str) -> Outcome<Instruments> {
        let Some(table) = table else { return Ok(Instruments::default()) };
        let at = table.span();
        let mut table = table.into_inner();
        let wrong = |problem| (at.clone(), problem);
        let reader = Reader { scope: &self.scope, own: &[], unknowns: self.unknowns, at: at.clone() };
        let list = table.remove("at").and_then(|v| v.as_array().cloned()).unwrap_or_default();
        let place = |v: &Toml| match letter {
            "p" => reader.extent("at", v, "m", self.medians),
            _ => reader.value("at", v, "m"),
        };
        let places = list.iter().map(place).collect::<Outcome<Vec<_>>>()?;
        if places.is_empty() {
            return Err(wrong(StudyProblem::Missing { key: "at".into(), need: "a list of places" }));
        }
        let names: Vec<String> = match table.remove("names") {
            None => (1..=places.len()).map(|k| format!("{letter}{k}")).collect(),
            Some(v) => {
                v.as_array().into_iter().flatten().filter_map(|v| v.as_str().map(str::to_owned)).collect()
            }
        };
        if names.len() != places.len() {
            let (value, need) = (format!("{} names", names.len()), "one name for every place of `at`");
            return Err(wrong(StudyProblem::Value { key: "names".into(), value, need }));
        }
        let mut reference = 0;
        match table.remove("reference") {
            None => {}
            Some(Toml::Integer(k)) if usize::try_from(k).is_ok_and(|k| k < names.len()) => {
                reference = k as usize
            }
            Some(v) => {
                let name = v.as_str().map_or_else(|| v.to_string(), str::to_owned);
                reference = names.iter().position(|n| *n == name).ok_or_else(|| {
                    let known = listed(names.iter().map(String::as_str));
                    wrong(StudyProblem::Unknown { what: "microphone", name, known })
                })?;
            }
        }
        let count = names.len();
        let (mut gain_sds, mut delay_sds) = (Vec::new(), Vec::new());
        if letter == "p" {
            gain_sds = sds(&reader, &mut table, "gain_sd", "1", count)?;
            delay_sds = sds(&reader, &mut table, "delay_sd", "s", count)?;
        }
        if let Some(key) = table.keys().next() {
            let known = if letter == "p" {
                "at, names, reference, gain_sd, delay_sd"
            } else {
                "at, names, reference"
            };
            let known = known.into();
            return Err(wrong(StudyProblem::Unknown { what: "key of this table", name: key.clone(), known }));
        }
        Ok(Instruments { names, at: places, line: 0, reference, gain_sds, delay_sds })
    }
}

/// Standard deviations at a key: one for all, or a list with one for each of `count` microphones; empty if
/// it is not there.
fn sds(
    reader: &Reader<'_>,
    table: &mut Table,
    key: &'static str,
    unit: &str,
    count: usize,
) -> Outcome<Vec<f64>> {
    let all = match table.remove(key) {
        None => return Ok(Vec::new()),
        Some(Toml::Array(list)) => list,
        Some(value) => vec![value; count],
    };
    let wrong = |value: String| {
        let need = "one standard deviation above zero for all microphones, or a list with one for each";
        (reader.at.clone(), StudyProblem::Value { key: key.into(), value, need })
    };
    if all.len() != count {
        return Err(wrong(format!("{} numbers for {count} microphones", all.len())));
    }
    let one = |value: &Toml| match reader.value(key, value, unit)? {
        Value::Number(sd) if key == "gain_sd" && sd > 1.0 => {
            let need = "at most 1, which is 100 % of the gain; write per cent as in gain_sd = \"3 %\"";
            Err((reader.at.clone(), StudyProblem::Value { key: key.into(), value: sd.to_string(), need }))
        }
        Value::Number(sd) if sd > 0.0 && sd.is_finite() => Ok(sd),
        _ => Err(wrong(value.to_string())),
    };
    all.iter().map(one).collect()
}
