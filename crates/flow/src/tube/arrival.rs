//! What is observed and reported of a gas state: arrival times and velocity at the heater.

use super::draught::Draught;
use super::pipe::Pipe;
use crate::number::Number;

impl Pipe {
    /// Time after the trigger at which a click from x = 0 arrives at each microphone, s: the integral of
    /// (1 + delta)/(c + u), and beyond the heater the delay L_or/(2c) of its orifices.
    ///
    /// delta = sqrt(nu/(2 omega))/a (1 + (gamma - 1)/sqrt(Pr)) is Kirchhoff's retardation by the boundary
    /// layers of the wall at the frequency of the pulse. Exact for uniform gas.
    pub fn arrival_times<N: Number>(&self, gas: &Draught<N>, orifice_length: N, times: &mut Vec<N>) {
        let mut orifice = N::constant(0.0);
        for (cell, &t) in self.cells.iter().zip(&gas.march.mean).filter(|(cell, _)| cell.heater > 0.0) {
            orifice = orifice + self.air.sound_speed(t).recip() * (0.5 * cell.heater);
        }
        let delay = orifice * orifice_length;
        let at_face = self.times_at_faces(gas);
        times.clear();
        times.extend(
            self.microphones.iter().map(
                |&(x, face)| {
                    if x > self.heater { at_face[face] + delay } else { at_face[face] }
                },
            ),
        );
    }

    /// Time at which the click passes each face, s, without the delay of the orifices.
    pub(crate) fn times_at_faces<N: Number>(&self, gas: &Draught<N>) -> Vec<N> {
        let mut time = N::constant(0.0);
        let mut at_face = Vec::with_capacity(self.faces.len());
        at_face.push(time);
        for (cell, &t) in self.cells.iter().zip(&gas.march.mean) {
            time = time + self.slowness(gas, t) * cell.length;
            at_face.push(time);
        }
        at_face
    }

    /// Time at which the click passes `x`, s, where it passes the faces `at_face`: a cubic between the faces
    /// whose slopes there are those of the click, so that a grid that moves past `x` changes the time
    /// smoothly.
    pub(crate) fn time_at(&self, gas: &Draught<f64>, at_face: &[f64], x: f64) -> f64 {
        let upper = self.faces.partition_point(|&face| face <= x).clamp(1, self.cells.len());
        let (from, length) = (self.faces[upper - 1], self.cells[upper - 1].length);
        let s = (x - from) / length;
        let [low, high] = [upper - 1, upper].map(|k| self.slowness(gas, gas.march.face[k]) * length);
        let rise = at_face[upper] - at_face[upper - 1];
        at_face[upper - 1] + s * (low + s * (3.0 * rise - 2.0 * low - high + s * (low + high - 2.0 * rise)))
    }

    /// Of a click in gas at temperature `t` that moves with the flow, s/m.
    fn slowness<N: Number>(&self, gas: &Draught<N>, t: N) -> N {
        let flux = gas.mass_flow * (1.0 / self.area);
        let slowness = (self.air.sound_speed(t) + flux * self.air.volume(t)).recip();
        let layer = self.layer();
        if layer > 0.0 { slowness * (self.retardation(t) * layer + 1.0) } else { slowness }
    }

    /// delta of a cold tube at `ambient` (K): what signal processing takes out when it undoes the dispersion.
    pub(crate) fn cold_retardation(&self, ambient: f64) -> f64 {
        self.retardation(ambient) * self.layer()
    }

    /// 1/(a sqrt(2 omega)), s^{1/2}/m, at the frequency of the pulse; zero for an infinite one.
    fn layer(&self) -> f64 {
        let omega = std::f64::consts::TAU * self.closures.pulse_frequency;
        (0.5 / omega).sqrt() / (0.5 * self.diameter)
    }

    /// sqrt(nu) (1 + (gamma - 1)/sqrt(Pr)) at temperature `t`, m/s^{1/2}.
    fn retardation<N: Number>(&self, t: N) -> N {
        let air = &self.air;
        let cp = air.specific_heat(t);
        let gamma = cp / (cp - air.constant);
        let (viscosity, volume) = (air.viscosity(t), air.volume(t));
        let prandtl = viscosity * cp / air.conductivity(t);
        (viscosity * volume).sqrt() * ((gamma - 1.0) / prandtl.sqrt() + 1.0)
    }

    /// Velocity of the gas that approaches the heater, U_h, m/s; negative for downward flow.
    pub fn heater_velocity<N: Number>(&self, gas: &Draught<N>) -> N {
        let [lower, upper] = self.edges.map(|face| self.air.volume(gas.march.face[face]));
        let up = gas.mass_flow.map(|m| (m.max(0.0), if m < 0.0 { 0.0 } else { 1.0 }));
        let down = gas.mass_flow.map(|m| (m.min(0.0), if m < 0.0 { 1.0 } else { 0.0 }));
        (up * lower + down * upper) * (1.0 / self.area)
    }
}
