//! The balances of a steady state with their derivatives, gathered in one march.

use crate::error::FlowError;
use crate::number::{Dual, Number};
use crate::tube::band::Band;
use crate::tube::draught::GRAVITY;
use crate::tube::march::{Drive, Flow, March};
use crate::tube::parameters::TubeParameters;
use crate::tube::pipe::Pipe;

/// Balances at one wall and mass flow, and Newton's linear system: rows 2i the heat of wall cell i, rows 2i +
/// 1 the gas leaving cell i; unknowns 2i the wall of cell i, 2i + 1 the gas at face i + 1; bordered by the
/// mass flow and the balance of the draught.
pub(super) struct Tangent {
    /// Heat into every cell of the wall, W.
    pub(super) heat: Vec<f64>,
    /// Buoyancy less losses, and the losses, Pa.
    pub(super) excess: f64,
    pub(super) losses: f64,
    system: System,
}

/// The linear system.
pub(super) struct System {
    band: Band,
    /// Derivatives of the rows with respect to the mass flow; in a system that is ready, the unknowns that
    /// would make up for them.
    along: Vec<f64>,
    /// Derivatives of the draught with respect to the unknowns, and to the mass flow.
    draught: Vec<f64>,
    draught_by_flow: f64,
}

impl Pipe {
    /// Marches the gas for an upward mass flow `flow` (kg/s), left in `march`, and takes all derivatives on
    /// the way.
    pub(super) fn tangent(
        &self,
        wall: &[f64],
        drive: Drive<f64>,
        flow: f64,
        p: &TubeParameters,
        march: &mut March<f64>,
    ) -> Tangent {
        let n = wall.len();
        let mut band = Band::zeros(2 * n);
        let (mut by_flow, mut draught) = (vec![0.0; 2 * n], vec![0.0; 2 * n]);
        let mut heat = vec![0.0; n];
        march.resize(n, 0.0);
        march.face[0] = drive.ambient;
        let parameters = p.map(Dual::<3>::constant);
        let single = p.map(Dual::<1>::constant);
        let released = Dual::constant(drive.released);
        let size = Flow::new(Dual::<3>::variable(flow, 2));
        let air = &self.air;
        let flux = flow / self.area;
        let friction = 32.0 * flux / (self.diameter * self.diameter);
        let outside = air.volume(drive.ambient).recip();
        let (mut buoyancy, mut heater, mut viscous, mut draught_by_flow) = (0.0, 0.0, 0.0, 0.0);
        for (i, cell) in self.cells.iter().enumerate() {
            let [t, w] = [Dual::<3>::variable(march.face[i], 0), Dual::<3>::variable(wall[i], 1)];
            let source = self.source(cell, released, parameters.wall_share);
            let (outflow, mean, to_wall) = self.cell(cell, size, t, w, source, &parameters);
            (march.face[i + 1], march.mean[i], march.to_wall[i]) = (outflow.value, mean.value, to_wall.value);
            let losses = self.losses(Dual::<1>::variable(wall[i], 0), Dual::constant(drive.ambient), &single);
            let lost = (losses.convection + losses.radiation) * cell.length;
            let mount = cell.mount / p.mount_resistance;
            // Wall row.
            let row = 2 * i;
            let share = p.wall_share * cell.heater + self.closures.radiated_share * cell.radiated;
            heat[i] +=
                to_wall.value + drive.released * share - lost.value - mount * (wall[i] - drive.ambient);
            band.add(row, row, to_wall.slopes[1] - lost.slopes[0] - mount);
            if i > 0 {
                band.add(row, row - 1, to_wall.slopes[0]);
            }
            if i + 1 < n {
                let k = self.conductance(i);
                let along = k * (wall[i] - wall[i + 1]);
                heat[i] -= along;
                heat[i + 1] += along;
                band.add(row, row, -k);
                band.add(row, row + 2, k);
                band.add(row + 2, row + 2, -k);
                band.add(row + 2, row, k);
            }
            by_flow[row] = to_wall.slopes[2];
            // Gas row: outflow(t, w, m) - T_{i+1} = 0.
            band.add(row + 1, row + 1, -1.0);
            band.add(row + 1, row, outflow.slopes[1]);
            if i > 0 {
                band.add(row + 1, row - 1, outflow.slopes[0]);
            }
            by_flow[row + 1] = outflow.slopes[2];
            // Draught: -g rho dx - friction mu v - C_d G^2 v/2, through the mean temperature.
            let mean_only = Dual::<1>::variable(mean.value, 0);
            let volume = air.volume(mean_only);
            let density = volume.recip();
            let viscosity = air.viscosity(mean_only) * volume * (cell.friction * cell.length);
            let drag = 0.5 * p.heater_drag * cell.heater * flux * flux;
            let slope = -density.slopes[0] * GRAVITY * cell.length
                - viscosity.slopes[0] * friction
                - volume.slopes[0] * drag;
            draught[row] += slope * mean.slopes[1];
            if i > 0 {
                draught[row - 1] += slope * mean.slopes[0];
            }
            draught_by_flow += slope * mean.slopes[2];
            buoyancy += (outside - density.value) * cell.length;
            heater += volume.value * cell.heater;
            viscous += viscosity.value;
        }
        let c = &self.closures;
        let (v_in, v_out) = (air.volume(march.face[0]), air.volume(march.face[n]));
        let entrance = 0.5 * (1.0 + c.entrance_loss + c.development_loss);
        let inertial = c.profile_factor * (v_out - v_in) + entrance * v_in + 0.5 * p.heater_drag * heater;
        draught[2 * n - 1] -= flux * flux * c.profile_factor * air.constant / air.pressure;
        draught_by_flow -=
            (2.0 * flux * inertial + 32.0 / (self.diameter * self.diameter) * viscous) / self.area;
        let losses = flux * flux * inertial + friction * viscous;
        let excess = GRAVITY * buoyancy - losses;
        Tangent { heat, excess, losses, system: System { band, along: by_flow, draught, draught_by_flow } }
    }
}

impl Tangent {
    /// Right-hand side of a Newton step: what the rows lack.
    pub(super) fn rows(&self) -> Vec<f64> {
        self.heat.iter().flat_map(|h| [-h, 0.0]).collect()
    }

    /// The system, ready to solve.
    ///
    /// # Errors
    /// [`FlowError::NotSteady`] if it is singular.
    pub(super) fn factorised(mut self) -> Result<System, FlowError> {
        let System { band, along, .. } = &mut self.system;
        if !band.factorise() {
            return Err(FlowError::NotSteady { steps: 0, residual: f64::NAN });
        }
        band.solve(along);
        Ok(self.system)
    }
}

impl System {
    /// Solves for the unknowns and the mass flow by eliminating the border.
    pub(super) fn solve(&self, mut rows: Vec<f64>, balance: f64) -> (Vec<f64>, f64) {
        self.band.solve(&mut rows);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let dm =
            (balance - dot(&self.draught, &rows)) / (self.draught_by_flow - dot(&self.draught, &self.along));
        rows.iter_mut().zip(&self.along).for_each(|(r, a)| *r -= dm * a);
        (rows, dm)
    }
}
