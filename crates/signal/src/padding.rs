//! Records of a fixed length whose acquisition stopped before: the rest is one number.

use crate::Trace;

/// So many equal samples at the end of all channels are no sound.
const LEAST: usize = 24;
/// A converter is so coarse that its silence is one number if this share of successive samples before are
/// equal.
const EQUAL: f64 = 0.45;

impl Trace<'_> {
    /// The first sample from which on every channel holds one number to the end of the record, if these are
    /// no silence of a coarse converter. A channel that holds nothing else is dead, and says nothing.
    pub(crate) fn padded_from(&self) -> Option<usize> {
        let from = |y: &Vec<f64>| Some(y.iter().rposition(|v| Some(v) != y.last())? + 1);
        let from = self.channels.iter().filter_map(from).max()?;
        let padded = self.len() >= from + LEAST && !self.is_one_number_before(from);
        padded.then_some(from)
    }

    /// Whether equal samples follow each other before the end as well, in any channel that is not dead.
    fn is_one_number_before(&self, end: usize) -> bool {
        let equal = |part: &[f64]| {
            let pairs = part.windows(2).filter(|pair| pair[0] == pair[1]).count();
            pairs as f64 > EQUAL * part.len() as f64 && part.iter().any(|v| *v != part[0])
        };
        self.channels.iter().any(|y| y.get(end - end / 10..end).is_some_and(equal))
    }
}
