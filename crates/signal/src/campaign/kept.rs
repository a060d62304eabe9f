//! Fits that were made before.

use super::calibration::Calibrated;
use super::fitted::Fitted;
use super::options::ProcessError;
use rijke_rig::RecordSet;
use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Fits of the records of a set that grows, so that processing it again costs what is new. All calls must
/// have the same options, and a record whose file changed must be forgotten.
#[derive(Debug, Default)]
pub struct Kept {
    /// With the largest pressure of each record, Pa.
    fits: Mutex<BTreeMap<String, (Fitted, f64)>>,
    /// For which sampling rates were wanted and which clicks were there.
    calibration: Mutex<Option<(Basis, Calibrated)>>,
}

/// What a calibration stands on: whether there are pings and clicks, and the calibration clicks.
type Basis = ([bool; 2], Vec<String>);

impl Kept {
    /// Forgets what was made of a file.
    pub fn forget(&self, file: &str) {
        lock(&self.fits).remove(file);
        let mut calibration = lock(&self.calibration);
        if calibration.as_ref().is_some_and(|((_, clicks), _)| clicks.iter().any(|c| c == file)) {
            *calibration = None;
        }
    }

    pub(super) fn fit(&self, file: &str) -> Option<(Fitted, f64)> {
        lock(&self.fits).get(file).cloned()
    }

    pub(super) fn keep(&self, file: &str, fitted: &Fitted, peak: f64) {
        lock(&self.fits).insert(file.to_owned(), (fitted.clone(), peak));
    }

    /// What is known of the channels: as before if it stands on the same clicks. Else all fits are forgotten,
    /// since those of clicks stand on it.
    pub(super) fn calibrated(
        &self,
        set: &RecordSet,
        calibrate: impl FnOnce() -> Result<Calibrated, ProcessError>,
    ) -> Result<Calibrated, ProcessError> {
        let has = |pings: bool| {
            set.points.iter().any(|p| if pings { !p.pings.is_empty() } else { !p.clicks.is_empty() })
        };
        let clicks = set.calibrations.iter().flat_map(|c| c.clicks.iter().cloned()).collect();
        let basis = ([has(true), has(false)], clicks);
        if let Some((_, known)) = lock(&self.calibration).as_ref().filter(|(known, _)| *known == basis) {
            return Ok(known.clone());
        }
        let found = calibrate()?;
        lock(&self.fits).clear();
        *lock(&self.calibration) = Some((basis, found.clone()));
        Ok(found)
    }
}

fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    // Nothing is half done under these locks.
    of.lock().unwrap_or_else(PoisonError::into_inner)
}
