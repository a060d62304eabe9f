//! The stages of `rijke rank` that need the base flow: Figs. 6 to 11 and Table 4.

use super::{own, say, table_head, table_row, write};
use crate::{
    failure::{Classify, Failure},
    ui::{Progress, Ui},
};
use rijke_lab::Truth;
use rijke_model::{BaseStates, SavedModel};
use rijke_rig::Observations;
use rijke_studies::{
    Check, ColdStage, HeatRelease, Hot, HotPredictions, ProngModel, Terms, feedback, feedback_naive,
    figure_8, figure_9, figure_10, figure_11, heat_release, truths,
};
use std::path::Path;

/// Number of steps of progress.
pub(super) const STEPS: u64 = 5;

/// What the hot stages found, as far as the terminal shows it.
pub(super) struct Found {
    table: HeatRelease,
    checks: Vec<Check>,
}

/// Runs the hot stages and writes their numbers below `out`.
pub(super) fn hot(
    observations: &Observations,
    flow: &Path,
    cold: ColdStage,
    terms: Terms,
    truth: Option<&Truth>,
    out: &Path,
    progress: &Progress,
) -> Result<Found, Failure> {
    let remedy = "Run `rijke flow` on the same observations first, and name its folder with --flow.";
    let states = BaseStates::read(flow).or_bad_input().map_err(|f| f.remedy(remedy))?;
    let numbers = out.join("numbers");
    let hot = Hot::new(observations, &states, cold).or_bad_input().map_err(|f| f.at(flow).remedy(remedy))?;
    let calibrated = feedback(&hot).or_failed()?;
    progress.advance(1);
    let naive = feedback_naive(&hot, &calibrated).or_failed()?;
    progress.advance(1);
    let (table, best) = heat_release(&hot, terms).or_failed()?;
    progress.advance(1);
    let undamped = [figure_8(&hot).or_failed()?, figure_9(&hot).or_failed()?];
    progress.advance(1);
    let full = figure_10(&hot, &best).or_failed()?;
    // A campaign without the eight points of Fig. 11 has all other figures.
    let eight = figure_11(&hot, &best, &full).ok();
    progress.advance(1);

    write(&numbers, "feedback", &calibrated)?;
    write(&numbers, "feedback_naive", &naive)?;
    write(&numbers, "heat_release", &table)?;
    let figures: Vec<HotPredictions> = undamped.into_iter().chain([full]).chain(eight).collect();
    for figure in &figures {
        write(&numbers, &format!("figure_{}", figure.figure), figure)?;
    }
    let truths = truth.map(|t| truths(observations, t, &hot, &best)).transpose().or_failed()?;
    if let Some(truths) = &truths {
        write(&numbers, "truths", truths)?;
    }
    let trained_on = table.measured.iter().map(|m| m.measured.id.clone()).collect();
    let saved = SavedModel::new(
        &best.assembly,
        &best.trained,
        trained_on,
        observations.kind,
        observations.source.clone(),
    );
    saved.write(&out.join("model.json")).or_failed()?;
    let checks = [&calibrated.checks, &naive.checks, &table.checks]
        .into_iter()
        .chain(figures.iter().map(|f| &f.checks))
        .chain(truths.iter().map(|t| &t.checks))
        .flatten()
        .cloned()
        .collect();
    Ok(Found { table, checks })
}

impl Found {
    /// The rows of Table 4.
    pub(super) fn models(&self) -> &[ProngModel] {
        &self.table.models
    }

    /// The statements of the text.
    pub(super) fn into_checks(self) -> Vec<Check> {
        self.checks
    }

    /// Table 4 and the statements of the text.
    pub(super) fn show(&self, ui: &Ui, terms: &Terms) {
        table_head(ui);
        for model in &self.table.models {
            table_row(ui, model, &self.table.chosen);
        }
        own::standing(ui, &self.table.models, self.table.measured.len(), &terms.own);
        for check in &self.checks {
            say(ui, check);
        }
    }
}
