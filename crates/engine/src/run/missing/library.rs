//! The effects that are tried: every kind at every place, in proportion to one and to every factor.

use super::factors::factors;
use crate::observed::Used;
use crate::point::Probed;
use crate::predictor::Predictor;
use crate::{Assembly, EngineError, Observed, PointModel};
use rayon::prelude::*;
use rijke_inference::{Forward, InferenceError};
use rijke_network::Workspace;
use rijke_numerics::{C64, InOrder, Matrix, Order};
use rijke_rig::ModeRows;
use rijke_study::names::{DENSITY, SOUND_SPEED};
use rijke_study::{Campaign, Candidate, PartAt, Place, Shape};
use std::borrow::Cow;
use std::collections::BTreeSet;

/// A term of the library.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Term {
    /// What it does.
    pub(super) effect: String,
    /// Where.
    pub(super) place: String,
    /// Whether something is there in the rig: no place of the grid.
    pub(super) named: bool,
    /// Whether it is the gain or the delay of a law of the model.
    pub(super) of_a_law: bool,
    /// What acts, both phases of it and whatever it is in proportion to: one effect at one place.
    pub(super) acts: String,
    /// Mean over the observations of where that is, m; none for what acts along the rig.
    pub(super) x: Option<f64>,
    /// What it is in proportion to; nothing if it is the same at all points.
    pub(super) times: String,
    /// Unit of its strength.
    pub(super) unit: Cow<'static, str>,
}

/// All terms, and the change of every datum per strength of each.
pub(super) struct Library {
    pub(super) terms: Vec<Term>,
    pub(super) directions: Vec<Vec<f64>>,
}

/// An effect at a place: the coefficient, and what it is per strength, of density, speed of sound and s.
struct Kind {
    name: &'static str,
    coefficient: usize,
    unit: &'static str,
    per_strength: fn(f64, f64, C64) -> C64,
}

/// In the order k_mu, k_mp, k_eu, k_ep of a probe. Resistances and leaks are in rho c, inertia and compliance
/// are lengths of duct, heat release is that of -k_eu = n (1 - s tau).
const KINDS: [Kind; 8] = [
    Kind { name: "resistance", coefficient: 0, unit: "1", per_strength: |rho, c, _| C64::from(rho * c) },
    Kind { name: "inertia", coefficient: 0, unit: "m", per_strength: |rho, _, s| s * rho },
    Kind {
        name: "force in phase with pressure",
        coefficient: 1,
        unit: "1",
        per_strength: |_, _, _| C64::ONE,
    },
    Kind { name: "force out of phase with pressure", coefficient: 1, unit: "s", per_strength: |_, _, s| s },
    Kind {
        name: "heat release in phase with velocity",
        coefficient: 2,
        unit: "1",
        per_strength: |_, _, _| -C64::ONE,
    },
    Kind {
        name: "heat release out of phase with velocity",
        coefficient: 2,
        unit: "s",
        per_strength: |_, _, s| s,
    },
    Kind { name: "leak", coefficient: 3, unit: "1", per_strength: |rho, c, _| C64::from(1.0 / (rho * c)) },
    Kind { name: "compliance", coefficient: 3, unit: "m", per_strength: |rho, c, s| s / (rho * c * c) },
];

/// Least distance of places, m, and their least and largest number.
const SPACING: f64 = 0.05;
const PLACES: [f64; 2] = [10.0, 40.0];

/// A part as near as this to a place of the grid takes its place, in its spacings.
const TAKES: f64 = 0.02;

/// A place of the library, where it is at each observation.
struct Spot {
    name: String,
    named: bool,
    at: Vec<Option<f64>>,
}

