//! What became of one record.

use crate::Fault;
use crate::ping::{APART_HZ, Drift, Excesses, PingFit};
use rijke_numerics::C64;
use rijke_numerics::words::counted;
use rijke_rig::{Click, Ping, RecordItem, Rejection};
use std::f64::consts::TAU;

/// Share of the amplitude of a mode from which a neighbour may take its place in another repeat.
const EQUAL: f64 = 0.5;

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
    /// Frequencies of the mode and of another one within 12 Hz that is half as loud or more, Hz.
    pub(super) pair_hz: Option<[f64; 2]>,
    /// When a part begins in which all channels hold one number to the end of the record, which is cut off,
    /// s.
    pub(super) padded_from_s: Option<f64>,
    /// Whether a step of the converter is larger than the noise of a channel.
    pub(super) coarse: bool,
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

/// What to say of pings, by name, in which a second mode is about as loud as the one that was taken: the
/// frequencies of this one and of the other, Hz.
pub(super) fn pairs_in_words(found: &[(&str, [f64; 2])]) -> Option<String> {
    let (name, [taken, other]) = found.first()?;
    let (pings, hold) = (counted(found.len(), "ping"), if found.len() == 1 { "holds" } else { "hold" });
    Some(format!(
        "{pings} {hold} two modes that are about equally loud, {name} near {taken:.1} and {other:.1} Hz; the louder one, {taken:.1} Hz, is taken. Drive at the \
         frequency of the one that is wanted: then it is much the louder one in all repeats"
    ))
}

/// Frequencies of the mode of a fit and of the loudest one within 12 Hz that is half as loud or more, Hz.
pub(super) fn pair(fit: &PingFit) -> Option<[f64; 2]> {
    let (first, own) = fit.tones.first()?;
    let size = |amplitudes: &[C64]| amplitudes.iter().map(|a| a.norm_sqr()).sum::<f64>().sqrt();
    let close = |s: &C64| (s.im - first.im).abs() < TAU * APART_HZ && s.re < 0.0;
    let others = fit.tones.iter().skip(1).filter(|(s, _)| fit.modes.contains(s) && close(s));
    let (loudest, amplitudes) = others.max_by(|a, b| size(&a.1).total_cmp(&size(&b.1)))?;
    (size(amplitudes) > EQUAL * size(own)).then_some([first.im, loudest.im].map(|omega| omega / TAU))
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

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use rijke_numerics::Matrix;

    /// A ping of three microphones with the given noise.
    pub(crate) fn ping(noise: Vec<f32>, coarse: bool) -> PingOfRecord {
        PingOfRecord {
            repeat: 0,
            ping: Ping {
                s: C64::new(-9.0, 1070.0),
                pressures: vec![C64::ONE; 3],
                reference: 0,
                covariance: Matrix::identity(6),
            },
            drift: Drift::default(),
            excess: Excesses::default(),
            skipped_s: 0.0,
            pair_hz: None,
            padded_from_s: None,
            coarse,
            noise,
            live: vec![0, 1, 2],
            left_out: Vec::new(),
        }
    }

    #[test]
    fn message_two_modes_of_like_strength_are_said_with_both_frequencies() {
        let said = pairs_in_words(&[("a.wav", [175.02, 170.0]), ("b.wav", [175.0, 170.0])]).unwrap();
        let start = "2 pings hold two modes that are about equally loud, a.wav near 175.0 and 170.0 Hz; the louder one, 175.0 Hz, is taken";
        assert!(said.starts_with(start), "{said}");
        assert_eq!(pairs_in_words(&[]), None);
    }
}
