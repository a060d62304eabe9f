//! A duct: its shape, its gas, the losses of its wall.

use super::Reading;
use super::shapes::in_range;
use crate::StudyProblem;
use crate::law::Coefficient;
use crate::rig::Duct;
use crate::rig::elements::WALLS;
use crate::rig::value::{Given, Value};
use crate::source::{Outcome, listed};
use std::ops::Range;
use toml::{Table, Value as Toml};

impl Reading<'_> {
    pub(super) fn duct(&mut self, part: usize, table: &mut Table, at: &Range<usize>) -> Outcome<Duct> {
        let length = self.needed(part, table, "length", "m", at)?;
        let one_of = |what: &'static str| {
            (at.clone(), StudyProblem::Missing { key: what.into(), need: "give one of the two" })
        };
        let mut area = |round: &'static str, plain: &'static str| -> Outcome<Option<Value>> {
            match (table.remove(round), table.remove(plain)) {
                (Some(d), None) => {
                    // A disc, with the diameter in place.
                    let text = match self.extent(part, round, &d, "m", at)? {
                        Value::Number(d) => {
                            in_range(round, &Given::Value(Value::Number(d)), at)?;
                            return Ok(Some(Value::Number(0.25 * std::f64::consts::PI * d * d)));
                        }
                        Value::Formula(f) | Value::Unknown(f, _) => format!("pi/4*({})^2", f.source()),
                        Value::Table(factor, rows) => {
                            let owner = self.parts[part].name.clone();
                            let name = self.loose(&owner, round, "m", Value::Table(factor, rows), at)?;
                            format!("pi/4*({name})^2")
                        }
                    };
                    self.extent(part, round, &Toml::String(text), "m^2", at).map(Some)
                }
                (None, Some(a)) => self.extent(part, plain, &a, "m^2", at).map(Some),
                (None, None) => Ok(None),
                (Some(_), Some(_)) => Err(one_of("diameter or area")),
            }
        };
        let start = area("diameter", "area")?.ok_or_else(|| one_of("diameter or area"))?;
        let end = area("diameter_end", "area_end")?.unwrap_or_else(|| start.clone());
        let mut temperatures = Vec::new();
        for key in ["temperature", "temperature_end"] {
            if let Some(value) = table.remove(key) {
                temperatures.push(self.extent(part, key, &value, "K", at)?);
            }
        }
        if let Some(value) = table.remove("temperatures") {
            let list = value.as_array().filter(|_| temperatures.is_empty()).cloned().ok_or_else(|| {
                let need = "a list, without `temperature` beside it";
                (
                    at.clone(),
                    StudyProblem::Value { key: "temperatures".into(), value: value.to_string(), need },
                )
            })?;
            for value in &list {
                temperatures.push(self.read(part, "temperatures", value, "K", at)?);
            }
        }
        let temperature_sd = self.plain(table, "temperature_sd", "K", at)?.unwrap_or(0.0);
        let stands_alone = temperature_sd > 0.0 && temperatures.is_empty();
        if temperature_sd.is_nan() || temperature_sd < 0.0 || stands_alone {
            let (key, value) = ("temperature_sd".into(), temperature_sd.to_string());
            let need = "positive, beside a `temperature` of this duct";
            return Err((at.clone(), StudyProblem::Value { key, value, need }));
        }
        let pieces = self.plain(table, "pieces", "1", at)?;
        let pieces = match pieces {
            None => None,
            Some(n) if (1.0..=1e5).contains(&n) && n.fract() == 0.0 => Some(n as usize),
            Some(n) => {
                let need = "a whole number from 1 to 100000";
                return Err((
                    at.clone(),
                    StudyProblem::Value { key: "pieces".into(), value: n.to_string(), need },
                ));
            }
        };
        if let Some(wall) = table.remove("wall") {
            let wanted = wall.as_str().unwrap_or("?");
            let factor = table.remove("wall_factor").unwrap_or(Toml::Float(1.0));
            let law = WALLS.iter().find(|(name, _)| *name == wanted);
            match law {
                Some((_, laws)) => {
                    let definitions = self.definition(part, "wall_factor", "1", &factor, at)?;
                    for (coefficient, law) in [Coefficient::Mu, Coefficient::Ep].into_iter().zip(laws) {
                        let place = self.parts[part].name.clone();
                        self.wait(at, place, coefficient, (*law).to_owned(), &definitions, Some(part));
                    }
                }
                None if wanted == "none" => {}
                None => {
                    let known = listed(["none"].into_iter().chain(WALLS.iter().map(|w| w.0)));
                    return Err((
                        at.clone(),
                        StudyProblem::Unknown { what: "law of the wall", name: wanted.into(), known },
                    ));
                }
            }
        }
        let gas = Box::new(self.duct_gas(part, table, at)?);
        Ok(Duct { length, area: [start, end], temperatures, temperature_sd, gas, pieces })
    }

    /// Ratio of specific heats and gas constant of a duct whose gas is not that of the rig.
    fn duct_gas(&self, part: usize, table: &mut Table, at: &Range<usize>) -> Outcome<[Option<Value>; 2]> {
        let mut number = |key: &'static str, unit: &str| -> Outcome<Option<Value>> {
            let Some(value) = table.remove(key) else { return Ok(None) };
            if self.gas_follows_temperature {
                let need = "left out: the [gas] of this file follows temperature, with molar_mass and heat_capacity; \
                            a duct has gas of its own beside a [gas] with gamma and gas_constant";
                return Err((
                    at.clone(),
                    StudyProblem::Value { key: key.into(), value: value.to_string(), need },
                ));
            }
            let read = self.extent(part, key, &value, unit, at)?;
            if let Value::Number(v) = read {
                in_range(key, &Given::Value(Value::Number(v)), at)?;
            }
            Ok(Some(read))
        };
        Ok([number("gamma", "1")?, number("gas_constant", "J/(kg K)")?])
    }
}
