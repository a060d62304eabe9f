//! The steady state by Newton's method, and its derivatives by the implicit function theorem.
//!
//! Knows parameters at given values, and neither priors nor readings.

mod tangent;

use super::draught::Draught;
use super::march::{Drive, Flow, March};
use super::parameters::TubeParameters;
use super::pipe::Pipe;
use super::wall::HeatBalance;
use crate::base::state::BaseState;
use crate::error::FlowError;
use crate::number::{Dual, Number};
use tangent::System;

/// Most Newton steps; from a cold start seven are typical.
const STEPS: usize = 40;
/// Names of what the sensitivities refer to: the six parameters, the power (relative) and the ambient
/// temperature (K).
pub const SENSITIVE_TO: [&str; 8] = [
    "heater_drag",
    "outer_nusselt",
    "mount_resistance",
    "wall_share",
    "inner_nusselt",
    "jet_enhancement",
    "power_factor",
    "ambient_offset",
];

/// A steady state.
#[derive(Clone, Debug)]
pub struct Steady {
    /// Wall temperature of the cells, K (mean over the thickness).
    pub wall: Vec<f64>,
    /// The gas.
    pub gas: Draught<f64>,
    /// Where the power goes, W.
    pub budget: HeatBalance,
    /// Newton steps taken.
    pub steps: usize,
    drive: Drive<f64>,
    parameters: TubeParameters,
}

/// A steady state with Newton's system there, which leads to its neighbours.
pub(crate) struct Nearby<'a> {
    steady: &'a Steady,
    system: System,
}

/// Derivatives of a steady state with respect to one of [`SENSITIVE_TO`].
#[derive(Clone, Debug, PartialEq)]
pub struct Sensitivity {
    /// Of the mass flow, kg/s.
    pub mass_flow: f64,
    /// Of the velocity at the heater, m/s.
    pub heater_velocity: f64,
    /// Of the gas temperature at the faces, K.
    pub temperature: Vec<f64>,
    /// Of the wall temperature of the cells, K.
    pub wall: Vec<f64>,
}

impl Pipe {
    /// The steady state at `power` (W) and `ambient` (K). Without power the tube is cold, exactly.
    ///
    /// # Errors
    /// [`FlowError::Power`], [`FlowError::Range`] for input out of range; [`FlowError::NotSteady`],
    /// [`FlowError::NoFlow`] if there is no answer.
    pub fn steady(&self, p: &TubeParameters, power: f64, ambient: f64) -> Result<Steady, FlowError> {
        let (wall, flow) = self.first_guess(p, power, ambient)?;
        self.steady_from(p, power, ambient, wall, flow)
    }

    /// As [`Pipe::steady`], starting from a neighbouring state: two or three steps instead of seven.
    ///
    /// # Errors
    /// As [`Pipe::steady`].
    pub fn steady_near(
        &self,
        p: &TubeParameters,
        power: f64,
        ambient: f64,
        near: &Steady,
    ) -> Result<Steady, FlowError> {
        self.first_guess(p, power, ambient)?; // for its checks of the input
        self.steady_from(p, power, ambient, near.wall.clone(), near.gas.mass_flow)
    }

