//! Whether what an earlier stage handed on as a Gaussian holds where a later stage ends.

use super::course::{Chosen, Done, Run};
use rijke_study::plan::Stage;

/// How far the predictions of an earlier stage may be from linear ones, in standard deviations of its data
/// all together: half of the square are nats.
const BENT: f64 = 2.0;

/// Step of the differences, a part of the way from one stage to the next.
const STEP: f64 = 1e-3;

impl Run {
    /// The stages whose posterior is no Gaussian at the parameters that a model of a later stage found, each
    /// in a sentence: their data are predicted there otherwise than to first order about what they handed on.
    pub(super) fn bent(&self, stage: &Stage, found: &Chosen) -> Vec<String> {
        let here = found.choice();
        // Not where the model has another candidate than the one that went on.
        let same =
            |done: &Done| done.choice.iter().all(|(role, id)| here.get(role).is_none_or(|own| own == id));
        let all = self.study.plan.stages.iter().zip(&self.done);
        let earlier = all.filter(|(before, done)| stage.on.contains(&before.id) && same(done));
        earlier.filter_map(|(before, done)| self.bent_from(before, &done.chosen, found)).collect()
    }

    fn bent_from(&self, before: &Stage, chosen: &Chosen, found: &Chosen) -> Option<String> {
        let names: Vec<&str> = chosen.assembly.parameters().iter().map(|p| p.name.as_str()).collect();
        // By the maximum that the model stands on.
        let known =
            found.known.iter().find(|known| names.iter().all(|n| known.names.iter().any(|k| k == n)))?;
        let (mut from, mut to) = (Vec::new(), Vec::new());
        for (name, at) in names.iter().zip(&chosen.trained.values) {
            let handed = known.mean[known.names.iter().position(|k| k == name)?];
            let here = found.trained.parameters.iter().position(|p| p.name == *name)?;
            from.push((*name, handed - at));
            to.push((*name, found.trained.values[here] - at));
        }
        let between = |share: f64| -> Vec<(&str, f64)> {
            from.iter().zip(&to).map(|((name, a), (_, b))| (*name, a + share * (b - a))).collect()
        };
        let at = |share: f64| self.predicted(&self.study, before, chosen, &between(share), 1.0).ok();
        let (first, near, last) = (at(0.0)?, at(STEP)?, at(1.0)?);
        let beside = |i: usize| last[i] - first[i] - (near[i] - first[i]) / STEP;
        let bent: Vec<f64> = (0..first.len()).map(beside).collect();
        let size = chosen.trained.linear.0.size_of(&bent).sqrt();
        (size > BENT).then(|| {
            format!(
                "stage `{}` handed its posterior on as a Gaussian, which does not hold at these values: its data are predicted {size:.0} sd from where it takes \
                 them to be; train its points in one stage with these",
                before.id
            )
        })
    }
}
