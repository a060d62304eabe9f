//! A rig for the tests of this crate.

use crate::Surroundings;
use rijke_rig::{Campaign, Rig};

/// The paper's rig at 20 C with the prongs at 0.35 m.
pub(crate) fn surroundings() -> Surroundings {
    let (rig, campaign) = (Rig::juniper_yoko_2022(), Campaign::juniper_yoko_2022());
    let point = campaign.points.iter().find(|p| p.id == "C3-35").expect("a point of Table 1");
    let gas = rig.gas.at(293.15, rig.pressure);
    Surroundings::new(&rig, point, &gas, 293.15, 0.0)
}
