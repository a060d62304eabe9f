//! A parameter of a model with what is known of it before and after.

use crate::Trained;
use rijke_inference::{Conflict, Prior};
use rijke_numerics::Matrix;
use rijke_numerics::words::{fixed, quantity, rounded, with_sd};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A parameter with what is known of it before and after.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrainedParameter {
    /// Name.
    pub name: String,
    /// Symbol in print.
    pub symbol: String,
    /// Unit.
    pub unit: String,
    /// Most probable value.
    pub value: f64,
    /// Standard deviation.
    pub sd: f64,
    /// Between which values it lies with a probability of 68 %, where one of them is much farther from the
    /// most probable value than the other; none where `sd` says as much.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interval: Option<[f64; 2]>,
    /// How many standard deviations of its prior, as its candidate states it, the value lies from the prior's
    /// mean; none for a prior that is not normal.
    pub prior_sds: Option<f64>,
    /// Its standard deviation over that of its prior, as its candidate states it; none for a flat one.
    #[serde(default)]
    pub narrowed: Option<f64>,
    /// Value and standard deviation averaged over the models that earlier stages leave open, in the model
    /// that goes on; none where they leave none open that has this parameter.
    #[serde(default)]
    pub averaged: Option<[f64; 2]>,
    /// The parameter with which it is correlated most, and the correlation, where its modulus is above 0.9:
    /// the data tell a combination of the two better than either.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tied: Option<(String, f64)>,
}

/// Width of the posterior relative to the prior above which a parameter or a direction counts as not
/// identified.
pub(super) const UNIDENTIFIED: f64 = 0.9;

/// Distances of the ends of an interval from the value, their difference over their sum, from which a
/// standard deviation alone is no description: that of a logarithm known to 0.2.
const SKEWED: f64 = 0.1;

/// Correlation from which two parameters are said to be told together.
const TIED: f64 = 0.9;

impl TrainedParameter {
    /// From the most probable `value` and the standard deviation `to_first_order` about it.
    pub(crate) fn of(p: &rijke_inference::Parameter, value: f64, to_first_order: f64) -> Self {
        let sd = p.sd_about(value, to_first_order);
        let interval = Some(p.interval_about(value, to_first_order)).filter(|[low, high]| {
            let skewed = (low + high - 2.0 * value).abs() > SKEWED * (high - low);
            skewed && low.is_finite() && high.is_finite()
        });
        let prior_sds = match p.prior {
            Prior::Normal { mean, sd } => Some((value - mean) / sd),
            _ => None,
        };
        let (name, symbol, unit) = (p.name.clone(), p.symbol.clone(), p.unit.clone());
        let prior_sd = match p.prior {
            Prior::Normal { sd, .. } => Some(sd),
            // Of a standard normal number: that of the prior itself.
            Prior::Truncated { .. } => {
                let [median, slope, _] = p.physical(0.0);
                Some(p.sd_about(median, slope))
            }
            Prior::LogNormal { ln_sd, .. } => Some(value * ln_sd),
            Prior::Uniform { low, high } => Some((high - low) / 12_f64.sqrt()),
            Prior::HalfNormal { sd } => Some(sd * (1.0 - 2.0 / PI).sqrt()),
            Prior::Flat => None,
        };
        let narrowed = prior_sd.map(|prior| sd / prior);
        Self { name, symbol, unit, value, sd, interval, prior_sds, narrowed, averaged: None, tied: None }
    }

    /// Notes the strongest correlations among parameters, of which `covariance` is, in any units.
    pub(crate) fn tie(all: &mut [Self], covariance: &Matrix) {
        let names: Vec<String> = all.iter().map(|p| p.name.clone()).collect();
        let sd = |i: usize| covariance[(i, i)].sqrt();
        let with = |i: usize, j: usize| (names[j].clone(), covariance[(i, j)] / (sd(i) * sd(j)));
        for (i, p) in all.iter_mut().enumerate() {
            let others = (0..names.len()).filter(|j| *j != i).map(|j| with(i, j));
            let most = others.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
            // Rounding may put a correlation of one beyond it.
            p.tied = most.map(|(other, r)| (other, r.clamp(-1.0, 1.0))).filter(|(_, r)| r.abs() >= TIED);
        }
    }

