//! What became of one record.

use crate::Fault;
use crate::ping::Drift;
use rijke_rig::{Click, Ping, Rejection};

#[derive(Clone, Debug)]
pub(super) enum Fitted {
    /// And the microphones that recorded it.
    Ping(Result<(Ping, Drift), Fault>, Vec<usize>),
    /// Arrival times and the channel of opposite polarity, if any; none without a calibration.
    Click(Result<Option<(Click, Option<usize>)>, Fault>),
}

/// A record that is not used, and why.
pub(super) fn rejection(record: &str, fault: &Fault) -> Rejection {
    Rejection { record: record.to_owned(), reason: fault.to_string() }
}
