//! What an element brings: the shape of a duct, and the laws of ducts and devices.

use super::{Reading, Waiting, complex};
use crate::Problem;
use crate::law::Coefficient;
use crate::rig::Duct;
use crate::rig::elements::{HOLE_OUTLETS, HOLE_WALLS, Key, Kind, SCREEN_LOSS, SIDE_HOLE, WALLS, transfer};
use crate::rig::value::{Given, Value};
use crate::source::{Outcome, listed};
use std::ops::Range;
use toml::{Table, Value as Toml};

impl Reading<'_> {
    pub(super) fn duct(&mut self, part: usize, table: &mut Table, at: &Range<usize>) -> Outcome<Duct> {
        let length = self.needed(part, table, "length", "m", at)?;
        let one_of = |what: &'static str| {
            (at.clone(), Problem::Missing { key: what.into(), need: "give one of the two" })
        };
        let mut area = |round: &'static str, plain: &'static str| -> Outcome<Option<Value>> {
            match (table.remove(round), table.remove(plain)) {
                (Some(d), None) => {
                    // A disc, with the diameter in place.
                    let text = match self.extent(part, round, &d, "m", at)? {
                        Value::Number(d) => {
                            return Ok(Some(Value::Number(0.25 * std::f64::consts::PI * d * d)));
                        }
                        Value::Formula(f) | Value::Unknown(f, _) => format!("pi/4*({})^2", f.source()),
                        Value::Table(..) => {
                            let need = "a number or a formula";
                            return Err((
                                at.clone(),
                                Problem::Value { key: round.into(), value: "a table".into(), need },
                            ));
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
                (at.clone(), Problem::Value { key: "temperatures".into(), value: value.to_string(), need })
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
            return Err((at.clone(), Problem::Value { key, value, need }));
        }
        let pieces = self.plain(table, "pieces", "1", at)?;
        let pieces = match pieces {
            None => None,
            Some(n) if (1.0..=1e5).contains(&n) && n.fract() == 0.0 => Some(n as usize),
            Some(n) => {
                let need = "a whole number from 1 to 100000";
                return Err((
                    at.clone(),
                    Problem::Value { key: "pieces".into(), value: n.to_string(), need },
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
                        Problem::Unknown { what: "law of the wall", name: wanted.into(), known },
                    ));
                }
            }
        }
        Ok(Duct { length, area: [start, end], temperatures, temperature_sd, pieces })
    }

    /// A number of an element, for its laws: as a number of its part, or, where it needs more than the operating point, as a named
    /// subexpression.
    pub(super) fn definition(
        &mut self,
        part: usize,
        key: &str,
        unit: &str,
        value: &Toml,
        at: &Range<usize>,
    ) -> Outcome<Vec<(String, String)>> {
        match self.given(part, key, value, unit, at)? {
            // An unknown that is called as the number is it.
            Given::Law(text) if text.trim() == key => Ok(Vec::new()),
            Given::Law(text) => Ok(vec![(key.to_owned(), text)]),
            Given::Value(_) => self.number(part, key, value, unit, at).map(|()| Vec::new()),
        }
    }

    pub(super) fn wait(
        &mut self,
        at: &Range<usize>,
        place: String,
        coefficient: Coefficient,
        text: String,
        definitions: &[(String, String)],
        part: Option<usize>,
    ) {
        let (at, definitions) = (at.clone(), definitions.to_vec());
        self.waiting.push(Waiting { at, place, coefficient, text, definitions, part });
    }

    pub(super) fn compact(
        &mut self,
        part: usize,
        kind: &Kind,
        table: &mut Table,
        at: &Range<usize>,
    ) -> Outcome<()> {
        let mut definitions = Vec::new();
        if kind.name == "feedback" {
            return self.feedback(part, kind, table, at);
        }
        if kind.name == "flame" {
            definitions.extend(self.flame(part, table, at)?);
        }
        if kind.name == "screen"
            && let Some(open_area) = table.remove("open_area")
        {
            if table.contains_key("loss") {
                let need = "give one of the two";
                return Err((at.clone(), Problem::Missing { key: "loss or open_area".into(), need }));
            }
            definitions.extend(self.definition(part, "open_area", "1", &open_area, at)?);
            definitions.push(("loss".into(), SCREEN_LOSS.into()));
        }
        for key in kind.keys {
            if definitions.iter().any(|(name, _)| name == key.name) {
                continue;
            }
            definitions.extend(self.key(part, key, table, at)?);
        }
        if kind.name == "side-hole" {
            for (name, key, laws) in
                [("hole_loss", "wall", HOLE_WALLS), ("hole_outside", "outlet", HOLE_OUTLETS)]
            {
                definitions.push((name.to_owned(), one_of_these(table, key, &laws, at)?));
            }
            definitions.extend(SIDE_HOLE.map(|(name, text)| (name.to_owned(), text.to_owned())));
        }
        let name = self.parts[part].name.clone();
        for (coefficient, law) in kind.laws {
            self.wait(at, name.clone(), *coefficient, (*law).to_owned(), &definitions, Some(part));
        }
        Ok(())
    }

    /// The four couplings as they are given: numbers, [re, im], formulas. Their keys are names that formulas know as something else, as
    /// `mu` for the viscosity, so that they are no numbers of the part.
    fn feedback(&mut self, part: usize, kind: &Kind, table: &mut Table, at: &Range<usize>) -> Outcome<()> {
        let name = self.parts[part].name.clone();
        for (key, (coefficient, law)) in kind.keys.iter().zip(kind.laws) {
            let Some(value) = table.remove(key.name).map(complex) else { continue };
            let text = match self.given(part, key.name, &value, key.unit, at)? {
                Given::Value(Value::Number(v)) => format!("{v:e}"),
                Given::Value(Value::Formula(formula)) => formula.source().to_owned(),
                Given::Law(text) => text,
                Given::Value(_) => {
                    let need = "a number, [re, im] or a formula";
                    let (key, value) = (key.name.into(), "a table".into());
                    return Err((at.clone(), Problem::Value { key, value, need }));
                }
            };
            let definition = [(format!("coupling_{}", key.name), text)];
            self.wait(at, name.clone(), *coefficient, (*law).to_owned(), &definition, Some(part));
        }
        Ok(())
    }

    pub(super) fn key(
        &mut self,
        part: usize,
        key: &Key,
        table: &mut Table,
        at: &Range<usize>,
    ) -> Outcome<Vec<(String, String)>> {
        let value = match (table.remove(key.name), key.default) {
            (Some(value), _) => complex(value),
            (None, Some(default)) => Toml::Float(default.parse().unwrap_or(f64::NAN)),
            (None, None) => {
                let need = "a number, a quantity, a formula, or \"$unknown\"";
                return Err((at.clone(), Problem::Missing { key: key.name.into(), need }));
            }
        };
        self.definition(part, key.name, key.unit, &value, at)
    }

    /// `gain` from `n`, and `transfer` from what is given of delay, filter and polynomials.
    pub(super) fn flame(
        &mut self,
        part: usize,
        table: &mut Table,
        at: &Range<usize>,
    ) -> Outcome<Vec<(String, String)>> {
        let mut all = Vec::new();
        if let Some(n) = table.remove("n") {
            if table.contains_key("gain") {
                return Err((
                    at.clone(),
                    Problem::Missing { key: "gain or n".into(), need: "give one of the two" },
                ));
            }
            all.extend(self.definition(part, "n", "1", &n, at)?);
            all.push(("gain".into(), "(n)*(T_2 - T)/T*A/A_2".into()));
        }
        let delay = table.remove("delay");
        let delay = match delay {
            None => None,
            Some(value) => {
                let given = self.given(part, "delay", &value, "s", at)?;
                all.extend(self.definition(part, "delay", "s", &value, at)?);
                Some(given)
            }
        };
        let cutoff = match table.remove("cutoff_hz") {
            None => false,
            Some(value) => {
                all.extend(self.definition(part, "cutoff_hz", "Hz", &value, at)?);
                true
            }
        };
        let mut polynomial = |key: &'static str| -> Outcome<Vec<String>> {
            let Some(value) = table.remove(key) else { return Ok(Vec::new()) };
            let list = value.as_array().cloned().unwrap_or_default();
            let mut names = Vec::new();
            for (k, value) in list.iter().enumerate() {
                let name = format!("{key}_{k}");
                all.extend(self.definition(part, &name, "", value, at)?);
                names.push(name);
            }
            if names.is_empty() {
                let need = "a list of coefficients, ascending powers of s";
                return Err((at.clone(), Problem::Value { key: key.into(), value: value.to_string(), need }));
            }
            Ok(names)
        };
        let (numerator, denominator) = (polynomial("numerator")?, polynomial("denominator")?);
        all.push(("transfer".into(), transfer(delay.as_ref(), cutoff, &numerator, &denominator)));
        Ok(all)
    }
}

/// The law that a word of the file names; the first if there is no word.
fn one_of_these(
    table: &mut Table,
    key: &'static str,
    laws: &[(&str, &str)],
    at: &Range<usize>,
) -> Outcome<String> {
    let Some(wanted) = table.remove(key) else { return Ok(laws[0].1.to_owned()) };
    let wanted = wanted.as_str().unwrap_or("?").to_owned();
    let found = laws.iter().find(|(name, _)| *name == wanted).map(|(_, law)| (*law).to_owned());
    found.ok_or_else(|| {
        let known = listed(laws.iter().map(|law| law.0));
        (at.clone(), Problem::Unknown { what: key, name: wanted, known })
    })
}
