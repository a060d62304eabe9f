//! What stands across the tube: the heater's wires, plates and gap, and thermocouples. Each is short against
//! a wavelength, so pressure and volume velocity jump: p1 = p2 + Z U1, U1 (1 + h) = U2 + Y p2 (1 below, 2
//! above).

use super::walls::outside;
use rijke_numerics::C64;
use rijke_rig::GasState;
use std::f64::consts::PI;

/// A short obstacle.
#[derive(Clone, Debug)]
pub struct Obstacle {
    /// The gas at the obstacle.
    pub gas: GasState,
    /// The gas in the boundary layers of hot surfaces (at film temperature); `gas` again where nothing is
    /// hot.
    pub film: GasState,
    /// Cross-section of the tube, m^2.
    pub area: f64,
    /// Mass end correction: length over area, 1/m.
    pub inertance: f64,
    /// Pressure drop per velocity in the tube that depends on no frequency, Pa s/m.
    pub resistance: f64,
    /// Thin cylinders across the flow.
    pub cylinders: Option<Cylinders>,
    /// Gas beside the passage, m^3.
    pub volume: f64,
    /// Surface that is isothermal on the scale of a period, other than the cylinders', m^2.
    pub surface: f64,
    /// Heat release that follows velocity.
    pub heat: Option<HeatRelease>,
    /// What else it takes: pressure drop per velocity in the tube, Pa s/m, and velocity per pressure, m/(Pa
    /// s).
    pub drift: [C64; 2],
}

/// Wires or probes across the flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinders {
    /// Length of all together, m.
    pub length: f64,
    /// Radius, m.
    pub radius: f64,
    /// Velocity at the cylinders over velocity in the tube.
    pub speed_up: f64,
    /// Drag over that of a single smooth cylinder.
    pub crowding: f64,
}

/// Heat that a hot cylinder gives off, with the lag of its boundary layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeatRelease {
    /// Relative velocity change above the heater per relative velocity change, at low frequency.
    pub gain: f64,
    /// How it lags behind.
    pub lag: Lag,
    /// rho1 u1 / A, Pa s/m^3: the momentum of the gas that is accelerated.
    pub momentum: f64,
}

/// A lag of heat release.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lag {
    /// The time constant of a boundary layer, s.
    Relaxation(f64),
    /// A delay, s.
    Delay(f64),
    /// An angle at all frequencies, rad.
    Angle(f64),
}

impl Obstacle {
    /// One that does nothing.
    #[must_use]
    pub fn none(gas: GasState, area: f64) -> Self {
        let (cylinders, heat) = (None, None);
        let (inertance, resistance, volume, surface) = (0.0, 0.0, 0.0, 0.0);
        let drift = [C64::ZERO; 2];
        Self { gas, film: gas, area, inertance, resistance, cylinders, volume, surface, heat, drift }
    }

    /// From just above to just below.
    #[must_use]
    pub fn descend(&self, s: C64, (p2, u2): (C64, C64)) -> (C64, C64) {
        let heat = self.heat.map_or(C64::ZERO, |h| h.transfer(s));
        let u1 = (u2 + self.admittance(s) * p2) / (1.0 + heat);
        // Momentum p + rho u^2 is conserved where heat accelerates the gas, to first order in the Mach
        // number.
        let acceleration = self.heat.map_or(C64::ZERO, |h| h.momentum * (u2 - u1));
        (p2 + self.impedance(s) * u1 + acceleration, u1)
    }

    /// Pressure drop per volume velocity, Pa s/m^3.
    #[must_use]
    pub fn impedance(&self, s: C64) -> C64 {
        let cylinders = self
            .cylinders
            .map_or(C64::ZERO, |c| c.length * c.drag(&self.film, s) * c.speed_up.powi(2) / self.area.powi(2));
        s * self.gas.density * self.inertance + (self.resistance + self.drift[0]) / self.area + cylinders
    }

