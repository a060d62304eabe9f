//! The numbers of a chain with flow that laws attach to.

use super::ducts::ActionKind;
use crate::error::NetworkError;
use crate::slot::Slot;

/// A number of a chain with flow that laws can change: what it is in the chain plus the sum of weight times
/// law over everything attached to it. Ducts and places are numbered from 0; place j lies before duct j.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlowSlot {
    /// Length of a duct, m. References of actions keep their distances.
    Length(usize),
    /// Area of a duct, m^2; the mean flow follows.
    Area(usize),
    /// Temperature ratio at the upstream end of a duct; the mean flow follows.
    Ratio(usize),
    /// Pressure of the inlet state, Pa.
    Pressure,
    /// Density of the inlet state, kg/m^3.
    Density,
    /// Velocity of the inlet state, m/s.
    Velocity,
    /// Viscous loss per metre of a duct, Pa s/m^2.
    Viscous(usize),
    /// Thermal loss per metre of a duct, 1/(Pa s).
    Thermal(usize),
    /// Feedback at a place from the velocity or pressure in front of it.
    At(usize, ActionKind),
    /// The coefficient of an action that the duct has: duct, number of the action. It hears where the action
    /// does.
    Action(usize, usize),
    /// R_u; not of a choked end.
    Upstream,
    /// R_d; not of a choked end.
    Downstream,
}

impl FlowSlot {
    /// Whether the mean flow depends on it.
    pub(super) fn is_mean(self) -> bool {
        matches!(self, Self::Area(_) | Self::Ratio(_) | Self::Pressure | Self::Density | Self::Velocity)
    }
}

impl TryFrom<Slot> for FlowSlot {
    type Error = NetworkError;

    /// # Errors
    /// [`NetworkError::SlotOfRest`] for sound speeds and densities, which follow from the inlet with flow.
    fn try_from(slot: Slot) -> Result<Self, NetworkError> {
        Ok(match slot {
            Slot::Length(i) => Self::Length(i),
            Slot::Area(i) => Self::Area(i),
            Slot::Viscous(i) => Self::Viscous(i),
            Slot::Thermal(i) => Self::Thermal(i),
            Slot::Mu(j) => Self::At(j, ActionKind::Mu),
            Slot::Mp(j) => Self::At(j, ActionKind::Mp),
            Slot::Eu(j) => Self::At(j, ActionKind::Eu),
            Slot::Ep(j) => Self::At(j, ActionKind::Ep),
            Slot::Upstream => Self::Upstream,
            Slot::Downstream => Self::Downstream,
            Slot::SoundSpeed(_) | Slot::Density(_) => return Err(NetworkError::SlotOfRest { slot }),
        })
    }
}

/// A law in a slot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Attached {
    pub(super) slot: FlowSlot,
    pub(super) law: usize,
    pub(super) weight: f64,
}

impl Attached {
    pub(super) fn acts_at(&self, place: usize) -> bool {
        matches!(self.slot, FlowSlot::At(j, _) if j == place)
    }
}
