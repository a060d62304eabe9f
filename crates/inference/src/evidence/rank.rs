//! Competing models side by side.

use super::laplace::Evidence;
use crate::numbers::shares;
use serde::{Deserialize, Serialize};

/// One model of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// Name of the model.
    pub name: String,
    /// Number of its parameters.
    pub parameters: usize,
    /// ln of the prior weight of the model; zero for all if none is preferred, as in the paper.
    pub ln_prior_weight: f64,
    /// Its evidence, or why there is none.
    pub outcome: Result<Evidence, String>,
    /// Reasons not to trust the evidence; empty if it passed its checks.
    pub warnings: Vec<String>,
}

/// Models in order of decreasing posterior probability; those without evidence come last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ranking {
    /// The rows.
    pub models: Vec<RankedModel>,
}

/// One row of a ranking.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RankedModel {
    /// The model.
    #[serde(flatten)]
    pub entry: Entry,
    /// Place in the order in which the entries were given.
    pub index: usize,
    /// Posterior probability among the models that have an evidence.
    pub probability: Option<f64>,
    /// ln of the Bayes factor of this model over the best one; zero or, with unequal prior weights, either
    /// sign.
    pub ln_bayes_factor: Option<f64>,
}

/// The probability of every model if one of them is right, by the ln of its evidence times its prior weight
/// (equation 7 of the paper, normalised). Zero for a model without evidence, whose ln is not finite.
#[must_use]
pub fn probabilities(ln_evidence: &[f64]) -> Vec<f64> {
    shares(ln_evidence).0
}

/// Orders models by [their probabilities](probabilities). Ties keep the given order.
#[must_use]
pub fn rank(entries: Vec<Entry>) -> Ranking {
    let score = |e: &Entry| match &e.outcome {
        Ok(evidence) => evidence.ln_marginal + e.ln_prior_weight,
        Err(_) => f64::NEG_INFINITY,
    };
    let scores: Vec<f64> = entries.iter().map(score).collect();
    let mut order: Vec<(usize, (Entry, f64))> =
        entries.into_iter().zip(probabilities(&scores)).enumerate().collect();
    order.sort_by(|(a, _), (b, _)| scores[*b].total_cmp(&scores[*a]));
    let ln_best = order.first().and_then(|(_, (e, _))| e.outcome.as_ref().ok()).map(|e| e.ln_marginal);
    let models = order
        .into_iter()
        .map(|(index, (entry, probability))| RankedModel {
            probability: scores[index].is_finite().then_some(probability),
            ln_bayes_factor: entry.outcome.as_ref().ok().zip(ln_best).map(|(e, b)| e.ln_marginal - b),
            index,
            entry,
        })
        .collect();
    Ranking { models }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(name: &str, ln_marginal: f64) -> Entry {
        let evidence = Evidence { ln_best_fit: ln_marginal, ln_occam: 0.0, ln_marginal, datapoints: 1 };
        Entry {
            name: name.into(),
            parameters: 1,
            ln_prior_weight: 0.0,
            outcome: Ok(evidence),
            warnings: Vec::new(),
        }
    }

    #[test]
    fn exact_probabilities_of_three_models() {
        let failed = Entry { outcome: Err("the model failed everywhere".into()), ..entry("c", 0.0) };
        let heavy = Entry { ln_prior_weight: 4_f64.ln(), ..entry("b", -1000.0 - 2_f64.ln()) };
        let ranking = rank(vec![failed, entry("a", -1000.0), heavy]);
        let names: Vec<&str> = ranking.models.iter().map(|m| m.entry.name.as_str()).collect();
        assert_eq!(names, ["b", "a", "c"]);
        assert!((ranking.models[0].probability.unwrap() - 2.0 / 3.0).abs() < 1e-12);
        assert!((ranking.models[1].ln_bayes_factor.unwrap() - 2_f64.ln()).abs() < 1e-12);
        assert_eq!(ranking.models[2].entry.outcome, Err("the model failed everywhere".into()));
        assert_eq!(ranking.models[2].probability, None);
        assert_eq!(probabilities(&[f64::NEG_INFINITY, f64::NAN]), [0.0, 0.0]);
    }
}
