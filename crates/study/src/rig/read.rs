//! From the text of `rig.toml` to a rig.

use super::elements::{COMPACT, ENDS, Key, Kind, WALLS, transfer};
use super::value::{Given, Reader, Value};
use super::{Duct, GasModel, Instruments, Part, Place, Rig, Shape};
use crate::catalogue::{Parameters, parameters};
use crate::law::{Candidate, Coefficient, Effect, Words};
use crate::names::{add, built_in};
use crate::source::{Outcome, listed};
use crate::{Campaign, Problem};
use rijke_formula::{Kind as NameKind, Name, Scope};
use serde::Deserialize;
use std::collections::BTreeSet;
use std::ops::Range;
use toml::{Spanned, Table, Value as Toml};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    name: String,
    #[serde(default)]
    source: String,
    gas: Option<Spanned<Table>>,
    search: Option<Search>,
    upstream: Spanned<Table>,
    downstream: Spanned<Table>,
    #[serde(default)]
    element: Vec<Spanned<Table>>,
    microphones: Option<Spanned<Table>>,
    thermometers: Option<Spanned<Table>>,
    #[serde(default)]
    unknown: Parameters,
    #[serde(default)]
    base: BaseNumbers,
    /// How records are taken: for the readers of records.
    #[serde(default, rename = "recording")]
    _recording: Table,
}

/// Numbers that base states bring for laws, with their units.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct BaseNumbers {
    numbers: std::collections::BTreeMap<String, String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Search {
    growth_rate: Option<[f64; 2]>,
    frequency_hz: Option<[f64; 2]>,
}

/// A law of an element that waits until all names are known.
struct Waiting {
    at: Range<usize>,
    place: String,
    coefficient: Coefficient,
    text: String,
    definitions: Vec<(String, String)>,
    part: Option<usize>,
}

struct Reading<'a> {
    scope: Scope,
    parts: Vec<Part>,
    waiting: Vec<Waiting>,
    unknowns: &'a [String],
    /// Numbers of the two ends by bare name.
    end_numbers: Vec<(String, String)>,
}

pub(super) fn rig(file: File, campaign: &Campaign) -> Outcome<Rig> {
    let mut scope = built_in().map_err(|problem| (0..0, problem))?;
    let mut factors = Vec::new();
    for factor in &campaign.factors {
        let (name, unit, meaning) =
            (factor.name.clone(), factor.unit.clone(), "factor of the campaign".into());
        let name = Name { name, unit, meaning, kind: NameKind::Global };
        factors.push(add(&mut scope, "factor", name).map_err(|problem| (0..0, problem))?);
    }
    let mut brought = Vec::new();
    for (name, unit) in file.base.numbers {
        let meaning = "number that the base state brings".into();
        let name = Name { name, unit, meaning, kind: NameKind::Global };
        brought.push(add(&mut scope, "number of the base state", name).map_err(|problem| (0..0, problem))?);
    }
    let unknowns = parameters(file.unknown, &scope)?;
    let names: Vec<String> = unknowns.iter().map(|(p, _)| p.name.clone()).collect();
    let mut reading =
        Reading { scope, parts: Vec::new(), waiting: Vec::new(), unknowns: &names, end_numbers: Vec::new() };
    let gas_at = file.gas.as_ref().map_or(0..0, Spanned::span);
    let (gas, pressure, temperature) = reading.gas(file.gas)?;
    for (k, element) in file.element.into_iter().enumerate() {
        reading.element(k, element)?;
    }
    if !reading.parts.iter().any(|p| matches!(p.shape, Shape::Duct(_))) {
        let need = "add an [[element]] with type = \"duct\" and a length";
        return Err((gas_at, Problem::Empty { what: "duct", need }));
    }
    for (place, end) in [("upstream", file.upstream), ("downstream", file.downstream)] {
        reading.end(place, end)?;
    }
    let microphones = reading.instruments(file.microphones, "p")?;
    let thermometers = reading.instruments(file.thermometers, "T")?;
    let (effects, used) = reading.effects()?;
    if let Some((unknown, at)) = unknowns.iter().find(|(p, _)| !used.contains(&p.name)) {
        let (name, place) = (format!("${}", unknown.name), "the file".to_owned());
        return Err((at.clone(), Problem::Unused { name, place }));
    }
    let search = file.search.unwrap_or(Search { growth_rate: None, frequency_hz: None });
    let own = Candidate {
        id: "rig".into(),
        role: "rig".into(),
        name: file.name.clone(),
        cite: vec![file.source.clone()],
        note: String::new(),
        extends: None,
        parameters: unknowns.into_iter().map(|(p, _)| p).collect(),
        effects,
    };
    Ok(Rig {
        name: file.name,
        source: file.source,
        gas,
        pressure,
        temperature,
        parts: reading.parts,
        own,
        microphones,
        thermometers,
        scope: reading.scope,
        factors,
        brought,
        search: [
            search.growth_rate.unwrap_or([-500.0, 500.0]),
            search.frequency_hz.unwrap_or([10.0, 1000.0]),
        ],
    })
}

