//! Candidates read from TOML.

use crate::head::ErrorTerm;
use crate::law::{
    Candidate, Coefficient, Effect, MeanFlow, Measured, Parameters, Place, SECOND, TableUse, check_name,
    parameters, words,
};
use crate::plan::SdSpec;
use crate::rig::Rig;
use crate::source::{Outcome, Source, listed};
use crate::{StudyError, StudyProblem};
use rijke_inference::Parameter;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::Path;
use toml::{Spanned, Value as Toml};

/// Candidates in the order of their files.
#[derive(Clone, Debug, Default)]
pub struct Catalogue {
    candidates: Vec<Candidate>,
    /// File and line of each candidate's id.
    places: Vec<(String, usize)>,
    /// What is doubtful but possible, each in a sentence with its file and line.
    pub doubts: Vec<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    candidate: Vec<Spec>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Spec {
    id: Spanned<String>,
    role: String,
    name: String,
    cite: Spanned<Vec<String>>,
    #[serde(default)]
    note: String,
    /// The candidate of another role whose place it takes.
    extends: Option<String>,
    /// Whether waves are those of a mean flow.
    mean_flow: Option<MeanFlow>,
    #[serde(default)]
    parameters: Parameters,
    /// Named subexpressions.
    #[serde(default, rename = "where")]
    definitions: BTreeMap<String, Spanned<String>>,
    /// Measured functions of s.
    #[serde(default)]
    tables: BTreeMap<String, Spanned<TableSpec>>,
    #[serde(default)]
    effect: Vec<Spanned<EffectSpec>>,
    /// Whether it is a measuring head, whose errors stand in `error`; a perfect one has none.
    #[serde(default)]
    head: bool,
    #[serde(default)]
    error: Vec<Spanned<ErrorSpec>>,
}

/// A measured function of s.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TableSpec {
    /// Rows, or the name of a file beside that of the candidate.
    table: Toml,
    tolerance: Option<Toml>,
    /// What it is a function of: s, or s in the time scale of another flow.
    #[serde(default = "of_s")]
    of: String,
}

fn of_s() -> String {
    "s".to_owned()
}

/// An error term of a measuring head as files have it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ErrorSpec {
    power: i32,
    functions: usize,
    sd: SdSpec,
}

impl Catalogue {
    /// Reads a file of candidates for a rig.
    ///
    /// # Errors
    /// File, line and remedy.
    pub fn read(path: &Path, rig: &Rig) -> Result<Self, StudyError> {
        Self::parse(&Source::read(path)?, rig)
    }

    pub(crate) fn parse(source: &Source, rig: &Rig) -> Result<Self, StudyError> {
        let specs: File = source.toml()?;
        let mut all = Self::default();
        for spec in specs.candidate {
            let at = spec.id.span().start;
            let candidate = source.located(candidate(spec, rig, source, &mut all.doubts))?;
            if all.get(&candidate.id).is_some() {
                return Err(
                    source.fail(at, StudyProblem::Duplicate { what: "candidate", name: candidate.id })
                );
            }
            all.candidates.push(candidate);
            all.places.push((source.file.clone(), source.line(at)));
        }
        Ok(all)
    }

    /// The candidate called `id`, of this role.
    ///
    /// # Errors
    /// [`StudyProblem`] with the candidates of the role, or the role that it has.
    pub fn of_role(&self, role: &str, id: &str) -> Result<&Candidate, StudyProblem> {
        match self.get(id) {
            Some(c) if c.role == role => Ok(c),
            Some(c) => Err(StudyProblem::Value {
                key: format!("with.{role}"),
                value: format!("{id}, whose role is {}", c.role),
                need: "a candidate of that role",
            }),
            None => {
                let known = listed(self.competing(role).iter().map(|c| c.id.as_str()));
                Err(StudyProblem::Unknown { what: "candidate", name: id.to_owned(), known })
            }
        }
    }

    /// All candidates, in order.
    #[must_use]
    pub fn candidates(&self) -> &[Candidate] {
        &self.candidates
    }

