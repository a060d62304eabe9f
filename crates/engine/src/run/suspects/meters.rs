//! Errors of meters that all points share, as training found them.

use super::super::course::{Chosen, Run};
use rijke_numerics::words::{quantity, with_sd};
use rijke_study::{Cause, Duct, Factor, Part, Shape};
use std::collections::BTreeSet;

/// An error whose standard deviation is a larger part of the stated one than this is as it was stated.
const AS_STATED: f64 = 0.9;

/// Errors that are told to this part of their stated deviation are judged together.
const TOLD: f64 = 0.5;
/// So many standard deviations their mean is from zero, or the root of their mean square above one.
const APART: f64 = 3.3;
/// So many stated standard deviations from zero, one that all points share is doubted.
const FAR: f64 = 3.0;

impl Run {
    /// Factors whose errors, each drawn anew by what is stated, lie to one side, or are larger than stated,
    /// in a sentence each.
    pub(in crate::run) fn one_sided(&self, found: &Chosen) -> Vec<String> {
        let posterior = found.trained.posterior();
        let displaced = found.observed.iter().flat_map(|o| &o.conditions.displaced).map(|d| &d.cause);
        let causes: BTreeSet<&Cause> = displaced.collect();
        let common = &self.study.plan.common_errors;
        let one = |factor: &Factor| {
            let of_it = |cause: &&&Cause| matches!(cause, Cause::Factor { name, .. } if *name == factor.name);
            let errors = causes.iter().filter(of_it).filter_map(|cause| posterior.error_of(cause));
            let told: Vec<f64> = errors.filter(|[_, sd]| *sd < TOLD).map(|[error, _]| error).collect();
            let n = told.len() as f64;
            let (mean, square) = (told.iter().sum::<f64>() / n, told.iter().map(|e| e * e).sum::<f64>() / n);
            let aside = mean.abs() * n.sqrt() > APART;
            let larger = square.sqrt() > 1.0 + APART / (2.0 * n).sqrt();
            (told.len() > 2 && !common.contains(&factor.name) && (aside || larger)).then(|| {
                format!(
                    "the inferred errors of `{0}` at {1} settings are {mean:+.1} times `{0}_sd` on average ({2:.1} rms): if the meter is wrong everywhere, \
                     name it in `common_errors`; otherwise `{0}_sd` is too small, or the model is wrong",
                    factor.name,
                    told.len(),
                    square.sqrt()
                )
            })
        };
        self.study.campaign.factors.iter().filter_map(one).collect()
    }

    /// The errors of factors (`common_errors`) and of ducts (`temperature_sd`) that all points share, each in
    /// a sentence, where the data tell them.
    pub(in crate::run) fn meters(&self, found: &Chosen) -> Vec<String> {
        let (posterior, campaign) = (found.trained.posterior(), &self.study.campaign);
        let one = |name: &String| {
            let factor = campaign.factor(name)?;
            let [error, sd] = posterior.error_of(&Cause::of_all_points(name))?;
            // Where a deviation is in proportion to its factor it is nothing at some points.
            let points = found.observed.iter().map(|o| &o.conditions.point);
            let there = points.max_by(|a, b| a.factor_sds[factor].total_cmp(&b.factor_sds[factor]))?;
            let stated = there.factor_sds[factor];
            let unit = campaign.factors[factor].unit_in_print();
            let (what, key) = (format!("`{name}`"), format!("{name}_sd"));
            let said = shared(&what, &key, [error, sd], stated, &unit)?;
            let doubt = far(&what, &key, error).unwrap_or_default();
            Some(format!(
                "{said} at {}; predictions take `{name}` as the same meter reads it{doubt}",
                there.id
            ))
        };
        let of_part = |part: &Part| {
            let Shape::Duct(Duct { temperature_sd: stated, .. }) = &part.shape else { return None };
            let told = posterior.error_of(&Cause::Part(part.name.clone()))?;
            let (what, key) = (format!("the temperature of {}", part.name), "temperature_sd");
            Some(shared(&what, key, told, *stated, "K")? + &far(&what, key, told[0]).unwrap_or_default())
        };
        let factors = self.study.plan.common_errors.iter().filter_map(one);
        factors.chain(self.study.rig.parts.iter().filter_map(of_part)).collect()
    }
}

/// An error that all points share, found in units of the standard deviation that `key` states, in words; none
/// where the data tell nothing of it.
fn shared(what: &str, key: &str, [error, sd]: [f64; 2], stated: f64, unit: &str) -> Option<String> {
    (sd < AS_STATED).then(|| {
        let (share, size) = (with_sd(error, sd), quantity(error * stated, sd * stated, unit));
        format!("the shared error of {what} is {share} times `{key}`: {size}")
    })
}

/// The doubt about an error that all points share and that lies far from zero, in standard deviations as
/// `key` states them, to stand behind what was said of it.
fn far(what: &str, key: &str, error: f64) -> Option<String> {
    (error.abs() > FAR).then(|| {
        format!(
            ". This error lies {:.1} stated standard deviations from zero: check {what} and `{key}`; if both are right, the model is wrong",
            error.abs()
        )
    })
}

#[cfg(test)]
mod tests {
    use super::far;

    #[test]
    fn message_a_shared_error_of_more_than_three_deviations_is_doubted() {
        assert_eq!(far("`q`", "q_sd", -2.9), None);
        let said = far("`q`", "q_sd", -3.21).unwrap();
        assert!(said.starts_with(". This error lies 3.2 stated standard deviations from zero"), "{said}");
        assert!(said.contains("check `q` and `q_sd`"), "{said}");
    }
}
