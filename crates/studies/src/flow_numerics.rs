//! Numerics of the pipe flow: orders in the cell and in the step, and how well the energy closes.

use crate::{Check, StudyError};
use rijke_flow::{Closures, FlowError, Parameters, Pipe, Transient, Unknowns};
use rijke_rig::Rig;
use serde::{Deserialize, Serialize};

/// Convergence and energy of the pipe flow, at the middle of what handbooks suggest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FlowNumerics {
    /// Place of the heater for orders and transient, m.
    pub heater_m: f64,
    /// Number of cells, and errors of the steady state at 180 W.
    pub cells: Vec<FlowOrder>,
    /// Step in s, and errors 120 s after a step from 80 to 180 W.
    pub steps: Vec<FlowOrder>,
    /// Steady states: place of the heater (m), power (W), and what is missing in the balance over the power.
    pub at_rest: Vec<[f64; 3]>,
    /// Staircase of powers: time (s), and what is missing in the balance so far over the energy supplied so far.
    pub in_motion: Vec<[f64; 2]>,
    /// What was found.
    pub checks: Vec<Check>,
}

/// Errors at one resolution, against the limit that two runs more than four times finer give.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FlowOrder {
    /// Number of cells, or step in s.
    pub size: f64,
    /// Error of the arrival time at the uppermost microphone (us), of the velocity at the heater (mm/s), and of the highest
    /// temperature (K): of the gas for cells, of the wall for steps.
    pub errors: [f64; 3],
    /// log2 of the errors of the row before over these: the order.
    pub orders: Option<[f64; 3]>,
}

/// The powers of the paper, W.
const POWERS: [f64; 8] = [0.0, 7.0, 15.0, 30.0, 50.0, 80.0, 130.0, 180.0];
const AMBIENT: f64 = 293.15;
/// Tolerance of the mass flow, so that it does not hide the order.
const TIGHT: f64 = 1e-12;

/// Orders with the heater at a quarter of the tube, the energy of steady states at 15 places, and that of the paper's staircase.
///
/// # Errors
/// Those of the flow; none for the rig of the paper.
pub fn flow_numerics(rig: &Rig) -> Result<FlowNumerics, StudyError> {
    let length = rig.tube.length;
    let pipe = |heater: f64, refinement: u32| Pipe::new(rig, &Closures::default(), heater, refinement);
    let heater = 0.25 * length;
    let middle = Unknowns {
        parameters: Parameters::default(),
        power_factor: 1.0,
        ambient_offset: 0.0,
        heater_lag: 35.0,
        orifice_length: 0.05,
    };
    let coarse = pipe(heater, 1)?;
    let refined = |refinement: u32| settled(&pipe(heater, refinement)?, &middle);
    let cells = orders(&[1, 2, 4, 8], [32, 64], |r| coarse.size() as f64 * f64::from(r), refined)?;
    let stepped = |halvings: u32| after_a_step(&coarse, &middle, 60.0 / f64::from(1 << halvings));
    let steps = orders(&[0, 1, 2, 3, 4], [6, 7], |h| 60.0 / f64::from(1 << h), stepped)?;
    let mut at_rest = Vec::new();
    for place in 3..18 {
        let pipe = pipe(0.05 * length * f64::from(place), 1)?;
        for power in POWERS.into_iter().filter(|p| *p > 0.0) {
            let budget = pipe.steady(&middle.parameters, power, AMBIENT)?.budget;
            at_rest.push([pipe.heater(), power, (budget.imbalance().abs() + budget.stored.abs()) / power]);
        }
    }
    let in_motion = staircase(&coarse, &middle)?;
    let checks = checks(&cells, &steps, &at_rest, &in_motion);
    Ok(FlowNumerics { heater_m: heater, cells, steps, at_rest, in_motion, checks })
}

/// Rows at each of `levels`; the limit is Richardson's from the two `finest`.
fn orders(
    levels: &[u32],
    finest: [u32; 2],
    size: impl Fn(u32) -> f64,
    run: impl Fn(u32) -> Result<[f64; 3], FlowError>,
) -> Result<Vec<FlowOrder>, FlowError> {
    let [fine, finer] = [run(finest[0])?, run(finest[1])?];
    let mut rows: Vec<FlowOrder> = Vec::new();
    for &level in levels {
        let values = run(level)?;
        let errors = [0, 1, 2].map(|k| values[k] - (finer[k] + (finer[k] - fine[k]) / 3.0));
        let orders = rows.last().map(|before| [0, 1, 2].map(|k| (before.errors[k] / errors[k]).abs().log2()));
        rows.push(FlowOrder { size: size(level), errors, orders });
    }
    Ok(rows)
}

