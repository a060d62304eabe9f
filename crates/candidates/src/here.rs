//! The local state that a law sees.

use crate::Symbol;
use rijke_numerics::{C64, Jet, JetSpace};
use rijke_rig::{GasState, OperatingPoint, Rig};

/// The real quantities of one place at one operating point, ready to be looked up by [`Symbol`].
#[derive(Clone, Debug, PartialEq)]
pub struct Surroundings {
    values: [f64; Symbol::WallMu as usize],
}

/// Everything that a law may use: the real surroundings, s, and the quantities that depend on s.
///
/// `T` is a [`Jet`] where derivatives in the parameters are carried, and a [`Dual`] in a root search.
#[derive(Clone, Copy, Debug)]
pub struct Here<'a, T = Jet> {
    /// Number and order of the derivatives that jets carry.
    pub space: JetSpace,
    /// The real quantities.
    pub surroundings: &'a Surroundings,
    /// The complex angular frequency, a seed of `space`.
    pub s: &'a T,
    /// Viscous and thermal loss per metre of the tube wall; none where the wall model itself is evaluated.
    pub wall: Option<[&'a T; 2]>,
    /// Reflection coefficient of Levine and Schwinger; none away from the ends.
    pub levine_schwinger: Option<&'a T>,
}

impl Surroundings {
    /// The state at a place with gas `gas`. `ambient` in K; `flow` is the mean velocity at the heater in m/s and the mass
    /// flux in kg/(m^2 s), both 0 without flow.
    #[must_use]
    pub fn new(rig: &Rig, point: &OperatingPoint, gas: &GasState, ambient: f64, flow: [f64; 2]) -> Self {
        let (tube, heater) = (&rig.tube, &rig.heater);
        let mut all = Self { values: [0.0; Symbol::WallMu as usize] };
        for (symbol, value) in [
            (Symbol::Density, gas.density),
            (Symbol::SoundSpeed, gas.sound_speed),
            (Symbol::Temperature, gas.temperature),
            (Symbol::Pressure, gas.pressure),
            (Symbol::Viscosity, gas.viscosity),
            (Symbol::Conductivity, gas.conductivity),
            (Symbol::SpecificHeat, gas.specific_heat),
            (Symbol::Gamma, gas.gamma),
            (Symbol::Prandtl, gas.prandtl),
            (Symbol::AmbientTemperature, ambient),
            (Symbol::Length, tube.length),
            (Symbol::Diameter, tube.inner_diameter),
            (Symbol::Area, tube.area()),
            (Symbol::TubePerimeter, tube.perimeter()),
            (Symbol::ProngPerimeter, rig.prongs.perimeter()),
            (Symbol::ProngArea, rig.prongs.area()),
            (Symbol::Position, point.position.unwrap_or(0.0)),
            (Symbol::OpenArea, heater.open_area()),
            (Symbol::PlateThickness, heater.plate_thickness),
            (Symbol::PlateGap, heater.plate_gap),
            (Symbol::WireDiameter, heater.wire_diameter),
            (Symbol::Power, point.power),
            (Symbol::Velocity, flow[0]),
            (Symbol::MassFlux, flow[1]),
        ] {
            all.values[symbol as usize] = value;
        }
        all
    }

    /// The value of a real symbol; none for the symbols that depend on s.
    #[must_use]
    pub fn get(&self, symbol: Symbol) -> Option<f64> {
        if symbol == Symbol::S { None } else { self.values.get(symbol as usize).copied() }
    }
}

/// A value and its derivative with respect to s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual {
    /// The value.
    pub value: C64,
    /// d/ds.
    pub slope: C64,
}

impl<'a, T> Here<'a, T> {
    /// The value of a symbol that depends on s; none for the others, and where it does not exist.
    pub(crate) fn of_s(&self, symbol: Symbol) -> Option<&'a T> {
        match symbol {
            Symbol::S => Some(self.s),
            Symbol::WallMu => self.wall.map(|w| w[0]),
            Symbol::WallEp => self.wall.map(|w| w[1]),
            Symbol::LevineSchwinger => self.levine_schwinger,
            _ => None,
        }
    }
}

impl Here<'_> {
    /// The value of any symbol as a jet; none where it does not exist ([`Symbol::WallMu`] in the wall model).
    #[must_use]
    pub fn jet(&self, symbol: Symbol) -> Option<Jet> {
        match self.surroundings.get(symbol) {
            Some(real) => Some(self.space.real(real)),
            None => self.of_s(symbol).cloned(),
        }
    }

    /// The value of s.
    #[must_use]
    pub fn s_value(&self) -> C64 {
        self.s.value()
    }
}
