//! Flames that release their heat along ducts.

use super::Reading;
use crate::StudyProblem;
use crate::law::Spread;
use crate::rig::elements::fault_of;
use crate::rig::value::{Value, number};
use crate::source::Outcome;
use std::ops::Range;
use toml::{Table, Value as Toml};

/// Pieces of a spread flame whose file does not say a number.
const PIECES: f64 = 40.0;

impl Reading<'_> {
    /// Along what a flame is spread, if it is; its `transfer` is made that of a piece. `delayed` says whether
    /// it has a delay at its beginning.
    pub(super) fn spread(
        &mut self,
        part: usize,
        table: &mut Table,
        definitions: &mut Vec<(String, String)>,
        delayed: bool,
        at: &Range<usize>,
    ) -> Outcome<Option<Spread>> {
        let Some(length) = table.remove("length") else {
            let alone = ["delay_end", "pieces", "density"].into_iter().find(|key| table.contains_key(*key));
            return alone.map_or(Ok(None), |key| {
                let (key, need) = (format!("length (beside {key})"), "how far the flame reaches, in m");
                Err((at.clone(), StudyProblem::Missing { key, need }))
            });
        };
        if let Value::Number(v) = self.read(part, "length", &length, "m", at)?
            && let Some(need) = fault_of("length", v)
        {
            return Err((
                at.clone(),
                StudyProblem::Value { key: "length".into(), value: v.to_string(), need },
            ));
        }
        self.number(part, "length", &length, "m", at)?;
        let place = |reading: &Self| reading.parts[part].numbers.last().map_or(0, |(place, _)| *place);
        let length = place(self);
        self.number(part, "along", &Toml::Float(0.5), "1", at)?;
        let along = place(self);
        if let Some(end) = table.remove("delay_end") {
            definitions.splice(0..0, self.definition(part, "delay_end", "s", &end, at)?);
            let begin = if delayed { " - (delay)" } else { "" };
            if let Some((_, text)) = definitions.iter_mut().find(|(name, _)| name == "transfer") {
                text.push_str(&format!("*exp(-s*along*((delay_end){begin}))"));
            }
        }
        let pieces = self.plain(table, "pieces", "1", at)?.unwrap_or(PIECES);
        if !(1.0..=1000.0).contains(&pieces) || pieces.fract() != 0.0 {
            let need = "a whole number from 1 to 1000";
            let (key, value) = ("pieces".into(), pieces.to_string());
            return Err((at.clone(), StudyProblem::Value { key, value, need }));
        }
        let density = match table.remove("density") {
            None => vec![1.0],
            Some(given) => density(&given).ok_or_else(|| {
                let need =
                    "a list of numbers, zero or more and not all zero: heat per length from end to end";
                (at.clone(), StudyProblem::Value { key: "density".into(), value: given.to_string(), need })
            })?,
        };
        Ok(Some(Spread { length, along, density, pieces: pieces as usize }))
    }
}

/// Heat per length at equally spaced points; none if no heat is there.
fn density(given: &Toml) -> Option<Vec<f64>> {
    let sound = |v: &f64| v.is_finite() && *v >= 0.0;
    let all: Option<Vec<f64>> = given.as_array()?.iter().map(|v| number(v).filter(sound)).collect();
    all.filter(|all| all.iter().any(|v| *v > 0.0))
}
