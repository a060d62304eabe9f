//! What an element brings: the laws of ducts and devices.

use super::owner::Owner;
use super::{Reading, Waiting, complex};
use crate::StudyProblem;
use crate::law::{Coefficient, Hears, words};
use crate::names::add;
use crate::rig::elements::{
    FUNCTION, HOLE_OUTLETS, Key, Kind, PLATE, PLATE_OF_HOLES, SCREEN_LOSS, SHED, SIDE_HOLE, WALLS, fault_of,
};
use crate::rig::value::{Given, Value};
use crate::source::{Outcome, listed};
use rijke_formula::{Kind as NameKind, Name};
use std::ops::Range;
use toml::{Table, Value as Toml};

impl Reading<'_> {
    /// A number of an element, for its laws: as a number of its part, or, where it needs more than the
    /// operating point, as a named subexpression.
    pub(super) fn definition(
        &mut self,
        part: usize,
        key: &str,
        unit: &str,
        value: &Toml,
        at: &Range<usize>,
    ) -> Outcome<Vec<(String, String)>> {
        let given = self.given(Owner::Part(part), key, value, unit, at)?;
        in_range(key, &given, at)?;
        match given {
            // An unknown that is called as the number is it.
            Given::Law(text) if text.trim() == key => Ok(Vec::new()),
            Given::Law(text) => Ok(vec![(key.to_owned(), text)]),
            Given::Value(_) => self.number(part, key, value, unit, at).map(|()| Vec::new()),
        }
    }

    /// Refuses an unknown that is called as a number of the element and is not it: formulas of the element
    /// would take the one for the other.
    fn no_clash(&self, table: &Table, at: &Range<usize>) -> Outcome<()> {
        let texts = table.values().filter_map(Toml::as_str);
        for name in texts.flat_map(|text| text.split('$').skip(1)).filter_map(|rest| words(rest).next()) {
            let other = table.get(name).filter(|v| v.as_str().is_none_or(|t| t.trim() != format!("${name}")));
            if other.is_some() && self.unknowns.iter().any(|u| u == name) {
                return Err((at.clone(), StudyProblem::Clash { name: name.to_owned() }));
            }
        }
        Ok(())
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
        self.waiting.push(Waiting { at, place, coefficient, text, definitions, part, hears: None });
    }

    pub(super) fn compact(
        &mut self,
        part: usize,
        kind: &Kind,
        table: &mut Table,
        at: &Range<usize>,
    ) -> Outcome<()> {
        self.no_clash(table, at)?;
        let mut definitions = Vec::new();
        if kind.name == "feedback" {
            return self.feedback(part, kind, table, at);
        }
        let mut hears = None;
        if kind.name == "flame" {
            hears = self.reference(part, table, at)?;
            let delayed = table.contains_key("delay");
            definitions.extend(self.flame(part, table, at)?);
            let spread = self.spread(part, table, &mut definitions, delayed, at)?;
            if spread.is_some() && hears.as_ref().is_some_and(|hears| hears.downstream) {
                let (key, value) = ("reference_side".to_owned(), "downstream".to_owned());
                let need = "left out: a flame with `length` answers to a velocity upstream";
                return Err((at.clone(), StudyProblem::Value { key, value, need }));
            }
            if let Some(hears) = &mut hears {
                hears.spread = spread;
            }
        }
        if kind.name == "screen"
            && let Some(open_area) = table.remove("open_area")
        {
            if table.contains_key("loss") {
                let need = "give one of the two";
                return Err((at.clone(), StudyProblem::Missing { key: "loss or open_area".into(), need }));
            }
            definitions.extend(self.definition(part, "open_area", "1", &open_area, at)?);
            definitions.push(("loss".into(), SCREEN_LOSS.into()));
        }
        let mut plate = PLATE;
        if kind.name == "orifice"
            && let Some(porosity) = table.remove("porosity")
        {
            definitions.extend(self.definition(part, "porosity", "1", &porosity, at)?);
            plate[..PLATE_OF_HOLES.len()].copy_from_slice(&PLATE_OF_HOLES);
        }
        for key in kind.keys {
            if definitions.iter().any(|(name, _)| name == key.name) {
                continue;
            }
            definitions.extend(self.key(part, key, table, at)?);
        }
        if kind.name == "side-hole" {
            let [viscous, thermal] = hole_wall(table, at)?;
            definitions.extend([("hole_viscous".to_owned(), viscous), ("hole_thermal".to_owned(), thermal)]);
            definitions.push(("hole_outside".to_owned(), one_of_these(table, "outlet", &HOLE_OUTLETS, at)?));
            definitions.extend(SIDE_HOLE.map(|(name, text)| (name.to_owned(), text.to_owned())));
        }
        if kind.name == "orifice" {
            definitions.extend(plate.map(|(name, text)| (name.to_owned(), text.to_owned())));
        }
        if let Some((_, shed)) = SHED.iter().find(|(name, _)| *name == kind.name) {
            let text = match table.remove("bias_velocity") {
                None => "0",
                Some(velocity) => {
                    definitions.extend(self.definition(part, "bias_velocity", "m/s", &velocity, at)?);
                    shed
                }
            };
            definitions.push(("shed".to_owned(), text.to_owned()));
        }
        let name = self.parts[part].name.clone();
        for (coefficient, law) in kind.laws {
            self.wait(at, name.clone(), *coefficient, (*law).to_owned(), &definitions, Some(part));
            if let Some(waiting) = self.waiting.last_mut() {
                waiting.hears.clone_from(&hears);
            }
        }
        Ok(())
    }

    /// The velocity that a flame answers to, if it is not that at the flame.
    fn reference(&mut self, part: usize, table: &mut Table, at: &Range<usize>) -> Outcome<Option<Hears>> {
        let side = table.remove("reference_side");
        let downstream = match side.as_ref().map(|side| side.as_str().unwrap_or("?")) {
            None | Some("upstream") => false,
            Some("downstream") => true,
            Some(other) => {
                let (what, known) = ("side of a reference", "upstream, downstream".to_owned());
                return Err((at.clone(), StudyProblem::Unknown { what, name: other.to_owned(), known }));
            }
        };
        let distance = table.remove("reference").unwrap_or(Toml::Integer(0));
        match self.read(part, "reference", &distance, "m", at)? {
            Value::Number(v) if v < 0.0 => {
                let (key, value) = ("reference".to_owned(), v.to_string());
                let need = "a distance: zero or more; `reference_side` says where";
                Err((at.clone(), StudyProblem::Value { key, value, need }))
            }
            Value::Number(0.0) if !downstream && !table.contains_key("length") => Ok(None),
            _ => {
                self.number(part, "reference", &distance, "m", at)?;
                let place = self.parts[part].numbers.last().map_or(0, |(place, _)| *place);
                let of_mean = table.contains_key("n");
                Ok(Some(Hears { distance: place, downstream, of_mean, spread: None }))
            }
        }
    }

    /// The four couplings as they are given: numbers, [re, im], formulas, or functions of s. Their keys are
    /// names that formulas know as something else, as `mu` for the viscosity, so that they are no numbers of
    /// the part.
    fn feedback(&mut self, part: usize, kind: &Kind, table: &mut Table, at: &Range<usize>) -> Outcome<()> {
        let name = self.parts[part].name.clone();
        let keys = FUNCTION.iter().find(|(name, _)| *name == kind.name).map_or(&[][..], |(_, keys)| *keys);
        for (key, (coefficient, law)) in kind.keys.iter().zip(kind.laws) {
            let Some(value) = table.remove(key.name) else { continue };
            // A pair is a formula of plain numbers, which has any unit.
            let unit = if value.is_array() { "" } else { key.unit };
            let value = complex(value);
            let prefix = format!("{}_", key.name);
            let coupling = format!("coupling_{}", key.name);
            let definitions = match value {
                // A table over a factor is a number.
                Toml::Table(mut function) if !function.contains_key("over") => {
                    let owner = Owner::Other { name: &name, prefix: &prefix, part: Some(part) };
                    let mut all = self.transfer(owner, &mut function, keys, at)?;
                    if let Some(other) = function.keys().next() {
                        let (what, known) = ("key of a coupling", listed(keys.iter().copied()));
                        return Err((at.clone(), StudyProblem::Unknown { what, name: other.clone(), known }));
                    }
                    all.push((coupling, format!("{prefix}transfer")));
                    all
                }
                value => {
                    let owner = Owner::Other { name: &name, prefix: "coupling_", part: Some(part) };
                    self.defined(owner, key.name, unit, &value, at)?
                }
            };
            self.wait(at, name.clone(), *coefficient, (*law).to_owned(), &definitions, Some(part));
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
                return Err((at.clone(), StudyProblem::Missing { key: key.name.into(), need }));
            }
        };
        self.definition(part, key.name, key.unit, &value, at)
    }

    /// A number of an owner for its laws, as [`Reading::definition`] makes it of one of a part.
    pub(super) fn defined(
        &mut self,
        owner: Owner<'_>,
        key: &str,
        unit: &str,
        value: &Toml,
        at: &Range<usize>,
    ) -> Outcome<Vec<(String, String)>> {
        let name = match owner {
            Owner::Part(part) => return self.definition(part, key, unit, value, at),
            Owner::Other { name, .. } => name,
        };
        let given = self.given(owner, key, value, unit, at)?;
        in_range(key, &given, at)?;
        let text = match given {
            Given::Law(text) => text,
            Given::Value(Value::Number(v)) => format!("({v:e})"),
            Given::Value(Value::Formula(f) | Value::Unknown(f, _)) => f.source().to_owned(),
            Given::Value(table) => self.loose(name, &owner.name(key), unit, table, at)?,
        };
        Ok(vec![(owner.name(key), text)])
    }

    /// Puts a number into the scope that is none of a part, and returns its name there.
    pub(super) fn loose(
        &mut self,
        owner: &str,
        key: &str,
        unit: &str,
        value: Value,
        at: &Range<usize>,
    ) -> Outcome<String> {
        let full = self.scoped(owner, key);
        let meaning = format!("number of {owner}");
        let name = Name { name: full.clone(), unit: unit.to_owned(), meaning, kind: NameKind::Global };
        let place = add(&mut self.scope, "number", name).map_err(|p| (at.clone(), p))?;
        self.loose.push((place, value));
        Ok(full)
    }
}