impl Library {
    /// The terms for a trained model with these parameters. `rows` are the observation and the row in its
    /// prediction of every datum.
    pub(super) fn of(
        assembly: &Assembly,
        campaign: &Campaign,
        observed: &[Observed],
        used: &[Used],
        values: &[f64],
        rows: &[(usize, usize)],
    ) -> Result<Self, EngineError> {
        let mut spots = spots(assembly, observed);
        // The grid lies in the rig as its priors have it; where a length or a place is inferred, parts may
        // have moved across it.
        if assembly.rig.is_of_unknown_shape() {
            for spot in spots.iter_mut().filter(|spot| !spot.named) {
                for (at, (o, u)) in spot.at.iter_mut().zip(observed.iter().zip(used)) {
                    let Some(x) = *at else { continue };
                    let cut = PointModel::with_cuts(assembly, &o.conditions, &u.microphones, &[x])?;
                    if !cut.is_possible(values) {
                        *at = None;
                    }
                }
            }
            spots.retain(|spot| spot.at.iter().any(Option::is_some));
        }
        let probe = |(k, (o, u)): (usize, (&Observed, &Used))| -> Result<Probed, EngineError> {
            let xs: Vec<f64> = spots.iter().filter_map(|spot| spot.at[k]).collect();
            let model = PointModel::with_cuts(assembly, &o.conditions, &u.microphones, &xs)?;
            model.starting_from(o.near).probe(values, &o.conditions, &mut Workspace::default())
        };
        let probed: Vec<Probed> =
            observed.par_iter().zip(used).enumerate().map(probe).in_order::<Result<_, EngineError>>()?;
        let factors = factors(campaign, observed, &probed);
        let mut making = Making {
            library: Self { terms: Vec::new(), directions: Vec::new() },
            observed,
            probed,
            factors,
            rows,
        };
        making.add_places(&spots);
        making.add_ends();
        making.add_walls();
        making.add_laws(assembly);
        let slopes = Predictor::new(assembly, observed, used)?.predict(values, Order::First);
        making.add_parameters(assembly, used, &slopes.map_err(InferenceError::from)?.jacobian);
        let mut library = making.library;
        library.add_channels(assembly, used, rows);
        Ok(library)
    }

    /// Errors of microphones, whose change of the relative pressures may be that of a force at their place: a
    /// wrong gain or phase of one, the same at all points.
    fn add_channels(&mut self, assembly: &Assembly, used: &[Used], rows: &[(usize, usize)]) {
        let microphones = &assembly.rig.microphones;
        let heard: BTreeSet<usize> = used.iter().flat_map(|u| u.microphones.iter().copied()).collect();
        for (m, (effect, unit, by)) in heard
            .iter()
            .flat_map(|m| [("gain error", "1", C64::ONE), ("phase error", "rad", C64::I)].map(|e| (*m, e)))
        {
            let datum = |&(k, row): &(usize, usize)| {
                let Some(i) = row.checked_sub(ModeRows::pressure(0)).map(|row| row / 2) else { return 0.0 };
                // Pressures are over that of the reference.
                let share = f64::from(used[k].others[i] == m) - f64::from(microphones.reference == m);
                let z = used[k].pressures[i] * by * share;
                if row % 2 == 0 { z.re } else { z.im }
            };
            self.directions.push(rows.iter().map(datum).collect());
            self.terms.push(Term {
                effect: effect.to_owned(),
                place: format!("microphone {}", microphones.names[m]),
                named: true,
                of_a_law: false,
                acts: "channel".to_owned(),
                x: None,
                times: String::new(),
                unit: unit.into(),
            });
        }
    }
}

/// A library in the making, of terms that the model was probed with.
struct Making<'a> {
    library: Library,
    observed: &'a [Observed],
    probed: Vec<Probed>,
    /// What a term may be in proportion to, and that at each observation.
    factors: Vec<(String, Vec<f64>)>,
    rows: &'a [(usize, usize)],
}

