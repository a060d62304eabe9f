//! A rig for the tests of this crate.

use crate::Surroundings;
use rijke_rig::{Campaign, Rig};

/// The paper's rig at 20 C with the prongs at 0.35 m.
pub(crate) fn surroundings() -> Surroundings {
    at("C3-35", 0.0)
}

/// The paper's rig at 20 C at an operating point of Table 1, with a velocity at the heater in m/s.
pub(crate) fn at(id: &str, velocity: f64) -> Surroundings {
    heated(id, velocity, 293.15)
}

/// The same with gas at another temperature (K).
pub(crate) fn heated(id: &str, velocity: f64, temperature: f64) -> Surroundings {
    let (rig, campaign) = (Rig::juniper_yoko_2022(), Campaign::juniper_yoko_2022());
    let point = campaign.points.iter().find(|p| p.id == id).expect("a point of Table 1");
    let gas = rig.gas.at(temperature, rig.pressure);
    Surroundings::new(&rig, point, &gas, 293.15, [velocity, 1.2 * velocity])
}
