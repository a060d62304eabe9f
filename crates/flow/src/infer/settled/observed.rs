//! Runs of settled states from the observations of a campaign.

use super::readings::Readings;
use super::run::{SettledRun, State};
use crate::apparatus::observed::{ObservedTube, TubeObservations};
use crate::apparatus::ramp::Ramp;
use crate::error::FlowError;
use crate::infer::sensor::SensorKind;
use crate::tube::parameters::TubeParameters;
use crate::tube::pipe::Pipe;
use rijke_numerics::{Cholesky, Matrix};

/// Half of the width of a click's window around its centre, s: what comes within this time is heard with it.
const WINDOW: f64 = 0.8e-3;
/// Excess delay that is the same in all states, s, where the heater's reflection is heard with the direct
/// click, and elsewhere: an orifice plate reflects a third to a half of a click, which shifts its phase by a
/// tenth of its 0.6 ms.
const NEAR_SD: f64 = 30e-6;
const FAR_SD: f64 = 2e-6;
/// The same where the open end is heard, which reflects twice as much and is modelled by signal processing: a
/// quarter is left.
const END_SD: f64 = 15e-6;
/// Part of these shifts that changes when the gas gets hot.
const CHANGE: f64 = 0.1;
/// What is left in any arrival time when the pulse changes its shape along hot gas, s.
const SHAPE_SD: f64 = 0.5e-6;

/// One run per place of the heater at which a heated point has clicks or readings `along` the tube, lowest
/// first: mean clicks and readings of all its points in the same configuration (with or without
/// thermometers), cold ones included. Points of a ramp need neither: the others tell of the flow that passes
/// them. Nor do points at which nothing was measured yet, neither pings nor clicks: a state of them is
/// foreseen. A place may have such points alone; without a heated reading at any place there are no runs.
/// `pipe` makes the tube for a heater.
///
/// Errors of an arrival time beyond those stated for it:
/// * the stated covariance counts twice, as noise of the state and as error common to all states, because
///   observations do not say how much of it is calibration; but for the shift of the installation, which the
///   rig declares and all states share;
/// * the heater reflects: up to a window's length below it, and within it, the direct click is shifted by
///   about 30 us in all states alike, of which a tenth may change with temperature;
/// * the open end reflects, up to 60 us where its reflection overlaps the window wholly: signal processing
///   models it, and may miss a quarter in all states alike, and a tenth that changes with temperature.
///
/// # Errors
/// Those of [`SettledRun::checked`], with the heater's place, and of the model.
pub(super) fn runs(
    observations: &TubeObservations,
    along: &Readings,
    pipe: &dyn Fn(f64) -> Result<Pipe, FlowError>,
) -> Result<Vec<(Pipe, SettledRun)>, FlowError> {
    let passed = |id: &str| observations.ramps.iter().any(|ramp| ramp.time_of(id).is_some());
    let read = |p: &&ObservedTube| {
        p.is_planned || p.click.is_some() || !along.of(&p.point.id).is_empty() || passed(&p.point.id)
    };
    let usable = |p: &&ObservedTube| p.point.plates && p.point.position.is_some() && read(p);
    let points: Vec<&ObservedTube> = observations.points.iter().filter(usable).collect();
    let mut places: Vec<(f64, bool)> = Vec::new();
    for p in points.iter().filter(|p| p.point.power > 0.0) {
        let key = (p.point.position.unwrap_or(0.0), p.point.thermometers);
        if !places.contains(&key) {
            places.push(key);
        }
    }
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    let installation = observations.rig.recording.arrival_setting_sd_s;
    let one = |&(heater, thermometers): &(f64, bool)| {
        let pipe = pipe(heater)?;
        let mine = points
            .iter()
            .filter(|p| p.point.position == Some(heater) && p.point.thermometers == thermometers);
        let mine: Vec<&&ObservedTube> = mine.collect();
        let mut states: Vec<State> =
            mine.iter().map(|p| state(p, along, &pipe, installation)).collect::<Result<_, _>>()?;
        let clicks = mine.iter().filter_map(|p| Some((p.point.power, p.click.as_ref()?)));
        let coldest = clicks.min_by(|a, b| a.0.total_cmp(&b.0));
        let count = pipe.microphones.len();
        let stated = coldest.map_or_else(|| Matrix::zeros(count, count), |(_, c)| c.covariance.clone());
        let local: Vec<f64> = pipe
            .microphones
            .iter()
            .map(|&(x, _)| {
                let heater = if near(&pipe, x) { NEAR_SD } else { FAR_SD };
                heater.powi(2) + (END_SD * overlap(&pipe, x, 343.0)).powi(2)
            })
            .collect();
        let common = stated.plus(1.0, &Matrix::diagonal(&local));
        let here = |id: &str| states.iter().any(|s: &State| s.id == id);
        let mut ramps = Ramp::restricted(&observations.ramps, &here);
        ramps.retain(Ramp::is_measured);
        for state in &mut states {
            let times = ramps.iter().enumerate().filter_map(|(k, ramp)| Some((k, ramp.time_of(&state.id)?)));
            state.moment = { times }.next();
        }
        let run = SettledRun { heater, states, common, offset_sd: along.offset_sd, ramps }.checked(&pipe)?;
        Ok((pipe, run))
    };
    let runs = places.iter().map(one).collect::<Result<Vec<(Pipe, SettledRun)>, FlowError>>()?;
    Ok(if runs.iter().any(|(_, run)| run.is_read()) { runs } else { Vec::new() })
}

