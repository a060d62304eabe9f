//! Which candidates make the model, and which of their parameters are free.

use crate::ModelError;
use rijke_candidates::{Candidate, Place};
use rijke_inference::Parameter;
use rijke_numerics::{C64, Jet, JetSpace};
use rijke_rig::Rig;
use serde::{Deserialize, Serialize};

/// How losses along the tube are discretised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// In the propagation: the exact lossy line. `elements` equal elements where the gas varies; none are needed where
    /// it does not.
    Line {
        /// Number of equal elements along the tube when the gas is not uniform.
        elements: usize,
    },
    /// The paper's: jumps between `elements` equal elements, each with the loss of one element. First-order accurate,
    /// because the half elements at the ends get no loss.
    Lumped {
        /// Number of equal elements, 40 in the paper.
        elements: usize,
    },
}

/// A rig and one candidate per role, with some parameters held fixed.
#[derive(Clone, Debug)]
pub struct Assembly {
    /// The rig.
    pub rig: Rig,
    /// How losses are discretised.
    pub scheme: Scheme,
    candidates: Vec<Candidate>,
    /// For each candidate and each of its parameters.
    sources: Vec<Vec<Source>>,
    free: Vec<Parameter>,
    /// For each candidate, see [`Assembly::seeds`].
    seeds: Vec<Vec<usize>>,
    seeds_of_tube: Vec<usize>,
}

/// Where the value of a parameter comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Source {
    /// Number in the list of free parameters.
    Free(usize),
    /// Held at a value.
    Fixed(f64),
}

impl Assembly {
    /// One candidate per role; all their parameters are free, in the order given.
    ///
    /// # Errors
    /// [`ModelError::SameRole`], [`ModelError::SameName`].
    pub fn new(rig: Rig, candidates: Vec<Candidate>) -> Result<Self, ModelError> {
        for (k, candidate) in candidates.iter().enumerate() {
            for earlier in &candidates[..k] {
                let (first, second) = (earlier.id.clone(), candidate.id.clone());
                if earlier.role == candidate.role {
                    return Err(ModelError::SameRole { role: candidate.role.clone(), first, second });
                }
                let twice = |p: &&Parameter| earlier.parameters.iter().any(|e| e.name == p.name);
                if let Some(parameter) = candidate.parameters.iter().find(twice) {
                    return Err(ModelError::SameName { parameter: parameter.name.clone(), first, second });
                }
            }
        }
        let scheme = Scheme::Line { elements: 10 };
        let sources = candidates.iter().map(|c| vec![Source::Fixed(f64::NAN); c.parameters.len()]).collect();
        let (free, seeds, seeds_of_tube) = (Vec::new(), Vec::new(), Vec::new());
        let mut assembly = Self { rig, scheme, candidates, sources, free, seeds, seeds_of_tube };
        assembly.number(|_| None);
        Ok(assembly)
    }

    /// The same assembly with the parameter `name` held at `value`.
    ///
    /// # Errors
    /// [`ModelError::UnknownParameter`].
    pub fn fixed(mut self, name: &str, value: f64) -> Result<Self, ModelError> {
        let names: Vec<&str> =
            self.candidates.iter().flat_map(|c| &c.parameters).map(|p| p.name.as_str()).collect();
        if !names.contains(&name) {
            return Err(ModelError::UnknownParameter { name: name.to_owned(), known: names.join(", ") });
        }
        self.number(|parameter| (parameter == name).then_some(value));
        Ok(self)
    }

    /// The same assembly with another discretisation.
    #[must_use]
    pub fn with_scheme(self, scheme: Scheme) -> Self {
        Self { scheme, ..self }
    }

    /// The free parameters with their priors, in the order in which [`crate::PointModel::respond`] wants their values.
    #[must_use]
    pub fn parameters(&self) -> &[Parameter] {
        &self.free
    }

    /// The candidates.
    #[must_use]
    pub fn candidates(&self) -> &[Candidate] {
        &self.candidates
    }

    /// Names and values of the parameters that are held.
    #[must_use]
    pub fn held(&self) -> Vec<(String, f64)> {
        let both = self.candidates.iter().zip(&self.sources);
        let all = both.flat_map(|(c, sources)| c.parameters.iter().zip(sources));
        let held = |(p, source): (&Parameter, &Source)| match *source {
            Source::Fixed(value) => Some((p.name.clone(), value)),
            Source::Free(_) => None,
        };
        all.filter_map(held).collect()
    }

    /// Numbers the free parameters again, holding those for which `fix` has a value.
    fn number(&mut self, fix: impl Fn(&str) -> Option<f64>) {
        self.free.clear();
        for (candidate, sources) in self.candidates.iter().zip(&mut self.sources) {
            for (parameter, source) in candidate.parameters.iter().zip(sources) {
                match (fix(&parameter.name), *source) {
                    (Some(value), _) => *source = Source::Fixed(value),
                    (None, Source::Fixed(value)) if !value.is_nan() => {}
                    _ => {
                        *source = Source::Free(self.free.len());
                        self.free.push(parameter.clone());
                    }
                }
            }
        }
        let own = |sources: &Vec<Source>| {
            let free = |s: &Source| if let Source::Free(i) = *s { Some(i) } else { None };
            sources.iter().filter_map(free).collect::<Vec<usize>>()
        };
        let walls = self.candidates.iter().zip(&self.sources);
        let walls = walls.filter(|(c, _)| c.effects.iter().any(|e| e.place == Place::Tube));
        self.seeds_of_tube = walls.flat_map(|(_, s)| own(s)).collect();
        let with_wall = |sources: &Vec<Source>| {
            let mut all = [own(sources), self.seeds_of_tube.clone()].concat();
            all.sort_unstable();
            all.dedup();
            all
        };
        self.seeds = self.sources.iter().map(with_wall).collect();
    }

    /// The free parameters on which the laws of each candidate depend: its own and those of the wall, ascending.
    pub(crate) fn seeds(&self) -> &[Vec<usize>] {
        &self.seeds
    }

    /// The free parameters of the wall, ascending.
    pub(crate) fn seeds_of_tube(&self) -> &[usize] {
        &self.seeds_of_tube
    }

    /// The parameters of every candidate as numbers, free ones taken from `values`.
    pub(crate) fn numbers(&self, values: &[f64]) -> Vec<Vec<f64>> {
        let number = |source: &Source| match *source {
            Source::Free(i) => values[i],
            Source::Fixed(value) => value,
        };
        self.sources.iter().map(|sources| sources.iter().map(number).collect()).collect()
    }

    /// The parameters of candidate `k` as jets of `space`, whose seeds are the free parameters `seeds` (and s).
    pub(crate) fn jets(&self, k: usize, seeds: &[usize], space: JetSpace, values: &[f64]) -> Vec<Jet> {
        let jet = |source: &Source| match *source {
            Source::Free(i) => {
                let place = seeds.iter().position(|s| *s == i).unwrap_or(usize::MAX);
                space.seed(place, C64::new(values[i], 0.0))
            }
            Source::Fixed(value) => space.real(value),
        };
        self.sources[k].iter().map(jet).collect()
    }
}