    /// Its value with standard deviation, the parameter to which it is tied, and its average over models.
    #[must_use]
    pub fn words(&self) -> String {
        let averaged = self.averaged.map_or(String::new(), |[value, sd]| {
            format!("; {} averaged over what earlier stages leave open", with_sd(value, sd))
        });
        let value = quantity(self.value, self.sd, &self.unit);
        format!("{} = {value}{}{}{averaged}", self.name, self.interval_words(), self.tied_words())
    }

    /// The interval in words, to follow its value; nothing where the standard deviation says as much.
    #[must_use]
    pub fn interval_words(&self) -> String {
        self.interval.map_or_else(String::new, |ends| {
            let [low, high] = ends.map(rounded);
            format!(" (68 % between {low} and {high})")
        })
    }

    /// The correlation in words, to follow its value; nothing where there is none.
    #[must_use]
    pub fn tied_words(&self) -> String {
        let Some((other, r)) = &self.tied else { return String::new() };
        format!(" (correlation with {other}: {})", fixed(*r, if r.abs() < 0.995 { 2 } else { 4 }))
    }

    /// How many standard deviations of its prior it lies from what was known before, where that is a
    /// contradiction.
    #[must_use]
    pub fn conflict(&self) -> Option<f64> {
        self.prior_sds.map(f64::abs).filter(|z| *z > Conflict::LIMIT)
    }

    /// Whether the data tell next to nothing of it: its posterior is as wide as its prior, and lies where
    /// that does. One that is as wide but elsewhere is not told nothing: several parameters together are
    /// known, and contradict what was known before.
    #[must_use]
    pub fn is_as_before(&self) -> bool {
        self.narrowed.is_some_and(|share| share > UNIDENTIFIED) && self.conflict().is_none()
    }
}

pub(super) fn parameters(
    trained: &Trained,
    of_the_model: &[rijke_inference::Parameter],
) -> Vec<TrainedParameter> {
    let record = |(i, p): (usize, &rijke_inference::Parameter)| {
        TrainedParameter::of(p, trained.values[i], trained.covariance[(i, i)].sqrt())
    };
    let known = of_the_model.iter().take(trained.values.len());
    let mut all: Vec<TrainedParameter> = known.enumerate().map(record).collect();
    TrainedParameter::tie(&mut all, &trained.covariance);
    all
}

#[cfg(test)]
mod tests {
    use super::TrainedParameter;
    use rijke_inference::{Parameter, Prior};
    use rijke_numerics::Matrix;

    #[test]
    fn exact_what_contradicts_its_prior_is_not_said_to_be_as_before() {
        let parameter = Parameter::new("k", "k", "1", Prior::Normal { mean: 0.0, sd: 1.0 });
        let of = |value: f64, sd: f64| TrainedParameter::of(&parameter, value, sd);
        assert!(of(0.3, 0.95).is_as_before());
        assert!(!of(0.3, 0.5).is_as_before());
        let far = of(-7.1, 0.95);
        assert_eq!((far.conflict(), far.is_as_before()), (Some(7.1), false));
    }

    #[test]
    fn exact_a_wide_logarithm_is_told_by_an_interval() {
        let prior = Prior::LogNormal { median: 1.0, ln_sd: 1.0 };
        let of = |sd: f64| TrainedParameter::of(&Parameter::new("a", "a", "1", prior), 0.5, sd);
        // The logarithm is known to 0.8: 0.5/e^0.8 and 0.5 e^0.8.
        assert_eq!(of(0.4).words(), "a = 0.50 +- 0.40 (68 % between 0.225 and 1.11)");
        assert_eq!(of(0.05).words(), "a = 0.500 +- 0.050");
    }

    #[test]
    fn exact_parameters_that_are_told_together_name_each_other() {
        let of = |name: &str| {
            let p = Parameter::new(name, name, "1", Prior::Normal { mean: 0.0, sd: 1.0 });
            TrainedParameter::of(&p, 0.1, 0.1)
        };
        let mut all = ["n", "tau", "eta"].map(of);
        // Standard deviations 2, 0.5 and 1; correlations -0.95, 0.3 and 0.2.
        let rows = [[4.0, -0.95, 0.6], [-0.95, 0.25, 0.1], [0.6, 0.1, 1.0]];
        TrainedParameter::tie(&mut all, &Matrix::from_fn(3, 3, |i, j| rows[i][j]));
        assert_eq!(all[0].tied_words(), " (correlation with tau: -0.95)");
        assert_eq!(all[1].tied_words(), " (correlation with n: -0.95)");
        assert_eq!((all[2].tied.as_ref(), all[2].tied_words().as_str()), (None, ""));
    }
}
