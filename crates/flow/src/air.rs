//! The gas as the kernels need it: the rig's formulas, for any [`Number`].

use crate::number::Number;
use rijke_rig::Gas;

/// A gas at the ambient pressure, with its constants ready for the kernels.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Air {
    pub(crate) pressure: f64,
    pub(crate) constant: f64,
    heat: [f64; 4],
    viscosity: [f64; 2],
    conductivity: [f64; 2],
}

impl Air {
    pub(crate) fn new(gas: &Gas, pressure: f64) -> Self {
        // Sutherland: reference (T/T0)^1.5 (T0 + S)/(T + S) = factor T sqrt(T)/(T + S).
        let factor = |[reference, s]: [f64; 2]| [reference * (273.15 + s) / 273.15_f64.powf(1.5), s];
        Self {
            pressure,
            constant: gas.constant(),
            heat: gas.heat_capacity.map(|c| c / gas.molar_mass),
            viscosity: factor(gas.viscosity),
            conductivity: factor(gas.conductivity),
        }
    }

    /// Specific heat at constant pressure, J/(kg K).
    pub(crate) fn specific_heat<N: Number>(&self, t: N) -> N {
        let [a, b, c, d] = self.heat;
        ((t * d + c) * t + b) * t + a
    }

    /// Enthalpy, J/kg: the integral of the specific heat from 0 K, of which only differences mean anything.
    pub(crate) fn enthalpy<N: Number>(&self, t: N) -> N {
        let [a, b, c, d] = self.heat;
        (((t * (d / 4.0) + c / 3.0) * t + b / 2.0) * t + a) * t
    }

    /// Dynamic viscosity, Pa s.
    pub(crate) fn viscosity<N: Number>(&self, t: N) -> N {
        let [factor, s] = self.viscosity;
        t * t.sqrt() / (t + s) * factor
    }

    /// Thermal conductivity, W/(m K).
    pub(crate) fn conductivity<N: Number>(&self, t: N) -> N {
        let [factor, s] = self.conductivity;
        t * t.sqrt() / (t + s) * factor
    }

    /// Specific volume, m^3/kg.
    pub(crate) fn volume<N: Number>(&self, t: N) -> N {
        t * (self.constant / self.pressure)
    }

    /// Speed of sound, m/s.
    pub(crate) fn sound_speed<N: Number>(&self, t: N) -> N {
        let cp = self.specific_heat(t);
        (t * cp / (cp - self.constant) * self.constant).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn oracle_kernels_agree_with_the_rig() {
        let (gas, p) = (Gas::air(), 101_325.0);
        let air = Air::new(&gas, p);
        for t in [250.0, 293.15, 480.0, 900.0] {
            let state = gas.at(t, p);
            assert_relative_eq!(air.specific_heat(t), state.specific_heat, max_relative = 1e-14);
            assert_relative_eq!(air.viscosity(t), state.viscosity, max_relative = 1e-13);
            assert_relative_eq!(air.conductivity(t), state.conductivity, max_relative = 1e-13);
            assert_relative_eq!(air.volume(t), 1.0 / state.density, max_relative = 1e-14);
            assert_relative_eq!(air.sound_speed(t), state.sound_speed, max_relative = 1e-14);
            let slope = (air.enthalpy(t + 0.1) - air.enthalpy(t - 0.1)) / 0.2;
            assert_relative_eq!(slope, state.specific_heat, max_relative = 1e-8);
        }
    }
}
