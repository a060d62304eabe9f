//! Whether what an earlier stage handed on as a Gaussian holds where a later stage ends.

use super::super::course::{Chosen, Done, Run};
use rijke_study::plan::Stage;

/// How far the predictions of an earlier stage may be from linear ones, in standard deviations of its data
/// all together. The limit is low, because the Gaussian itself keeps a later stage near its mean: 24 of 122
/// chains of two stages were off by two of their standard deviations and all exceed it, as no chain with
/// normal priors does (docs/records/studies.md).
const BENT: f64 = 0.5;

/// Step of the differences, a part of the way from one stage to the next.
const STEP: f64 = 1e-3;

impl Run {
    /// The stages whose posterior is no Gaussian at the parameters that a model of a later stage found, each
    /// in a sentence: their data are predicted there otherwise than to first order about what they handed on.
    pub(in crate::run) fn bent(&self, stage: &Stage, found: &Chosen) -> Vec<String> {
        let here = found.choice();
        // Not where the model has another candidate than the one that went on.
        let same =
            |done: &Done| done.choice.iter().all(|(role, id)| here.get(role).is_none_or(|own| own == id));
        let all = self.study.plan.stages.iter().zip(&self.done);
        let earlier = all.filter(|(before, done)| stage.on.contains(&before.id) && same(done));
        earlier.filter_map(|(before, done)| self.bent_from(before, &done.chosen, found)).collect()
    }

    fn bent_from(&self, before: &Stage, chosen: &Chosen, found: &Chosen) -> Option<String> {
        let own = chosen.assembly.parameters();
        let names: Vec<&str> = own.iter().map(|p| p.name.as_str()).collect();
        // By the maximum that the model stands on.
        let known =
            found.known.iter().find(|known| names.iter().all(|n| known.names.iter().any(|k| k == n)))?;
        let (mut from, mut to) = (Vec::new(), Vec::new());
        for (name, p) in names.iter().zip(own) {
            let handed = known.mean[known.names.iter().position(|k| k == name)?];
            let here = found.trained.parameters.iter().position(|p| p.name == *name)?;
            from.push(p.working(handed));
            to.push(p.working(found.trained.values[here]));
        }
        if from.iter().chain(&to).any(|z| !z.is_finite()) {
            return None;
        }
        // Straight where the Gaussian is one: in the coordinates of the priors.
        let between = |share: f64| -> Vec<(&str, f64)> {
            let at = |i: usize| own[i].physical(from[i] + share * (to[i] - from[i]))[0];
            (0..own.len()).map(|i| (names[i], at(i) - chosen.trained.values[i])).collect()
        };
        let at = |share: f64| self.predicted(&self.study, before, chosen, &between(share), 1.0).ok();
        let (first, near, last) = (at(0.0)?, at(STEP)?, at(1.0)?);
        let beside = |i: usize| last[i] - first[i] - (near[i] - first[i]) / STEP;
        let bent: Vec<f64> = (0..first.len()).map(beside).collect();
        let size = chosen.trained.linear.0.size_of(&bent).sqrt();
        (size > BENT).then(|| {
            format!(
                "at these values the Gaussian posterior of stage `{}` is not valid: it misrepresents that stage's data by {size:.1} sd, so values and \
                 evidence here may be wrong; train the points of both stages in one stage",
                before.id
            )
        })
    }
}
