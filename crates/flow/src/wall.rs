//! The wall: one mean temperature per cell (Biot number h e/k = 1e-3), conduction, and losses to the room.

use crate::Parameters;
use crate::draught::Draught;
use crate::gas::Drive;
use crate::number::Number;
use crate::pipe::Pipe;

/// Stefan-Boltzmann constant, W/(m^2 K^4) (CODATA 2018).
const STEFAN_BOLTZMANN: f64 = 5.670_374_419e-8;
/// Smoothing of |T_w - T_a|, K, so that natural convection is differentiable at zero.
const SMOOTHING: f64 = 0.05;

/// Where the heat goes, W (or J, summed over time).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Budget {
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

impl Budget {
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

/// Prandtl number of the shape functions of natural convection.
const PR: f64 = 0.71;

/// B [32^{1/2} L/D_o]^C and C of the slender-cylinder factor 1 + B [32^{1/2} Gr^{-1/4} L/D_o]^C (Popiel et al. 2007), for
/// `slenderness` L/D_o.
pub(crate) fn slender(slenderness: f64) -> [f64; 2] {
    let b = 0.057_132_2 + 0.203_05 * PR.powf(-0.43);
    let c = 0.9165 - 0.0043 * PR.sqrt() + 0.01333 * PR.ln() + 0.000_480_9 / PR;
    [b * (32.0_f64.sqrt() * slenderness).powf(c), c]
}

impl Pipe {
    /// Coefficient of natural convection h_o, W/(m^2 K): Churchill & Chu (1975) on the tube's length times the
    /// slender-cylinder factor of Popiel, Wojtkowiak & Bober (2007); film properties; shape functions at Pr = 0.71,
    /// which moves them by less than 0.1 % up to 600 K.
    pub(crate) fn outer_coefficient<N: Number>(&self, wall: N, ambient: N) -> N {
        let film = (wall + ambient) * 0.5;
        let (air, height) = (&self.air, self.length);
        let difference = wall - ambient;
        let difference = difference.map(|d| (d.abs() + SMOOTHING, if d < 0.0 { -1.0 } else { 1.0 }));
        let kinematic = air.viscosity(film) * air.volume(film);
        let grashof = difference / (film * kinematic * kinematic) * (9.81 * height.powi(3));
        let ln = grashof.ln();
        let sixth = (ln * (1.0 / 6.0)).exp() * PR.powf(1.0 / 6.0);
        let plate = 0.387 / (1.0 + (0.492 / PR).powf(9.0 / 16.0)).powf(8.0 / 27.0);
        let root = sixth * plate + 0.825;
        let [slender, exponent] = self.slender;
        let factor = (ln * (-0.25 * exponent)).exp() * slender + 1.0;
        air.conductivity(film) * root * root * factor * (1.0 / height)
    }

    /// Convection and radiation of the outer wall, W/m.
    pub(crate) fn losses<N: Number>(&self, wall: N, ambient: N, p: &Parameters<N>) -> Losses<N> {
        let perimeter = std::f64::consts::PI * self.outer_diameter;
        let convection =
            p.outer_nusselt * self.outer_coefficient(wall, ambient) * (wall - ambient) * perimeter;
        let (w2, a2) = (wall * wall, ambient * ambient);
        let radiation = (w2 - a2) * (w2 + a2) * (self.closures.emissivity * STEFAN_BOLTZMANN * perimeter);
        Losses { convection, radiation }
    }

    /// Heat into every cell of the wall, W, with the gas as marched; returns where the released power goes at this
    /// instant, with what the wall gains as the sum of `heat`.
    pub(crate) fn wall_heat<N: Number>(
        &self,
        wall: &[N],
        drive: Drive<N>,
        p: &Parameters<N>,
        gas: &Draught<N>,
        heat: &mut Vec<N>,
    ) -> Budget {
        let (n, march) = (self.cells.len(), &gas.march);
        heat.clear();
        let to_mount = p.mount_resistance.recip();
        let mut budget = Budget { released: drive.released.total(), ..Budget::default() };
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
