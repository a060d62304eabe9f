//! What can go wrong.

use crate::Slot;
use rijke_numerics::C64;

/// Why a network has no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NetworkError {
    /// There is no segment.
    #[error("the network has no segment: give at least one")]
    Empty,
    /// A property of a segment is not a positive finite number.
    #[error("segment {index}: the {quantity} is {value}, but must be positive and finite")]
    Segment {
        /// Number of the segment, from 0.
        index: usize,
        /// Which property.
        quantity: &'static str,
        /// Its value.
        value: f64,
    },
    /// A position is outside the tube.
    #[error("position {x} m is outside the network, which reaches from 0 to {length} m")]
    Outside {
        /// The position, m.
        x: f64,
        /// Length of the network, m.
        length: f64,
    },
    /// No segment ends at a position.
    #[error("no segment ends at {x} m (the network is {length} m long): cut it there first")]
    NoPlace {
        /// The position, m.
        x: f64,
        /// Length of the network, m.
        length: f64,
    },
    /// There is no such slot.
    #[error("{slot:?} does not exist: the network has segments 0 to {} and places 0 to {segments}", segments - 1)]
    Slot {
        /// The slot asked for.
        slot: Slot,
        /// Number of segments.
        segments: usize,
    },
    /// Newton's iteration did not settle.
    #[error("Newton's iteration did not converge in {steps} steps; relative residual {residual:.2e}")]
    NotConverged {
        /// Number of steps taken.
        steps: usize,
        /// |Newton step| / |s| at the end.
        residual: f64,
    },
    /// Newton's iteration settled on a root far from the guess.
    #[error("the root found, {to}, is too far from the guess {from}: another branch")]
    LostBranch {
        /// The guess.
        from: C64,
        /// The root found.
        to: C64,
    },
    /// A coefficient is not a finite number.
    #[error("the network is not finite at s = {s}: a law has a pole or is undefined there")]
    NotFinite {
        /// Where.
        s: C64,
    },
    /// The pressure at the reference place vanishes.
    #[error("the mode has no pressure at the reference place {place}: choose another reference")]
    SilentReference {
        /// The place.
        place: usize,
    },
}

impl NetworkError {
    /// Whether another guess or another parameter value may succeed, so that a search can shorten its step.
    #[must_use]
    pub fn is_recoverable(&self) -> bool {
        matches!(
            self,
            Self::NotConverged { .. }
                | Self::LostBranch { .. }
                | Self::NotFinite { .. }
                | Self::SilentReference { .. }
        )
    }
}
