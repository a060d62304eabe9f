//! The names that a formula may use, apart from its own parameters.

/// A quantity of the local state that formulas may name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs, reason = "each variant is described once, in the table SYMBOLS")]
pub enum Symbol {
    S,
    Density,
    SoundSpeed,
    Temperature,
    Pressure,
    Viscosity,
    Conductivity,
    SpecificHeat,
    Gamma,
    Prandtl,
    AmbientTemperature,
    Length,
    Diameter,
    Area,
    TubePerimeter,
    ProngPerimeter,
    ProngArea,
    Position,
    OpenArea,
    PlateThickness,
    PlateGap,
    WireDiameter,
    Power,
    Velocity,
    MassFlux,
    WallMu,
    WallEp,
    LevineSchwinger,
}

/// What a symbol is called and what it means.
#[derive(Clone, Copy, Debug)]
pub struct Meaning {
    /// The symbol.
    pub symbol: Symbol,
    /// Its name in formulas.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// What it is.
    pub text: &'static str,
    /// Whether it depends on s, and therefore may not pass through a function that is not analytic.
    pub depends_on_s: bool,
}

const fn real(symbol: Symbol, name: &'static str, unit: &'static str, text: &'static str) -> Meaning {
    Meaning { symbol, name, unit, text, depends_on_s: false }
}

const fn of_s(symbol: Symbol, name: &'static str, unit: &'static str, text: &'static str) -> Meaning {
    Meaning { symbol, name, unit, text, depends_on_s: true }
}

/// Every symbol, in the order of [`Symbol`]. Gas properties are those at the place where the effect acts.
pub const SYMBOLS: [Meaning; 28] = [
    of_s(Symbol::S, "s", "1/s", "complex angular frequency, sigma + i omega"),
    real(Symbol::Density, "rho", "kg/m^3", "density"),
    real(Symbol::SoundSpeed, "c", "m/s", "speed of sound"),
    real(Symbol::Temperature, "T", "K", "gas temperature"),
    real(Symbol::Pressure, "p_0", "Pa", "mean pressure"),
    real(Symbol::Viscosity, "mu", "Pa s", "dynamic viscosity"),
    real(Symbol::Conductivity, "k_gas", "W/(m K)", "thermal conductivity of the gas"),
    real(Symbol::SpecificHeat, "c_p", "J/(kg K)", "specific heat at constant pressure"),
    real(Symbol::Gamma, "gamma", "1", "ratio of specific heats"),
    real(Symbol::Prandtl, "Pr", "1", "Prandtl number"),
    real(Symbol::AmbientTemperature, "T_amb", "K", "ambient temperature"),
    real(Symbol::Length, "L", "m", "length of the tube"),
    real(Symbol::Diameter, "D", "m", "inner diameter of the tube"),
    real(Symbol::Area, "A", "m^2", "inner cross-section of the tube"),
    real(Symbol::TubePerimeter, "P_t", "m", "inner perimeter of the tube"),
    real(Symbol::ProngPerimeter, "P_p", "m", "sum of the perimeters of prongs and feed wires"),
    real(Symbol::ProngArea, "A_p", "m^2", "sum of the cross-sections of prongs and feed wires"),
    real(Symbol::Position, "X_h", "m", "where the prongs end and the heater sits; 0 for the empty tube"),
    real(Symbol::OpenArea, "A_d", "m^2", "open area of a heater plate"),
    real(Symbol::PlateThickness, "t_h", "m", "thickness of a heater plate"),
    real(Symbol::PlateGap, "h_h", "m", "gap between the heater plates"),
    real(Symbol::WireDiameter, "d_w", "m", "diameter of the heating wire"),
    real(Symbol::Power, "Q_h", "W", "electrical power of the heater"),
    real(Symbol::Velocity, "U_h", "m/s", "mean velocity at the heater"),
    real(Symbol::MassFlux, "G", "kg/(m^2 s)", "mass flux of the mean flow, the same all along the tube"),
    of_s(
        Symbol::WallMu,
        "wall_mu",
        "kg/(m^3 s)",
        "viscous loss of the tube wall per metre, as the wall model gives it",
    ),
    of_s(
        Symbol::WallEp,
        "wall_ep",
        "1/(Pa s)",
        "thermal loss of the tube wall per metre, as the wall model gives it",
    ),
    of_s(
        Symbol::LevineSchwinger,
        "R_LS",
        "1",
        "reflection coefficient of Levine & Schwinger 1948 at ka = s a/(i c)",
    ),
];

impl Symbol {
    /// Name, unit and meaning.
    #[must_use]
    pub fn meaning(self) -> &'static Meaning {
        &SYMBOLS[self as usize]
    }

    /// Whether it is a property of the gas, which differs along a heated tube; all others are those of the rig and of
    /// the operating point.
    #[must_use]
    pub fn is_of_the_gas(self) -> bool {
        matches!(
            self,
            Self::Density
                | Self::SoundSpeed
                | Self::Temperature
                | Self::Pressure
                | Self::Viscosity
                | Self::Conductivity
                | Self::SpecificHeat
                | Self::Gamma
                | Self::Prandtl
        )
    }

    /// The symbol called `name` in formulas.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        SYMBOLS.iter().find(|m| m.name == name).map(|m| m.symbol)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_the_table_is_in_the_order_of_the_symbols() {
        for (k, meaning) in SYMBOLS.iter().enumerate() {
            assert_eq!(meaning.symbol as usize, k, "{}", meaning.name);
            assert_eq!(Symbol::named(meaning.name), Some(meaning.symbol));
        }
    }
}
