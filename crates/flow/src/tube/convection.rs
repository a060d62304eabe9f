//! Natural convection from the outside of a vertical tube.

use super::air::Air;
use crate::number::Number;

/// A tube whose outer surface gives heat to still air.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Convection {
    height: f64,
    /// B [32^{1/2} L/D_o]^C and C of the slender-cylinder factor 1 + B [32^{1/2} Gr^{-1/4} L/D_o]^C (Popiel
    /// et al. 2007).
    slender: [f64; 2],
}

/// Prandtl number of the shape functions.
const PR: f64 = 0.71;
/// Smoothing of |T_w - T_a|, K, so that natural convection is differentiable at zero.
const SMOOTHING: f64 = 0.05;

impl Convection {
    /// For a tube of `height` and outer `diameter`, m.
    pub(crate) fn new(height: f64, diameter: f64) -> Self {
        let b = 0.057_132_2 + 0.203_05 * PR.powf(-0.43);
        let c = 0.9165 - 0.0043 * PR.sqrt() + 0.01333 * PR.ln() + 0.000_480_9 / PR;
        Self { height, slender: [b * (32.0_f64.sqrt() * (height / diameter)).powf(c), c] }
    }

    /// Coefficient of natural convection h_o, W/(m^2 K): Churchill & Chu (1975) on the tube's length times
    /// the slender-cylinder factor of Popiel, Wojtkowiak & Bober (2007); film properties; shape functions at
    /// Pr = 0.71, which moves them by less than 0.1 % up to 600 K.
    pub(crate) fn coefficient<N: Number>(&self, air: &Air, wall: N, ambient: N) -> N {
        let film = (wall + ambient) * 0.5;
        let difference = wall - ambient;
        let difference = difference.map(|d| (d.abs() + SMOOTHING, if d < 0.0 { -1.0 } else { 1.0 }));
        let kinematic = air.viscosity(film) * air.volume(film);
        let grashof = difference / (film * kinematic * kinematic) * (9.81 * self.height.powi(3));
        let ln = grashof.ln();
        let sixth = (ln * (1.0 / 6.0)).exp() * PR.powf(1.0 / 6.0);
        let plate = 0.387 / (1.0 + (0.492 / PR).powf(9.0 / 16.0)).powf(8.0 / 27.0);
        let root = sixth * plate + 0.825;
        let [slender, exponent] = self.slender;
        let factor = (ln * (-0.25 * exponent)).exp() * slender + 1.0;
        air.conductivity(film) * root * root * factor * (1.0 / self.height)
    }
}
