//! The heater as it stands in the tube: two annular plates with a gap, wound with wire, of finite thickness.

use crate::acoustics::obstacle::{Cylinders, HeatRelease, Lag, Obstacle, end_correction};
use crate::truth::{LawOfTable4, Truth};
use rijke_flow::BaseState;
use rijke_flow::{TubePoint, TubeRig};
use rijke_numerics::C64;
use std::f64::consts::PI;

/// The heater's three obstacles: its lower face, its middle (wires, gap, heat), its upper face. Between them
/// the gas flows through the bore of the plates, which are lines of their own.
pub(crate) struct Heater {
    pub(crate) lower_face: Obstacle,
    pub(crate) middle: Obstacle,
    pub(crate) upper_face: Obstacle,
}

/// The heater of an operating point whose base flow is `base`.
pub(crate) fn heater(
    rig: &TubeRig,
    truth: &Truth,
    point: &TubePoint,
    position: f64,
    base: &BaseState,
) -> Heater {
    let (geometry, values) = (&rig.plates, &truth.heater);
    let (area, open, half) = (rig.tube.area(), geometry.open_area(), 0.5 * geometry.length());
    let face = |x: f64| Obstacle {
        inertance: end_correction(0.5 * geometry.inner_diameter, rig.tube.radius()) / open,
        ..Obstacle::none(base.at(x), area)
    };
    let gas = base.at(position);
    let cylinders = Cylinders {
        length: values.wire_length_m,
        radius: 0.5 * geometry.wire_diameter,
        speed_up: values.wire_speed_up,
        crowding: values.wire_crowding,
    };
    let annulus = 0.25 * PI * geometry.outer_diameter.powi(2) - open;
    let below = base.at(position - half);
    let hot = HotWire::new(rig, truth, point, position, base);
    let middle = Obstacle {
        film: hot.film,
        // Mean flow through the plates: the steady loss C_d G u, of which the sound sees a share.
        resistance: values.steady_drag_share * truth.flow.parameters.heater_drag * base.mass_flux
            + below.density * (base.velocity(position + half) - base.velocity(position - half)).max(0.0),
        cylinders: Some(cylinders),
        volume: (area - open) * geometry.plate_gap,
        surface: 4.0 * annulus,
        heat: hot.release,
        drift: hot.drift,
        ..Obstacle::none(gas, area)
    };
    Heater { lower_face: face(position - half), middle, upper_face: face(position + half) }
}

/// The wire when current flows through it.
struct HotWire {
    film: rijke_rig::GasState,
    release: Option<HeatRelease>,
    drift: [C64; 2],
}

impl HotWire {
    fn new(rig: &TubeRig, truth: &Truth, point: &TubePoint, position: f64, base: &BaseState) -> Self {
        let (values, half, d) = (&truth.heater, 0.5 * rig.plates.length(), rig.plates.wire_diameter);
        let cold = base.at(position);
        let speed = values.wire_speed_up * base.velocity(position);
        if point.power <= 0.0 || speed <= 0.0 {
            return Self { film: cold, release: None, drift: [C64::ZERO; 2] };
        }
        // Wire temperature: share of the power = h pi d l (T_wire - T_gas), h = Nu k/d; Nu = 0.24 + 0.56
        // Re^0.45 with properties at film temperature, Collis & Williams, J. Fluid Mech. 6 (1959) 357, for Re
        // < 44 (here below 25). Five passes settle it.
        let (mut film, mut slope) = (cold, 0.0);
        for _ in 0..5 {
            let reynolds = speed * d * film.density / film.viscosity;
            let power_law = 0.56 * f64::powf(reynolds, 0.45);
            let nusselt = 0.24 + power_law;
            slope = 0.45 * power_law / nusselt;
            let conductance = nusselt * film.conductivity * PI * values.wire_length_m;
            let excess = values.wire_share * point.power / conductance;
            film = base_gas(rig, cold.temperature + 0.5 * excess);
        }
        let below = base.at(position - half);
        let speed_below = base.velocity(position - half);
        // Energy: (gamma - 1) Q'/(gamma p) = U2' - U1', Q' = share Q slope u'/u.
        let expansion =
            (below.gamma - 1.0) / (below.gamma * rig.pressure) * values.wire_share * point.power * slope;
        let momentum = base.mass_flux / rig.tube.area();
        let of_the_wire = HeatRelease {
            gain: expansion / (speed_below * rig.tube.area()),
            lag: Lag::Relaxation(values.lag_factor * 0.2 * d / speed),
            momentum,
        };
        let Some(law) = &values.law else {
            return Self { film, release: Some(of_the_wire), drift: [C64::ZERO; 2] };
        };
        let (gain, lag, drift) = law.at(point.power, speed_below, d, &below);
        Self { film, release: Some(HeatRelease { gain, lag, momentum }), drift }
    }
}

