//! What the sensors read and what the flow is, at given unknowns.

use super::run::{SettledRun, State};
use super::unknowns::Filled;
use crate::error::FlowError;
use crate::infer::sensor::SensorKind;
use crate::tube::draught::Draught;
use crate::tube::parameters::Unknowns;
use crate::tube::pipe::Pipe;
use crate::tube::steady::{Nearby, Steady};
use rijke_inference::Parameter;
use rijke_numerics::interpolate;
use std::collections::BTreeMap;

/// One state as predicted.
#[derive(Clone, Debug)]
pub(crate) struct Predicted {
    pub(crate) readings: Vec<f64>,
    /// Mass flux, velocity at the heater, then the gas temperature at the places of the base state.
    pub(crate) base: Vec<f64>,
    pub(crate) flow: Flowing,
}

/// The flow of a state.
#[derive(Clone, Debug)]
pub(crate) enum Flowing {
    Settled(Steady),
    /// A moment of a ramp.
    Passed(Draught<f64>),
}

impl Flowing {
    pub(crate) fn settled(&self) -> Option<&Steady> {
        match self {
            Flowing::Settled(steady) => Some(steady),
            Flowing::Passed(_) => None,
        }
    }

    fn gas(&self) -> &Draught<f64> {
        match self {
            Flowing::Settled(steady) => &steady.gas,
            Flowing::Passed(gas) => gas,
        }
    }
}

/// Predicted states from which others, that hardly differ, are found.
pub(crate) struct Around<'a> {
    at: &'a [Predicted],
    /// None of a moment of a ramp.
    settled: Vec<Option<Nearby<'a>>>,
}

/// The tube and its unknowns as the model takes them.
struct Setting {
    pipe: Pipe,
    filled: Filled,
    /// Ambient temperature of each state, K.
    ambient: Vec<f64>,
    /// Excess length of the path of each interval, m.
    paths: Vec<f64>,
}

impl SettledRun {
    /// All states of the tube `pipe` at `scores` of the unknowns `priors`; the search for settled flows
    /// starts at `near`, if there are any.
    pub(crate) fn predict(
        &self,
        pipe: &Pipe,
        priors: &[Parameter],
        scores: &[f64],
        near: Option<&[Predicted]>,
    ) -> Result<Vec<Predicted>, FlowError> {
        let set = self.setting(pipe, priors, scores)?;
        let mut passed = self.passed(&set)?;
        let one = |(k, state): (usize, &State)| {
            let flow = match passed.remove(&k) {
                Some(gas) => Flowing::Passed(gas),
                None => {
                    let (p, power) = (&set.filled.parameters, state.power * set.filled.power_factor);
                    let near = near.and_then(|near| near.get(k)?.flow.settled());
                    let found = near.and_then(|n| set.pipe.steady_near(p, power, set.ambient[k], n).ok());
                    let cold = || set.pipe.steady(p, power, set.ambient[k]);
                    Flowing::Settled(found.map_or_else(cold, Ok)?)
                }
            };
            let (readings, base) = self.read(k, pipe, &set, flow.gas());
            Ok(Predicted { readings, base, flow })
        };
        self.states.iter().enumerate().map(one).collect()
    }

