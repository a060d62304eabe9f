//! The numbers of all studies that were run.

use crate::{
    BaseFlow, ReportError,
    figures::{self, feedback, predictions, prongs},
    page::Item,
};
use rijke_studies::{
    CampaignRead, Cold, Consistency, EmptyTube, Feedback, FlowNumerics, HeatRelease, HotPredictions,
    LumpedConvergence, Microphones, Prongs, Truths,
};
use serde::de::DeserializeOwned;
use std::{fs, path::Path};

/// The records of the studies, each if it was run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Numbers {
    /// `campaign.json`: Table 1.
    pub campaign: Option<CampaignRead>,
    /// `flow.json`: Fig. 2.
    pub flow: Option<BaseFlow>,
    /// `empty_tube.json`: Fig. 3.
    pub empty_tube: Option<EmptyTube>,
    /// `prongs.json`: Table 2 and Fig. 4.
    pub prongs: Option<Prongs>,
    /// `heater.json`: Table 3.
    pub heater: Option<Prongs>,
    /// `cold.json`: Fig. 5.
    pub cold: Option<Cold>,
    /// `feedback.json`: Fig. 6.
    pub feedback: Option<Feedback>,
    /// `feedback_naive.json`: Fig. 7.
    pub feedback_naive: Option<Feedback>,
    /// `heat_release.json`: Table 4.
    pub heat_release: Option<HeatRelease>,
    /// `figure_8.json` to `figure_11.json`.
    pub predictions: [Option<HotPredictions>; 4],
    /// `microphones.json`: Fig. 12.
    pub microphones: Option<Microphones>,
    /// `consistency.json`: the check of section 6.1.
    pub consistency: Option<Consistency>,
    /// `lumped_convergence.json`: the paper's discretisation of the wall loss.
    pub lumped_convergence: Option<LumpedConvergence>,
    /// `flow_numerics.json`: orders and energy of the pipe flow.
    pub flow_numerics: Option<FlowNumerics>,
    /// `truths.json`: virtual data only.
    pub truths: Option<Truths>,
}

impl Numbers {
    /// Reads the files of a folder; a study without a file was not run.
    ///
    /// # Errors
    /// [`ReportError::Read`], [`ReportError::Malformed`] and [`ReportError::Shape`] name the file and the place in it.
    pub fn read(folder: &Path) -> Result<Self, ReportError> {
        if !folder.is_dir() {
            let source = std::io::ErrorKind::NotFound.into();
            return Err(ReportError::Read { path: folder.to_owned(), source });
        }
        let figure = |number: u32| record(folder, &format!("figure_{number}.json"));
        let numbers = Self {
            campaign: record(folder, "campaign.json")?,
            flow: record(folder, "flow.json")?,
            empty_tube: record(folder, "empty_tube.json")?,
            prongs: record(folder, "prongs.json")?,
            heater: record(folder, "heater.json")?,
            cold: record(folder, "cold.json")?,
            feedback: record(folder, "feedback.json")?,
            feedback_naive: record(folder, "feedback_naive.json")?,
            heat_release: record(folder, "heat_release.json")?,
            predictions: [figure(8)?, figure(9)?, figure(10)?, figure(11)?],
            microphones: record(folder, "microphones.json")?,
            consistency: record(folder, "consistency.json")?,
            lumped_convergence: record(folder, "lumped_convergence.json")?,
            flow_numerics: record(folder, "flow_numerics.json")?,
            truths: record(folder, "truths.json")?,
        };
        numbers.check_shapes(folder)?;
        Ok(numbers)
    }

    /// What the page shows, in the order of the paper; what is not in the paper comes last.
    pub(crate) fn items(&self) -> Vec<Item> {
        let cold = [
            self.campaign.as_ref().map(figures::campaign::item),
            self.flow.as_ref().map(figures::base_flow::item),
            self.empty_tube.as_ref().map(figures::empty_tube::item),
            self.prongs.as_ref().map(|s| prongs::item(s, &prongs::PRONGS)),
            self.heater.as_ref().map(|s| prongs::item(s, &prongs::HEATER)),
            self.cold.as_ref().map(figures::cold::item),
            self.feedback.as_ref().map(|s| feedback::item(s, &feedback::FIGURE_6)),
            self.feedback_naive.as_ref().map(|s| feedback::item(s, &feedback::FIGURE_7)),
            self.heat_release.as_ref().map(figures::heat_release::item),
        ];
        let which =
            [predictions::FIGURE_8, predictions::FIGURE_9, predictions::FIGURE_10, predictions::FIGURE_11];
        let hot = self.predictions.iter().zip(&which);
        let hot = hot.map(|(s, which)| s.as_ref().map(|s| predictions::item(s, which)));
        let rest = [
            self.microphones.as_ref().map(figures::microphones::item),
            self.consistency.as_ref().map(figures::consistency::item),
            self.lumped_convergence.as_ref().map(figures::lumped::item),
            self.flow_numerics.as_ref().map(figures::flow_numerics::item),
            self.truths.as_ref().map(figures::truths::item),
        ];
        cold.into_iter().chain(hot).chain(rest).flatten().collect()
    }
}

fn record<T: DeserializeOwned>(folder: &Path, name: &str) -> Result<Option<T>, ReportError> {
    let path = folder.join(name);
    if !path.exists() {
        return Ok(None);
    }
    // A pipe would wait for a writer.
    if !path.is_file() {
        let source = std::io::Error::new(std::io::ErrorKind::InvalidInput, "it is not a file");
        return Err(ReportError::Read { path, source });
    }
    let text =
        fs::read_to_string(&path).map_err(|source| ReportError::Read { path: path.clone(), source })?;
    serde_json::from_str(&text).map(Some).map_err(|source| ReportError::Malformed { path, source })
}
