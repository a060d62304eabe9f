//! Which candidates make the model, and which of their parameters are free.

use crate::EngineError;
use crate::noise::Added;
use rijke_inference::{Parameter, Parameters, Prior};
use rijke_numerics::{C64, Jet, JetSpace};
use rijke_study::{Candidate, Coefficient, Effect, MeanFlow, Rig, RigAtPoint};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A rig and one candidate per role, with some parameters held fixed.
#[derive(Clone, Debug)]
pub struct Assembly {
    /// The rig.
    pub rig: Arc<Rig>,
    candidates: Vec<Candidate>,
    /// For each candidate and each of its parameters.
    sources: Vec<Vec<Source>>,
    free: Vec<Parameter>,
    /// For each candidate the free parameters on which its laws depend: its own and those of the wall,
    /// ascending.
    seeds: Vec<Vec<usize>>,
    seeds_of_wall: Vec<usize>,
    /// The candidate whose laws are in error, of which its last two parameters say how far.
    erring: Option<(usize, Erring)>,
}

/// What the error of a candidate's laws is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Erring {
    /// A factor 1 + e of every law.
    Relative,
    /// A term e of the law of the effect of this number.
    Added(usize),
}

/// Names of the real and the imaginary part of the relative error of laws: no formula can use them.
pub(crate) const LAW_ERROR: [&str; 2] = ["error of the law, real", "error of the law, imaginary"];

/// Where the value of a parameter comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Source {
    /// Number in the list of free parameters.
    Free(usize),
    /// Held at a value.
    Fixed(f64),
}

/// Whether an effect is a loss of the walls of ducts, which other laws may name as `wall_mu` and `wall_ep`;
/// which of the two.
pub(crate) fn part_of_wall(effect: &Effect) -> Option<usize> {
    match effect.coefficient {
        Coefficient::Mu if effect.place.is_duct() => Some(0),
        Coefficient::Ep if effect.place.is_duct() => Some(1),
        _ => None,
    }
}

impl Assembly {
    /// What the file of the rig says, and one candidate per role; all parameters are free but those of
    /// `hold`.
    ///
    /// # Errors
    /// [`EngineError::SameRole`], [`EngineError::SameName`], [`EngineError::UnknownParameter`].
    pub fn new(
        rig: Arc<Rig>,
        candidates: Vec<Candidate>,
        hold: &BTreeMap<String, f64>,
    ) -> Result<Self, EngineError> {
        let own = Some(rig.own.clone()).filter(|own| !own.effects.is_empty() || !own.parameters.is_empty());
        let candidates: Vec<Candidate> = own.into_iter().chain(candidates).collect();
        for (k, candidate) in candidates.iter().enumerate() {
            for earlier in &candidates[..k] {
                let (first, second) = (earlier.id.clone(), candidate.id.clone());
                if earlier.role == candidate.role {
                    return Err(EngineError::SameRole { role: candidate.role.clone(), first, second });
                }
                let twice = |p: &&Parameter| earlier.parameters.iter().any(|e| e.name == p.name);
                if let Some(parameter) = candidate.parameters.iter().find(twice) {
                    return Err(EngineError::SameName { parameter: parameter.name.clone(), first, second });
                }
            }
        }
        let names: Vec<&str> =
            candidates.iter().flat_map(|c| &c.parameters).map(|p| p.name.as_str()).collect();
        if let Some(name) = hold.keys().find(|name| !names.contains(&name.as_str())) {
            return Err(EngineError::UnknownParameter { name: name.clone(), known: names.join(", ") });
        }
        let mut free = Vec::new();
        let mut source = |p: &Parameter| match hold.get(&p.name) {
            Some(value) => Source::Fixed(*value),
            None => {
                free.push(p.clone());
                Source::Free(free.len() - 1)
            }
        };
        let sources: Vec<Vec<Source>> =
            candidates.iter().map(|c| c.parameters.iter().map(&mut source).collect()).collect();
        let own = |sources: &Vec<Source>| -> Vec<usize> {
            sources.iter().filter_map(|s| if let Source::Free(i) = *s { Some(i) } else { None }).collect()
        };
        let walls = candidates.iter().zip(&sources);
        let walls = walls.filter(|(c, _)| c.effects.iter().any(|e| part_of_wall(e).is_some()));
        let mut seeds_of_wall: Vec<usize> = walls.flat_map(|(_, s)| own(s)).collect();
        seeds_of_wall.sort_unstable();
        let with_wall = |sources: &Vec<Source>| {
            let mut all = [own(sources), seeds_of_wall.clone()].concat();
            all.sort_unstable();
            all.dedup();
            all
        };
        let seeds = sources.iter().map(with_wall).collect();
        Ok(Self { rig, candidates, sources, free, seeds, seeds_of_wall, erring: None })
    }

    /// The free parameters with their priors, in the order in which values are given.
    #[must_use]
    pub fn parameters(&self) -> &[Parameter] {
        &self.free
    }

    /// The values of the free parameters at the centre of their priors.
    ///
    /// # Errors
    /// [`EngineError::Inference`], for priors that are none.
    pub(crate) fn centre(&self) -> Result<Vec<f64>, EngineError> {
        let parameters = Parameters::new(self.free.clone())?;
        Ok(parameters.physical(&parameters.centre()))
    }

