//! Whether the base state of a study is one of its rig.

use super::Base;
use crate::{Part, Rig, Shape, StudyProblem};

impl Base {
    /// Refuses what rig.toml says of the gas of a duct, and the base state does not use.
    pub(super) fn suits(&self, rig: &Rig) -> Result<(), StudyProblem> {
        let hot = |part: &&Part| matches!(&part.shape, Shape::Duct(duct) if !duct.temperatures.is_empty());
        if let Some(part) = rig.parts.iter().find(hot).filter(|_| !matches!(self, Self::Rig)) {
            return Err(StudyProblem::UnusedTemperature { part: part.name.clone() });
        }
        let other = rig.parts.iter().find(|part| part.is_of_other_gas());
        match (self, other) {
            (Self::States(_) | Self::HeatedFlow(_) | Self::Measured(_), Some(part)) => {
                Err(StudyProblem::OtherGas { part: part.name.clone() })
            }
            _ => Ok(()),
        }
    }
}
