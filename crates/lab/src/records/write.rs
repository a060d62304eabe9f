//! From the laboratory to a folder of records.

use super::virtual_rig::VirtualRig;
use crate::truth::LabError;
use rayon::prelude::*;
use rijke_numerics::InOrder;
use rijke_rig::{RecordSource, RigError};
use std::path::Path;

impl VirtualRig {
    /// Number of records in the set.
    #[must_use]
    pub fn record_count(&self) -> usize {
        let set = self.set();
        let points: usize = set.points.iter().map(|p| p.pings.len() + p.clicks.len()).sum();
        points + set.calibrations.iter().map(|c| c.clicks.len()).sum::<usize>()
    }

    /// Writes every record and, last, the manifest. Records are made one at a time per thread and never held;
    /// `written` is told how many more have been written.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(&self, folder: &Path, written: &(dyn Fn(usize) + Sync)) -> Result<(), LabError> {
        let set = self.set();
        let folders = set.points.iter().map(|p| p.point.id.as_str()).chain(["calibration"]);
        for name in folders {
            let path = folder.join(name);
            std::fs::create_dir_all(&path).map_err(|cause| RigError::Write { path, cause })?;
        }
        let points = (0..set.points.len()).map(Batch::Point);
        let batches: Vec<Batch> = points.chain((0..set.calibrations.len()).map(Batch::Calibration)).collect();
        let write = |batch: &Batch| self.write_batch(folder, *batch, written);
        batches.par_iter().map(write).in_order::<Result<(), _>>()?;
        self.tube.write_within(folder, &|_| true)?;
        Ok(set.write(folder)?)
    }

    fn write_batch(
        &self,
        folder: &Path,
        batch: Batch,
        written: &(dyn Fn(usize) + Sync),
    ) -> Result<(), RigError> {
        let (set, channels) = (self.set(), self.set().channels.len() as u16);
        match batch {
            Batch::Point(point) => {
                let files = &set.points[point];
                for (repeat, name) in files.pings.iter().enumerate() {
                    self.ping_samples(point, repeat).write(channels, &folder.join(name))?;
                    written(1);
                }
                for (repeat, name) in files.clicks.iter().enumerate() {
                    self.click_samples(point, repeat).write(channels, &folder.join(name))?;
                    written(1);
                }
            }
            Batch::Calibration(which) => {
                for (repeat, name) in set.calibrations[which].clicks.iter().enumerate() {
                    self.calibration_samples(which, repeat).write(channels, &folder.join(name))?;
                    written(1);
                }
            }
        }
        Ok(())
    }
}

/// Which records of a set are written together.
#[derive(Clone, Copy)]
enum Batch {
    Point(usize),
    Calibration(usize),
}
