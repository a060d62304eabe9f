//! Transients: the wall in time, with the gas following it at once.

#[cfg(test)]
mod tests;

use super::draught::{Balanced, Draught};
use super::march::Drive;
use super::parameters::Unknowns;
use super::pipe::Pipe;
use super::wall::HeatBalance;
use crate::error::FlowError;
use crate::number::{Lanes, Number};

/// gamma of ROS2 that makes it L-stable with small errors.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
/// Constant slopes of the losses in the implicit matrix: W/(m K) of convection and radiation, W/(m K) to the
/// gas, and W/K of a mount; typical values. The scheme is second order whatever they are.
const OUTER: f64 = 1.1;
const INNER: f64 = 1.3;
const MOUNT: f64 = 0.4;

/// The wall, the heater's lag and the gas at one time.
///
/// The gas is quasi-steady: it holds 0.2 % of the wall's heat and passes in seconds. The wall advances by
/// ROS2 (Verwer, Spee, Blom & Hundsdorfer 1999), a W-method: second order for any matrix, and L-stable in the
/// stiff part, the conduction in small cells, which the matrix holds exactly. The matrix does not depend on
/// the state, so derivatives of the scheme are exact and one factorisation serves a whole run.
#[derive(Clone, Debug)]
pub struct Transient<N> {
    /// Wall temperature of the cells, K.
    pub wall: Vec<N>,
    /// Power released by the heater, W.
    pub released: N,
    /// Ambient temperature, K.
    pub ambient: N,
    /// The gas.
    pub gas: Draught<N>,
    heat: Vec<N>,
    stage: [Vec<N>; 2],
}

/// The implicit matrix I - gamma dt A, factorised.
#[derive(Clone, Debug)]
pub struct Implicit {
    dt: f64,
    /// Slopes of the losses per cell, 1/s: outer, inner, mounts.
    slopes: Vec<[f64; 3]>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    pivot: Vec<f64>,
}

/// Tolerance of the mass flow in ln(buoyancy/losses) during transients.
pub(crate) const TOLERANCE: f64 = 1e-8;
/// The same where derivatives are taken by differences or must be exact: 1e-9 in U_h.
pub(crate) const TIGHT: f64 = 1e-10;

impl Pipe {
    /// Factorises the implicit matrix for steps of `dt` seconds.
    #[must_use]
    pub fn implicit(&self, dt: f64) -> Implicit {
        let n = self.cells.len();
        let (mut lower, mut upper, mut pivot, mut slopes) =
            (vec![0.0; n], vec![0.0; n], vec![1.0; n], vec![]);
        for i in 0..n {
            let capacity = self.wall_capacity() * self.cells[i].length;
            let share = self.cells[i].length / capacity;
            let s = [OUTER * share, INNER * share, MOUNT * self.cells[i].mount / capacity];
            pivot[i] += GAMMA * dt * s.iter().sum::<f64>();
            slopes.push(s);
            if i > 0 {
                lower[i] = -GAMMA * dt * self.conductance(i - 1) / capacity;
                pivot[i] -= lower[i];
            }
            if i + 1 < n {
                upper[i] = -GAMMA * dt * self.conductance(i) / capacity;
                pivot[i] -= upper[i];
            }
        }
        for i in 1..n {
            lower[i] /= pivot[i - 1];
            pivot[i] -= lower[i] * upper[i - 1];
        }
        Implicit { dt, slopes, lower, upper, pivot }
    }
}

impl Implicit {
    /// Step size, s.
    #[must_use]
    pub fn dt(&self) -> f64 {
        self.dt
    }

    fn solve<N: Number>(&self, x: &mut [N]) {
        let n = x.len();
        for i in 1..n {
            x[i] = x[i] - x[i - 1] * self.lower[i];
        }
        x[n - 1] = x[n - 1] * (1.0 / self.pivot[n - 1]);
        for i in (0..n - 1).rev() {
            x[i] = (x[i] - x[i + 1] * self.upper[i]) * (1.0 / self.pivot[i]);
        }
    }
}

impl<N: Balanced> Transient<N> {
    /// Everything at the ambient temperature, no power released yet.
    ///
    /// # Errors
    /// [`FlowError::Range`] for an ambient temperature at which the properties of air do not hold, and as
    /// [`Transient::step`].
    pub fn cold(pipe: &Pipe, unknowns: &Unknowns<N>, ambient: f64) -> Result<Self, FlowError> {
        super::air::in_range("the ambient temperature", ambient)?;
        let ambient = unknowns.ambient_offset + ambient;
        let mut state = Self {
            wall: vec![ambient; pipe.size()],
            released: N::constant(0.0),
            ambient,
            gas: Draught::empty(),
            heat: Vec::new(),
            stage: [Vec::new(), Vec::new()],
        };
        state.refresh(pipe, unknowns, TOLERANCE)?;
        Ok(state)
    }

    /// Solves the gas for the present wall, power and ambient temperature; call after changing them from
    /// outside.
    ///
    /// # Errors
    /// [`FlowError::NoFlow`].
    pub fn refresh(&mut self, pipe: &Pipe, unknowns: &Unknowns<N>, tolerance: f64) -> Result<(), FlowError> {
        let drive = Drive { released: self.released, ambient: self.ambient };
        pipe.draught(&self.wall, drive, &unknowns.parameters, tolerance, &mut self.gas)
    }

