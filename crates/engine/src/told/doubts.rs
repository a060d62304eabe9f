//! What is said of parameters and of models that cannot be fitted.

use crate::run::TrainedParameter;
use rijke_numerics::Tell;

/// The reasons of a remark, which has a line for each.
pub fn reasons(remark: &Option<String>) -> impl Iterator<Item = &str> {
    remark.iter().flat_map(|remark| remark.lines())
}

/// Says of a parameter that the data tell next to nothing of it, `missed` if the model misses them by far.
pub fn not_identified(p: &TrainedParameter, missed: bool, tell: &dyn Tell) {
    if p.is_as_before() {
        tell.say(match missed {
            true => format!("          the misfit is so large that these data determine nothing about {}: its posterior is its prior, which may be wrong", p.name),
            false => format!("          not identified by these data: the posterior of {} is its prior", p.name),
        });
    }
}

/// Warns of a parameter that lies far from its prior.
pub fn warn_of_prior(p: &TrainedParameter, tell: &dyn Tell) {
    if let Some(z) = p.conflict() {
        tell.note(format!(
            "warning: {} lies {z:.1} sd of its prior from the prior mean: prior and data contradict each other, or the model is wrong",
            p.name
        ));
    }
}