    /// Checks that some candidate has this role.
    ///
    /// # Errors
    /// [`StudyProblem::Unknown`] with the roles that there are.
    pub fn known_role(&self, role: &str) -> Result<(), StudyProblem> {
        if self.candidates.iter().any(|c| c.role == role) {
            return Ok(());
        }
        if self.candidates.is_empty() {
            let need = "write the laws that compete to candidates/*.toml, each with its role";
            return Err(StudyProblem::Empty { what: "candidate", need });
        }
        Err(StudyProblem::Unknown { what: "role", name: role.to_owned(), known: listed(self.roles()) })
    }

    /// Checks that of the candidates `among` which a stage chooses, unless there are none, every role that
    /// competes has one: else no model could be made of them.
    ///
    /// # Errors
    /// [`StudyProblem::Value`].
    pub(crate) fn among_all(&self, compete: &[String], among: &[String]) -> Result<(), StudyProblem> {
        let has_one = |role: &&String| self.competing(role).iter().any(|c| among.contains(&c.id));
        match compete.iter().find(|role| !among.is_empty() && !has_one(role)) {
            None => Ok(()),
            Some(role) => Err(StudyProblem::Value {
                key: "among".to_owned(),
                value: format!("without a candidate of role {role}"),
                need: "one or more candidates of every role that competes",
            }),
        }
    }

    /// The candidates that compete for one role.
    #[must_use]
    pub fn competing(&self, role: &str) -> Vec<&Candidate> {
        self.candidates.iter().filter(|c| c.role == role).collect()
    }

    /// The candidate called `id`.
    #[must_use]
    pub fn get(&self, id: &str) -> Option<&Candidate> {
        self.candidates.iter().find(|c| c.id == id)
    }

    /// File and line of the candidate called `id`.
    #[must_use]
    pub fn place(&self, id: &str) -> Option<(&str, usize)> {
        let k = self.candidates.iter().position(|c| c.id == id)?;
        self.places.get(k).map(|(file, line)| (file.as_str(), *line))
    }

    /// Every role, in order, each once.
    #[must_use]
    pub fn roles(&self) -> Vec<&str> {
        let mut seen: Vec<&str> = Vec::new();
        for candidate in &self.candidates {
            if !seen.contains(&candidate.role.as_str()) {
                seen.push(&candidate.role);
            }
        }
        seen
    }

    /// Adds the candidates of another file.
    ///
    /// # Errors
    /// [`StudyProblem::Duplicate`] at the second of two candidates with one id.
    pub fn join(&mut self, other: Self) -> Result<(), StudyError> {
        self.doubts.extend(other.doubts);
        for (candidate, (file, line)) in other.candidates.into_iter().zip(other.places) {
            if self.get(&candidate.id).is_some() {
                let problem = Box::new(StudyProblem::Duplicate { what: "candidate", name: candidate.id });
                return Err(StudyError { file, line: Some(line), problem });
            }
            self.candidates.push(candidate);
            self.places.push((file, line));
        }
        Ok(())
    }
}