    /// The mean flow of which the waves are, if a candidate says so.
    #[must_use]
    pub fn mean_flow(&self) -> Option<MeanFlow> {
        self.candidates.iter().find_map(|c| c.mean_flow)
    }

    /// Whether a law uses a measured table.
    pub(crate) fn has_tables(&self) -> bool {
        self.candidates.iter().flat_map(|c| &c.effects).any(|effect| !effect.tables.is_empty())
    }

    /// The candidates; the first is what the file of the rig itself says, where it says anything.
    #[must_use]
    pub fn candidates(&self) -> &[Candidate] {
        &self.candidates
    }

    /// The assembly with the laws of a role times 1 + e, or one of them plus e; the real and the imaginary
    /// part of e are two more parameters. None for a model without that role or law.
    ///
    /// # Errors
    /// Those of [`Assembly::new`].
    pub(crate) fn with_law_error(
        &self,
        role: &str,
        added: Option<&Added>,
    ) -> Result<Option<Self>, EngineError> {
        let Some(erring) = self.candidates.iter().position(|c| c.role == role) else { return Ok(None) };
        let how = match added {
            None => Erring::Relative,
            Some(law) => {
                let it = |e: &Effect| e.coefficient.name() == law.coefficient && e.place_text == law.place;
                let Some(effect) = self.candidates[erring].effects.iter().position(it) else {
                    return Ok(None);
                };
                Erring::Added(effect)
            }
        };
        let mut candidates = self.candidates.clone();
        let prior = Prior::Normal { mean: 0.0, sd: 1.0 };
        candidates[erring].parameters.extend(LAW_ERROR.map(|name| Parameter::new(name, "", "1", prior)));
        let own = candidates.iter().filter(|c| c.role == "rig").count();
        let rest = candidates.into_iter().skip(own).collect();
        Ok(Some(Self { erring: Some((erring, how)), ..Self::new(self.rig.clone(), rest, &self.held())? }))
    }

    /// How the law of effect `effect` of candidate `k` is in error by e, if it is; the parts of e are the
    /// candidate's last two parameters.
    pub(crate) fn erring(&self, k: usize, effect: usize) -> Option<Erring> {
        let (_, how) = self.erring.filter(|(candidate, _)| *candidate == k)?;
        matches!(how, Erring::Relative).then_some(how).or(Some(how).filter(|h| *h == Erring::Added(effect)))
    }

    /// Refuses propagation constants of waves where a model is none of pressures, or where the ducts of
    /// `layout` are not alike.
    ///
    /// # Errors
    /// [`EngineError::Waves`].
    pub(crate) fn waves_for(&self, sources: usize, layout: &RigAtPoint) -> Result<(), EngineError> {
        let states = |c: &&Candidate| c.effects.iter().any(|e| e.coefficient.is_wave());
        let Some(candidate) = self.candidates.iter().find(states) else { return Ok(()) };
        let refuse = |problem| Err(EngineError::Waves { candidate: candidate.id.clone(), problem });
        let inside = |e: &&Effect| !e.place.is_end() && !e.place.is_duct();
        let areas = || layout.ducts.iter().flat_map(|d| d.area);
        match sources {
            0 => return refuse("which only pressures of unknown sources use: take it out of this stage"),
            1 => {
                return refuse(
                    "which say nothing of what an end reflects: write sources = [\"upstream\", \"downstream\"], so that waves enter at both ends",
                );
            }
            _ => {}
        }
        if areas().any(|a| areas().next() != Some(a)) {
            return refuse(
                "but the ducts are of several areas, at whose steps waves are reflected: leave these to the network",
            );
        }
        match self.candidates.iter().flat_map(|c| &c.effects).find(inside) {
            Some(_) => refuse(
                "but a law acts between the ends, where waves are reflected: leave these to the network",
            ),
            None => Ok(()),
        }
    }

    /// Names and values of the parameters that are held.
    #[must_use]
    pub fn held(&self) -> BTreeMap<String, f64> {
        let both = self.candidates.iter().zip(&self.sources);
        let all = both.flat_map(|(c, sources)| c.parameters.iter().zip(sources));
        let held = |(p, source): (&Parameter, &Source)| match *source {
            Source::Fixed(value) => Some((p.name.clone(), value)),
            Source::Free(_) => None,
        };
        all.filter_map(held).collect()
    }

    /// The ids of the candidates but the rig's own.
    #[must_use]
    pub fn ids(&self) -> Vec<&str> {
        self.candidates.iter().filter(|c| c.role != "rig").map(|c| c.id.as_str()).collect()
    }

    pub(crate) fn seeds(&self) -> &[Vec<usize>] {
        &self.seeds
    }

    pub(crate) fn seeds_of_wall(&self) -> &[usize] {
        &self.seeds_of_wall
    }

    /// The parameters of every candidate as numbers, free ones taken from `values`.
    pub(crate) fn numbers(&self, values: &[f64]) -> Vec<Vec<f64>> {
        let number = |source: &Source| match *source {
            Source::Free(i) => values[i],
            Source::Fixed(value) => value,
        };
        self.sources.iter().map(|sources| sources.iter().map(number).collect()).collect()
    }

    /// The parameters of candidate `k` as jets of `space`, whose seeds are the free parameters `seeds` (and
    /// s).
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
