//! What is said of parameters and of models that cannot be fitted.

use crate::run::TrainedParameter;
use std::collections::BTreeSet;

/// The reasons of a remark, which has a line for each.
pub fn reasons(remark: &Option<String>) -> impl Iterator<Item = &str> {
    remark.iter().flat_map(|remark| remark.lines())
}

/// The remarks on the models of a stage, one after the other: a last clause that says at length what to do is
/// said once.
#[derive(Default)]
pub(super) struct Remarks(BTreeSet<String>);

/// From so many characters on.
const AT_LENGTH: usize = 80;

impl Remarks {
    pub(super) fn next(&mut self, remark: &str) -> String {
        match remark.rsplit_once("; ") {
            Some((what, remedy)) if remedy.len() >= AT_LENGTH && !self.0.insert(remedy.to_owned()) => {
                format!("{what}; see above")
            }
            _ => remark.to_owned(),
        }
    }
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

#[cfg(test)]
mod tests {
    use super::Remarks;

    #[test]
    fn message_what_to_do_is_said_once() {
        let remedy = "state these errors, or give the microphones larger ones, or measure at more frequencies than these";
        let mut remarks = Remarks::default();
        assert_eq!(remarks.next(&format!("rms 0.0058; {remedy}")), format!("rms 0.0058; {remedy}"));
        assert_eq!(remarks.next(&format!("rms 0.0061; {remedy}")), "rms 0.0061; see above");
        // What is short, or stands alone, is said again.
        for said in ["aliases; two of them", remedy] {
            assert_eq!([remarks.next(said), remarks.next(said)], [said, said]);
        }
    }
}