fn candidate(spec: Spec, rig: &Rig, source: &Source, doubts: &mut Vec<String>) -> Outcome<Candidate> {
    if spec.cite.get_ref().iter().all(|c| c.trim().is_empty()) {
        let need = "say where the model comes from, or \"own judgement\"";
        return Err((spec.cite.span(), StudyProblem::Missing { key: "cite".into(), need }));
    }
    let parameters = parameters(spec.parameters, &rig.scope)?;
    let names: Vec<String> = parameters.iter().map(|(p, _)| p.name.clone()).collect();
    // The order of the file, so that a definition may use those before it.
    let mut definitions: Vec<_> = spec.definitions.into_iter().collect();
    let folder = Path::new(&source.file).parent().unwrap_or(Path::new(""));
    let mut stated: Option<f64> = None;
    let mut tables = Vec::new();
    for (name, table) in spec.tables {
        let (at, TableSpec { table, tolerance, of }) = (table.span(), table.into_inner());
        let argument = format!("({of})*{SECOND}");
        let measured = Measured::read(&table, tolerance.as_ref(), &argument, folder)
            .map_err(|problem| (at.clone(), problem))?;
        stated = measured.stated.into_iter().chain(stated).reduce(f64::max);
        let beyond = measured.beyond(rig.search[1]).filter(|_| of == "s");
        let line = source.line(at.start);
        let said = measured.doubt.iter().chain(&beyond);
        doubts.extend(said.map(|said| format!("{}, line {line}: table `{name}`: {said}", source.file)));
        tables.push(NamedTable { name: name.clone(), band_hz: measured.band, of });
        definitions.push((name, Spanned::new(at, measured.text)));
    }
    // A table comes after the names that its argument uses, wherever these are written.
    let places: BTreeMap<&str, usize> =
        definitions.iter().map(|(name, text)| (name.as_str(), text.span().start)).collect();
    let after = |name: &str| {
        let of = tables.iter().find(|table| table.name == name).map_or("", |table| table.of.as_str());
        words(of).chain([name]).filter_map(|word| places.get(word).copied()).max()
    };
    let is_table = |name: &String| tables.iter().any(|table: &NamedTable| table.name == *name);
    let order: Vec<_> = definitions.iter().map(|(name, _)| (after(name), is_table(name))).collect();
    let mut ordered: Vec<_> = order.into_iter().zip(definitions).collect();
    ordered.sort_by_key(|(place, _)| *place);
    let definitions: Vec<_> = ordered.into_iter().map(|(_, definition)| definition).collect();
    for (name, text) in &definitions {
        check_name("definition", name, &rig.scope).map_err(|problem| (text.span(), problem))?;
    }
    let places: Vec<Range<usize>> = definitions.iter().map(|(_, text)| text.span()).collect();
    let definitions: Vec<(String, String)> =
        definitions.into_iter().map(|(name, text)| (name, text.into_inner())).collect();
    let mut used = BTreeSet::new();
    let mut effects = Vec::new();
    for effect in spec.effect {
        effects.extend(read_effect(effect, rig, &parameters, &names, (&definitions, &tables), &mut used)?);
    }
    let id = spec.id.get_ref().clone();
    let errors = spec.error.into_iter().map(error_term).collect::<Outcome<Vec<_>>>()?;
    if effects.is_empty() && !spec.head && spec.mean_flow.is_none() {
        let need = "add a [[candidate.effect]] with acts_at and one of mu, mp, eu, ep, reflection, forward, backward";
        return Err((spec.id.span(), StudyProblem::Empty { what: "effect", need }));
    }
    for (k, (parameter, at)) in parameters.iter().enumerate() {
        if !effects.iter().any(|e| e.law.uses_parameter(k)) {
            let (name, place) = (parameter.name.clone(), format!("any formula of `{id}`"));
            return Err((at.clone(), StudyProblem::Unused { name, place }));
        }
    }
    for ((name, _), at) in definitions.iter().zip(places) {
        if !used.contains(name) {
            let (name, place) = (name.clone(), format!("any formula of `{id}`"));
            return Err((at, StudyProblem::Unused { name, place }));
        }
    }
    Ok(Candidate {
        mean_flow: spec.mean_flow,
        id,
        role: spec.role,
        name: spec.name,
        cite: spec.cite.into_inner(),
        note: spec.note,
        extends: spec.extends,
        parameters: parameters.into_iter().map(|(p, _)| p).collect(),
        effects,
        errors,
        tolerance: stated,
    })
}

/// Most polynomials of one error term: more bend faster than data can tell.
const MOST_FUNCTIONS: usize = 60;