/// Refuses a number that the key cannot have.
pub(super) fn in_range(key: &str, given: &Given, at: &Range<usize>) -> Outcome<()> {
    let Given::Value(Value::Number(value)) = given else { return Ok(()) };
    match fault_of(key, *value) {
        None => Ok(()),
        Some(need) => {
            Err((at.clone(), StudyProblem::Value { key: key.to_owned(), value: value.to_string(), need }))
        }
    }
}

/// Viscous and thermal loss per metre of a side hole, those of a duct of its diameter.
fn hole_wall(table: &mut Table, at: &Range<usize>) -> Outcome<[String; 2]> {
    let of_hole = |law: &str| law.replace("(wall_factor)*", "").replace('D', "(diameter)");
    let laws = WALLS.map(|(name, laws)| (name, laws.map(of_hole)));
    let part = |k: usize| -> Vec<(&str, &str)> {
        std::iter::once(("none", "0"))
            .chain(laws.iter().map(|(name, law)| (*name, law[k].as_str())))
            .collect()
    };
    let mut same = table.clone();
    let viscous = one_of_these(table, "wall", &part(0), at)?;
    Ok([viscous, one_of_these(&mut same, "wall", &part(1), at)?])
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
        (at.clone(), StudyProblem::Unknown { what: key, name: wanted, known })
    })
}
