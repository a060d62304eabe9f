//! From the text of `rig.toml` to a rig.

mod duct;
mod element;
mod ends;
mod instruments;
mod names;
mod owner;
mod recording;
mod shapes;
mod spread;
mod transfer;

use self::names::Names;
use self::recording::Recording;
use super::gas::{GasModel, check_lists};
use super::oscilos::Folder;
use super::part::{Instruments, Part, Shape, end_numbers};
use super::value::{Reader, Value, number};
use super::whole::Rig;
use crate::campaign::COLDEST;
use crate::doubtful::late;
use crate::law::{
    Candidate, Coefficient, Effect, Hears, Measured, Parameters, Place, SECOND, TableUse, Words, parameters,
};
use crate::names::add;
use crate::source::{Outcome, Source};
use crate::{Campaign, StudyProblem};
use rijke_formula::{Kind as NameKind, Name, Scope};
use rijke_numerics::words::of_toml;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::Path;
use toml::{Spanned, Table, Value as Toml};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    /// The name of the file, if it is left out.
    #[serde(default)]
    name: String,
    #[serde(default)]
    source: String,
    /// A folder of OSCILOS_lite beside this file; what this file says comes before what is said there.
    oscilos: Option<Spanned<String>>,
    gas: Option<Spanned<Table>>,
    search: Option<Search>,
    /// A key of network files, refused with the remedy.
    flow: Option<Spanned<Table>>,
    upstream: Option<Spanned<Table>>,
    downstream: Option<Spanned<Table>>,
    #[serde(default)]
    element: Vec<Spanned<Table>>,
    microphones: Option<Spanned<Table>>,
    thermometers: Option<Spanned<Table>>,
    #[serde(default)]
    unknown: Parameters,
    #[serde(default)]
    base: BaseNumbers,
    #[serde(default)]
    recording: Recording,
}

/// Numbers that base states bring for laws, with their units.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct BaseNumbers {
    numbers: BTreeMap<String, String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Search {
    #[serde(default, deserialize_with = "two")]
    growth_rate: Option<[f64; 2]>,
    #[serde(default, deserialize_with = "two")]
    frequency_hz: Option<[f64; 2]>,
}

/// Two numbers and no more: an array of fixed length would pass over a third.
fn two<'de, D: serde::Deserializer<'de>>(from: D) -> Result<Option<[f64; 2]>, D::Error> {
    let list = Vec::<f64>::deserialize(from)?;
    match *list {
        [low, high] if low < high => Ok(Some([low, high])),
        [low, high] => Err(serde::de::Error::custom(format!(
            "two numbers are needed, the lowest before the highest, but {low} is not below {high}"
        ))),
        _ => Err(serde::de::Error::custom(format!(
            "two numbers are needed, lowest and highest; {} stand here",
            list.len()
        ))),
    }
}

/// A law of an element that waits until all names are known.
struct Waiting {
    at: Range<usize>,
    place: String,
    coefficient: Coefficient,
    text: String,
    definitions: Vec<(String, String)>,
    part: Option<usize>,
    hears: Option<Hears>,
}

struct Reading<'a> {
    scope: Scope,
    parts: Vec<Part>,
    waiting: Vec<Waiting>,
    unknowns: &'a [String],
    /// Medians of their priors.
    medians: &'a [f64],
    /// Where tables stand that the file names.
    folder: &'a Path,
    /// Numbers that are none of a part: place in the scope, and value.
    loose: Vec<(usize, Value)>,
    /// Numbers of ends.
    of_ends: Vec<(usize, Value)>,
    /// Measured tables, what formulas call them, and where the file has them.
    tables: Vec<(String, Range<usize>, Measured)>,
    /// Delays that are plain numbers, s.
    delays: Vec<(Range<usize>, f64)>,
    is_choked: bool,
    /// Whether properties of the gas follow temperature, so that it has no gamma of its own.
    gas_follows_temperature: bool,
}

impl File {
    /// Whether a folder of OSCILOS_lite is to be read, and where that is said.
    pub(super) fn oscilos(&self) -> Option<&str> {
        self.oscilos.as_ref().map(|name| name.get_ref().as_str())
    }

    /// With what a folder says where this file says nothing. An element of a name that the folder has adds
    /// its keys to that one.
    pub(super) fn beside(mut self, folder: Folder) -> Self {
        let at = self.oscilos.as_ref().map_or(0..0, Spanned::span);
        let spanned = |table: Table| Spanned::new(at.clone(), table);
        let Folder { gas, ends: [upstream, downstream], elements } = folder;
        self.gas = self.gas.or(Some(spanned(gas)));
        self.upstream = self.upstream.or(Some(spanned(upstream)));
        self.downstream = self.downstream.or(Some(spanned(downstream)));
        let mut own = std::mem::take(&mut self.element);
        for element in elements {
            let same = |e: &Spanned<Table>| e.get_ref().get("name") == element.get("name");
            self.element.push(match own.iter().position(same) {
                Some(k) => {
                    let (at, more) = (own[k].span(), own.remove(k).into_inner());
                    let other_kind = more.get("type").is_some_and(|kind| Some(kind) != element.get("type"));
                    let mut whole = if other_kind { Table::new() } else { element };
                    whole.extend(more);
                    Spanned::new(at, whole)
                }
                None => spanned(element),
            });
        }
        self.element.extend(own);
        self
    }
}