    /// One step of `implicit.dt()` with the indicated `power` (W), to the indicated ambient temperature (K)
    /// at its end. Returns the energies of the step, J, which close to rounding: each loss is the mean of its
    /// two stages plus the scheme's own implicit correction.
    ///
    /// # Errors
    /// [`FlowError::NoFlow`] if the gas finds no balance, as when a temperature has left its range.
    pub fn step(
        &mut self,
        pipe: &Pipe,
        implicit: &Implicit,
        unknowns: &Unknowns<N>,
        power: f64,
        ambient: f64,
        tolerance: f64,
    ) -> Result<HeatBalance, FlowError> {
        self.step_each(pipe, implicit, unknowns, power, N::constant(ambient), tolerance)
    }

    /// As [`Transient::step`], with an indicated ambient temperature for each lane.
    pub(crate) fn step_each(
        &mut self,
        pipe: &Pipe,
        implicit: &Implicit,
        unknowns: &Unknowns<N>,
        power: f64,
        ambient: N,
        tolerance: f64,
    ) -> Result<HeatBalance, FlowError> {
        let (dt, n, p) = (implicit.dt, self.wall.len(), &unknowns.parameters);
        let mut energy = HeatBalance::default();
        // k1 from the present state.
        let drive = Drive { released: self.released, ambient: self.ambient };
        let first = pipe.wall_heat(&self.wall, drive, p, &self.gas, &mut self.heat);
        let [k1, k2] = &mut self.stage;
        rates(pipe, &self.heat, k1);
        implicit.solve(k1);
        implicit.book(pipe, &first, k1, &mut energy);
        // k2 at the end of the step, from the predictor wall + dt k1.
        let before = self.wall.clone();
        for (w, k) in self.wall.iter_mut().zip(k1.iter()) {
            *w = *w + *k * dt;
        }
        let supplied = unknowns.power_factor * power;
        let decay = (unknowns.heater_lag.recip() * -dt).exp();
        self.released = supplied + (self.released - supplied) * decay;
        self.ambient = unknowns.ambient_offset + ambient;
        let drive = Drive { released: self.released, ambient: self.ambient };
        pipe.draught(&self.wall, drive, p, tolerance, &mut self.gas)?;
        let second = pipe.wall_heat(&self.wall, drive, p, &self.gas, &mut self.heat);
        rates(pipe, &self.heat, k2);
        for i in 0..n {
            k2[i] = k2[i] - k1[i] * 2.0;
        }
        implicit.solve(k2);
        implicit.book(pipe, &second, k2, &mut energy);
        for i in 0..n {
            self.wall[i] = before[i] + (k1[i] * 1.5 + k2[i] * 0.5) * dt;
            energy.stored += (self.wall[i] - before[i]).total() * pipe.capacity(i);
        }
        pipe.draught(&self.wall, drive, p, tolerance, &mut self.gas)?;
        Ok(energy)
    }
}

impl<const L: usize> Transient<Lanes<L>> {
    /// At most L states side by side; the lanes left over repeat the last one.
    pub(crate) fn gather(states: &[Transient<f64>]) -> Option<Self> {
        let last = states.last()?;
        let blank = |values: &[f64]| vec![Lanes::constant(0.0); values.len()];
        let mut all = Self {
            wall: blank(&last.wall),
            released: Lanes::constant(0.0),
            ambient: Lanes::constant(0.0),
            gas: Draught::empty(),
            heat: Vec::new(),
            stage: [Vec::new(), Vec::new()],
        };
        (0..L).for_each(|k| all.set_lane(k, states.get(k).unwrap_or(last)));
        Some(all)
    }

    /// Lane `k` by itself.
    pub(crate) fn lane(&self, k: usize) -> Transient<f64> {
        Transient {
            wall: self.wall.iter().map(|w| w.0[k]).collect(),
            released: self.released.0[k],
            ambient: self.ambient.0[k],
            gas: self.gas.lane(k),
            heat: Vec::new(),
            stage: [Vec::new(), Vec::new()],
        }
    }

    /// Replaces lane `k`.
    pub(crate) fn set_lane(&mut self, k: usize, one: &Transient<f64>) {
        self.wall.iter_mut().zip(&one.wall).for_each(|(w, &v)| w.0[k] = v);
        (self.released.0[k], self.ambient.0[k]) = (one.released, one.ambient);
        self.gas.set_lane(k, &one.gas);
    }
}

impl Implicit {
    /// Adds half a step of one stage: its powers, and what the implicit matrix makes of each loss.
    fn book<N: Number>(&self, pipe: &Pipe, power: &HeatBalance, k: &[N], energy: &mut HeatBalance) {
        let mut implied = [0.0; 3];
        for (i, (slopes, k)) in self.slopes.iter().zip(k).enumerate() {
            let scale = GAMMA * self.dt * pipe.capacity(i) * k.total();
            implied.iter_mut().zip(slopes).for_each(|(sum, s)| *sum += scale * s);
        }
        let half = 0.5 * self.dt;
        energy.released += half * power.released;
        energy.convection += half * (power.convection + implied[0]);
        energy.gas += half * (power.gas + implied[1]);
        energy.radiation += half * power.radiation;
        energy.mounts += half * (power.mounts + implied[2]);
    }
}

impl Pipe {
    /// Heat capacity of the wall of cell `i`, J/K.
    pub(crate) fn capacity(&self, i: usize) -> f64 {
        self.wall_capacity() * self.cells[i].length
    }
}

fn rates<N: Number>(pipe: &Pipe, heat: &[N], rate: &mut Vec<N>) {
    rate.clear();
    rate.extend(heat.iter().enumerate().map(|(i, &q)| q * (1.0 / pipe.capacity(i))));
}