impl Making<'_> {
    /// The changes `slope` of each observation per strength of a term, in proportion to each factor.
    fn add(&mut self, term: &Term, slope: &dyn Fn(&Self, usize) -> Option<Vec<C64>>) {
        let slopes: Vec<Option<Vec<C64>>> = (0..self.observed.len()).map(|k| slope(self, k)).collect();
        if slopes.iter().all(Option::is_none) {
            return;
        }
        for (times, weights) in &self.factors {
            let datum = |&(k, row): &(usize, usize)| {
                let z = slopes[k].as_ref().map_or(C64::ZERO, |z| z[row / 2]);
                weights[k] * if row % 2 == 0 { z.re } else { z.im }
            };
            self.library.directions.push(self.rows.iter().map(datum).collect());
            self.library.terms.push(Term { times: times.clone(), ..term.clone() });
        }
    }

    /// Forces, heat and mass at places.
    fn add_places(&mut self, spots: &[Spot]) {
        for (number, spot) in spots.iter().enumerate() {
            let there: Vec<f64> = spot.at.iter().copied().flatten().collect();
            // To a micrometre: a mean of equal places is that place.
            let x = Some((there.iter().sum::<f64>() / there.len() as f64 * 1e6).round() * 1e-6);
            for Kind { name, coefficient, unit, per_strength } in &KINDS {
                let term = Term {
                    effect: (*name).to_owned(),
                    place: spot.name.clone(),
                    named: spot.named,
                    of_a_law: false,
                    acts: coefficient.to_string(),
                    x,
                    times: String::new(),
                    unit: (*unit).into(),
                };
                self.add(&term, &|of, k| {
                    let x = spot.at[k]?;
                    let place = spots[..number].iter().filter(|other| other.at[k].is_some()).count();
                    let around = of.observed[k].conditions.around(x);
                    let probed = &of.probed[k];
                    let slope = probed.places[place][*coefficient].as_ref()?;
                    Some(times(slope, per_strength(around[DENSITY], around[SOUND_SPEED], probed.s)))
                });
            }
        }
    }

    /// What the ends reflect.
    fn add_ends(&mut self) {
        for (end, place) in ["upstream end", "downstream end"].into_iter().enumerate() {
            let length = |o: &Observed| if end == 0 { 0.0 } else { o.conditions.layout.length };
            let x = self.observed.iter().map(length).sum::<f64>() / self.observed.len() as f64;
            let at = |effect, unit| Term { x: Some(x), acts: "end".to_owned(), ..term(effect, place, unit) };
            self.add(&at("reflection, real part", "1"), &|of, k| of.probed[k].ends[end].clone());
            self.add(&at("reflection, in proportion to s", "s"), &|of, k| {
                Some(times(of.probed[k].ends[end].as_ref()?, of.probed[k].s))
            });
        }
    }

    /// What walls take and store, along all ducts.
    fn add_walls(&mut self) {
        for (part, [loss, reactive]) in
            [["friction of walls", "inertia of the gas"], ["heat to walls", "compliance of the gas"]]
                .into_iter()
                .enumerate()
        {
            self.add(&term(loss, "all ducts", "m^-1"), &|of, k| of.probed[k].walls[part].clone());
            self.add(&term(reactive, "all ducts", "1"), &|of, k| {
                let by = of.probed[k].s / of.observed[k].conditions.base.at(0.0).sound_speed;
                Some(times(of.probed[k].walls[part].as_ref()?, by))
            });
        }
        // The commonest loss of all: both parts of the walls' loss together, in proportion to sqrt(s).
        self.add(&term("boundary layers of walls", "all ducts", "1"), &|of, k| {
            Some(times(of.probed[k].layers.as_ref()?, of.probed[k].s.sqrt()))
        });
    }

    /// Gain and delay of the laws of the model.
    fn add_laws(&mut self, assembly: &Assembly) {
        let mut owners: Vec<[usize; 2]> =
            self.probed.iter().flat_map(|p| p.laws.iter().map(|l| l.0)).collect();
        owners.sort_unstable();
        owners.dedup();
        for [candidate, number] in owners {
            let owner = &assembly.candidates()[candidate];
            let effect = &owner.effects[number];
            if effect.place.is_end() {
                continue;
            }
            let slope = |of: &Self, k: usize| {
                of.probed[k].laws.iter().find(|l| l.0 == [candidate, number]).map(|l| l.1.clone())
            };
            let of = |what: &str| format!("{what} of {} of {}", effect.coefficient.name(), owner.id);
            let of_law =
                |what: &str, unit| Term { of_a_law: true, ..term(&of(what), &effect.place_text, unit) };
            self.add(&of_law("gain", "1"), &slope);
            if !effect.place.is_along() {
                self.add(&of_law("delay", "s"), &|of, k| Some(times(&slope(of, k)?, -of.probed[k].s)));
            }
        }
    }

    /// Parameters of the model that are not the same at all points. The `slopes` are of all numbers of the
    /// prediction, of which `used` tells how many are of each observation, by the model's parameters.
    fn add_parameters(&mut self, assembly: &Assembly, used: &[Used], slopes: &Matrix) {
        let first = |k: usize| used[..k].iter().map(Used::size).sum::<usize>();
        let place: Vec<usize> = self.rows.iter().map(|(k, row)| first(*k) + row).collect();
        for (j, parameter) in assembly.parameters().iter().enumerate() {
            let has = |c: &&Candidate| c.parameters.iter().any(|p| p.name == parameter.name);
            let effect = assembly.candidates().iter().find(has).and_then(|c| c.effects.first());
            let Some(effect) = effect else { continue };
            let changes = Term {
                unit: parameter.unit.clone().into(),
                ..term(&format!("change of {}", parameter.name), &effect.place_text, "1")
            };
            for (times, weights) in self.factors.iter().filter(|(times, _)| !times.is_empty()) {
                let datum = |(i, (k, _)): (&usize, &(usize, usize))| weights[*k] * slopes[(*i, j)];
                self.library.directions.push(place.iter().zip(self.rows).map(datum).collect());
                self.library.terms.push(Term { times: times.clone(), ..changes.clone() });
            }
        }
    }
}

