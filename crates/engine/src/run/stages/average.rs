//! The models that the evidence leaves open, each as probable as the evidence of all stages makes it, and
//! parameters averaged over them (Hoeting et al. 1999, eqs. 1 to 3).

use super::super::course::{Beside, Chosen, Run};
use super::super::points::predicted::mixed;
use super::super::record::ModelRecord;
use super::maxima::APART;
use crate::rows::Row;
use crate::{EngineError, SavedModel};
use rijke_numerics::words::precise;
use rijke_study::plan::Stage;
use serde::{Deserialize, Serialize};

/// The most models that predictions are averaged over, beside the one that goes on.
const MOST: usize = 15;

/// A model that is open beside the one that goes on from a stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OpenModel {
    /// Its odds against that one.
    pub odds: f64,
    /// The model.
    pub model: SavedModel,
}

/// How probable other maxima of the posterior of this model are, of those that are open beside it, and where
/// the most probable lies: a sentence, if there are any.
#[must_use]
pub fn at_other_maxima(model: &SavedModel, open: &[OpenModel]) -> Option<String> {
    let itself: Vec<&OpenModel> = open.iter().filter(|o| o.model.candidates == model.candidates).collect();
    let first = itself.iter().max_by(|a, b| a.odds.total_cmp(&b.odds))?;
    let [here, there] = [model, &first.model].map(|m| m.posterior().ok().map(|p| p.gaussian));
    let (here, there) = (here?, there?);
    let apart = |k: usize| {
        let name = &here.names[k];
        let other = there.mean[there.names.iter().position(|n| n == name)?];
        let sds = (other - here.mean[k]).abs() / here.covariance[(k, k)].sqrt();
        (sds > APART).then(|| format!("{name} = {} (here {})", precise(other), precise(here.mean[k])))
    };
    let values: Vec<String> = (0..here.names.len()).filter_map(apart).take(3).collect();
    let odds: f64 = itself.iter().map(|o| o.odds).sum();
    Some(format!(
        "{} of these {} this model at another maximum of its posterior, with a probability of {:.2} in all; the most probable {}. The columns without \
         averaged_ hold for one maximum: use the averaged ones",
        itself.len(),
        if itself.len() == 1 { "is" } else { "are" },
        odds / (1.0 + odds),
        if values.is_empty() {
            "has a noise of another size".to_owned()
        } else {
            format!("lies at {}", values.join(", "))
        }
    ))
}

impl Run {
    /// Sets, in the `model` of `row` that goes on from `stage`, the value and the deviation of every
    /// parameter averaged over the models of the same candidates here that stand on what earlier stages leave
    /// open, each as probable as the evidence of all stages makes it (Hoeting et al. 1999, eqs. 1 to 3).
    /// `best` is the largest ln evidence of the stage.
    pub(in crate::run) fn average(&self, stage: &Stage, row: &Row, model: &mut ModelRecord, best: f64) {
        let same = |b: &&Beside| {
            let alike = |role: &String| b.choice.get(role) == row.choice.get(role);
            b.stage == stage.id && row.own.iter().all(|c| alike(&c.role))
        };
        let others: Vec<&Beside> = self.done.iter().flat_map(|done| &done.beside).filter(same).collect();
        let own = (model.ln_evidence() - best).exp();
        for p in &mut model.parameters {
            let of = |b: &&Beside| {
                let found = b.parameters.iter().find(|q| q.name == p.name)?;
                Some([b.odds, found.value, found.sd])
            };
            let all: Vec<[f64; 3]> =
                [[own, p.value, p.sd]].into_iter().chain(others.iter().filter_map(of)).collect();
            if all.len() > 1 {
                p.averaged = Some(mixed(all.into_iter()));
            }
        }
    }

    /// The models that one may want to tell from the one that goes on from a stage: those that are open
    /// beside it, else the best other one.
    ///
    /// # Errors
    /// Those of training.
    pub fn rivals(&self, id: &str) -> Result<Vec<OpenModel>, EngineError> {
        let open = self.saved_open(id)?;
        let alone = |model| OpenModel { odds: 0.0, model };
        Ok(if open.is_empty() { self.saved_rival(id)?.map(alone).into_iter().collect() } else { open })
    }

    /// The models that are open beside the one that goes on from a stage, to be kept on disk: it itself at
    /// other maxima of its posterior, those of its own table, and those that stand on what earlier stages
    /// leave open. They are trained with what enters predictions.
    ///
    /// # Errors
    /// Those of training.
    pub fn saved_open(&self, id: &str) -> Result<Vec<OpenModel>, EngineError> {
        let (Some((_, stage)), Some(done)) = (self.study.plan.stage(id), self.stage_done(id)) else {
            return Ok(Vec::new());
        };
        let evidences = done.rows.iter().map(|(m, _)| m.ln_evidence());
        let best = evidences.fold(f64::NEG_INFINITY, f64::max);
        // Odds against the best of the table, or against the model that goes on where later stages were
        // tried.
        let odds = |m: &ModelRecord| match &done.open[..] {
            [] => (m.ln_evidence() - best).exp(),
            _ if m.candidates == done.choice => 1.0,
            open => open.iter().find(|(_, c)| c.id == m.id).map_or(0.0, |(odds, _)| *odds),
        };
        let own = done.rows.iter().find(|(m, _)| m.candidates == done.choice).map_or(0.0, |(m, _)| odds(m));
        let others = done.rows.iter().filter(|(m, _)| m.candidates != done.choice);
        let here = others.map(|(m, chosen)| (odds(m) / own, &m.candidates, chosen));
        let beside = self.done.iter().flat_map(|d| &d.beside).filter(|b| b.stage == id);
        let beside = beside.map(|Beside { odds, choice, chosen, .. }| (odds / own, choice, chosen));
        let mut open: Vec<_> =
            here.chain(beside).filter(|(odds, ..)| odds * own >= (-stage.decides).exp()).collect();
        open.sort_by(|a, b| b.0.total_cmp(&a.0));
        open.truncate(MOST);
        // The evidence of a model is that of all its maxima; the model that goes on stands at one of them.
        let maxima = &done.chosen.maxima;
        let all: f64 = 1.0 + maxima.iter().map(|m| m.odds).sum::<f64>();
        let elsewhere = maxima
            .iter()
            .map(|m| Ok(OpenModel { odds: m.odds, model: self.saved_elsewhere(stage, &done.chosen, m)? }));
        let kept = |(odds, choice, chosen): (f64, _, &Chosen)| {
            Ok(OpenModel { odds: odds * all, model: self.saved_of(stage, choice, chosen)? })
        };
        elsewhere.chain(open.into_iter().map(kept)).collect()
    }
}
