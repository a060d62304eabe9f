//! One element of the chain: its name, its numbers, what kind it is.

use super::Reading;
use super::owner::Owner;
use crate::StudyProblem;
use crate::names::{add, factor_of, factors};
use crate::rig::elements::{COMPACT, ENDS, FUNCTION, REFUSED};
use crate::rig::part::{Hole, Part, Shape, numbers_of, own_numbers};
use crate::rig::value::{Given, Reader, Value};
use crate::source::{Outcome, listed};
use rijke_formula::{Kind as NameKind, Name};
use rijke_numerics::words::nearest;
use std::ops::Range;
use toml::{Spanned, Table, Value as Toml};

impl Reading<'_> {
    pub(super) fn element(&mut self, index: usize, table: Spanned<Table>) -> Outcome<()> {
        let at = table.span();
        let mut table = table.into_inner();
        let wrong = |problem| (at.clone(), problem);
        let text = |table: &mut Table, key: &'static str| match table.remove(key) {
            None => Ok(None),
            Some(Toml::String(text)) => Ok(Some(text)),
            Some(other) => {
                Err(wrong(StudyProblem::Value { key: key.into(), value: other.to_string(), need: "a text" }))
            }
        };
        let kind = text(&mut table, "type")?.ok_or_else(|| {
            wrong(StudyProblem::Missing { key: "type".into(), need: "say what the element is" })
        })?;
        let name = text(&mut table, "name")?.unwrap_or_else(|| format!("{kind}_{}", index + 1));
        self.check_name(&name).map_err(wrong)?;
        let present = text(&mut table, "present")?;
        let present = match present {
            None => None,
            Some(factor) => Some(factor_of(&self.scope, &factor).ok_or_else(|| {
                let known = listed(factors(&self.scope));
                wrong(StudyProblem::Unknown { what: "factor", name: factor, known })
            })?),
        };
        let near_field = self.plain(&mut table, "near_field", "1", &at)?;
        let free = free_numbers(&mut table, &at)?;
        let part = self.parts.len();
        self.parts.push(Part {
            name: name.clone(),
            shape: Shape::Device(Vec::new()),
            numbers: Vec::new(),
            present,
            near_field,
            hole: None,
        });
        in_any_order(&free, |key, value| self.number(part, key, value, "", &at))?;
        if kind == "duct" {
            let duct = self.duct(part, &mut table, &at)?;
            self.parts[part].shape = Shape::Duct(duct);
        } else if kind == "insert" {
            let [from, to] = ["from", "to"].map(|key| self.needed(part, &mut table, key, "m", &at));
            self.parts[part].shape = Shape::Insert(from?, to?);
        } else {
            let found = COMPACT.iter().find(|k| k.name == kind).ok_or_else(|| {
                let known = listed(["duct", "insert"].into_iter().chain(COMPACT.iter().map(|k| k.name)));
                wrong(StudyProblem::Unknown { what: "type of element", name: kind.clone(), known })
            })?;
            let places = match table.remove("at") {
                None => Vec::new(),
                Some(Toml::Array(list)) => {
                    list.iter().map(|v| self.extent(part, "at", v, "m", &at)).collect::<Outcome<_>>()?
                }
                Some(value) => vec![self.extent(part, "at", &value, "m", &at)?],
            };
            self.parts[part].shape = Shape::Device(places);
            self.compact(part, found, &mut table, &at)?;
            let number = |key: &str| self.scope.find(&self.scoped(&name, key));
            if let (true, Some(diameter)) =
                (["orifice", "side-hole"].contains(&found.name), number("diameter"))
            {
                self.parts[part].hole = Some(Hole { diameter, porosity: number("porosity") });
            }
        }
        self.finished(&table, &kind, &at)
    }

    pub(super) fn finished(&self, table: &Table, kind: &str, at: &Range<usize>) -> Outcome<()> {
        let Some(key) = table.keys().next() else { return Ok(()) };
        if let Some((_, _, need)) = REFUSED.iter().find(|(of, name, _)| *of == kind && name == key) {
            let value = table[key].to_string();
            return Err((at.clone(), StudyProblem::Value { key: key.clone(), value, need }));
        }
        let is_end = ENDS.iter().any(|k| k.name == kind);
        let of_kind = match kind {
            "duct" => {
                "length, diameter, diameter_end, area, area_end, temperature, temperature_end, temperatures, temperature_sd, gamma, gas_constant, pieces, wall, wall_factor"
            }
            "insert" => "from, to",
            "flame" => "n, reference, reference_side, length, delay_end, density, pieces",
            "side-hole" => "outlet, wall",
            "screen" => "open_area",
            "orifice" => "porosity, bias_velocity",
            "helmholtz" => "bias_velocity",
            "unflanged" => "calibration",
            _ => "",
        };
        let keys = COMPACT.iter().chain(&ENDS).find(|k| k.name == kind).map_or(&[][..], |k| k.keys);
        let function = FUNCTION.iter().find(|(name, _)| *name == kind && kind != "feedback");
        let function = function.map_or(&[][..], |(_, keys)| *keys);
        let common: &[&str] = if is_end {
            &["type", "numbers"]
        } else {
            &["at", "name", "type", "present", "near_field", "numbers"]
        };
        let all = keys.iter().map(|k| k.name).chain([of_kind]).chain(function.iter().copied());
        let known = listed(all.chain(common.iter().copied()).filter(|name| !name.is_empty()));
        Err((at.clone(), StudyProblem::Unknown { what: "key of this element", name: key.clone(), known }))
    }

    pub(super) fn check_name(&self, name: &str) -> Result<(), StudyProblem> {
        let why = "letters, digits, _ and - only, starting with a letter; upstream, downstream, ends and ducts are taken";
        let good = name.starts_with(|c: char| c.is_alphabetic())
            && name.chars().all(|c| c.is_alphanumeric() || c == '_' || c == '-')
            && !["upstream", "downstream", "ends", "ducts"].contains(&name);
        if !good {
            return Err(StudyProblem::Name { what: "part", name: name.to_owned(), why });
        }
        if self.parts.iter().any(|p| p.name == name) {
            return Err(StudyProblem::Duplicate { what: "part", name: name.to_owned() });
        }
        Ok(())
    }

    /// Names of a part in the scope: `part.number`, with `_` in the place of `-`.
    pub(super) fn scoped(&self, part: &str, key: &str) -> String {
        format!("{}.{key}", part.replace('-', "_"))
    }

    pub(super) fn own(&self, part: usize) -> Vec<(String, String)> {
        own_numbers(&self.scope, &self.parts[part])
    }

    /// The numbers that formulas of an owner may call by their bare names.
    pub(super) fn own_of(&self, owner: Owner<'_>) -> Vec<(String, String)> {
        match owner {
            Owner::Part(part) | Owner::Other { part: Some(part), .. } => self.own(part),
            Owner::Other { name, part: None, .. } => numbers_of(&self.scope, name),
        }
    }

    pub(super) fn given(
        &self,
        owner: Owner<'_>,
        key: &str,
        value: &Toml,
        unit: &str,
        at: &Range<usize>,
    ) -> Outcome<Given> {
        let own = self.own_of(owner);
        let reader = Reader { scope: &self.scope, own: &own, unknowns: self.unknowns, at: at.clone() };
        reader.given(key, value, unit)
    }

    pub(super) fn read(
        &self,
        part: usize,
        key: &str,
        value: &Toml,
        unit: &str,
        at: &Range<usize>,
    ) -> Outcome<Value> {
        let own = self.own(part);
        let reader = Reader { scope: &self.scope, own: &own, unknowns: self.unknowns, at: at.clone() };
        reader.value(key, value, unit)
    }

    /// A length, a temperature or a place, in which unknowns may stand.
    pub(super) fn extent(
        &self,
        part: usize,
        key: &str,
        value: &Toml,
        unit: &str,
        at: &Range<usize>,
    ) -> Outcome<Value> {
        let own = self.own(part);
        let reader = Reader { scope: &self.scope, own: &own, unknowns: self.unknowns, at: at.clone() };
        reader.extent(key, value, unit, self.medians)
    }

    pub(super) fn needed(
        &self,
        part: usize,
        table: &mut Table,
        key: &'static str,
        unit: &str,
        at: &Range<usize>,
    ) -> Outcome<Value> {
        let value = table.remove(key);
        let value = value.ok_or_else(|| {
            let misspelt = table.keys().find(|other| nearest(other, &[key]).is_some());
            let problem = match misspelt.cloned() {
                Some(name) => StudyProblem::Unknown { what: "key of this element", name, known: key.into() },
                None => StudyProblem::Missing {
                    key: key.into(),
                    need: "give it a number, a quantity such as \"12 mm\", or a formula",
                },
            };
            (at.clone(), problem)
        })?;
        self.extent(part, key, &value, unit, at)
    }

    /// A plain number, if it is given.
    pub(super) fn plain(
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
                StudyProblem::Value { key: key.into(), value: value.to_string(), need: "a number" },
            )),
        }
    }

    /// Adds a number to a part.
    pub(super) fn number(
        &mut self,
        part: usize,
        key: &str,
        value: &Toml,
        unit: &str,
        at: &Range<usize>,
    ) -> Outcome<()> {
        let (name, own) = (self.parts[part].name.clone(), self.own(part));
        let named = self.named(&name, &own, key, (value, unit), at)?;
        self.parts[part].numbers.push(named);
        Ok(())
    }

    /// Puts a number of a part or an end into the scope, in whose formula `own` may be called: its place
    /// there, and its value.
    pub(super) fn named(
        &mut self,
        owner: &str,
        own: &[(String, String)],
        key: &str,
        (value, unit): (&Toml, &str),
        at: &Range<usize>,
    ) -> Outcome<(usize, Value)> {
        // A table { value, unit } states the unit of a formula.
        let (stated, value) = match value.as_table().map(|t| (t.get("unit"), t.get("value"), t.len())) {
            Some((Some(Toml::String(unit)), Some(value), 2)) => (unit.clone(), value.clone()),
            _ => (unit.to_owned(), value.clone()),
        };
        let reader = Reader { scope: &self.scope, own, unknowns: self.unknowns, at: at.clone() };
        let read = reader.value(key, &value, &stated)?;
        let unit = match (&read, value.as_str().map(rijke_rig::Quantity::parse)) {
            (Value::Number(_), Some(Ok(q))) if stated.is_empty() => crate::campaign::si_text(&q.unit),
            _ => stated,
        };
        let full = self.scoped(owner, key);
        let is_end = ["upstream", "downstream"].contains(&owner);
        let meaning =
            if is_end { format!("number of the {owner} end") } else { format!("number of the part {owner}") };
        let name = Name { name: full, unit, meaning, kind: NameKind::Global };
        let place = add(&mut self.scope, "number of a part or an end", name).map_err(|p| (at.clone(), p))?;
        Ok((place, read))
    }
}

/// The numbers that a part or an end brings for its laws.
pub(super) fn free_numbers(table: &mut Table, at: &Range<usize>) -> Outcome<Table> {
    match table.remove("numbers") {
        None => Ok(Table::new()),
        Some(Toml::Table(numbers)) => Ok(numbers),
        Some(other) => {
            let (value, need) = (other.to_string(), "a table, { name = value, ... }");
            Err((at.clone(), StudyProblem::Value { key: "numbers".into(), value, need }))
        }
    }
}

/// Adds numbers of which one may name another, wherever that stands.
pub(super) fn in_any_order(numbers: &Table, mut add: impl FnMut(&str, &Toml) -> Outcome<()>) -> Outcome<()> {
    let mut waiting: Vec<(&String, &Toml)> = numbers.iter().collect();
    while !waiting.is_empty() {
        let before = waiting.len();
        let mut fault = None;
        waiting.retain(|(key, value)| match add(key, value) {
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
    Ok(())
}
