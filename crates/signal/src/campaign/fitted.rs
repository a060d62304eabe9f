//! What became of one record.

use crate::Fault;
use crate::ping::{Drift, Excesses};
use rijke_numerics::words::counted;
use rijke_rig::{Click, Ping, RecordItem, Rejection};

/// The pings of each point that were fitted, in the order of the jobs.
pub(super) fn by_point<'a>(
    jobs: &[RecordItem],
    fitted: &'a [Fitted],
    points: usize,
) -> Vec<Vec<&'a PingOfRecord>> {
    let mut found: Vec<Vec<&PingOfRecord>> = vec![Vec::new(); points];
    for (job, fit) in jobs.iter().zip(fitted) {
        if let (RecordItem::Ping(point, _), Fitted::Ping(Ok(ping), _)) = (job, fit) {
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
    pub(super) excess: Excesses,
    /// How much of the decay was left out because another mode sounds there, s.
    pub(super) skipped_s: f64,
    /// When a part begins in which all channels hold one number to the end of the record, which is cut off,
    /// s.
    pub(super) padded_from_s: Option<f64>,
    /// White noise that its fit leaves, the first of it, row by row.
    pub(super) noise: Vec<f32>,
    /// The microphones that tell of it.
    pub(super) live: Vec<usize>,
    /// Those that recorded it and were left out, and why.
    pub(super) left_out: Vec<(usize, Fault)>,
}

#[derive(Clone, Debug)]
pub(super) enum Fitted {
    /// And the frequency of mains that it hums with beside the stated one, Hz.
    Ping(Result<Box<PingOfRecord>, Fault>, Option<f64>),
    /// A record that is a copy of another one.
    Copy(Rejection),
    /// Arrival times and the channels of opposite polarity; none without a calibration.
    Click(Result<Option<(Click, Vec<usize>)>, Fault>),
}

/// What to say of pings, by name, of which so many seconds of the decay were left out because another mode
/// sounds there.
pub(super) fn skipped_in_words(found: &[(&str, f64)]) -> Option<String> {
    let (name, most) = found.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(format!(
        "{} begin with another mode beside the wanted one, and the fit leaves out the part of the decay in which it sounds, {:.0} ms of {name} \
         at most; errors are larger for it. Drive the wanted mode alone to use the whole of the decay",
        counted(found.len(), "ping"),
        1e3 * most
    ))
}

/// What to say of pings, by name, whose last part, from a time (s) on, is one number.
pub(super) fn padded_in_words(found: &[(&str, f64)]) -> Option<String> {
    let (name, first) = found.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let (pings, end) = (counted(found.len(), "ping"), if found.len() == 1 { "ends" } else { "end" });
    Some(format!(
        "{pings} {end} in equal samples in all channels, {name} from {first:.4} s on: this part is cut off, and the rest is fitted. Let the \
         acquisition record as long as the file is"
    ))
}

/// A record that is not used, and why.
pub(super) fn rejection(record: &str, fault: &Fault) -> Rejection {
    Rejection { record: record.to_owned(), reason: fault.to_string() }
}
