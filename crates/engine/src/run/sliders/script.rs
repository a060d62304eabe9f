//! The rig and the laws of a model as data that a script can evaluate.

use crate::{Assembly, Conditions, PointModel};
use rijke_network::levine_schwinger;
use rijke_numerics::C64;
use rijke_study::names::{DIAMETER, FLANGED, LEVINE_SCHWINGER, SOUND_SPEED};
use rijke_study::{GasModel, Place, Rig, Shape, Value};
use serde::Serialize;

/// A number of the rig: known, words of a formula, or a table over the name of a factor.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub(super) enum Number {
    Known(f64),
    Words(String),
    Table { over: usize, rows: Vec<[f64; 2]> },
}

/// A part of the rig.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct PartScript {
    /// `duct`, `device` or `insert`.
    shape: &'static str,
    /// The name of the factor that says whether it is there.
    present: Option<usize>,
    /// Names and values of its numbers.
    numbers: Vec<(usize, Number)>,
    /// Length and both areas of a duct; places of a device; beginning and end of an insert.
    at: Vec<Number>,
    /// Pieces of a cone.
    /// Of a straight duct, and of a cone.
    pieces: [usize; 2],
}

/// A law of the model and where it acts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct EffectScript {
    /// Kind of place, and the part.
    place: (&'static str, Option<usize>),
    coefficient: &'static str,
    /// Its words; parameters as `p` and their number.
    law: String,
    /// Whether it is a number of the local gas times what is the same everywhere.
    proportional: bool,
}

/// Coefficients of h in R = -exp(ka h), powers of ln ka - ln `centre`: Levine and Schwinger's reflection
/// about one ka.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Radiation {
    centre: f64,
    terms: Vec<[f64; 2]>,
}

/// A model at any setting.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Script {
    /// Number of names, and the places of the factors among them.
    names: usize,
    factors: Vec<usize>,
    pressure: f64,
    gas: serde_json::Value,
    parts: Vec<PartScript>,
    effects: Vec<EffectScript>,
    radiation: Vec<Radiation>,
}

fn number(value: &Value) -> Number {
    match value {
        Value::Number(x) => Number::Known(*x),
        Value::Formula(formula) | Value::Unknown(_, formula) => {
            Number::Words(formula.postfix(|_| "nan".into()))
        }
        Value::Table(over, rows) => Number::Table { over: *over, rows: rows.clone() },
    }
}

impl Script {
    /// `model` is that of one operating point; `ka` the range of end radius times wave number.
    pub(super) fn of(assembly: &Assembly, model: &PointModel<'_>, ka: [f64; 2]) -> Result<Self, String> {
        let rig: &Rig = &assembly.rig;
        let part = |part: &rijke_study::Part| {
            let (shape, at, pieces) = match &part.shape {
                Shape::Duct(d) => ("duct", vec![&d.length, &d.area[0], &d.area[1]], d.pieces()),
                Shape::Device(at) => ("device", at.iter().collect(), [1; 2]),
                Shape::Insert(from, to) => ("insert", vec![from, to], [1; 2]),
            };
            let numbers = part.numbers.iter().map(|(name, value)| (*name, number(value))).collect();
            let at = at.into_iter().map(number).collect();
            PartScript { shape, present: part.present, numbers, at, pieces }
        };
        let mut effects = Vec::new();
        for (k, candidate) in assembly.candidates().iter().enumerate() {
            for (e, effect) in candidate.effects.iter().enumerate() {
                effects.push(EffectScript {
                    place: place(&effect.place),
                    coefficient: effect.coefficient.name(),
                    law: effect.law.postfix(|p| assembly.parameter_word(k, p)),
                    proportional: effect.place.is_along() && model.is_proportional(k, e),
                });
            }
        }
        if effects.iter().any(|e| e.law.split_whitespace().any(|word| word == "howe")) {
            return Err("a bias flow sheds vortices from a hole".to_owned());
        }
        let uses =
            |name: usize| assembly.candidates().iter().flat_map(|c| &c.effects).any(|e| e.law.uses(name));
        let radiation = if uses(LEVINE_SCHWINGER) { radiation(ka)? } else { Vec::new() };
        if uses(FLANGED) && ka[1] > 1.0 {
            return Err("its modes are too high for an end in a baffle".to_owned());
        }
        let gas = match &rig.gas {
            GasModel::Real(gas) => {
                serde_json::json!({ "constant": rig.gas.constant(), "molar_mass": gas.molar_mass,
                "heat_capacity": gas.heat_capacity, "viscosity": gas.viscosity, "conductivity": gas.conductivity })
            }
            GasModel::Perfect { gamma, constant, viscosity, prandtl } => {
                serde_json::json!({ "constant": constant,
                "gamma": gamma, "viscosity": viscosity, "prandtl": prandtl })
            }
        };
        let mut parts: Vec<PartScript> = rig.parts.iter().map(part).collect();
        // Numbers that are none of a part are known first.
        if let Some(first) = parts.first_mut() {
            first.numbers.splice(0..0, rig.loose.iter().map(|(name, value)| (*name, number(value))));
        }
        if let Some(last) = parts.last_mut() {
            last.numbers.extend(rig.of_ends.iter().map(|(name, value)| (*name, number(value))));
        }
        let (names, factors) = (rig.scope.len(), rig.factors.clone());
        Ok(Self { names, factors, pressure: rig.pressure, gas, parts, effects, radiation })
    }
}