/// Whether a click at `x` is heard together with its reflection at the heater.
fn near(pipe: &Pipe, x: f64) -> bool {
    let [low, high] = pipe.edges.map(|e| pipe.faces[e]);
    // There and back at some 343 m/s, within the window.
    x < high && x > low - 0.5 * WINDOW * 343.0
}

/// Share of a click's window at `x` in which the reflection at the open end is heard, at speed of sound `c`.
/// The end reflects from 0.61 radii beyond it (Levine & Schwinger 1948).
fn overlap(pipe: &Pipe, x: f64, c: f64) -> f64 {
    let lag = 2.0 * (pipe.length + 0.305 * pipe.diameter - x) / c;
    (1.0 - lag / WINDOW).max(0.0)
}

/// One point; `installation` is the sd of the shift of all its arrival times that the run has in common, s.
fn state(p: &ObservedTube, along: &Readings, pipe: &Pipe, installation: f64) -> Result<State, FlowError> {
    let power = p.point.power;
    let ambient = p.ambient.ambient_temperature;
    let (mut sensors, mut readings) = (Vec::new(), Vec::new());
    let mut clicks = Matrix::zeros(0, 0);
    if let Some(click) = &p.click {
        sensors.extend((0..click.arrival_times.len()).map(|microphone| SensorKind::Arrival { microphone }));
        readings.extend(&click.arrival_times);
        let shared = stated_installation(&click.covariance, installation);
        clicks = Matrix::from_fn(click.covariance.rows(), click.covariance.rows(), |i, j| {
            click.covariance[(i, j)] - shared
        });
    }
    if power > 0.0 && p.click.is_some() {
        let at = |source| FlowError::Point { id: p.point.id.clone(), source: Box::new(source) };
        let guess = pipe.steady(&TubeParameters::default(), power, ambient).map_err(at)?;
        let top = guess.gas.march.face.last().copied().unwrap_or(ambient);
        let hot = pipe.air.sound_speed(top);
        for (m, &(x, _)) in pipe.microphones.iter().enumerate() {
            let end = 2.0 * NEAR_SD * CHANGE * overlap(pipe, x, hot);
            let heater = if near(pipe, x) { CHANGE * NEAR_SD } else { 0.0 };
            clicks[(m, m)] += SHAPE_SD.powi(2) + end.powi(2) + heater.powi(2);
        }
    }
    let others = along.of(&p.point.id);
    sensors.extend(others.iter().map(|r| r.0));
    readings.extend(others.iter().map(|r| r.1));
    let arrivals = clicks.rows();
    let noise = Matrix::from_fn(sensors.len(), sensors.len(), |i, j| {
        if i < arrivals && j < arrivals {
            clicks[(i, j)]
        } else if i == j {
            others[i - arrivals].2.powi(2)
        } else {
            0.0
        }
    });
    Ok(State {
        id: p.point.id.clone(),
        power,
        ambient,
        ambient_sd: p.ambient.ambient_temperature_sd,
        day: p.ambient.id.clone(),
        sensors,
        readings,
        noise,
        moment: None,
    })
}

/// The variance of a common shift that a stated covariance holds: that of the installation, unless it is too
/// small to hold it, such as one prepared by hand.
fn stated_installation(covariance: &Matrix, installation: f64) -> f64 {
    let count = covariance.rows();
    let smaller = Matrix::from_fn(count, count, |i, j| {
        let scale = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
        (covariance[(i, j)] - installation.powi(2)) / scale
    });
    let held = (0..count).all(|i| smaller[(i, i)] > 0.0) && Cholesky::new(&smaller).is_ok();
    if held { installation.powi(2) } else { 0.0 }
}
