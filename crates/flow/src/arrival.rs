//! What is observed and reported of a gas state: arrival times and velocity at the heater.

use crate::draught::Draught;
use crate::number::Number;
use crate::pipe::Pipe;

impl Pipe {
    /// Time after the trigger at which a click from x = 0 arrives at each microphone, s: the integral of
    /// (1 + delta)/(c + u), and beyond the heater the delay L_or/(2c) of its orifices.
    ///
    /// delta = sqrt(nu/(2 omega))/a (1 + (gamma - 1)/sqrt(Pr)) is Kirchhoff's retardation by the boundary layers of
    /// the wall at the frequency of the pulse. Exact for uniform gas.
    pub fn arrival_times<N: Number>(&self, gas: &Draught<N>, orifice_length: N, times: &mut Vec<N>) {
        let air = &self.air;
        let omega = std::f64::consts::TAU * self.closures.pulse_frequency;
        let layer = (0.5 / omega).sqrt() / (0.5 * self.diameter);
        let flux = gas.mass_flow * (1.0 / self.area);
        let (mut time, mut orifice) = (N::constant(0.0), N::constant(0.0));
        let mut at_face = Vec::with_capacity(self.faces.len());
        at_face.push(time);
        for (cell, &t) in self.cells.iter().zip(&gas.march.mean) {
            let cp = air.specific_heat(t);
            let gamma = cp / (cp - air.constant);
            let c = (t * gamma * air.constant).sqrt();
            let mut slowness = (c + flux * air.volume(t)).recip();
            if layer > 0.0 {
                let (viscosity, volume) = (air.viscosity(t), air.volume(t));
                let prandtl = viscosity * cp / air.conductivity(t);
                let delta = (viscosity * volume).sqrt() * ((gamma - 1.0) / prandtl.sqrt() + 1.0) * layer;
                slowness = slowness * (delta + 1.0);
            }
            time = time + slowness * cell.length;
            if cell.heater > 0.0 {
                orifice = orifice + c.recip() * (0.5 * cell.heater);
            }
            at_face.push(time);
        }
        let delay = orifice * orifice_length;
        times.clear();
        times.extend(
            self.microphones.iter().map(
                |&(x, face)| {
                    if x > self.heater { at_face[face] + delay } else { at_face[face] }
                },
            ),
        );
    }

    /// Velocity of the gas that approaches the heater, U_h, m/s; negative for downward flow.
    pub fn heater_velocity<N: Number>(&self, gas: &Draught<N>) -> N {
        let edge = usize::from(gas.mass_flow.value() < 0.0);
        gas.mass_flow * self.air.volume(gas.march.face[self.edges[edge]]) * (1.0 / self.area)
    }
}
