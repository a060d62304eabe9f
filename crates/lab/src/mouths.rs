//! The two mouths of the tube as they are at one setting of the rig.

use crate::radiation::OpenEnd;
use crate::truth::Truth;
use crate::virtual_rig::normal;
use rijke_numerics::Streams;
use rijke_rig::{OperatingPoint, Rig};

/// The bottom and the top of the tube at `point` in the laboratory of `seed`.
///
/// Every time the rig is set anew, that is at every cold point and at every position of the hot heater, the mouths
/// come out a little different, both alike ([`crate::Ends::absorption_sd`], [`crate::Ends::extension_sd`]); all powers
/// at one position share one setting.
#[must_use]
pub fn mouths(rig: &Rig, truth: &Truth, point: &OperatingPoint, seed: u64) -> [OpenEnd; 2] {
    let setting = match (point.thermometers, point.id.rsplit_once('-')) {
        (true, Some((_, position))) => format!("hot-{position}"),
        _ => point.id.clone(),
    };
    let ends = &truth.ends;
    let mut stream = Streams::new(seed).stream(&format!("lab/mouths/{setting}"));
    let (loss, extension) =
        (ends.absorption_sd * normal(&mut stream), ends.extension_sd * normal(&mut stream));
    [ends.absorption_bottom, ends.absorption_top].map(|absorption| OpenEnd {
        inner_radius: rig.tube.radius(),
        outer_radius: rig.tube.radius() + rig.tube.wall_thickness,
        absorption: absorption + loss,
        extension,
    })
}

/// What a set of records says of where it comes from.
pub(crate) fn source(campaign: &str, seed: u64) -> String {
    format!("{SOURCE}, {campaign}, seed {seed}")
}

const SOURCE: &str = "virtual laboratory";

/// The seed of the laboratory that made the records whose source is `source`; none if they come from elsewhere.
#[must_use]
pub fn seed_of(source: &str) -> Option<u64> {
    let (_, seed) = source.strip_prefix(SOURCE)?.rsplit_once(", seed ")?;
    seed.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_the_source_names_its_seed() {
        assert_eq!(seed_of(&source("any campaign, seed 3", 17)), Some(17));
        assert_eq!(seed_of("laboratory of a friend, seed 3"), None);
    }
}