    /// Newton's system at a `steady` state of this very tube.
    ///
    /// # Errors
    /// [`FlowError::NotSteady`] if it is singular.
    pub(crate) fn nearby<'a>(&self, steady: &'a Steady) -> Result<Nearby<'a>, FlowError> {
        let flow = steady.gas.mass_flow.max(super::draught::STILL);
        let tangent =
            self.tangent(&steady.wall, steady.drive, flow, &steady.parameters, &mut March::default());
        Ok(Nearby { steady, system: tangent.factorised()? })
    }

    /// The gas of a steady state of this tube, which hardly differs from that of `near`, by one step with the
    /// system there. The error is of second order in the difference, and even: central differences do not see
    /// it.
    ///
    /// # Errors
    /// As [`Pipe::steady`].
    pub(crate) fn gas_near(
        &self,
        p: &TubeParameters,
        power: f64,
        ambient: f64,
        near: &Nearby<'_>,
    ) -> Result<Draught<f64>, FlowError> {
        if power == 0.0 {
            return Ok(self.steady(p, power, ambient)?.gas);
        }
        let drive = Drive { released: power, ambient };
        let (mut wall, flow) = (near.steady.wall.clone(), Flow::new(near.steady.gas.mass_flow));
        let mut gas = Draught::at(near.steady.gas.mass_flow, March::default());
        self.march(&wall, drive, flow, p, &mut gas.march);
        let balance = self.balance(&gas.march, flow, ambient, p);
        let mut heat = Vec::new();
        self.wall_heat(&wall, drive, p, &gas, &mut heat);
        let rows = heat.iter().flat_map(|h| [-h, 0.0]).collect();
        let (change, dm) = near.system.solve(rows, balance.losses - balance.buoyancy);
        wall.iter_mut().zip(change.iter().step_by(2)).for_each(|(w, d)| *w += d);
        gas.mass_flow += dm;
        self.march(&wall, drive, Flow::new(gas.mass_flow), p, &mut gas.march);
        Ok(gas)
    }

    fn steady_from(
        &self,
        p: &TubeParameters,
        power: f64,
        ambient: f64,
        mut wall: Vec<f64>,
        mut flow: f64,
    ) -> Result<Steady, FlowError> {
        let drive = Drive { released: power, ambient };
        let mut march = March::default();
        let (mut residual, mut settled) = (f64::INFINITY, false);
        if power == 0.0 {
            wall.fill(ambient);
            flow = super::draught::STILL;
        }
        for steps in 0..STEPS {
            let tangent = self.tangent(&wall, drive, flow, p, &mut march);
            residual = tangent.heat.iter().fold(0.0_f64, |m, h| m.max(h.abs())) / power.max(1e-3);
            let unbalanced = if power == 0.0 { 0.0 } else { (tangent.excess / tangent.losses).abs() };
            // Very short cells conduct so well that rounding alone moves watts: then the last step decides.
            if (residual < 1e-12 && unbalanced < 1e-11) || (settled && residual < 1e-9) {
                let gas = Draught::at(if power == 0.0 { 0.0 } else { flow }, march);
                let budget = self.wall_heat(&wall, drive, p, &gas, &mut Vec::new());
                return Ok(Steady { wall, gas, budget, steps, drive, parameters: *p });
            }
            let (rows, excess) = (tangent.rows(), tangent.excess);
            let system = tangent.factorised()?;
            let (change, mut dm) = system.solve(rows, -excess);
            // Far from the solution: no wall moves by more than 80 K, the flow by no more than a half.
            let largest = change.iter().step_by(2).fold(0.0_f64, |m, d| m.max(d.abs()));
            let share = (80.0 / largest).min(0.5 * flow / dm.abs()).min(1.0);
            dm *= share;
            for (w, d) in wall.iter_mut().zip(change.iter().step_by(2)) {
                *w += share * d;
            }
            flow += dm;
            settled = largest < 1e-9 && dm.abs() < 1e-11 * flow;
            if !flow.is_finite() {
                break;
            }
        }
        Err(FlowError::NotSteady { steps: STEPS, residual })
    }

    /// Small-difference chimney law for the flow, a uniform hot column for the wall.
    fn first_guess(
        &self,
        p: &TubeParameters,
        power: f64,
        ambient: f64,
    ) -> Result<(Vec<f64>, f64), FlowError> {
        if power.is_nan() || power < 0.0 || power.is_infinite() {
            return Err(FlowError::Power { watts: power });
        }
        super::air::in_range("the ambient temperature", ambient)?;
        let density = self.air.pressure / (self.air.constant * ambient);
        let cp = self.air.specific_heat(ambient);
        let losses = 1.0 + self.closures.entrance_loss + self.closures.development_loss + p.heater_drag;
        let column = (self.length - self.heater).max(0.05);
        let cube = 2.0 * 9.81 * column * power / (density * cp * ambient * self.area * losses);
        let flow = 0.8 * density * self.area * cube.cbrt();
        let rise = if flow > 0.0 { (power / (flow * cp)).min(400.0) } else { 0.0 };
        let wall = self.faces.windows(2).map(|f| {
            let share = if f[1] > self.heater { 0.45 } else { 0.02 };
            ambient + share * rise
        });
        Ok((wall.collect(), flow.max(1e-6)))
    }
}