impl Reading<'_> {
    fn gas(&self, table: Option<Spanned<Table>>) -> Outcome<(GasModel, f64, f64)> {
        let at = table.as_ref().map_or(0..0, Spanned::span);
        let mut table = table.map(Spanned::into_inner).unwrap_or_default();
        let reader = Reader { scope: &self.scope, own: &[], unknowns: &[], at: at.clone() };
        let number = |table: &mut Table, key: &str, unit: &str, default: f64| match table.remove(key) {
            None => Ok(default),
            Some(value) => {
                let value = reader.value(key, &value, unit)?.at(&[]);
                if value > 0.0 && value.is_finite() {
                    return Ok(value);
                }
                let problem = Problem::Value { key: key.into(), value: value.to_string(), need: "positive" };
                Err((at.clone(), problem))
            }
        };
        let pressure = number(&mut table, "pressure", "Pa", 101_325.0)?;
        let temperature = number(&mut table, "temperature", "K", 293.15)?;
        if table.contains_key("molar_mass") {
            // The same form as in the file of a rig: numbers or, for the mass, a quantity.
            if let Some(text) = table.get("molar_mass").filter(|v| v.is_str()) {
                let mass = reader.value("molar_mass", text, "kg/mol")?.at(&[]);
                table.insert("molar_mass".into(), Toml::Float(mass));
            }
            let gas = rijke_rig::Gas::deserialize(Toml::Table(table))
                .map_err(|error| (at, Problem::Toml(error.message().to_owned())))?;
            return Ok((GasModel::Real(gas), pressure, temperature));
        }
        let gamma = number(&mut table, "gamma", "1", 1.4)?;
        let constant = number(&mut table, "gas_constant", "J/(kg K)", 287.05)?;
        let viscosity = number(&mut table, "viscosity", "Pa s", 1.813e-5)?;
        let prandtl = number(&mut table, "prandtl", "1", 0.71)?;
        if gamma <= 1.0 {
            let problem = Problem::Value { key: "gamma".into(), value: gamma.to_string(), need: "above 1" };
            return Err((at, problem));
        }
        if let Some(key) = table.keys().next() {
            let known = "pressure, temperature, gamma, gas_constant, viscosity, prandtl; or molar_mass, heat_capacity, \
                         viscosity, conductivity"
                .into();
            return Err((at, Problem::Unknown { what: "key of [gas]", name: key.clone(), known }));
        }
        Ok((
            GasModel::Perfect { gamma, constant, viscosity: [viscosity, temperature], prandtl },
            pressure,
            temperature,
        ))
    }

    fn element(&mut self, index: usize, table: Spanned<Table>) -> Outcome<()> {
        let at = table.span();
        let mut table = table.into_inner();
        let wrong = |problem| (at.clone(), problem);
        let text = |table: &mut Table, key: &'static str| match table.remove(key) {
            None => Ok(None),
            Some(Toml::String(text)) => Ok(Some(text)),
            Some(other) => {
                Err(wrong(Problem::Value { key: key.into(), value: other.to_string(), need: "a text" }))
            }
        };
        let kind = text(&mut table, "type")?
            .ok_or_else(|| wrong(Problem::Missing { key: "type".into(), need: "say what the element is" }))?;
        let name = text(&mut table, "name")?.unwrap_or_else(|| format!("{kind}_{}", index + 1));
        self.check_name(&name).map_err(wrong)?;
        let present = text(&mut table, "present")?;
        let present = match present {
            None => None,
            Some(factor) => Some(self.scope.find(&factor).ok_or_else(|| {
                let known = listed(self.scope.names().iter().map(|n| n.name.as_str()));
                wrong(Problem::Unknown { what: "factor", name: factor, known })
            })?),
        };
        let near_field = self.plain(&mut table, "near_field", "1", &at)?;
        let free = match table.remove("numbers") {
            None => Table::new(),
            Some(Toml::Table(numbers)) => numbers,
            Some(other) => {
                let need = "a table, { name = value, ... }";
                return Err(wrong(Problem::Value { key: "numbers".into(), value: other.to_string(), need }));
            }
        };
        let part = self.parts.len();
        self.parts.push(Part {
            name: name.clone(),
            shape: Shape::Device(Vec::new()),
            numbers: Vec::new(),
            present,
            near_field,
        });
        // A number may name another one, wherever that stands.
        let mut waiting: Vec<(&String, &Toml)> = free.iter().collect();
        while !waiting.is_empty() {
            let before = waiting.len();
            let mut fault = None;
            waiting.retain(|(key, value)| match self.number(part, key, value, "", &at) {
                Ok(()) => false,
                Err(error) => {
                    fault.get_or_insert(error);
                    true
                }
            });
            if let Some(fault) = fault.filter(|_| waiting.len() == before) {
                return Err(fault);
            }
        }
        if kind == "duct" {
            let duct = self.duct(part, &mut table, &at)?;
            self.parts[part].shape = Shape::Duct(duct);
        } else if kind == "insert" {
            let [from, to] = ["from", "to"].map(|key| self.needed(part, &mut table, key, "m", &at));
            self.parts[part].shape = Shape::Insert(from?, to?);
        } else {
            let found = COMPACT.iter().find(|k| k.name == kind).ok_or_else(|| {
                let known = listed(["duct", "insert"].into_iter().chain(COMPACT.iter().map(|k| k.name)));
                wrong(Problem::Unknown { what: "type of element", name: kind.clone(), known })
            })?;
            let places = match table.remove("at") {
                None => Vec::new(),
                Some(Toml::Array(list)) => {
                    list.iter().map(|v| self.read(part, "at", v, "m", &at)).collect::<Outcome<_>>()?
                }
                Some(value) => vec![self.read(part, "at", &value, "m", &at)?],
            };
            self.parts[part].shape = Shape::Device(places);
            self.compact(part, found, &mut table, &at)?;
        }
        self.finished(&table, &kind, &at)
    }

    fn finished(&self, table: &Table, kind: &str, at: &Range<usize>) -> Outcome<()> {
        let Some(key) = table.keys().next() else { return Ok(()) };
        let keys = COMPACT.iter().chain(&ENDS).find(|k| k.name == kind).map_or(&[][..], |k| k.keys);
        let of_kind = match kind {
            "duct" => {
                "length, diameter, diameter_end, area, area_end, temperature, temperature_end, temperatures, pieces, wall, wall_factor"
            }
            "insert" => "from, to",
            "flame" => "n, delay, cutoff_hz, numerator, denominator, at",
            _ => "at",
        };
        let common = ["name", "type", "present", "near_field", "numbers"];
        let known = listed(keys.iter().map(|k| k.name).chain([of_kind]).chain(common));
        Err((at.clone(), Problem::Unknown { what: "key of this element", name: key.clone(), known }))
    }

    fn check_name(&self, name: &str) -> Result<(), Problem> {
        let why = "letters, digits, _ and - only, starting with a letter; upstream, downstream, ends and ducts are taken";
        let good = name.starts_with(|c: char| c.is_alphabetic())
            && name.chars().all(|c| c.is_alphanumeric() || c == '_' || c == '-')
            && !["upstream", "downstream", "ends", "ducts"].contains(&name);
        if !good {
            return Err(Problem::Name { what: "part", name: name.to_owned(), why });
        }
        if self.parts.iter().any(|p| p.name == name) {
            return Err(Problem::Duplicate { what: "part", name: name.to_owned() });
        }
        Ok(())
    }

    /// Names of a part in the scope: `part.number`, with `_` in the place of `-`.
    fn scoped(&self, part: &str, key: &str) -> String {
        format!("{}.{key}", part.replace('-', "_"))
    }

    fn own(&self, part: usize) -> Vec<(String, String)> {
        super::own_numbers(&self.scope, &self.parts[part])
    }

    fn given(&self, part: usize, key: &str, value: &Toml, unit: &str, at: &Range<usize>) -> Outcome<Given> {
        let own = self.own(part);
        let reader = Reader { scope: &self.scope, own: &own, unknowns: self.unknowns, at: at.clone() };
        reader.given(key, value, unit)
    }

    fn read(&self, part: usize, key: &str, value: &Toml, unit: &str, at: &Range<usize>) -> Outcome<Value> {
        let own = self.own(part);
        let reader = Reader { scope: &self.scope, own: &own, unknowns: self.unknowns, at: at.clone() };
        reader.value(key, value, unit)
    }

    fn needed(
        &self,
        part: usize,
        table: &mut Table,
        key: &'static str,
        unit: &str,
        at: &Range<usize>,
    ) -> Outcome<Value> {
        let value = table.remove(key);
        let value = value.ok_or_else(|| {
            (at.clone(), Problem::Missing { key: key.into(), need: "a number, a quantity or a formula" })
        })?;
        self.read(part, key, &value, unit, at)
    }

    /// A plain number, if it is given.
    fn plain(
        &self,
        table: &mut Table,
        key: &'static str,
        unit: &str,
        at: &Range<usize>,
    ) -> Outcome<Option<f64>> {
        let Some(value) = table.remove(key) else { return Ok(None) };
        let reader = Reader { scope: &self.scope, own: &[], unknowns: &[], at: at.clone() };
        match reader.value(key, &value, unit)? {
            Value::Number(v) => Ok(Some(v)),
            _ => Err((
                at.clone(),
                Problem::Value { key: key.into(), value: value.to_string(), need: "a number" },
            )),
        }
    }

    /// Adds a number to a part.
    fn number(&mut self, part: usize, key: &str, value: &Toml, unit: &str, at: &Range<usize>) -> Outcome<()> {
        // A table { value, unit } states the unit of a formula.
        let (stated, value) = match value.as_table().map(|t| (t.get("unit"), t.get("value"), t.len())) {
            Some((Some(Toml::String(unit)), Some(value), 2)) => (unit.clone(), value.clone()),
            _ => (unit.to_owned(), value.clone()),
        };
        let read = self.read(part, key, &value, &stated, at)?;
        let unit = match (&read, value.as_str().map(rijke_rig::Quantity::parse)) {
            (Value::Number(_), Some(Ok(q))) if stated.is_empty() => crate::campaign::si_text(&q.unit),
            _ => stated,
        };
        let full = self.scoped(&self.parts[part].name, key);
        let meaning = format!("number of the part {}", self.parts[part].name);
        let name = Name { name: full, unit, meaning, kind: NameKind::Global };
        let place = add(&mut self.scope, "number of a part", name).map_err(|p| (at.clone(), p))?;
        self.parts[part].numbers.push((place, read));
        Ok(())
    }

    fn duct(&mut self, part: usize, table: &mut Table, at: &Range<usize>) -> Outcome<Duct> {
        let length = self.needed(part, table, "length", "m", at)?;
        let one_of = |what: &'static str| {
            (at.clone(), Problem::Missing { key: what.into(), need: "give one of the two" })
        };
        let mut area = |round: &'static str, plain: &'static str| -> Outcome<Option<Value>> {
            match (table.remove(round), table.remove(plain)) {
                (Some(d), None) => {
                    // A disc, with the diameter in place.
                    let text = match self.read(part, round, &d, "m", at)? {
                        Value::Number(d) => {
                            return Ok(Some(Value::Number(0.25 * std::f64::consts::PI * d * d)));
                        }
                        Value::Formula(f) => format!("pi/4*({})^2", f.source()),
                        Value::Table(..) => {
                            let need = "a number or a formula";
                            return Err((
                                at.clone(),
                                Problem::Value { key: round.into(), value: "a table".into(), need },
                            ));
                        }
                    };
                    self.read(part, round, &Toml::String(text), "m^2", at).map(Some)
                }
                (None, Some(a)) => self.read(part, plain, &a, "m^2", at).map(Some),
                (None, None) => Ok(None),
                (Some(_), Some(_)) => Err(one_of("diameter or area")),
            }
        };
        let start = area("diameter", "area")?.ok_or_else(|| one_of("diameter or area"))?;
        let end = area("diameter_end", "area_end")?.unwrap_or_else(|| start.clone());
        let mut temperatures = Vec::new();
        for key in ["temperature", "temperature_end"] {
            if let Some(value) = table.remove(key) {
                temperatures.push(self.read(part, key, &value, "K", at)?);
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
        Ok(Duct { length, area: [start, end], temperatures, pieces })
    }

    /// A number of an element, for its laws: as a number of its part, or, where it needs more than the operating point, as a named
    /// subexpression.
    fn definition(
        &mut self,
        part: usize,
        key: &str,
        unit: &str,
        value: &Toml,
        at: &Range<usize>,
    ) -> Outcome<Vec<(String, String)>> {
        match self.given(part, key, value, unit, at)? {
            Given::Law(text) => Ok(vec![(key.to_owned(), text)]),
            Given::Value(_) => self.number(part, key, value, unit, at).map(|()| Vec::new()),
        }
    }

    fn wait(
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

    fn compact(&mut self, part: usize, kind: &Kind, table: &mut Table, at: &Range<usize>) -> Outcome<()> {
        let mut definitions = Vec::new();
        if kind.name == "flame" {
            definitions.extend(self.flame(part, table, at)?);
        }
        for key in kind.keys {
            if definitions.iter().any(|(name, _)| name == key.name) {
                continue;
            }
            definitions.extend(self.key(part, key, table, at)?);
        }
        let name = self.parts[part].name.clone();
        for (coefficient, law) in kind.laws {
            let wanted = |(name, _): &&(String, String)| crate::law::words(law).any(|w| w == name);
            let nothing = kind.name == "feedback" && !definitions.iter().any(|d| wanted(&d)) && {
                let own = self.own(part);
                let zero = self.parts[part].numbers.iter().zip(&own).any(|((_, value), (bare, _))| {
                    bare == coefficient.name() && matches!(value, Value::Number(v) if *v == 0.0)
                });
                zero
            };
            if !nothing {
                self.wait(at, name.clone(), *coefficient, (*law).to_owned(), &definitions, Some(part));
            }
        }
        Ok(())
    }

    fn key(
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
    fn flame(&mut self, part: usize, table: &mut Table, at: &Range<usize>) -> Outcome<Vec<(String, String)>> {
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

    fn end(&mut self, place: &'static str, table: Spanned<Table>) -> Outcome<()> {
        let at = table.span();
        let mut table = table.into_inner();
        let kind = table.remove("type");
        let kind = kind.as_ref().and_then(Toml::as_str).unwrap_or("?");
        let found = ENDS.iter().find(|k| k.name == kind).ok_or_else(|| {
            let known = listed(ENDS.iter().map(|k| k.name));
            (at.clone(), Problem::Unknown { what: "type of end", name: kind.to_owned(), known })
        })?;
        // `calibration` = [modulus, angle], as network files have it.
        if let Some(Toml::Array(list)) = table.remove("calibration") {
            let mut list = list.into_iter();
            for key in ["modulus", "angle"] {
                list.next().map(|value| table.insert(key.into(), value));
            }
        }
        // Numbers of ends are parts of none: they are texts in the law itself.
        let mut definitions = Vec::new();
        let reader = Reader { scope: &self.scope, own: &[], unknowns: self.unknowns, at: at.clone() };
        for key in found.keys {
            let value = match (table.remove(key.name), key.default) {
                (Some(value), _) => complex(value),
                (None, Some(default)) => Toml::Float(default.parse().unwrap_or(f64::NAN)),
                (None, None) => {
                    let need = "a number, a quantity, a formula, or \"$unknown\"";
                    return Err((at.clone(), Problem::Missing { key: key.name.into(), need }));
                }
            };
            let text = match reader.given(key.name, &value, key.unit)? {
                Given::Law(text) => text,
                Given::Value(Value::Number(v)) => format!("({v:e})"),
                Given::Value(Value::Formula(f)) => f.source().to_owned(),
                Given::Value(Value::Table(..)) => {
                    let need = "a number or a formula";
                    return Err((
                        at.clone(),
                        Problem::Value { key: key.name.into(), value: "a table".into(), need },
                    ));
                }
            };
            definitions.push((key.name.to_owned(), text));
        }
        self.finished(&table, kind, &at)?;
        for (coefficient, law) in found.laws {
            self.wait(&at, place.to_owned(), *coefficient, (*law).to_owned(), &definitions, None);
        }
        Ok(())
    }

    fn instruments(&self, table: Option<Spanned<Table>>, letter: &str) -> Outcome<Instruments> {
        let Some(table) = table else { return Ok(Instruments::default()) };
        let at = table.span();
        let mut table = table.into_inner();
        let wrong = |problem| (at.clone(), problem);
        let reader = Reader { scope: &self.scope, own: &[], unknowns: &[], at: at.clone() };
        let list = table.remove("at").and_then(|v| v.as_array().cloned()).unwrap_or_default();
        let places = list.iter().map(|v| reader.value("at", v, "m")).collect::<Outcome<Vec<_>>>()?;
        if places.is_empty() {
            return Err(wrong(Problem::Missing { key: "at".into(), need: "a list of places" }));
        }
        let names: Vec<String> = match table.remove("names") {
            None => (1..=places.len()).map(|k| format!("{letter}{k}")).collect(),
            Some(v) => {
                v.as_array().into_iter().flatten().filter_map(|v| v.as_str().map(str::to_owned)).collect()
            }
        };
        if names.len() != places.len() {
            let (value, need) = (format!("{} names", names.len()), "one name for every place of `at`");
            return Err(wrong(Problem::Value { key: "names".into(), value, need }));
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
                    wrong(Problem::Unknown { what: "microphone", name, known })
                })?;
            }
        }
        if let Some(key) = table.keys().next() {
            let known = "at, names, reference".into();
            return Err(wrong(Problem::Unknown { what: "key of this table", name: key.clone(), known }));
        }
        Ok(Instruments { names, at: places, reference })
    }

    /// The laws of all elements, and the unknowns that they use.
    fn effects(&mut self) -> Outcome<(Vec<Effect>, BTreeSet<String>)> {
        let mut used = BTreeSet::new();
        let mut effects = Vec::new();
        for waiting in std::mem::take(&mut self.waiting) {
            let Waiting { at, place: place_text, coefficient, text, definitions, part } = waiting;
            let place = Place::parse(&place_text, &self.parts).map_err(|problem| (at.clone(), problem))?;
            let own = part.map_or_else(|| self.end_numbers.clone(), |part| self.own(part));
            let words =
                Words { scope: &self.scope, parameters: self.unknowns, definitions: &definitions, own: &own };
            let law = words.law(&text, &place, at, &place_text, &mut BTreeSet::new())?;
            let named = |k: &usize| law.uses_parameter(*k);
            used.extend((0..self.unknowns.len()).filter(named).map(|k| self.unknowns[k].clone()));
            effects.push(Effect { place, place_text, coefficient, law });
        }
        Ok((effects, used))
    }
}

/// [re, im] as a formula.
fn complex(value: Toml) -> Toml {
    let number = |v: &Toml| v.as_float().or_else(|| v.as_integer().map(|i| i as f64));
    match value.as_array().map(Vec::as_slice) {
        Some([re, im]) => match (number(re), number(im)) {
            (Some(re), Some(im)) => Toml::String(format!("({re:e}) + i*({im:e})")),
            _ => value,
        },
        _ => value,
    }
}
