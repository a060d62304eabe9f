//! What is known of files and channels without looking at a record: how the files are written, on which days
//! or in which files that is otherwise, and what the channels do to a pressure.

use super::reading::Reading;

/// How the files of a set are written, and what is known of the channels. The default: numbers in Pa, all
/// channels listed by place, nothing known of the channels but what clicks tell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Acquisition {
    /// How the files are written.
    pub reading: Reading,
    /// Where that is otherwise. For a file that several speak of, the last one counts.
    pub exceptions: Vec<Exception>,
    /// Gains and delays of the channels as stated; none if only clicks can tell.
    pub stated: Option<StatedChannels>,
    /// Microphones that were dead in all records and are not in the rig of the set: their numbers in the rig
    /// as it stands, ascending, and their places, m.
    pub removed: Vec<(usize, f64)>,
    /// Frequencies between which the wanted mode lies, Hz, if stated.
    pub band_hz: Option<[f64; 2]>,
    /// Nominal frequency of the mains, Hz, if stated.
    pub mains_hz: Option<f64>,
    /// Whether a microphone may lie at a node of the wanted mode: one without signal then rejects no ping.
    pub may_be_silent: bool,
}

/// Files that are written otherwise than the rest of their set.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exception {
    /// Days, by their index.
    pub days: Vec<usize>,
    /// Files, as the manifest names them.
    pub files: Vec<String>,
    /// For every channel of a file the microphone that it records, where channels are listed by place.
    pub channels: Vec<Option<usize>>,
    /// How these files are written.
    pub reading: Reading,
    /// Sampling rate of the pings among them, Hz, where it is not that of the set.
    pub rate_hz: Option<f64>,
    /// Samples of these pings before the loudspeaker acts; if none, as long as in the other pings.
    pub quiet: Option<usize>,
}

/// What each channel does to a pressure p(t), stated by whoever calibrated it: it gives g p(t - d), with
/// errors of g and d that are independent from channel to channel. For each microphone of the rig one value.
#[derive(Clone, Debug, PartialEq)]
pub struct StatedChannels {
    /// Gains g, after the sensitivity.
    pub gains: Vec<f64>,
    /// Their relative standard deviations, that of the sensitivity included.
    pub gain_sds: Vec<f64>,
    /// Delays d, s.
    pub delays: Vec<f64>,
    /// Their standard deviations, s.
    pub delay_sds: Vec<f64>,
}

impl Acquisition {
    /// For each of the `count` microphones of the set, its number in the rig as it stands.
    #[must_use]
    pub fn numbers(&self, count: usize) -> Vec<usize> {
        let removed = |m: &usize| self.removed.iter().any(|(number, _)| number == m);
        (0..).filter(|m| !removed(m)).take(count).collect()
    }

    /// What is otherwise in a file of a day.
    pub(crate) fn exception(&self, day: usize, file: &str) -> Option<&Exception> {
        self.exceptions.iter().rev().find(|e| e.days.contains(&day) || e.files.iter().any(|f| f == file))
    }
}
