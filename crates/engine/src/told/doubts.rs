//! What is said of parameters and of models that cannot be fitted.

use crate::run::TrainedParameter;

/// The reasons of a remark, which has a line for each.
pub fn reasons(remark: &Option<String>) -> impl Iterator<Item = &str> {
    remark.iter().flat_map(|remark| remark.lines())
}

/// That the data tell next to nothing of a parameter, `missed` if the model misses them by far.
pub fn not_identified(p: &TrainedParameter, missed: bool) -> Option<String> {
    p.is_as_before().then(|| match missed {
        true => format!(
            "the model misses these data so far that they do not constrain {}: its posterior is its prior",
            p.name
        ),
        false => format!("not identified by these data: the posterior of {} is its prior", p.name),
    })
}

/// That a parameter lies far from its prior.
pub(super) fn far_from_prior(p: &TrainedParameter) -> Option<String> {
    p.conflict().map(|z| {
        format!(
            "{} lies {z:.1} sd of its prior from the prior mean: prior and data contradict each other, or the model is wrong",
            p.name
        )
    })
}