/// A term of a named place, of no place along x.
fn term(effect: &str, place: &str, unit: &'static str) -> Term {
    Term {
        effect: effect.to_owned(),
        place: place.to_owned(),
        named: true,
        of_a_law: false,
        acts: if place == "all ducts" { "walls" } else { effect.rsplit(" of ").next().unwrap_or(effect) }
            .to_owned(),
        x: None,
        times: String::new(),
        unit: unit.into(),
    }
}

fn times(z: &[C64], by: C64) -> Vec<C64> {
    z.iter().map(|z| z * by).collect()
}

/// A grid along the rig, and the parts that act at places.
fn spots(assembly: &Assembly, observed: &[Observed]) -> Vec<Spot> {
    let layouts = || observed.iter().map(|o| &o.conditions.layout);
    let mut spots = Vec::new();
    for (k, part) in assembly.rig.parts.iter().enumerate() {
        let kinds: &[(Place, &str)] = match part.shape {
            Shape::Device(_) => &[(Place::Middle(k), "")],
            Shape::Insert(..) => &[(Place::Start(k), ", start"), (Place::End(k), ", end")],
            Shape::Duct(_) => &[(Place::Start(k), ", start")],
        };
        for (place, side) in kinds {
            let at = layouts().map(|l| {
                let there = !matches!(l.parts.get(k), Some(PartAt::Absent) | None);
                let found = l.places(place).first().map(|(x, _)| *x).filter(|_| there);
                found.filter(|x| *x > 0.0 && *x < l.length)
            });
            let at: Vec<Option<f64>> = at.collect();
            if at.iter().any(Option::is_some) {
                spots.push(Spot { name: format!("{}{side}", part.name), named: true, at });
            }
        }
    }
    let longest = layouts().map(|l| l.length).fold(0.0, f64::max);
    let count = (longest / SPACING).ceil().clamp(PLACES[0], PLACES[1]);
    let step = longest / count;
    for k in 1..count as usize {
        let x = step * k as f64;
        let taken = |spot: &Spot| spot.at.iter().all(|at| at.is_some_and(|at| (at - x).abs() < TAKES * step));
        if !spots.iter().any(taken) {
            let at = layouts().map(|l| Some(x).filter(|x| *x < l.length)).collect();
            spots.push(Spot { name: format!("x = {x:.3} m"), named: false, at });
        }
    }
    spots
}
