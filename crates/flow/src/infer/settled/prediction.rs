//! What the sensors read and what the flow is, at given unknowns.

use super::run::{SettledRun, State};
use super::unknowns::Filled;
use crate::error::FlowError;
use crate::infer::sensor::SensorKind;
use crate::tube::draught::Draught;
use crate::tube::parameters::Unknowns;
use crate::tube::pipe::Pipe;
use crate::tube::steady::Steady;
use rijke_inference::Parameter;
use rijke_numerics::interpolate;
use std::collections::BTreeMap;

/// One state as predicted.
#[derive(Clone, Debug)]
pub(crate) struct Predicted {
    pub(crate) readings: Vec<f64>,
    /// Mass flux, velocity at the heater, then the gas temperature at the places of the base state.
    pub(crate) base: Vec<f64>,
    /// None of a moment of a ramp.
    pub(crate) steady: Option<Steady>,
}

impl SettledRun {
    /// All states of the tube `pipe` at `scores` of the unknowns `priors`; `near` are steady states to start
    /// from.
    pub(crate) fn predict(
        &self,
        pipe: &Pipe,
        priors: &[Parameter],
        scores: &[f64],
        near: Option<&[Predicted]>,
    ) -> Result<Vec<Predicted>, FlowError> {
        let mut filled = Filled::new(priors, scores, &pipe.closures)?;
        let places = pipe.faces();
        let days = self.days();
        let rest = std::mem::take(&mut filled.rest);
        let (offsets, rest) = rest.split_at(days.len());
        let (paths, of_ramps) = rest.split_at(pipe.microphones.len());
        if let [lag, capacity] = of_ramps {
            (filled.closures.heater_lag, filled.closures.wall_heat_capacity) = (*lag, *capacity);
        }
        let pipe = pipe.altered(filled.heater_shift, &filled.closures)?;
        let ambient = |state: &State| {
            let offset = days.iter().zip(offsets).find(|(d, _)| **d == state.day).map_or(0.0, |(_, o)| *o);
            state.ambient + offset
        };
        let mut passed = self.passed(&pipe, &filled, &ambient)?;
        let mut list = Vec::with_capacity(self.states.len());
        for (k, state) in self.states.iter().enumerate() {
            let (p, power) = (&filled.parameters, state.power * filled.power_factor);
            let (gas, steady) = match (passed.remove(&k), near.and_then(|n| n.get(k)?.steady.as_ref())) {
                (Some(gas), _) => (gas, None),
                (None, Some(near)) => {
                    let steady = pipe.steady_near(p, power, ambient(state), near)?;
                    (steady.gas.clone(), Some(steady))
                }
                (None, None) => {
                    let steady = pipe.steady(p, power, ambient(state))?;
                    (steady.gas.clone(), Some(steady))
                }
            };
            let arrivals = arrivals(&pipe, &gas, &filled, paths, state.ambient);
            let at = |place: f64| interpolate(&pipe.faces, &gas.march.face, place);
            let readings = state.sensors.iter().map(|sensor| match *sensor {
                SensorKind::Arrival { microphone } => arrivals[microphone],
                SensorKind::Temperature { place } => at(place),
                SensorKind::SoundSpeed { place } => pipe.air.sound_speed(at(place)),
            });
            let flow = [gas.mass_flow / pipe.area, pipe.heater_velocity(&gas)];
            let base = flow.into_iter().chain(places.iter().map(|&x| at(x))).collect();
            list.push(Predicted { readings: readings.collect(), base, steady });
        }
        Ok(list)
    }

    /// The gas of the states that are moments of ramps, by the number of the state.
    fn passed(
        &self,
        pipe: &Pipe,
        filled: &Filled,
        ambient: &dyn Fn(&State) -> f64,
    ) -> Result<BTreeMap<usize, Draught<f64>>, FlowError> {
        let known = Unknowns::known(&filled.parameters, &filled.closures);
        let unknowns = Unknowns { power_factor: filled.power_factor, ..known };
        let mut all = BTreeMap::new();
        for (r, ramp) in self.ramps.iter().enumerate() {
            let mine = self.states.iter().enumerate();
            let mine = mine.filter_map(|(k, s)| s.moment.filter(|m| m.0 == r).map(|(_, time)| (time, k, s)));
            let mut mine: Vec<(f64, usize, &State)> = mine.collect();
            mine.sort_by(|a, b| a.0.total_cmp(&b.0));
            let Some((_, _, first)) = mine.first() else { continue };
            let moments: Vec<f64> = mine.iter().map(|m| m.0).collect();
            let gas = pipe.gas_along(ramp, &unknowns, ambient(first), &moments, STEP)?;
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
        interpolate(&pipe.faces, &at_faces, x) + excess + orifice * beyond(x) - dispersion
    };
    pipe.microphones.iter().zip(paths).map(time).collect()
}