fn settled(pipe: &Pipe, at: &Unknowns) -> Result<[f64; 3], FlowError> {
    let steady = pipe.steady(&at.parameters, 180.0, AMBIENT)?;
    let mut times = Vec::new();
    pipe.arrival_times(&steady.gas, at.orifice_length, &mut times);
    let last = times.last().copied().unwrap_or(f64::NAN);
    let hottest = steady.gas.march.face.iter().copied().fold(0.0, f64::max);
    Ok([1e6 * last, 1e3 * pipe.heater_velocity(&steady.gas), hottest])
}

fn after_a_step(pipe: &Pipe, at: &Unknowns, step: f64) -> Result<[f64; 3], FlowError> {
    let mut state = Transient::cold(pipe, at, AMBIENT)?;
    let steady = pipe.steady(&at.parameters, 80.0, AMBIENT)?;
    (state.wall, state.released, state.gas.mass_flow) = (steady.wall, 80.0, steady.gas.mass_flow);
    state.refresh(pipe, at, TIGHT)?;
    let implicit = pipe.implicit(step);
    for _ in 0..(120.0 / step).round() as usize {
        state.step(pipe, &implicit, at, 180.0, AMBIENT, TIGHT)?;
    }
    let mut times = Vec::new();
    pipe.arrival_times(&state.gas, at.orifice_length, &mut times);
    let last = times.last().copied().unwrap_or(f64::NAN);
    let hottest = state.wall.iter().copied().fold(0.0, f64::max);
    Ok([1e6 * last, 1e3 * pipe.heater_velocity(&state.gas), hottest])
}

/// The paper's powers for 62.5 min each and 62.5 min of cooling, in steps of 15 s; an entry every minute.
fn staircase(pipe: &Pipe, at: &Unknowns) -> Result<Vec<[f64; 2]>, FlowError> {
    const STEP: f64 = 15.0;
    let (mut state, implicit) = (Transient::cold(pipe, at, AMBIENT)?, pipe.implicit(STEP));
    let (mut missing, mut supplied, mut time, mut rows) = (0.0, 0.0, 0.0, Vec::new());
    for power in POWERS.into_iter().chain([0.0]) {
        for step in 1..=250 {
            let energy = state.step(pipe, &implicit, at, power, AMBIENT, 1e-8)?;
            missing += energy.imbalance();
            supplied += energy.released;
            time += STEP;
            if step % 4 == 0 && supplied > 0.0 {
                rows.push([time, f64::abs(missing) / supplied]);
            }
        }
    }
    Ok(rows)
}

fn checks(
    cells: &[FlowOrder],
    steps: &[FlowOrder],
    at_rest: &[[f64; 3]],
    in_motion: &[[f64; 2]],
) -> Vec<Check> {
    let order = |what: &str, rows: &[FlowOrder]| {
        let last = rows.last().and_then(|r| r.orders).unwrap_or([f64::NAN; 3]);
        Check {
            statement: format!("The flow model is of second order in {what}."),
            holds: last.iter().all(|o| (1.8..2.2).contains(o)),
            figure: format!(
                "orders {:.2}, {:.2}, {:.2} of arrival time, velocity, temperature",
                last[0], last[1], last[2]
            ),
            explanation: None,
        }
    };
    let energy = |what: &str, worst: f64| Check {
        statement: format!("The energy {what} closes to 1e-10 of what was supplied."),
        holds: worst < 1e-10,
        figure: format!("at most {worst:.1e}"),
        explanation: None,
    };
    vec![
        order("the cell", cells),
        order("the step", steps),
        energy("of every steady state", at_rest.iter().map(|r| r[2]).fold(0.0, f64::max)),
        energy("over the staircase of powers", in_motion.iter().map(|r| r[1]).fold(0.0, f64::max)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_and_energy_of_the_flow() {
        let found = flow_numerics(&Rig::juniper_yoko_2022()).unwrap();
        assert!(found.checks.len() == 4 && found.checks.iter().all(|c| c.holds), "{:?}", found.checks);
        assert!(found.at_rest.len() == 15 * 7 && found.in_motion.len() > 400);
        // Finer is better, in every quantity.
        for rows in [&found.cells, &found.steps] {
            assert!(rows.windows(2).all(|w| (0..3).all(|k| w[1].errors[k].abs() < w[0].errors[k].abs())));
        }
    }
}