impl Steady {
    /// Derivatives with respect to each of [`SENSITIVE_TO`].
    ///
    /// # Errors
    /// [`FlowError::NotSteady`] if the linear system is singular. Without power only the ambient temperature
    /// acts.
    pub fn sensitivities(&self, pipe: &Pipe) -> Result<Vec<Sensitivity>, FlowError> {
        const P: usize = 9;
        let v = |value: f64, index: usize| Dual::<P>::variable(value, index);
        let p = &self.parameters;
        let parameters = TubeParameters {
            heater_drag: v(p.heater_drag, 0),
            outer_nusselt: v(p.outer_nusselt, 1),
            mount_resistance: v(p.mount_resistance, 2),
            wall_share: v(p.wall_share, 3),
            inner_nusselt: v(p.inner_nusselt, 4),
            jet_enhancement: v(p.jet_enhancement, 5),
        };
        let flow = self.gas.mass_flow.max(super::draught::STILL);
        let power = Dual::<P>::constant(self.drive.released) * v(1.0, 6);
        let drive = Drive { released: power, ambient: v(self.drive.ambient, 7) };
        let wall: Vec<Dual<P>> = self.wall.iter().map(|&w| Dual::constant(w)).collect();
        let mut gas = Draught::<Dual<P>>::empty();
        gas.mass_flow = Dual::constant(flow);
        pipe.march(&wall, drive, Flow::new(gas.mass_flow), &parameters, &mut gas.march);
        let balance = pipe.balance(&gas.march, Flow::new(gas.mass_flow), drive.ambient, &parameters);
        let excess = balance.buoyancy - balance.losses;
        let mut heat = Vec::new();
        pipe.wall_heat(&wall, drive, &parameters, &gas, &mut heat);
        let system = pipe.tangent(&self.wall, self.drive, flow, p, &mut March::default()).factorised()?;
        let n = wall.len();
        let edge = pipe.edges[0];
        let per_area = pipe.air.volume(1.0) / pipe.area;
        let one = |k: usize| {
            let mut rows = vec![0.0; 2 * n];
            heat.iter().enumerate().for_each(|(i, h)| rows[2 * i] = -h.slopes[k]);
            let (change, dm) = system.solve(rows, -excess.slopes[k]);
            let temperature: Vec<f64> = (0..=n)
                .map(|i| gas.march.face[i].slopes[k] + if i > 0 { change[2 * i - 1] } else { 0.0 })
                .collect();
            let heater_velocity =
                per_area * (dm * self.gas.march.face[edge] + self.gas.mass_flow * temperature[edge]);
            let wall = (0..n).map(|i| change[2 * i]).collect();
            Sensitivity { mass_flow: dm, heater_velocity, temperature, wall }
        };
        Ok((0..P - 1).map(one).collect())
    }

    /// What acoustics needs, without uncertainty.
    #[must_use]
    pub fn base_state(&self, pipe: &Pipe) -> BaseState {
        pipe.base_state(&self.gas)
    }
}

impl Pipe {
    /// What acoustics needs of the gas, without uncertainty.
    #[must_use]
    pub fn base_state(&self, gas: &Draught<f64>) -> BaseState {
        BaseState {
            gas: self.gas.clone(),
            pressure: self.air.pressure,
            mass_flux: gas.mass_flow / self.area,
            heater_velocity: self.heater_velocity(gas),
            places: self.faces.clone(),
            temperature: gas.march.face.clone(),
            errors: Vec::new(),
        }
    }
}
