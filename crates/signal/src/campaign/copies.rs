//! Copies of one record under several names: a file that was cut, scaled, converted or saved again.
//!
//! What a fit leaves of a record is white noise. Of two records of n samples of it, the correlation r =
//! a'b/(|a| |b|) has the standard deviation 1/sqrt(n) about zero if they are independent; a copy keeps its
//! noise, whatever its scale is and where it ends. The mean over a record and its copies is no better than
//! the record.

use super::fitted::{Fitted, PingOfRecord};
use rijke_numerics::words::counted;
use rijke_rig::{RecordItem, RecordSet, Rejection};

/// Correlation of noise beyond which it is the same: a file of coarser steps keeps this much of it.
const SAME: f64 = 0.5;
/// Fewest samples that tell: chance then reaches [`SAME`] in eight standard deviations.
const FEWEST: usize = 256;
/// Rows by which the decay of a copy may have been found earlier or later.
const SHIFT: usize = 4;

/// Makes of every ping that is a copy of an earlier one of its point a rejection, and says how many there
/// are.
pub(super) fn leave_out_copies(
    set: &RecordSet,
    jobs: &[RecordItem],
    fitted: &mut [Fitted],
) -> Option<String> {
    let mut copies: Vec<(usize, usize, f64)> = Vec::new();
    let mut first = 0;
    for same_point in jobs.chunk_by(|a, b| a.point() == b.point()) {
        let mut originals: Vec<usize> = Vec::new();
        for k in first..first + same_point.len() {
            let Some(ping) = of_ping(&fitted[k]) else { continue };
            let with = |o: &usize| Some((*o, correlation(of_ping(&fitted[*o])?, ping)?));
            match originals.iter().filter_map(with).find(|(_, r)| *r > SAME) {
                Some((original, r)) => copies.push((k, original, r)),
                None => originals.push(k),
            }
        }
        first += same_point.len();
    }
    let (first, original, _) = *copies.first()?;
    let pings = fitted.iter().filter(|f| matches!(f, Fitted::Ping(..))).count();
    let (name, of) = (jobs[first].name(set), jobs[original].name(set));
    let said = format!(
        "{} of {} are copies of other pings of their point, with the same noise, and tell nothing new: they are left out (rejections.csv names \
         them). The first, {name}, is a copy of {of}. Give the records that were meant, or delete the copies",
        copies.len(),
        counted(pings, "ping")
    );
    for (k, original, r) in copies {
        let reason = format!(
            "a copy of {}: the noise of both is the same (correlation {r:.3}; of independent records it is zero)",
            jobs[original].name(set)
        );
        fitted[k] = Fitted::Copy(Rejection { record: jobs[k].name(set).to_owned(), reason });
    }
    Some(said)
}

fn of_ping(fitted: &Fitted) -> Option<&PingOfRecord> {
    match fitted {
        Fitted::Ping(Ok(ping), _) => Some(ping),
        _ => None,
    }
}

/// The largest correlation of the noise of two pings; none where they have other channels, or too little of
/// it.
fn correlation(a: &PingOfRecord, b: &PingOfRecord) -> Option<f64> {
    let channels = a.live.len();
    if a.live != b.live || a.noise.len().min(b.noise.len()) < FEWEST + SHIFT * channels {
        return None;
    }
    let shifted = |rows: usize| {
        let from = rows * channels;
        [along(&a.noise[from..], &b.noise), along(&a.noise, &b.noise[from..])]
    };
    (0..=SHIFT).flat_map(shifted).max_by(f64::total_cmp)
}

fn along(a: &[f32], b: &[f32]) -> f64 {
    let (mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b).map(|(a, b)| (f64::from(*a), f64::from(*b))) {
        (aa, bb, ab) = (aa + a * a, bb + b * b, ab + a * b);
    }
    if aa * bb > 0.0 { ab / (aa * bb).sqrt() } else { 0.0 }
}