fn place(place: &Place) -> (&'static str, Option<usize>) {
    let kind = match place {
        Place::Duct(_) => "duct",
        Place::Along(_) => "along",
        Place::Start(_) => "start",
        Place::End(_) => "end",
        Place::Each(_) => "each",
        Place::Shared(_) => "shared",
        Place::Middle(_) => "middle",
        Place::Upstream => "upstream",
        Place::Downstream => "downstream",
        Place::Ends => "ends",
    };
    (kind, place.part())
}

impl Assembly {
    /// Parameter number `p` of candidate `k` in the words of a script: its number among the free ones, or its
    /// value.
    fn parameter_word(&self, k: usize, p: usize) -> String {
        let free = &self.candidates()[k].parameters[p].name;
        match self.parameters().iter().position(|parameter| parameter.name == *free) {
            Some(place) => format!("p{place}"),
            None => format!("{:e}", self.held().get(free).copied().unwrap_or(f64::NAN)),
        }
    }
}

/// The range of ka at the ends of the rig at one operating point and angular frequency.
pub(super) fn ka(conditions: &Conditions, omega: f64) -> [f64; 2] {
    let at = |x: f64| {
        let around = conditions.around(x);
        0.5 * around[DIAMETER] * omega / around[SOUND_SPEED]
    };
    let both = [at(0.0), at(conditions.layout.length)];
    [both[0].min(both[1]), both[0].max(both[1])]
}

/// Taylor's series of ln(-R)/ka about places that are 1 apart in ln ka, each by Cauchy's integral over a
/// circle of radius 1. The nearest singularity is the zero of J1 at ka = 3.83 (Levine & Schwinger, Physical
/// Review 73 (1948) 383).
fn radiation([low, high]: [f64; 2]) -> Result<Vec<Radiation>, String> {
    const POINTS: usize = 64;
    const TERMS: usize = 32;
    // Modes move by so much in ln ka while parameters do.
    const ROOM: f64 = 0.3;
    if !(low > 1e-4 && high < 0.5) {
        return Err(
            "its modes are too high or too low for the reflection of an open end in the page".to_owned()
        );
    }
    let turn = |k: usize| std::f64::consts::TAU * k as f64 / POINTS as f64;
    let wide = (high / low).ln() + 2.0 * ROOM;
    let count = wide.ceil().max(1.0);
    let series = |i: usize| {
        let centre = (low.ln() - ROOM + wide * (i as f64 + 0.5) / count).exp();
        let sample = |k: usize| {
            let ka = C64::from_polar(1.0, turn(k)).exp() * centre;
            (-levine_schwinger::reflection(ka)[0]).ln() / ka
        };
        let samples: Vec<C64> = (0..POINTS).map(sample).collect();
        let term = |n: usize| {
            let turned = |(k, h): (usize, &C64)| h * C64::from_polar(1.0, -turn((n * k) % POINTS));
            let sum: C64 = samples.iter().enumerate().map(turned).sum();
            [sum.re / POINTS as f64, sum.im / POINTS as f64]
        };
        Radiation { centre, terms: (0..TERMS).map(term).collect() }
    };
    Ok((0..count as usize).map(series).collect())
}
