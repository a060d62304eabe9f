//! What stands in a duct, and what hangs on it.

use super::value::Value;
use crate::acoustics::duct::Stretch;
use crate::acoustics::obstacle::{Cylinders, Obstacle, end_correction};
use crate::acoustics::walls::Section;
use rijke_numerics::C64;
use rijke_rig::GasState;
use serde::Deserialize;
use std::f64::consts::PI;

/// Something short across the duct: wires, a grid, a holder.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ObstacleTruth {
    pub(crate) at: Value,
    #[serde(default)]
    pub(crate) present: Option<String>,
    /// Pressure drop per velocity at rest, Pa s/m.
    #[serde(default)]
    pub(crate) resistance: f64,
    /// Pressure drop per velocity and mass flux of the mean flow.
    #[serde(default)]
    pub(crate) loss: f64,
    /// Length of gas that moves with it, m.
    #[serde(default)]
    pub(crate) inertia: f64,
    #[serde(default)]
    pub(crate) wires: Option<WiresTruth>,
    /// Gas beside the passage, m^3.
    #[serde(default)]
    pub(crate) volume: f64,
    /// Isothermal surface other than the wires', m^2.
    #[serde(default)]
    pub(crate) surface: f64,
}

/// Wires across the flow.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct WiresTruth {
    pub(crate) diameter: f64,
    pub(crate) length: f64,
    pub(crate) speed_up: f64,
    /// Drag over that of a single smooth cylinder.
    pub(crate) crowding: f64,
}

impl ObstacleTruth {
    /// In a duct of `area`, m^2, filled with `gas`, with the mass flux `flux`, kg/(m^2 s).
    pub(crate) fn obstacle(&self, gas: GasState, area: f64, flux: f64) -> Obstacle {
        let cylinders = self.wires.map(|w| Cylinders {
            length: w.length,
            radius: 0.5 * w.diameter,
            speed_up: w.speed_up,
            crowding: w.crowding,
        });
        Obstacle {
            inertance: self.inertia / area,
            resistance: self.resistance + self.loss * flux,
            cylinders,
            volume: self.volume,
            surface: self.surface,
            ..Obstacle::none(gas, area)
        }
    }
}

/// A closed cavity that hangs on the duct by necks: a Helmholtz resonator, or a quarter-wave tube if the neck
/// is the cavity.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct BranchTruth {
    pub(crate) at: Value,
    #[serde(default)]
    pub(crate) present: Option<String>,
    /// How many necks, side by side.
    pub(crate) necks: f64,
    pub(crate) neck_diameter: f64,
    pub(crate) neck_length: f64,
    pub(crate) cavity_diameter: f64,
    pub(crate) cavity_depth: Value,
    /// Temperature of the gas in it, K; that of the duct if absent.
    #[serde(default)]
    pub(crate) temperature: Option<f64>,
    /// Pressure drop per velocity in a neck beyond the boundary layers, Pa s/m: edges, a felt, a bias flow.
    #[serde(default)]
    pub(crate) resistance: f64,
    /// Factor on the boundary layers.
    pub(crate) layers: f64,
}

/// The same at one operating point.
#[derive(Clone, Debug)]
pub(crate) struct Branch {
    gas: GasState,
    necks: f64,
    neck: Section,
    neck_length: f64,
    cavity: Section,
    depth: f64,
    /// Added masses at the duct's and at the cavity's side, m.
    corrections: [f64; 2],
    resistance: f64,
}

impl BranchTruth {
    /// On a duct of `radius`, m, with a cavity of `depth`, m, filled with `gas`; with or without the added
    /// mass of its necks.
    pub(crate) fn branch(&self, gas: GasState, radius: f64, depth: f64, added_mass: bool) -> Branch {
        let section =
            |diameter: f64| Section { radius: 0.5 * diameter, roughness: self.layers, rods: vec![] };
        let (hole, share) = (0.5 * self.neck_diameter, 0.5 * self.cavity_diameter / self.necks.sqrt());
        Branch {
            gas,
            necks: self.necks,
            neck: section(self.neck_diameter),
            neck_length: self.neck_length,
            cavity: section(self.cavity_diameter),
            depth,
            corrections: [radius, share].map(|r| if added_mass { end_correction(hole, r) } else { 0.0 }),
            resistance: self.resistance,
        }
    }
}

impl Branch {
    /// Volume velocity that it takes in, and the pressure in the duct that drives it, for unit pressure at
    /// the closed end of its cavity, m^3/(s Pa) and 1. Both are analytic in `s`; their quotient has a pole at
    /// each resonance.
    pub(crate) fn opening(&self, s: C64) -> (C64, C64) {
        let line = self.cavity.line(&self.gas, s);
        // From the closed end outwards, x towards the duct: U is what comes out.
        let (p, u) = Stretch::new(&line, &line, self.depth).ascend((C64::ONE, C64::ZERO));
        let (area, u) = (PI * self.neck.radius.powi(2), u / self.necks);
        let mass = |length: f64| s * self.gas.density * length / area;
        let neck = self.neck.line(&self.gas, s);
        let p = p - mass(self.corrections[1]) * u;
        let (p, u) = Stretch::new(&neck, &neck, self.neck_length).ascend((p, u));
        (-self.necks * u, p - (mass(self.corrections[0]) + self.resistance / area) * u)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rijke_rig::Gas;

    fn admittance(branch: &Branch, s: C64) -> C64 {
        let (u, p) = branch.opening(s);
        u / p
    }

    fn truth() -> BranchTruth {
        BranchTruth {
            at: Value::Number(0.0),
            present: None,
            necks: 1.0,
            neck_diameter: 0.01,
            neck_length: 0.02,
            cavity_diameter: 0.06,
            cavity_depth: Value::Number(0.05),
            temperature: None,
            resistance: 0.0,
            layers: 0.0,
        }
    }

    #[test]
    fn exact_a_short_cavity_is_a_helmholtz_resonator() {
        // Without losses and for a cavity short against the wave: Y = (s V/(rho c^2))/(1 + s^2/omega_0^2),
        // with omega_0^2 = c^2 A/(V l) and the added masses in l. The neck's own volume counts as well; what
        // the lines add beyond that is of second order.
        let gas = Gas::air().at(293.15, 101_325.0);
        let branch = truth().branch(gas, 0.05, 0.05, true);
        let (area, volume) = (PI * 0.005_f64.powi(2), PI * 0.03_f64.powi(2) * 0.05);
        let length = 0.02 + branch.corrections.iter().sum::<f64>();
        let natural = gas.sound_speed * (area / (volume * length)).sqrt();
        let s = C64::new(0.0, 0.3 * natural);
        let lumped = s * (volume + 0.02 * area) / (gas.density * gas.sound_speed.powi(2)) / (1.0 - 0.09);
        assert!((admittance(&branch, s) / lumped - 1.0).norm() < 3e-3);
    }

    #[test]
    fn exact_a_neck_as_wide_as_the_cavity_is_a_quarter_wave_tube() {
        // Y = A/(rho c) tanh(s l/c) with the length of both, without losses.
        let gas = Gas::air().at(293.15, 101_325.0);
        let tube = BranchTruth { neck_diameter: 0.06, ..truth() };
        let branch = tube.branch(gas, 0.05, 0.05, false);
        let s = C64::new(-20.0, 3000.0);
        let closed =
            PI * 0.03_f64.powi(2) / (gas.density * gas.sound_speed) * (s * 0.07 / gas.sound_speed).tanh();
        assert!((admittance(&branch, s) / closed - 1.0).norm() < 1e-12);
    }
}
