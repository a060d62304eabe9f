//! Candidates read from TOML.

#[cfg(test)]
mod tests;

use crate::formula::is_reserved;
use crate::{Candidate, Coefficient, Effect, Formula, FormulaError, Place, Scope};
use rijke_inference::{Parameter, Prior};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use toml::Spanned;

/// Candidates in the order of their file.
#[derive(Clone, Debug, Default)]
pub struct Catalogue {
    candidates: Vec<Candidate>,
    /// File and line of each candidate's id.
    places: Vec<(String, usize)>,
}

/// Why a file is not a catalogue: which file, which line, what.
#[derive(Debug, thiserror::Error)]
#[error("{file}{}: {problem}", line.map(|l| format!(", line {l}")).unwrap_or_default())]
pub struct CatalogueError {
    /// Name of the file.
    pub file: String,
    /// Line, from 1; none if the file could not be read at all.
    pub line: Option<usize>,
    /// What is wrong there.
    pub problem: Box<CatalogueProblem>,
}

/// What is wrong in a catalogue.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CatalogueProblem {
    /// The file cannot be read.
    #[error("cannot be read: {0}")]
    Unreadable(std::io::Error),
    /// Not TOML, or a key or type that does not belong there; names the known ones.
    #[error("{0}")]
    Toml(String),
    /// A formula that cannot be used.
    #[error(transparent)]
    Formula(#[from] FormulaError),
    /// Two candidates of one name.
    #[error("a second candidate is called `{0}`; give it another id")]
    Duplicate(String),
    /// A parameter that is called like a symbol or a function.
    #[error(
        "the parameter `{0}` has the name of a symbol, constant or function of formulas; call it something else"
    )]
    Reserved(String),
    /// A name that a formula could not contain.
    #[error("`{0}` cannot be the name of a parameter: use letters, digits and _, and start with a letter")]
    NotAName(String),
    /// A parameter that no formula of its candidate uses.
    #[error("the parameter `{parameter}` appears in no formula of `{candidate}`; use it or remove it")]
    Unused {
        /// The parameter.
        parameter: String,
        /// The candidate.
        candidate: String,
    },
    /// `reflection` inside the tube, or a feedback coefficient at an end.
    #[error(
        "`{coefficient}` cannot act at `{place}`: ends take `reflection`, every other place mu, mp, eu and ep"
    )]
    WrongPlace {
        /// The coefficient.
        coefficient: &'static str,
        /// The place.
        place: String,
    },
    /// An effect without a formula, or a candidate without an effect.
    #[error("nothing is affected here; give at least one of mu, mp, eu, ep (or reflection at an end)")]
    Nothing,
    /// No source.
    #[error("`cite` is empty; say where the model comes from, or \"own judgement\"")]
    NoSource,
    /// A prior that is no probability density.
    #[error("the prior of `{parameter}` is not a density: {reason}")]
    Prior {
        /// The parameter.
        parameter: String,
        /// Why.
        reason: String,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    candidate: Vec<CandidateSpec>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CandidateSpec {
    id: Spanned<String>,
    role: String,
    name: String,
    cite: Spanned<Vec<String>>,
    #[serde(default)]
    note: String,
    #[serde(default)]
    parameters: BTreeMap<String, Spanned<ParameterSpec>>,
    #[serde(default)]
    effect: Vec<Spanned<EffectSpec>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ParameterSpec {
    symbol: String,
    unit: String,
    prior: Prior,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EffectSpec {
    acts_at: Place,
    mu: Option<Spanned<String>>,
    mp: Option<Spanned<String>>,
    eu: Option<Spanned<String>>,
    ep: Option<Spanned<String>>,
    reflection: Option<Spanned<String>>,
}

impl Catalogue {
    /// Reads a file.
    ///
    /// # Errors
    /// [`CatalogueError`], with file and line.
    pub fn read(path: &Path) -> Result<Self, CatalogueError> {
        let file = path.display().to_string();
        match std::fs::read_to_string(path) {
            Ok(text) => Self::from_toml(&text, &file),
            Err(error) => Err(CatalogueError {
                file,
                line: None,
                problem: Box::new(CatalogueProblem::Unreadable(error)),
            }),
        }
    }

    /// Reads the text of a file called `file`.
    ///
    /// # Errors
    /// [`CatalogueError`], with file and line.
    pub fn from_toml(text: &str, file: &str) -> Result<Self, CatalogueError> {
        let line = |at: usize| text[..at.min(text.len())].matches('\n').count() + 1;
        let fail = |at: usize, problem| CatalogueError {
            file: file.to_owned(),
            line: Some(line(at)),
            problem: Box::new(problem),
        };
        let specs: File = toml::from_str(text).map_err(|error| {
            let at = error.span().map_or(0, |span| span.start);
            fail(at, CatalogueProblem::Toml(error.message().to_owned()))
        })?;
        let (mut candidates, mut places) = (Vec::<Candidate>::new(), Vec::new());
        for spec in specs.candidate {
            let id_at = spec.id.span().start;
            if candidates.iter().any(|c| c.id == *spec.id.get_ref()) {
                return Err(fail(id_at, CatalogueProblem::Duplicate(spec.id.into_inner())));
            }
            candidates.push(candidate(spec).map_err(|(at, problem)| fail(at.start, problem))?);
            places.push((file.to_owned(), line(id_at)));
        }
        Ok(Self { candidates, places })
    }

    /// All candidates, in the order of the file.
    #[must_use]
    pub fn candidates(&self) -> &[Candidate] {
        &self.candidates
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

    /// The file and the line, from 1, in which the candidate called `id` stands.
    #[must_use]
    pub fn place(&self, id: &str) -> Option<(&str, usize)> {
        let k = self.candidates.iter().position(|c| c.id == id)?;
        self.places.get(k).map(|(file, line)| (file.as_str(), *line))
    }

    /// Both lists, one after the other.
    #[must_use]
    pub fn joined(mut self, other: Self) -> Self {
        self.candidates.extend(other.candidates);
        self.places.extend(other.places);
        self
    }
}

type Outcome<T> = Result<T, (Range<usize>, CatalogueProblem)>;

fn candidate(spec: CandidateSpec) -> Outcome<Candidate> {
    if spec.cite.get_ref().is_empty() {
        return Err((spec.cite.span(), CatalogueProblem::NoSource));
    }
    // The order of the file, not of the alphabet: tables list parameters as their author did.
    let mut specs: Vec<_> = spec.parameters.into_iter().collect();
    specs.sort_by_key(|(_, p)| p.span().start);
    let places: Vec<Range<usize>> = specs.iter().map(|(_, p)| p.span()).collect();
    let parameters = specs.into_iter().map(|(name, p)| parameter(name, p)).collect::<Outcome<Vec<_>>>()?;
    let names: Vec<String> = parameters.iter().map(|p| p.name.clone()).collect();
    let mut used = vec![false; names.len()];
    let mut effects = Vec::new();
    for spec in spec.effect {
        effects.extend(effect(spec, &names, &mut used)?);
    }
    if effects.is_empty() {
        return Err((spec.id.span(), CatalogueProblem::Nothing));
    }
    let id = spec.id.into_inner();
    if let Some(k) = used.iter().position(|u| !u) {
        let problem = CatalogueProblem::Unused { parameter: names[k].clone(), candidate: id };
        return Err((places[k].clone(), problem));
    }
    let (role, name, cite, note) = (spec.role, spec.name, spec.cite.into_inner(), spec.note);
    Ok(Candidate { id, role, name, cite, note, parameters, effects })
}

fn parameter(name: String, spec: Spanned<ParameterSpec>) -> Outcome<Parameter> {
    let at = spec.span();
    let starts_well = name.starts_with(|c: char| c.is_alphabetic() || c == '_');
    if !starts_well || !name.chars().all(|c| c.is_alphanumeric() || c == '_') {
        return Err((at, CatalogueProblem::NotAName(name)));
    }
    if is_reserved(&name) {
        return Err((at, CatalogueProblem::Reserved(name)));
    }
    let ParameterSpec { symbol, unit, prior } = spec.into_inner();
    let parameter = Parameter::new(name, symbol, unit, prior);
    // The checks on priors are those of the inference, where they are used.
    match rijke_inference::Parameters::new(vec![parameter.clone()]) {
        Ok(_) => Ok(parameter),
        Err(error) => {
            Err((at, CatalogueProblem::Prior { parameter: parameter.name, reason: error.to_string() }))
        }
    }
}

fn effect(spec: Spanned<EffectSpec>, names: &[String], used: &mut [bool]) -> Outcome<Vec<Effect>> {
    let at = spec.span();
    let EffectSpec { acts_at, mu, mp, eu, ep, reflection } = spec.into_inner();
    let mut effects = Vec::new();
    for (coefficient, name, text) in [
        (Coefficient::Mu, "mu", mu),
        (Coefficient::Mp, "mp", mp),
        (Coefficient::Eu, "eu", eu),
        (Coefficient::Ep, "ep", ep),
        (Coefficient::Reflection, "reflection", reflection),
    ] {
        let Some(text) = text else { continue };
        if acts_at.is_end() != (coefficient == Coefficient::Reflection) {
            let place = format!("{acts_at:?}");
            return Err((text.span(), CatalogueProblem::WrongPlace { coefficient: name, place }));
        }
        let scope = Scope { parameters: names, place: acts_at, coefficient };
        let formula = Formula::parse(text.get_ref(), &scope).map_err(|error| (text.span(), error.into()))?;
        for (k, used) in used.iter_mut().enumerate() {
            *used |= formula.uses_parameter(k);
        }
        effects.push(Effect { place: acts_at, coefficient, law: Arc::new(formula) });
    }
    if effects.is_empty() { Err((at, CatalogueProblem::Nothing)) } else { Ok(effects) }
}
