//! Parameters of earlier stages that a model moves although it lacks something.

use super::super::course::{Done, Run};
use super::super::found::Missing;
use rijke_numerics::words::quantity;
use rijke_study::plan::Stage;

/// Width of a posterior relative to that of the stage before from which this stage counts as having told the
/// parameter anew.
const TOLD_ANEW: f64 = 0.9;

impl Run {
    /// The parameters that stages below `stage` found and that the model which goes on from it tells more
    /// narrowly, each as the last of those stages has it, in a sentence without its stop. None where nothing
    /// is missing: only what a model lacks makes its narrower numbers worse.
    pub(in crate::run) fn moved_since(&self, stage: &Stage, missing: &Missing) -> Option<String> {
        missing.required().next()?;
        let (done, before) = self.done.split_last()?;
        let mut below: Vec<&str> = stage.on.iter().map(String::as_str).collect();
        let mut known: Vec<(&str, &Done)> = Vec::new();
        for (done, stage) in before.iter().zip(&self.study.plan.stages).rev() {
            if below.contains(&stage.id.as_str()) {
                below.extend(stage.on.iter().map(String::as_str));
                known.push((&stage.id, done));
            }
        }
        let now = &done.chosen.trained;
        let told = |(i, p): (usize, &rijke_inference::Parameter)| {
            let then = known.iter().find_map(|(id, done)| {
                let k = done.chosen.trained.parameters.iter().position(|q| q.name == p.name)?;
                Some((id, &done.chosen.trained, k))
            });
            let (id, then, k) = then?;
            let [new, old] = [now.covariance[(i, i)], then.covariance[(k, k)]].map(f64::sqrt);
            let value = quantity(then.values[k], old, &p.unit);
            (new < TOLD_ANEW * old).then(|| format!("{} = {value} ({id})", p.name))
        };
        let told: Vec<String> = now.parameters.iter().take(now.own).enumerate().filter_map(told).collect();
        (!told.is_empty()).then(|| {
            format!(
                "what is missing may have moved what earlier stages found by their own points: {}",
                told.join(", ")
            )
        })
    }
}
