//! The numbers of a chain with flow that laws attach to.

use super::ducts::ActionKind;
use crate::slot::Slot;

/// A law in a slot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Attached {
    pub(super) slot: Slot,
    pub(super) law: usize,
    pub(super) weight: f64,
}

impl Attached {
    /// Where it is feedback, and what it does there.
    pub(super) fn action(&self) -> Option<(usize, ActionKind)> {
        match self.slot {
            Slot::Mu(j) => Some((j, ActionKind::Mu)),
            Slot::Mp(j) => Some((j, ActionKind::Mp)),
            Slot::Eu(j) => Some((j, ActionKind::Eu)),
            Slot::Ep(j) => Some((j, ActionKind::Ep)),
            _ => None,
        }
    }

    pub(super) fn acts_at(&self, place: usize) -> bool {
        self.action().is_some_and(|(j, _)| j == place)
    }

    /// Whether the mean flow depends on it.
    pub(super) fn is_mean(&self) -> bool {
        matches!(self.slot, Slot::Area(_))
    }
}
