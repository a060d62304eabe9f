//! The gas in a rig.

use crate::StudyProblem;
use rijke_rig::{Gas, GasState};
use toml::Table;

/// Lists of numbers in a gas whose properties follow temperature, and what they hold.
const LISTS: [(&str, usize, &str); 3] = [
    (
        "heat_capacity",
        4,
        "four numbers: c0 to c3 of c0 + c1 T + c2 T^2 + c3 T^3 in J/(mol K), 0 where a gas has none",
    ),
    ("viscosity", 2, "two numbers: its value at 273.15 K in Pa s, and the constant of Sutherland's law in K"),
    (
        "conductivity",
        2,
        "two numbers: its value at 273.15 K in W/(m K), and the constant of Sutherland's law in K",
    ),
];

/// Refuses a list of another length, or what is none.
pub(super) fn check_lists(table: &Table) -> Result<(), StudyProblem> {
    for (key, count, need) in LISTS {
        let Some(value) = table.get(key) else { continue };
        if value.as_array().is_none_or(|list| list.len() != count) {
            return Err(StudyProblem::Value { key: key.to_owned(), value: value.to_string(), need });
        }
    }
    Ok(())
}

/// The gas: how its properties follow from temperature and pressure.
#[derive(Clone, Debug, PartialEq)]
pub enum GasModel {
    /// Heat capacity and transport follow temperature.
    Real(Gas),
    /// Constant ratio of specific heats and Prandtl number; viscosity by the power 0.7 of temperature.
    Perfect {
        /// Ratio of specific heats.
        gamma: f64,
        /// Specific gas constant, J/(kg K).
        constant: f64,
        /// Viscosity, Pa s, and the temperature that it belongs to, K.
        viscosity: [f64; 2],
        /// Prandtl number.
        prandtl: f64,
    },
}

impl GasModel {
    /// Specific gas constant, J/(kg K).
    #[must_use]
    pub fn constant(&self) -> f64 {
        match self {
            Self::Real(gas) => gas.constant(),
            Self::Perfect { constant, .. } => *constant,
        }
    }

    /// The gas with another ratio of specific heats and another gas constant (J/(kg K)), where they are
    /// given; none for a gas whose properties follow temperature.
    #[must_use]
    pub fn with(&self, [gamma, constant]: [Option<f64>; 2]) -> Option<Self> {
        let Self::Perfect { gamma: own, constant: own_constant, viscosity, prandtl } = *self else {
            return None;
        };
        let (gamma, constant) = (gamma.unwrap_or(own), constant.unwrap_or(own_constant));
        Some(Self::Perfect { gamma, constant, viscosity, prandtl })
    }

    /// c_p at `temperature` (K) and y K above it, over that at `temperature`, less 1: factors of y, y^2, y^3.
    #[must_use]
    pub fn growth_of_heat_capacity(&self, temperature: f64) -> [f64; 3] {
        let Self::Real(gas) = self else { return [0.0; 3] };
        let ([c0, c1, c2, c3], t) = (gas.heat_capacity, temperature);
        let here = c0 + t * (c1 + t * (c2 + t * c3));
        [c1 + t * (2.0 * c2 + t * 3.0 * c3), c2 + 3.0 * t * c3, c3].map(|by| by / here)
    }

    /// All properties at `temperature` (K) and `pressure` (Pa).
    #[must_use]
    pub fn at(&self, temperature: f64, pressure: f64) -> GasState {
        match self {
            Self::Real(gas) => gas.at(temperature, pressure),
            Self::Perfect { gamma, constant, viscosity: [viscosity, reference], prandtl } => {
                let viscosity = viscosity * (temperature / reference).powf(0.7);
                let specific_heat = gamma * constant / (gamma - 1.0);
                GasState {
                    temperature,
                    pressure,
                    density: pressure / (constant * temperature),
                    sound_speed: (gamma * constant * temperature).sqrt(),
                    viscosity,
                    conductivity: viscosity * specific_heat / prandtl,
                    specific_heat,
                    gamma: *gamma,
                    prandtl: *prandtl,
                }
            }
        }
    }
}
