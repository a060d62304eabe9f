//! Runs of settled states from the observations of a campaign.

use super::{Run, State};
use crate::assimilate::SensorKind;
use crate::{FlowError, Parameters, Pipe};
use rijke_numerics::Matrix;
use rijke_rig::{Observations, PointObservations};

/// Half of the width of a click's window around its centre, s: what comes within this time is heard with it.
const WINDOW: f64 = 0.8e-3;
/// Excess delay that is the same in all states, s, where the heater's reflection is heard with the direct click, and
/// elsewhere: an orifice plate reflects a third to a half of a click, which shifts its phase by a tenth of its 0.6 ms.
const NEAR_SD: f64 = 30e-6;
const FAR_SD: f64 = 2e-6;
/// Part of the excess delay near the heater that changes when its gas gets hot.
const NEAR_CHANGE: f64 = 0.1;
/// What is left in any arrival time when the pulse changes its shape along hot gas, s.
const SHAPE_SD: f64 = 0.5e-6;

/// One run per place of the heater at which a heated point has clicks, lowest first: the mean clicks of all its points in the
/// same configuration (with or without thermocouples), cold ones included. `pipe` makes the tube for a heater.
///
/// Errors of an arrival time beyond those stated for it:
/// * the stated covariance counts twice, as noise of the state and as error common to all states, because observations do not
///   say how much of it is calibration;
/// * the heater reflects: up to a window's length below it, and within it, the direct click is shifted by about 30 us in all states
///   alike, of which a tenth may change with temperature;
/// * the open end reflects: signal processing places that reflection with the cold speed of sound. In hot gas it comes earlier
///   by dl; where it overlaps the window by a share o the time may be off by o dl.
///
/// # Errors
/// Those of [`Run::checked`], with the heater's place, and of the model.
pub fn runs(
    observations: &Observations,
    pipe: &dyn Fn(f64) -> Result<Pipe, FlowError>,
) -> Result<Vec<(Pipe, Run)>, FlowError> {
    let with_click =
        |p: &&PointObservations| p.point.heater && p.point.position.is_some() && p.click.is_some();
    let points: Vec<&PointObservations> = observations.points.iter().filter(with_click).collect();
    let mut places: Vec<(f64, bool)> = Vec::new();
    for p in points.iter().filter(|p| p.point.power > 0.0) {
        let key = (p.point.position.unwrap_or(0.0), p.point.thermocouples);
        if !places.contains(&key) {
            places.push(key);
        }
    }
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    let one = |&(heater, thermocouples): &(f64, bool)| {
        let pipe = pipe(heater)?;
        let mine = points
            .iter()
            .filter(|p| p.point.position == Some(heater) && p.point.thermocouples == thermocouples);
        let states: Vec<State> =
            mine.filter_map(|p| state(p, &pipe).transpose()).collect::<Result<_, _>>()?;
        let cold = states.iter().min_by(|a, b| a.power.total_cmp(&b.power));
        let count = pipe.microphones.len();
        let stated = cold.map_or_else(|| Matrix::zeros(count, count), |s| s.noise.clone());
        let local: Vec<f64> = pipe
            .microphones
            .iter()
            .map(|&(x, _)| if near(&pipe, x) { NEAR_SD.powi(2) } else { FAR_SD.powi(2) })
            .collect();
        let run =
            Run { heater, states, common: stated.plus(1.0, &Matrix::diagonal(&local)) }.checked(&pipe)?;
        Ok((pipe, run))
    };
    places.iter().map(one).collect()
}

/// Whether a click at `x` is heard together with its reflection at the heater.
fn near(pipe: &Pipe, x: f64) -> bool {
    let [low, high] = pipe.edges.map(|e| pipe.faces[e]);
    // There and back at some 343 m/s, within the window.
    x < high && x > low - 0.5 * WINDOW * 343.0
}

fn state(p: &PointObservations, pipe: &Pipe) -> Result<Option<State>, FlowError> {
    let Some(click) = &p.click else { return Ok(None) };
    let power = p.point.power;
    let ambient = p.ambient.ambient_temperature;
    let mut noise = click.covariance.clone();
    if power > 0.0 {
        let guess = pipe.steady(&Parameters::default(), power, ambient)?;
        let top = guess.gas.march.face.last().copied().unwrap_or(ambient);
        let (cold, hot) = (pipe.air.sound_speed(ambient), pipe.air.sound_speed(top));
        // Levine & Schwinger 1948: the end reflects from 0.61 radii beyond it.
        let end = pipe.length + 0.305 * pipe.diameter;
        for (m, &(x, _)) in pipe.microphones.iter().enumerate() {
            let lag = |c: f64| 2.0 * (end - x) / c;
            let overlap = (1.0 - lag(hot) / WINDOW).max(0.0);
            let reflection = overlap * (lag(cold) - lag(hot));
            let heater = if near(pipe, x) { NEAR_CHANGE * NEAR_SD } else { 0.0 };
            noise[(m, m)] += SHAPE_SD.powi(2) + reflection.powi(2) + heater.powi(2);
        }
    }
    Ok(Some(State {
        id: p.point.id.clone(),
        power,
        ambient,
        ambient_sd: p.ambient.ambient_temperature_sd,
        day: p.ambient.id.clone(),
        sensors: (0..click.arrival_times.len())
            .map(|microphone| SensorKind::Arrival { microphone })
            .collect(),
        readings: click.arrival_times.clone(),
        noise,
    }))
}