pub(super) fn rig(mut file: File, campaign: &Campaign, source: &Source) -> Outcome<Rig> {
    if file.name.is_empty() {
        let stem = Path::new(&source.file).file_stem();
        file.name = stem.map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    }
    let Names { mut scope, factors, brought } = Names::of(campaign, file.base.numbers)?;
    if let Some(flow) = file.flow {
        let need = "left out: in a rig, and beside unknowns, the gas is at rest; in a study a candidate with `mean_flow` lets the waves run in the flow";
        return Err((
            flow.span(),
            StudyProblem::Value { key: "flow".to_owned(), value: "a table".to_owned(), need },
        ));
    }
    let second = Name {
        name: SECOND.to_owned(),
        unit: "s".into(),
        meaning: "one second, for tables".into(),
        kind: NameKind::Global,
    };
    let second = add(&mut scope, "number", second).map_err(|problem| (0..0, problem))?;
    let unknowns = parameters(file.unknown, &scope)?;
    let names: Vec<String> = unknowns.iter().map(|(p, _)| p.name.clone()).collect();
    let medians: Vec<f64> = unknowns.iter().map(|(p, _)| p.prior.quantile(0.5)).collect();
    let mut reading = Reading {
        scope,
        parts: Vec::new(),
        waiting: Vec::new(),
        unknowns: &names,
        medians: &medians,
        folder: Path::new(&source.file).parent().unwrap_or(Path::new("")),
        loose: vec![(second, Value::Number(1.0))],
        of_ends: Vec::new(),
        tables: Vec::new(),
        delays: Vec::new(),
        is_choked: false,
        gas_follows_temperature: false,
    };
    let gas_at = file.gas.as_ref().map_or(0..0, Spanned::span);
    let (gas, pressure, temperature) = reading.gas(file.gas)?;
    reading.gas_follows_temperature = matches!(gas, GasModel::Real(_));
    for (k, element) in file.element.into_iter().enumerate() {
        reading.element(k, element)?;
    }
    if !reading.parts.iter().any(|p| matches!(p.shape, Shape::Duct(_))) {
        let need = "add an [[element]] with type = \"duct\" and a length";
        return Err((gas_at, StudyProblem::Empty { what: "duct", need }));
    }
    for (place, end) in [("upstream", file.upstream), ("downstream", file.downstream)] {
        let need = "a table with the type of this end";
        let end = end.ok_or_else(|| (0..0, StudyProblem::Missing { key: format!("[{place}]"), need }))?;
        reading.end(place, end)?;
    }
    let lines = [&file.microphones, &file.thermometers]
        .map(|table| table.as_ref().map_or(0, |table| source.line(table.span().start)));
    let microphones = Instruments { line: lines[0], ..reading.instruments(file.microphones, "p")? };
    let thermometers = Instruments { line: lines[1], ..reading.instruments(file.thermometers, "T")? };
    let (effects, mut used) = reading.effects()?;
    let heard = microphones.at.iter().filter_map(Value::unknown);
    for formula in reading.parts.iter().flat_map(Part::unknown).chain(heard) {
        let named = (0..names.len()).filter(|k| formula.uses_parameter(*k));
        used.extend(named.map(|k| names[k].clone()));
    }
    if let Some((unknown, at)) = unknowns.iter().find(|(p, _)| !used.contains(&p.name)) {
        let (name, place) = (format!("${}", unknown.name), "the file".to_owned());
        return Err((at.clone(), StudyProblem::Unused { name, place }));
    }
    let search = file.search.unwrap_or(Search { growth_rate: None, frequency_hz: None });
    let hertz = search.frequency_hz.unwrap_or([10.0, 1000.0]);
    let doubts = reading.doubts(source, hertz);
    let own = Candidate {
        mean_flow: None,
        id: "rig".into(),
        role: "rig".into(),
        name: file.name.clone(),
        cite: vec![file.source.clone()],
        note: String::new(),
        extends: None,
        parameters: unknowns.into_iter().map(|(p, _)| p).collect(),
        effects,
        errors: Vec::new(),
        tolerance: None,
    };
    Ok(Rig {
        name: file.name,
        source: file.source,
        gas,
        pressure,
        temperature,
        parts: reading.parts,
        is_choked: reading.is_choked,
        loose: reading.loose,
        of_ends: reading.of_ends,
        doubts,
        own,
        microphones,
        thermometers,
        scope: reading.scope,
        factors,
        brought,
        ping_decay_times: file.recording.decay_times()?,
        arrival_setting_sd_s: file.recording.setting_sd()?,
        ping_band_hz: file.recording.band()?,
        mains_hz: file.recording.mains()?,
        search_is_stated: [search.growth_rate.is_some(), search.frequency_hz.is_some()],
        search: [search.growth_rate.unwrap_or([-500.0, 500.0]), hertz],
    })
}

