//! The two ends of a chain.

use crate::acoustics::radiation::OpenEnd;
use rijke_numerics::C64;
use rijke_rig::GasState;
use serde::Deserialize;

/// An end as the truth file tells it.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(tag = "type", rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum EndTruth {
    /// A plate. What it takes in, in units of 1/(rho c): a share that is always there, one that grows with
    /// the mean velocity (per m/s), and the thermal boundary layer on it.
    Rigid {
        #[serde(default)]
        admittance: f64,
        #[serde(default)]
        per_velocity: f64,
        #[serde(default)]
        layer: bool,
    },
    /// An open end without flange, wall of this thickness, m; see [`OpenEnd`].
    Open {
        wall: f64,
        #[serde(default)]
        absorption: f64,
        #[serde(default)]
        extension: f64,
    },
    /// A reflection that depends on no frequency.
    Reflection { modulus: f64, angle: f64 },
}

/// An end at one operating point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct End {
    truth: EndTruth,
    gas: GasState,
    radius: f64,
    velocity: f64,
}

impl EndTruth {
    /// At a duct of `radius`, m, with `gas` and mean `velocity`, m/s.
    pub(crate) fn end(self, gas: GasState, radius: f64, velocity: f64) -> End {
        End { truth: self, gas, radius, velocity }
    }
}

impl End {
    /// Reflected over incident pressure.
    pub(crate) fn reflection(&self, s: C64) -> C64 {
        match self.truth {
            EndTruth::Rigid { admittance, per_velocity, layer } => {
                let gas = &self.gas;
                let diffusivity = gas.viscosity / (gas.density * gas.prandtl);
                let thermal = (gas.gamma - 1.0) * (s * diffusivity).sqrt() / gas.sound_speed;
                let y = admittance + per_velocity * self.velocity + if layer { thermal } else { C64::ZERO };
                (1.0 - y) / (1.0 + y)
            }
            EndTruth::Open { wall, absorption, extension } => {
                let outer_radius = self.radius + wall;
                OpenEnd { inner_radius: self.radius, outer_radius, absorption, extension }
                    .reflection(&self.gas, s)
            }
            EndTruth::Reflection { modulus, angle } => C64::from_polar(modulus, angle),
        }
    }

    /// Characteristic impedance of the volume velocity, Pa s/m^3.
    pub(crate) fn wave_impedance(&self) -> f64 {
        self.gas.density * self.gas.sound_speed / (std::f64::consts::PI * self.radius.powi(2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rijke_rig::Gas;

    #[test]
    fn exact_a_plate_that_takes_in_nothing_reflects_all() {
        let gas = Gas::air().at(293.15, 101_325.0);
        let end = |layer, per_velocity| {
            EndTruth::Rigid { admittance: 0.0, per_velocity, layer }.end(gas, 0.02, 0.5)
        };
        let s = C64::new(-5.0, 700.0);
        assert_eq!(end(false, 0.0).reflection(s), C64::ONE);
        // 0.002 per m/s at 0.5 m/s takes in 0.001.
        assert!((end(false, 0.002).reflection(s) - 0.999 / 1.001).norm() < 1e-15);
        // Cremer 1948: the thermal layer takes in (gamma - 1) sqrt(omega alpha)/c of modulus, with equal
        // parts.
        let y = (1.0 - end(true, 0.0).reflection(s)) / (1.0 + end(true, 0.0).reflection(s));
        assert!((y.re / y.im - 1.0).abs() < 0.01 && (y.norm() - 1.4e-4).abs() < 0.1e-4, "{y}");
    }
}