    /// Volume velocity taken up per pressure, m^3/(s Pa): the compliance of the volume, and the boundary
    /// layers in which compression is isothermal.
    #[must_use]
    pub fn admittance(&self, s: C64) -> C64 {
        let (gas, stiffness) = (&self.gas, self.gas.density * self.gas.sound_speed.powi(2));
        let root = (s * self.film.density * self.film.prandtl / self.film.viscosity).sqrt();
        let plane = self.surface / root;
        let cylinders = self
            .cylinders
            .map_or(C64::ZERO, |c| 2.0 * PI * c.radius * c.length * outside(c.radius * root) / root);
        s / stiffness * (self.volume + (gas.gamma - 1.0) * (plane + cylinders)) + self.drift[1] * self.area
    }
}

impl Cylinders {
    /// Force per length and velocity on a cylinder in an oscillating stream, Pa s: Stokes 1851, rho s pi r^2
    /// (1 + 4 K1(z)/(z K0(z)) + 1), z = r sqrt(s/nu): viscous part and added mass, and the pressure gradient
    /// of the stream itself. Viscous part `crowding` times.
    fn drag(&self, gas: &GasState, s: C64) -> C64 {
        let z = self.radius * (s * gas.density / gas.viscosity).sqrt();
        let viscous = 4.0 * outside(z) / z;
        gas.density * s * PI * self.radius.powi(2) * (2.0 + self.crowding * viscous)
    }
}

impl HeatRelease {
    /// Relative velocity change above the heater per relative change below, with the lag of a hot cylinder: a
    /// simple relaxation, as Lighthill (Proc. R. Soc. A 224, 1954) finds at low frequency.
    fn transfer(&self, s: C64) -> C64 {
        match self.lag {
            Lag::Relaxation(time) => self.gain / (1.0 + s * time),
            Lag::Delay(time) => self.gain * (-s * time).exp(),
            Lag::Angle(angle) => C64::from_polar(self.gain, -angle),
        }
    }
}

/// Added length of a hole of radius `r` on one side of a plate that fills a tube of radius `outer`, m: 8 r/(3
/// pi) less what the wall of the tube confines (Ingard, J. Acoust. Soc. Am. 25, 1953, 1037), by the fit for a
/// round hole in a square cell (Atalla & Sgard, J. Sound Vib. 303, 2007, 195), taken at r/outer. It is larger
/// than Fok's function for a round tube.
pub(crate) fn end_correction(r: f64, outer: f64) -> f64 {
    let xi = r / outer;
    8.0 * r / (3.0 * PI) * (1.0 - 1.13 * xi - 0.09 * xi.powi(2) + 0.27 * xi.powi(3))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rijke_rig::Gas;

    fn gas() -> GasState {
        Gas::air().at(293.15, 101_325.0)
    }

    #[test]
    fn exact_drag_of_a_thick_cylinder_is_added_mass_and_boundary_layer() {
        // z large: rho s pi r^2 (2 + 4/z), that is 2 pi r (rho s r + 2 sqrt(rho mu s)): Stokes'
        // high-frequency limit.
        let cylinder = Cylinders { length: 1.0, radius: 0.1, speed_up: 1.0, crowding: 1.0 };
        let (gas, s) = (gas(), C64::new(0.0, 1000.0));
        let limit = 2.0 * PI * 0.1 * (gas.density * s * 0.1 + 2.0 * (gas.density * gas.viscosity * s).sqrt());
        assert!((cylinder.drag(&gas, s) / limit - 1.0).norm() < 1e-3);
    }

    #[test]
    fn exact_an_obstacle_that_is_nothing_does_nothing() {
        let state = (C64::new(2.0, 1.0), C64::new(-1e-3, 4e-3));
        assert_eq!(Obstacle::none(gas(), 1e-3).descend(C64::new(-9.0, 1000.0), state), state);
    }

    #[test]
    fn exact_heat_in_phase_with_velocity_expands_the_flow_and_lags_above_its_corner() {
        let heat = HeatRelease { gain: 0.1, lag: Lag::Relaxation(1e-3), momentum: 0.0 };
        let obstacle = Obstacle { heat: Some(heat), ..Obstacle::none(gas(), 1e-3) };
        let slow = obstacle.descend(C64::new(0.0, 1e-3), (C64::ONE, C64::new(1.1, 0.0))).1;
        assert!((slow - 1.0).norm() < 1e-5);
        assert!((heat.transfer(C64::new(0.0, 1e3)).arg() + PI / 4.0).abs() < 1e-12);
    }
}
