//! The numbers of all studies that were run.

use crate::{ReportError, figures, page::Item};
use rijke_studies::{CampaignRead, Consistency, EmptyTube, LumpedConvergence, Microphones, Prongs};
use serde::de::DeserializeOwned;
use std::{fs, path::Path};

/// The records of the studies, each if it was run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Numbers {
    /// `campaign.json`: Table 1.
    pub campaign: Option<CampaignRead>,
    /// `empty_tube.json`: Fig. 3.
    pub empty_tube: Option<EmptyTube>,
    /// `prongs.json`: Table 2 and Fig. 4.
    pub prongs: Option<Prongs>,
    /// `heater.json`: Table 3.
    pub heater: Option<Prongs>,
    /// `microphones.json`: Fig. 12.
    pub microphones: Option<Microphones>,
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
            campaign: record(folder, "campaign.json")?,
            empty_tube: record(folder, "empty_tube.json")?,
            prongs: record(folder, "prongs.json")?,
            heater: record(folder, "heater.json")?,
            microphones: record(folder, "microphones.json")?,
            consistency: record(folder, "consistency.json")?,
            lumped_convergence: record(folder, "lumped_convergence.json")?,
        })
    }

    /// What the page shows, in its order.
    pub(crate) fn items(&self) -> Vec<Item> {
        let campaign = self.campaign.as_ref().map(figures::campaign::item);
        let empty_tube = self.empty_tube.as_ref().map(figures::empty_tube::item);
        let prongs = self.prongs.as_ref().map(|s| figures::prongs::item(s, &figures::prongs::PRONGS));
        let heater = self.heater.as_ref().map(|s| figures::prongs::item(s, &figures::prongs::HEATER));
        let microphones = self.microphones.as_ref().map(figures::microphones::item);
        let consistency = self.consistency.as_ref().map(figures::consistency::item);
        let lumped = self.lumped_convergence.as_ref().map(figures::lumped::item);
        [campaign, empty_tube, prongs, heater, microphones, consistency, lumped].into_iter().flatten().collect()
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