    /// What [`SettledRun::predict_near`] needs of the states `at` the `scores`.
    pub(crate) fn around<'a>(
        &self,
        pipe: &Pipe,
        priors: &[Parameter],
        scores: &[f64],
        at: &'a [Predicted],
    ) -> Result<Around<'a>, FlowError> {
        let set = self.setting(pipe, priors, scores)?;
        let one = |p: &'a Predicted| p.flow.settled().map(|steady| set.pipe.nearby(steady)).transpose();
        Ok(Around { at, settled: at.iter().map(one).collect::<Result<_, _>>()? })
    }

    /// Readings and base vector of all states at `scores` that hardly differ from those `around`, settled
    /// flows to second order; if only readings depend on the difference, the flow is `kept`.
    pub(crate) fn predict_near(
        &self,
        pipe: &Pipe,
        priors: &[Parameter],
        scores: &[f64],
        around: &Around<'_>,
        kept: bool,
    ) -> Result<Vec<[Vec<f64>; 2]>, FlowError> {
        let set = self.setting(pipe, priors, scores)?;
        let mut passed = if kept { BTreeMap::new() } else { self.passed(&set)? };
        let one = |(k, state): (usize, &State)| {
            let power = state.power * set.filled.power_factor;
            let found = match (passed.remove(&k), &around.settled[k]) {
                (None, Some(near)) if !kept => {
                    Some(set.pipe.gas_near(&set.filled.parameters, power, set.ambient[k], near)?)
                }
                (passed, _) => passed,
            };
            let (readings, base) =
                self.read(k, pipe, &set, found.as_ref().unwrap_or(around.at[k].flow.gas()));
            Ok([readings, base])
        };
        self.states.iter().enumerate().map(one).collect()
    }

    fn setting(&self, pipe: &Pipe, priors: &[Parameter], scores: &[f64]) -> Result<Setting, FlowError> {
        let mut filled = Filled::new(priors, scores, &pipe.closures)?;
        let days = self.days();
        let rest = std::mem::take(&mut filled.rest);
        let (offsets, rest) = rest.split_at(days.len());
        let (paths, of_ramps) = rest.split_at(pipe.microphones.len());
        if let [lag, capacity] = of_ramps {
            (filled.closures.heater_lag, filled.closures.wall_heat_capacity) = (*lag, *capacity);
        }
        let ambient = |state: &State| {
            let offset = days.iter().zip(offsets).find(|(d, _)| **d == state.day).map_or(0.0, |(_, o)| *o);
            state.ambient + offset
        };
        Ok(Setting {
            pipe: pipe.altered(filled.heater_shift, &filled.closures)?,
            ambient: self.states.iter().map(ambient).collect(),
            paths: paths.to_vec(),
            filled,
        })
    }

    /// Readings and base vector of state `k` in `gas`; `pipe` has the places of the base state.
    fn read(&self, k: usize, pipe: &Pipe, set: &Setting, gas: &Draught<f64>) -> (Vec<f64>, Vec<f64>) {
        let state = &self.states[k];
        let arrivals = arrivals(&set.pipe, gas, &set.filled, &set.paths, state.ambient);
        let at = |place: f64| interpolate(&set.pipe.faces, &gas.march.face, place);
        let readings = state.sensors.iter().map(|sensor| match *sensor {
            SensorKind::Arrival { microphone } => arrivals[microphone],
            SensorKind::Temperature { place } => at(place),
            SensorKind::SoundSpeed { place } => set.pipe.air.sound_speed(at(place)),
        });
        let flow = [gas.mass_flow / set.pipe.area, set.pipe.heater_velocity(gas)];
        (readings.collect(), flow.into_iter().chain(pipe.faces().iter().map(|&x| at(x))).collect())
    }

    /// The gas of the states that are moments of ramps, by the number of the state.
    fn passed(&self, set: &Setting) -> Result<BTreeMap<usize, Draught<f64>>, FlowError> {
        let Setting { pipe, filled, ambient, .. } = set;
        let known = Unknowns::known(&filled.parameters, &filled.closures);
        let unknowns = Unknowns { power_factor: filled.power_factor, ..known };
        let mut all = BTreeMap::new();
        for (r, ramp) in self.ramps.iter().enumerate() {
            let mine = self.states.iter().enumerate();
            let mine = mine.filter_map(|(k, s)| s.moment.filter(|m| m.0 == r).map(|(_, time)| (time, k)));
            let mut mine: Vec<(f64, usize)> = mine.collect();
            mine.sort_by(|a, b| a.0.total_cmp(&b.0));
            let Some(&(_, first)) = mine.first() else { continue };
            let moments: Vec<f64> = mine.iter().map(|m| m.0).collect();
            let gas = pipe.gas_along(ramp, &unknowns, ambient[first], &moments, STEP)?;
            all.extend(mine.iter().map(|m| m.1).zip(gas));
        }
        Ok(all)
    }
}

/// Longest step of a run after a change of power, s: the error is below a tenth of a kelvin three minutes
/// after a step.
const STEP: f64 = 15.0;

/// Arrival times as signal processing reports them: delays of channels and the dispersion of the empty tube
/// at the `indicated` ambient temperature removed, so that an empty cold tube gives x/c. What is left of the
/// dispersion is its change with temperature. Each interval of the path may be longer than its geometry by
/// `paths` (m of sound path).
fn arrivals(pipe: &Pipe, gas: &Draught<f64>, filled: &Filled, paths: &[f64], indicated: f64) -> Vec<f64> {
    let at_faces = pipe.times_at_faces(gas);
    let slowness = |x: f64| 1.0 / pipe.air.sound_speed(interpolate(&pipe.faces, &gas.march.face, x));
    let cold = 1.0 / pipe.air.sound_speed(indicated);
    // At the heater, the mean of cold and hot gas.
    let [low, high] = pipe.edges.map(|e| pipe.faces[e]);
    let warmth = 0.5 * (slowness(low) + slowness(high)) / cold;
    let orifice = 0.5 * filled.orifice_length * cold * warmth.powf(filled.orifice_exponent);
    let (mut excess, mut from) = (0.0, 0.0);
    let beyond = |x: f64| ((x - low) / (high - low)).clamp(0.0, 1.0);
    let time = |(&(x, _), path): (&(f64, usize), &f64)| {
        // The speed of sound at both ends of the interval is enough for a few millimetres.
        excess += path * 0.5 * (slowness(from) + slowness(x));
        from = x;
        let dispersion = x * pipe.cold_retardation(indicated) * cold;
        pipe.time_at(gas, &at_faces, x) + excess + orifice * beyond(x) - dispersion
    };
    pipe.microphones.iter().zip(paths).map(time).collect()
}
