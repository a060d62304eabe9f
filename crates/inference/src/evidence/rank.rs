//! Competing models side by side.

use super::laplace::Evidence;
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

impl RankedModel {
    /// "trusted", or why not.
    #[must_use]
    pub fn verdict(&self) -> String {
        match &self.entry.outcome {
            Err(reason) => reason.clone(),
            Ok(_) if self.entry.warnings.is_empty() => "trusted".to_owned(),
            Ok(_) => self.entry.warnings.join("; "),
        }
    }
}

impl Ranking {
    /// ln of the Bayes factor of row `i` over row `j`, if both have an evidence.
    #[must_use]
    pub fn ln_bayes_factor(&self, i: usize, j: usize) -> Option<f64> {
        let ln = |k: usize| self.models.get(k)?.entry.outcome.as_ref().ok().map(|e| e.ln_marginal);
        Some(ln(i)? - ln(j)?)
    }
}

/// The probability of every model if one of them is right, by the ln of its evidence times its prior weight
/// (equation 7 of the paper, normalised). Zero for a model without evidence, whose ln is not finite.
#[must_use]
pub fn probabilities(ln_evidence: &[f64]) -> Vec<f64> {
    let best = ln_evidence.iter().copied().filter(|ln| ln.is_finite()).fold(f64::NEG_INFINITY, f64::max);
    let weight = |ln: &f64| if ln.is_finite() { (ln - best).exp() } else { 0.0 };
    let sum: f64 = ln_evidence.iter().map(weight).sum();
    ln_evidence.iter().map(|ln| if ln.is_finite() { weight(ln) / sum } else { 0.0 }).collect()
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
        assert!((ranking.ln_bayes_factor(1, 0).unwrap() - 2_f64.ln()).abs() < 1e-12);
        assert_eq!(ranking.models[2].verdict(), "the model failed everywhere");
        assert_eq!(ranking.models[2].probability, None);
        assert_eq!(probabilities(&[f64::NEG_INFINITY, f64::NAN]), [0.0, 0.0]);
    }
}