impl Reading<'_> {
    /// What is doubtful of tables and delays where the search ends at these frequencies, Hz.
    fn doubts(&self, source: &Source, hertz: [f64; 2]) -> Vec<String> {
        let of_tables = self.tables.iter().flat_map(|(_, at, table)| {
            table.doubt.clone().into_iter().chain(table.beyond(hertz)).map(move |said| (at, said))
        });
        let of_delays =
            self.delays.iter().filter_map(|(at, delay)| Some((at, late("delay", *delay, hertz[1])?)));
        let said = |(at, said): (&Range<usize>, String)| {
            format!("{}, line {}: {said}", source.file, source.line(at.start))
        };
        of_tables.chain(of_delays).map(said).collect()
    }

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
                let problem =
                    StudyProblem::Value { key: key.into(), value: value.to_string(), need: "positive" };
                Err((at.clone(), problem))
            }
        };
        let pressure = number(&mut table, "pressure", "Pa", 101_325.0)?;
        let temperature = number(&mut table, "temperature", "K", 293.15)?;
        if !(COLDEST..=4000.0).contains(&temperature) {
            let (key, value) = ("temperature".to_owned(), format!("{temperature} K"));
            return Err((
                at,
                StudyProblem::Value { key, value, need: "100 to 4000 K; say the unit, as in \"20 degC\"" },
            ));
        }
        let following = ["molar_mass", "heat_capacity", "conductivity"];
        if following.iter().any(|key| table.contains_key(*key)) {
            // The same form as in the file of a rig: numbers or, for the mass, a quantity.
            if let Some(text) = table.get("molar_mass").filter(|v| v.is_str()) {
                let mass = reader.value("molar_mass", text, "kg/mol")?.at(&[]);
                table.insert("molar_mass".into(), Toml::Float(mass));
            }
            check_lists(&table).map_err(|problem| (at.clone(), problem))?;
            let gas = rijke_rig::Gas::deserialize(Toml::Table(table))
                .map_err(|error| (at.clone(), StudyProblem::Toml(of_toml(error.message()))))?;
            gas.validate().map_err(|(key, problem)| (at, StudyProblem::Toml(format!("{key}: {problem}"))))?;
            return Ok((GasModel::Real(gas), pressure, temperature));
        }
        let gamma = number(&mut table, "gamma", "1", 1.4)?;
        let constant = number(&mut table, "gas_constant", "J/(kg K)", 287.05)?;
        let viscosity = number(&mut table, "viscosity", "Pa s", 1.813e-5)?;
        let prandtl = number(&mut table, "prandtl", "1", 0.71)?;
        if gamma <= 1.0 {
            let problem =
                StudyProblem::Value { key: "gamma".into(), value: gamma.to_string(), need: "above 1" };
            return Err((at, problem));
        }
        if let Some(key) = table.keys().next() {
            let known = "pressure, temperature, gamma, gas_constant, viscosity, prandtl; or molar_mass, heat_capacity, \
                         viscosity, conductivity"
                .into();
            return Err((at, StudyProblem::Unknown { what: "key of [gas]", name: key.clone(), known }));
        }
        Ok((
            GasModel::Perfect { gamma, constant, viscosity: [viscosity, temperature], prandtl },
            pressure,
            temperature,
        ))
    }

    /// The laws of all elements, and the unknowns that they use.
    fn effects(&mut self) -> Outcome<(Vec<Effect>, BTreeSet<String>)> {
        let mut used = BTreeSet::new();
        let mut effects = Vec::new();
        for waiting in std::mem::take(&mut self.waiting) {
            let Waiting { at, place: place_text, coefficient, text, definitions, part, hears } = waiting;
            let place = Place::parse(&place_text, &self.parts).map_err(|problem| (at.clone(), problem))?;
            let own = part.map_or_else(|| end_numbers(&self.scope, &place), |part| self.own(part));
            let words = Words {
                scope: &self.scope,
                parameters: self.unknowns,
                definitions: &definitions,
                own: &own,
                own_first: true,
            };
            let mut named = BTreeSet::new();
            let law = words.law(&text, &place, at.clone(), &place_text, &mut named)?;
            let measured = |(.., table): &(String, Range<usize>, Measured)| {
                let argument = words.law("s", &place, at.clone(), &place_text, &mut BTreeSet::new())?;
                Ok(TableUse { name: String::new(), band_hz: table.band, argument })
            };
            let of_the_law = self.tables.iter().filter(|(name, ..)| named.contains(name));
            let tables = of_the_law.map(measured).collect::<Outcome<_>>()?;
            let named = |k: &usize| law.uses_parameter(*k);
            used.extend((0..self.unknowns.len()).filter(named).map(|k| self.unknowns[k].clone()));
            effects.push(Effect { place, place_text, coefficient, law, hears, tables });
        }
        Ok((effects, used))
    }
}

/// [re, im] as a formula.
fn complex(value: Toml) -> Toml {
    match value.as_array().map(Vec::as_slice) {
        Some([re, im]) => match (number(re), number(im)) {
            (Some(re), Some(im)) => Toml::String(format!("({re:e}) + i*({im:e})")),
            _ => value,
        },
        _ => value,
    }
}
