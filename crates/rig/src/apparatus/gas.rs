//! Properties of the gas.

use crate::files::in_range;
use crate::problem::Problem;
use serde::{Deserialize, Serialize};

/// Universal gas constant, J/(mol K) (exact in the SI of 2019, to the digits given).
const UNIVERSAL: f64 = 8.314_462_618;

/// A perfect gas whose heat capacity is a cubic in temperature and whose transport follows Sutherland's law.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gas {
    /// Molar mass, kg/mol.
    pub molar_mass: f64,
    /// Molar heat capacity at constant pressure, J/(mol K): c_0 + c_1 T + c_2 T^2 + c_3 T^3, T in K.
    pub heat_capacity: [f64; 4],
    /// Sutherland's law of the viscosity: value in Pa s at 273.15 K, and the constant in K.
    pub viscosity: [f64; 2],
    /// Sutherland's law of the conductivity: value in W/(m K) at 273.15 K, and the constant in K.
    pub conductivity: [f64; 2],
}

/// The gas at one temperature and pressure; SI units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GasState {
    /// Temperature, K.
    pub temperature: f64,
    /// Pressure, Pa.
    pub pressure: f64,
    /// Density, kg/m^3.
    pub density: f64,
    /// Speed of sound, m/s.
    pub sound_speed: f64,
    /// Dynamic viscosity, Pa s.
    pub viscosity: f64,
    /// Thermal conductivity, W/(m K).
    pub conductivity: f64,
    /// Specific heat at constant pressure, J/(kg K).
    pub specific_heat: f64,
    /// Ratio of specific heats.
    pub gamma: f64,
    /// Prandtl number mu c_p / k.
    pub prandtl: f64,
}

impl Gas {
    /// Dry air. Heat capacity: Cengel & Boles, Thermodynamics, table A-2c (273 to 1800 K). Transport: White,
    /// Viscous Fluid Flow, 3rd ed., tables 1-2 and 1-3 (about 2 % from 210 to 1900 K).
    #[must_use]
    pub fn air() -> Self {
        Self {
            molar_mass: 28.97e-3,
            heat_capacity: [28.11, 0.1967e-2, 0.4802e-5, -1.966e-9],
            viscosity: [1.716e-5, 110.4],
            conductivity: [0.0241, 194.0],
        }
    }

    /// The gas of constant heat capacity and Prandtl number that has this state, and whose viscosity rises
    /// there as the power 0.7 of temperature: Sutherland's law with a constant of a quarter of the
    /// temperature. From 250 to 350 K the two laws differ by 0.3 %.
    #[must_use]
    pub fn of_state(state: &GasState) -> Self {
        let molar_mass = UNIVERSAL * state.temperature * state.density / state.pressure;
        let constant = 0.25 * state.temperature;
        let cold = sutherland([1.0, constant], state.temperature).recip();
        Self {
            molar_mass,
            heat_capacity: [state.specific_heat * molar_mass, 0.0, 0.0, 0.0],
            viscosity: [state.viscosity * cold, constant],
            conductivity: [state.conductivity * cold, constant],
        }
    }

    /// Refuses what no gas is, between 250 and 1500 K.
    ///
    /// # Errors
    /// Key and problem of the first number that makes no sense.
    pub fn validate(&self) -> Result<(), (String, Problem)> {
        in_range("gas.molar_mass", self.molar_mass, 1e-3, 0.5, "kg/mol")?;
        in_range("gas.viscosity[0]", self.viscosity[0], 1e-7, 1e-3, "Pa s")?;
        in_range("gas.viscosity[1]", self.viscosity[1], 0.0, 1e4, "K")?;
        in_range("gas.conductivity[0]", self.conductivity[0], 1e-4, 10.0, "W/(m K)")?;
        in_range("gas.conductivity[1]", self.conductivity[1], 0.0, 1e4, "K")?;
        for kelvin in [250.0, 500.0, 1500.0] {
            // 5/2 of the gas constant without inner motions; a large molecule has some twenty times as much.
            let over = self.at(kelvin, 101_325.0).specific_heat / self.constant();
            in_range(
                &format!("gas.heat_capacity at {kelvin} K"),
                over * UNIVERSAL,
                20.0,
                500.0,
                "J/(mol K)",
            )?;
        }
        Ok(())
    }

    /// Specific gas constant, J/(kg K).
    #[must_use]
    pub fn constant(&self) -> f64 {
        UNIVERSAL / self.molar_mass
    }

    /// All properties at `temperature` (K, positive) and `pressure` (Pa, positive). gamma follows the
    /// temperature: freezing it would move the speed of sound by 0.4 % at 500 K.
    #[must_use]
    pub fn at(&self, temperature: f64, pressure: f64) -> GasState {
        let (t, r) = (temperature, self.constant());
        let [c0, c1, c2, c3] = self.heat_capacity;
        let specific_heat = (c0 + t * (c1 + t * (c2 + t * c3))) / self.molar_mass;
        let gamma = specific_heat / (specific_heat - r);
        let (viscosity, conductivity) = (sutherland(self.viscosity, t), sutherland(self.conductivity, t));
        GasState {
            temperature,
            pressure,
            density: pressure / (r * t),
            sound_speed: (gamma * r * t).sqrt(),
            viscosity,
            conductivity,
            specific_heat,
            gamma,
            prandtl: viscosity * specific_heat / conductivity,
        }
    }
}

/// Sutherland's law: `[value at 273.15 K, constant in K]`.
fn sutherland([reference, constant]: [f64; 2], t: f64) -> f64 {
    reference * (t / 273.15).powf(1.5) * (273.15 + constant) / (t + constant)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn oracle_air_at_20_celsius() {
        let air = Gas::air().at(293.15, 101_325.0);
        // Handbook values for dry air at 20 C: 1.2041 kg/m^3, 343.2 m/s, 1.813e-5 Pa s, Pr 0.71.
        assert_relative_eq!(air.density, 1.2041, max_relative = 1e-3);
        assert_relative_eq!(air.sound_speed, 343.2, max_relative = 1e-3);
        assert_relative_eq!(air.viscosity, 1.813e-5, max_relative = 3e-3);
        assert_relative_eq!(air.prandtl, 0.71, max_relative = 1e-2);
        // The cold arrival time of the flow's acceptance list: 0.95 m at c(293.15 K) in 2.767067 ms.
        assert_relative_eq!(0.95 / air.sound_speed, 2.767_067e-3, max_relative = 3e-7);
    }

    #[test]
    fn oracle_air_from_cold_to_hot() {
        let at = |kelvin: f64| Gas::air().at(kelvin, 101_325.0);
        // U.S. Standard Atmosphere 1976, table 3: 1.4216e-5 Pa s at 216.65 K.
        assert_relative_eq!(at(216.65).viscosity, 1.4216e-5, max_relative = 1e-3);
        // Incropera & DeWitt, table A.4: heat capacity, J/(kg K), and conductivity, W/(m K).
        for (kelvin, heat, conductivity) in
            [(300.0, 1007.0, 0.0263), (600.0, 1051.0, 0.0469), (1000.0, 1141.0, 0.0667)]
        {
            assert_relative_eq!(at(kelvin).specific_heat, heat, max_relative = 6e-3);
            assert_relative_eq!(at(kelvin).conductivity, conductivity, max_relative = 0.02);
        }
    }
}
