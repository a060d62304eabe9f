//! Every record of a set, one after the other.

use super::record::Record;
use super::set::{RecordSet, RecordSource};
use crate::error::RigError;

/// A record of a set: which point or calibration, and which of its records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordItem {
    /// A ping of a point.
    Ping(usize, usize),
    /// A click of a point.
    Click(usize, usize),
    /// A click of a calibration.
    Calibration(usize, usize),
}

impl RecordItem {
    /// The record.
    ///
    /// # Errors
    /// As [`RecordSource::ping`].
    pub fn read(self, source: &dyn RecordSource) -> Result<Record, RigError> {
        match self {
            Self::Ping(point, repeat) => source.ping(point, repeat),
            Self::Click(point, repeat) => source.click(point, repeat),
            Self::Calibration(which, repeat) => source.calibration(which, repeat),
        }
    }

    /// The point that it is of; none for a calibration.
    #[must_use]
    pub fn point(self) -> Option<usize> {
        match self {
            Self::Ping(point, _) | Self::Click(point, _) => Some(point),
            Self::Calibration(..) => None,
        }
    }

    /// The name of its file.
    #[must_use]
    pub fn name(self, set: &RecordSet) -> &str {
        match self {
            Self::Ping(point, repeat) => &set.points[point].pings[repeat],
            Self::Click(point, repeat) => &set.points[point].clicks[repeat],
            Self::Calibration(which, repeat) => &set.calibrations[which].clicks[repeat],
        }
    }
}

impl RecordSet {
    /// All records: pings and clicks point by point, then calibrations.
    #[must_use]
    pub fn items(&self) -> Vec<RecordItem> {
        let points = self.points.iter().enumerate().flat_map(|(i, point)| {
            let pings = (0..point.pings.len()).map(move |r| RecordItem::Ping(i, r));
            pings.chain((0..point.clicks.len()).map(move |r| RecordItem::Click(i, r)))
        });
        let calibrations = self.calibrations.iter().enumerate();
        let calibrations =
            calibrations.flat_map(|(i, c)| (0..c.clicks.len()).map(move |r| RecordItem::Calibration(i, r)));
        points.chain(calibrations).collect()
    }
}
