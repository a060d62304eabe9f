//! The wall: one mean temperature per cell (Biot number h e/k = 1e-3), conduction, and losses to the room.

use super::draught::Draught;
use super::march::Drive;
use super::parameters::TubeParameters;
use super::pipe::Pipe;
use crate::number::Number;

/// Stefan-Boltzmann constant, W/(m^2 K^4) (CODATA 2018).
const STEFAN_BOLTZMANN: f64 = 5.670_374_419e-8;

/// Where the heat goes, W (or J, summed over time).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeatBalance {
    /// Power released by the heater.
    pub released: f64,
    /// Carried out by the gas.
    pub gas: f64,
    /// Convection from the outer wall.
    pub convection: f64,
    /// Radiation from the outer wall.
    pub radiation: f64,
    /// Conduction through the mounts.
    pub mounts: f64,
    /// Gained by the wall.
    pub stored: f64,
}

impl HeatBalance {
    /// Released minus everything it went to; zero but for rounding.
    #[must_use]
    pub fn imbalance(&self) -> f64 {
        self.released - self.gas - self.convection - self.radiation - self.mounts - self.stored
    }
}

/// Losses of one cell to the room, W per metre.
pub(crate) struct Losses<N> {
    pub(crate) convection: N,
    pub(crate) radiation: N,
}

impl Pipe {
    /// Convection and radiation of the outer wall, W/m.
    pub(crate) fn losses<N: Number>(&self, wall: N, ambient: N, p: &TubeParameters<N>) -> Losses<N> {
        let perimeter = std::f64::consts::PI * self.outer_diameter;
        let convection = p.outer_nusselt
            * self.outside.coefficient(&self.air, wall, ambient)
            * (wall - ambient)
            * perimeter;
        let (w2, a2) = (wall * wall, ambient * ambient);
        let radiation = (w2 - a2) * (w2 + a2) * (self.closures.emissivity * STEFAN_BOLTZMANN * perimeter);
        Losses { convection, radiation }
    }

    /// Heat into every cell of the wall, W, with the gas as marched; returns where the released power goes at
    /// this instant, with what the wall gains as the sum of `heat`.
    pub(crate) fn wall_heat<N: Number>(
        &self,
        wall: &[N],
        drive: Drive<N>,
        p: &TubeParameters<N>,
        gas: &Draught<N>,
        heat: &mut Vec<N>,
    ) -> HeatBalance {
        let (n, march) = (self.cells.len(), &gas.march);
        heat.clear();
        let to_mount = p.mount_resistance.recip();
        let mut budget = HeatBalance { released: drive.released.total(), ..HeatBalance::default() };
        for (i, cell) in self.cells.iter().enumerate() {
            let out = self.losses(wall[i], drive.ambient, p);
            let mount = (wall[i] - drive.ambient) * to_mount * cell.mount;
            let share = p.wall_share * cell.heater + self.closures.radiated_share * cell.radiated;
            let (convection, radiation) = (out.convection * cell.length, out.radiation * cell.length);
            heat.push(march.to_wall[i] + drive.released * share - convection - radiation - mount);
            budget.convection += convection.total();
            budget.radiation += radiation.total();
            budget.mounts += mount.total();
        }
        for i in 0..n - 1 {
            let flux = (wall[i] - wall[i + 1]) * self.conductance(i);
            heat[i] = heat[i] - flux;
            heat[i + 1] = heat[i + 1] + flux;
        }
        let enthalpy = |face: usize| self.air.enthalpy(march.face[face]);
        budget.gas = (gas.mass_flow * (enthalpy(n) - enthalpy(0))).total();
        budget.stored = heat.iter().map(|h| h.total()).sum();
        budget
    }
}
