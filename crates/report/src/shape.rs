//! Numbers that a file holds in another shape than its figure draws: a damaged file is refused, never drawn.

use crate::{Numbers, ReportError};
use rijke_studies::Case;
use std::path::Path;

/// |R|, angle of R, eta.
const PARAMETERS: usize = 3;

impl Numbers {
    /// Checks the vectors and matrices of the empty tube, whose lengths the files do not fix.
    pub(crate) fn check_shapes(&self, folder: &Path) -> Result<(), ReportError> {
        if let Some(study) = &self.empty_tube {
            let check = Shape { folder, file: "empty_tube.json" };
            check.vector("parameters", study.parameters.len())?;
            check.vector("predicted", study.predicted.len())?;
            check.vector("prior", study.prior.len())?;
            study.truth.iter().try_for_each(|truth| check.vector("truth", truth.len()))?;
            check.cases("cases", &study.cases)?;
        }
        if let Some(study) = &self.microphones {
            let check = Shape { folder, file: "microphones.json" };
            check.vector("parameters", study.parameters.len())?;
            check.vector("predicted", study.predicted.len())?;
            study.truth.iter().try_for_each(|truth| check.vector("truth", truth.len()))?;
            check.cases("sets", &study.sets)?;
        }
        Ok(())
    }
}

struct Shape<'a> {
    folder: &'a Path,
    file: &'a str,
}

impl Shape<'_> {
    fn cases(&self, name: &str, cases: &[Case]) -> Result<(), ReportError> {
        for (k, case) in cases.iter().enumerate() {
            self.vector(&format!("{name}[{k}].mean"), case.mean.len())?;
            self.matrix(&format!("{name}[{k}].covariance"), &case.covariance)?;
            self.matrix(&format!("{name}[{k}].correlation"), &case.correlation)?;
        }
        Ok(())
    }

    fn matrix(&self, place: &str, rows: &[Vec<f64>]) -> Result<(), ReportError> {
        self.vector(place, rows.len())?;
        rows.iter().enumerate().try_for_each(|(k, row)| self.vector(&format!("{place}[{k}]"), row.len()))
    }

    fn vector(&self, place: &str, have: usize) -> Result<(), ReportError> {
        if have == PARAMETERS {
            return Ok(());
        }
        let (path, place) = (self.folder.join(self.file), place.to_owned());
        Err(ReportError::Shape { path, place, have, need: PARAMETERS })
    }
}
