//! What became of one record.

use crate::Fault;
use crate::ping::{Drift, Excess};
use rijke_rig::{Click, Ping, Rejection};

/// The pings of each point that were fitted, in the order of the jobs.
pub(super) fn by_point<'a>(
    jobs: &[(usize, usize, bool)],
    fitted: &'a [Fitted],
    points: usize,
) -> Vec<Vec<&'a PingOfRecord>> {
    let mut found: Vec<Vec<&PingOfRecord>> = vec![Vec::new(); points];
    for ((point, _, _), fit) in jobs.iter().zip(fitted) {
        if let Fitted::Ping(Ok(ping), _) = fit {
            found[*point].push(ping);
        }
    }
    found
}

/// The fit of one ping.
#[derive(Clone, Debug)]
pub(super) struct PingOfRecord {
    /// Which of the pings of its point.
    pub(super) repeat: usize,
    pub(super) ping: Ping,
    pub(super) drift: Drift,
    pub(super) excess: Excess,
    /// The microphones that tell of it.
    pub(super) live: Vec<usize>,
    /// Those that recorded it and were left out, and why.
    pub(super) left_out: Vec<(usize, Fault)>,
}

#[derive(Clone, Debug)]
pub(super) enum Fitted {
    /// And the frequency of mains that it hums with beside the stated one, Hz.
    Ping(Result<PingOfRecord, Fault>, Option<f64>),
    /// Arrival times and the channel of opposite polarity, if any; none without a calibration.
    Click(Result<Option<(Click, Option<usize>)>, Fault>),
}

/// A record that is not used, and why.
pub(super) fn rejection(record: &str, fault: &Fault) -> Rejection {
    Rejection { record: record.to_owned(), reason: fault.to_string() }
}
