//! The numbers of all studies that were run.

use crate::{ReportError, figures, page::Item};
use rijke_studies::{Consistency, EmptyTube, LumpedConvergence, Prongs};
use serde::de::DeserializeOwned;
use std::{fs, path::Path};

/// The records of the studies, each if it was run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Numbers {
    /// `empty_tube.json`: Fig. 3.
    pub empty_tube: Option<EmptyTube>,
    /// `prongs.json`: Table 2 and Fig. 4.
    pub prongs: Option<Prongs>,
    /// `consistency.json`: the check of section 6.1.
    pub consistency: Option<Consistency>,
    /// `lumped_convergence.json`: the paper's discretisation of the wall loss.
    pub lumped_convergence: Option<LumpedConvergence>,
}

impl Numbers {
    /// Reads the files of a folder; a study without a file was not run.
    ///
    /// # Errors
    /// [`ReportError::Read`] and [`ReportError::Malformed`] name the file and the place in it.
    pub fn read(folder: &Path) -> Result<Self, ReportError> {
        if !folder.is_dir() {
            let source = std::io::ErrorKind::NotFound.into();
            return Err(ReportError::Read { path: folder.to_owned(), source });
        }
        Ok(Self {
            empty_tube: record(folder, "empty_tube.json")?,
            prongs: record(folder, "prongs.json")?,
            consistency: record(folder, "consistency.json")?,
            lumped_convergence: record(folder, "lumped_convergence.json")?,
        })
    }

    /// What the page shows, in its order.
    pub(crate) fn items(&self) -> Vec<Item> {
        let empty_tube = self.empty_tube.as_ref().map(figures::empty_tube::item);
        let prongs = self.prongs.as_ref().map(figures::prongs::item);
        let consistency = self.consistency.as_ref().map(figures::consistency::item);
        let lumped = self.lumped_convergence.as_ref().map(figures::lumped::item);
        [empty_tube, prongs, consistency, lumped].into_iter().flatten().collect()
    }
}

fn record<T: DeserializeOwned>(folder: &Path, name: &str) -> Result<Option<T>, ReportError> {
    let path = folder.join(name);
    if !path.exists() {
        return Ok(None);
    }
    let text =
        fs::read_to_string(&path).map_err(|source| ReportError::Read { path: path.clone(), source })?;
    serde_json::from_str(&text).map(Some).map_err(|source| ReportError::Malformed { path, source })
}