impl LawOfTable4 {
    /// Gain, lag, and what the drag drifts by, at a power (W), a velocity below the heater (m/s), a diameter
    /// of the wire (m) and the gas below: Table 4 of Juniper & Yoko 2022.
    fn at(&self, power: f64, velocity: f64, d: f64, gas: &rijke_rig::GasState) -> (f64, Lag, [C64; 2]) {
        let [k1, k2, k3, k4, k5, k6] = self.k;
        // King's law: Q (...)^-1/U, with the conductance of the wire's film.
        let peclet = velocity * d * gas.density / gas.viscosity * gas.prandtl * PI / 2.0;
        let king = power / ((peclet.powf(-0.5) + 2.0) * velocity);
        let gain = k1
            * match self.model {
                3 => power.powf(k3),
                4..=6 => king,
                _ => power,
            };
        let lag = match self.model {
            1 | 3 | 4 | 9 => Lag::Angle(k2),
            6 => Lag::Delay(k2 * 0.2 * d / velocity),
            _ => Lag::Delay(k2),
        };
        let impedance = gas.density * gas.sound_speed;
        let viscous = if self.model >= 7 { C64::new(k3, k4) * power * impedance } else { C64::ZERO };
        let thermal = if self.model >= 8 { C64::new(k5, k6) * power / impedance } else { C64::ZERO };
        (gain, lag, [viscous, thermal])
    }
}

fn base_gas(rig: &TubeRig, temperature: f64) -> rijke_rig::GasState {
    rig.gas.at(temperature, rig.pressure)
}

/// A thermocouple at `x`: a sheath that reaches to the axis.
pub(crate) fn thermocouple(rig: &TubeRig, truth: &Truth, x: f64, base: &BaseState) -> Obstacle {
    let values = &truth.thermocouples;
    let cylinders = Cylinders {
        length: values.depth_m,
        radius: 0.5 * values.sheath_diameter_m,
        speed_up: 1.0,
        crowding: 1.0,
    };
    Obstacle { cylinders: Some(cylinders), ..Obstacle::none(base.at(x), rig.tube.area()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rijke_flow::TubeCampaign;
    use rijke_numerics::C64;

    fn at(power: f64) -> (TubeRig, Truth, TubePoint, BaseState) {
        let (rig, truth) = (TubeRig::juniper_yoko_2022(), Truth::standard());
        let id = if power > 0.0 { "H180-25" } else { "C1-25" };
        let point = TubeCampaign::juniper_yoko_2022().points.into_iter().find(|p| p.id == id).unwrap();
        let point = TubePoint { power, ..point };
        let base = crate::apparatus::base::base_state(&rig, &truth, &point, 294.0).unwrap();
        (rig, truth, point, base)
    }

    #[test]
    fn paper_imaginary_part_of_the_cold_heater_is_about_six_times_the_real_part() {
        // Section 6.3: k_mu_h, whose imaginary part is six times its real part. Bore walls included by hand.
        let (rig, truth, point, base) = at(0.0);
        let h = heater(&rig, &truth, &point, 0.25, &base);
        let s = C64::new(0.0, 1050.0);
        let faces = h.lower_face.impedance(s) + h.upper_face.impedance(s);
        let bore = s * h.middle.gas.density * rig.plates.length() / rig.plates.open_area();
        let total = faces + bore + h.middle.impedance(s);
        let ratio = total.im / total.re;
        assert!((4.0..9.0).contains(&ratio), "{ratio}");
    }

    #[test]
    fn lab_heat_release_grows_with_power_and_lags_less_in_faster_flow() {
        let release = |power| {
            let (rig, truth, point, base) = at(power);
            heater(&rig, &truth, &point, 0.25, &base).middle.heat.unwrap()
        };
        let (low, high) = (release(30.0), release(180.0));
        let time = |r: &HeatRelease| if let Lag::Relaxation(time) = r.lag { time } else { f64::NAN };
        assert!(high.gain > 2.0 * low.gain && time(&high) < time(&low));
        let (rig, truth, point, base) = at(180.0);
        assert!(
            heater(&rig, &truth, &point, 0.25, &base).middle.film.temperature > base.temperature(0.25) + 20.0
        );
        assert!(at(0.0).3.heater_velocity.abs() < 1e-12);
    }
}
