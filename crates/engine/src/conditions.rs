//! An operating point with the state of its gas, and what a law sees at a place of it.

use rijke_rig::GasState;
use rijke_study::names::{
    AREA, AREA_AFTER, CONDUCTIVITY, DENSITY, DENSITY_AFTER, DIAMETER, GAMMA, MACH, MASS_FLUX, PERIMETER,
    PRANDTL, PRESSURE, SOUND_SPEED, SPECIFIC_HEAT, TEMPERATURE, TEMPERATURE_AFTER, VELOCITY, VISCOSITY,
};
use rijke_study::{Cause, Point, PointState, RigAtPoint};
use std::sync::Arc;

/// An operating point with the state of its gas.
#[derive(Clone, Debug)]
pub struct Conditions {
    /// Name of the operating point.
    pub id: String,
    /// The point.
    pub point: Point,
    /// Where everything is.
    pub layout: RigAtPoint,
    /// The gas along the ducts.
    pub base: PointState,
    /// For each factor that is not known exactly what its error does.
    pub displaced: Vec<Displaced>,
}

/// The conditions of a point with a factor at other values.
#[derive(Clone, Debug)]
pub struct Displaced {
    /// The error of the factor, and who shares it.
    pub cause: Cause,
    /// The standard deviation of the factor over its value.
    pub relative: f64,
    /// With the factor moved by a fiftieth of its standard deviation.
    pub near: Arc<Conditions>,
    /// With the factor so many of its standard deviations away as [`Displaced::FAR`] says, where the rig and
    /// its gas can be so.
    pub far: Option<[Arc<Conditions>; 4]>,
}

impl Displaced {
    /// Standard deviations of the factor at [`Displaced::far`].
    pub const FAR: [f64; 4] = [-1.0, 1.0, -2.0, 2.0];
}

impl Conditions {
    /// What a law sees in a segment of gas `gas` and cross-section `area`.
    pub(crate) fn around_piece(&self, gas: &GasState, area: f64) -> Vec<f64> {
        self.surroundings(gas, area, (gas.temperature, gas.density), area)
    }

    /// What a law sees at `x`: the gas on the upstream side, and temperature and area on the downstream side
    /// beside it.
    pub(crate) fn around(&self, x: f64) -> Vec<f64> {
        let [before, after] = self.layout.areas(x);
        let upstream_end = x <= 0.0;
        let temperatures = self.base.temperatures(x);
        let side = usize::from(upstream_end);
        let gas = self.base.gas_beside(x, side).at(temperatures[side], self.base.pressure);
        let area = if upstream_end { after } else { before };
        self.surroundings(&gas, area, self.behind(x), after)
    }

    /// Temperature (K) and density (kg/m^3) of the gas just downstream of `x`.
    pub(crate) fn behind(&self, x: f64) -> (f64, f64) {
        let temperature = self.base.temperatures(x)[1];
        (temperature, self.base.gas_beside(x, 1).at(temperature, self.base.pressure).density)
    }

    fn surroundings(&self, gas: &GasState, area: f64, behind: (f64, f64), area_after: f64) -> Vec<f64> {
        let mut all = self.layout.numbers.clone();
        let flux = self.base.mass_flow / area;
        let velocity = flux / gas.density;
        // Ducts are round unless their walls say otherwise.
        let diameter = 2.0 * (area / std::f64::consts::PI).sqrt();
        for (name, value) in [
            (DENSITY, gas.density),
            (SOUND_SPEED, gas.sound_speed),
            (TEMPERATURE, gas.temperature),
            (PRESSURE, gas.pressure),
            (VISCOSITY, gas.viscosity),
            (CONDUCTIVITY, gas.conductivity),
            (SPECIFIC_HEAT, gas.specific_heat),
            (GAMMA, gas.gamma),
            (PRANDTL, gas.prandtl),
            (VELOCITY, velocity),
            (MACH, velocity / gas.sound_speed),
            (MASS_FLUX, flux),
            (DIAMETER, diameter),
            (AREA, area),
            (PERIMETER, std::f64::consts::PI * diameter),
            (TEMPERATURE_AFTER, behind.0),
            (DENSITY_AFTER, behind.1),
            (AREA_AFTER, area_after),
        ] {
            all[name] = value;
        }
        for (name, value) in &self.base.numbers {
            all[*name] = *value;
        }
        all
    }
}