fn error_term(spec: Spanned<ErrorSpec>) -> Outcome<ErrorTerm> {
    let at = spec.span();
    let ErrorSpec { power, functions, sd } = spec.into_inner();
    let value = |key: &str, value: String, need| {
        Err((at.clone(), StudyProblem::Value { key: key.into(), value, need }))
    };
    if !(0..=4).contains(&power) {
        return value("power", power.to_string(), "a power of R from 0 to 4");
    }
    if !(1..=MOST_FUNCTIONS).contains(&functions) {
        return value("functions", functions.to_string(), "a number of polynomials from 1 to 60");
    }
    Ok(ErrorTerm { power, functions, sd })
}

/// The keys of an effect, each with its place.
type EffectSpec = BTreeMap<String, Spanned<Toml>>;

/// A measured table of a candidate.
struct NamedTable {
    /// What formulas call it.
    name: String,
    /// Its first and last frequency, Hz.
    band_hz: [f64; 2],
    /// The formula that stands in the place of s.
    of: String,
}

fn read_effect(
    effect: Spanned<EffectSpec>,
    rig: &Rig,
    parameters: &[(Parameter, Range<usize>)],
    names: &[String],
    (definitions, tables): (&[(String, String)], &[NamedTable]),
    used: &mut BTreeSet<String>,
) -> Outcome<Vec<Effect>> {
    let at = effect.span();
    let mut table = effect.into_inner();
    let known = || listed(["acts_at"].into_iter().chain(Coefficient::ALL.iter().map(|c| c.0)));
    let strange = |(key, value): (&String, &Spanned<Toml>)| {
        (value.span(), StudyProblem::Unknown { what: "key of an effect", name: key.clone(), known: known() })
    };
    let is_known = |key: &str| key == "acts_at" || Coefficient::ALL.iter().any(|c| c.0 == key);
    if let Some(other) = table.iter().find(|(key, _)| !is_known(key)) {
        return Err(strange(other));
    }
    let place = table.remove("acts_at").map(|text| (text.span(), text.into_inner()));
    let Some((place_at, Toml::String(place_text))) = place else {
        return Err((
            at,
            StudyProblem::Missing { key: "acts_at".into(), need: "name a part or a place of it" },
        ));
    };
    let place = Place::parse(&place_text, &rig.parts).map_err(|problem| (place_at, problem))?;
    let units: Vec<&str> = parameters.iter().map(|(p, _)| p.unit.as_str()).collect();
    let own = rig.own_numbers(&place);
    let words = rig.words(names, definitions, &own);
    let mut effects = Vec::new();
    for (key, coefficient) in Coefficient::ALL {
        let Some(value) = table.remove(key) else { continue };
        let at = value.span();
        let text = match value.into_inner() {
            Toml::String(text) => text,
            Toml::Integer(v) => v.to_string(),
            Toml::Float(v) => format!("{v:e}"),
            other => {
                let need = "a formula";
                return Err((at, StudyProblem::Value { key: key.into(), value: other.to_string(), need }));
            }
        };
        let fits = if coefficient.is_wave() {
            place.is_duct()
        } else {
            place.is_end() == (coefficient == Coefficient::Reflection)
        };
        if !fits {
            return Err((at, StudyProblem::WrongPlace { coefficient: key, place: place_text }));
        }
        let mut own = BTreeSet::new();
        let law = words.law(&text, &place, at.clone(), key, &mut own)?;
        if let Some(fault) = law.unit_fault(&rig.scope, &units, coefficient.unit(place.is_along())) {
            return Err((at, StudyProblem::UnitOfLaw { key: key.into(), place: place_text, fault }));
        }
        let measured = |table: &NamedTable| {
            let argument = words.law(&table.of, &place, at.clone(), &table.name, &mut BTreeSet::new())?;
            Ok(TableUse { name: table.name.clone(), band_hz: table.band_hz, argument })
        };
        let of_the_law = tables.iter().filter(|table| own.contains(&table.name));
        let tables = of_the_law.map(measured).collect::<Outcome<_>>()?;
        used.append(&mut own);
        let (place, place_text) = (place.clone(), place_text.clone());
        effects.push(Effect { place, place_text, coefficient, law, hears: None, tables });
    }
    Ok(effects)
}
