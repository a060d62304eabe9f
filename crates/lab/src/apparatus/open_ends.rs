//! The two open ends of the tube as they are at one installation of the rig.

use crate::acoustics::radiation::OpenEnd;
use crate::truth::Truth;
use rand::RngExt;
use rand_distr::StandardNormal;
use rijke_flow::{TubePoint, TubeRig};
use rijke_numerics::Streams;

/// The bottom and the top of the tube at `point` in the laboratory of `seed`.
///
/// Every time the rig is set anew, that is at every cold point and at every position of the hot heater, the
/// open ends come out a little different, both alike ([`crate::Ends::absorption_sd`],
/// [`crate::Ends::extension_sd`]); all powers at one position share one installation.
#[must_use]
pub fn open_ends(rig: &TubeRig, truth: &Truth, point: &TubePoint, seed: u64) -> [OpenEnd; 2] {
    let setting = match (point.thermometers, point.id.rsplit_once('-')) {
        (true, Some((_, position))) => format!("hot-{position}"),
        _ => point.id.clone(),
    };
    let ends = &truth.ends;
    let mut stream = Streams::new(seed).stream(&format!("lab/mouths/{setting}"));
    let mut normal = || stream.sample::<f64, _>(StandardNormal);
    let (loss, extension) = (ends.absorption_sd * normal(), ends.extension_sd * normal());
    [ends.absorption_bottom, ends.absorption_top].map(|absorption| OpenEnd {
        inner_radius: rig.tube.radius(),
        outer_radius: rig.tube.radius() + rig.tube.wall_thickness,
        absorption: absorption + loss,
        extension,
    })
}
