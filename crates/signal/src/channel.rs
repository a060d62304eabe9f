//! A channel of a record, as messages call it.

use std::fmt;

/// A channel of a record: by its place there, or by the microphone of the rig that it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Channel {
    /// Its place among the channels of the record, from 0.
    Place(usize),
    /// The microphone that it records.
    Microphone {
        /// Its number in the rig, from 0.
        number: usize,
        /// Its name in the rig.
        name: Box<str>,
    },
}

impl Channel {
    /// Its place, or the number of its microphone.
    #[must_use]
    pub fn number(&self) -> usize {
        match self {
            Self::Place(number) | Self::Microphone { number, .. } => *number,
        }
    }

    /// Calls it as `others` call the channel at its place, if they have one.
    pub(crate) fn call(&mut self, others: &[Self]) {
        if let Self::Place(place) = self
            && let Some(other) = others.get(*place)
        {
            *self = other.clone();
        }
    }
}

impl From<usize> for Channel {
    fn from(place: usize) -> Self {
        Self::Place(place)
    }
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Place(place) => write!(f, "channel {place}"),
            Self::Microphone { number, name } => write!(f, "microphone {number} ({name})"),
        }
    }
}
