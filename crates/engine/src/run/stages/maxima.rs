//! Models that stand on a posterior with several maxima: trained on each, with the evidence of all.

use super::super::course::{Chosen, Elsewhere, Trusted};
use crate::{EngineError, NamedGaussian};
use rayon::prelude::*;
use rijke_inference::{Evidence, probabilities};
use rijke_numerics::words::precise;
use rijke_study::unit_behind;
use std::sync::Arc;

/// Most maxima that are tried.
const MOST: usize = 32;
/// Standard deviations beyond which values tell one maximum from another.
pub(in crate::run) const APART: f64 = 3.0;
/// A probability below which another maximum is not told, and does not go on.
const SMALL: f64 = 1e-3;

/// What is known, and ln of the probability of it.
type Weighed = (f64, Arc<Vec<NamedGaussian>>);

/// Trains a model on what is known.
type Train<'a> = dyn Fn(&Arc<Vec<NamedGaussian>>, Trusted) -> Result<Chosen, EngineError> + Sync + 'a;

/// What several stages know, each by its maxima with their probabilities: every combination of these, the
/// most probable first.
pub(in crate::run) fn combined(stages: &[Vec<(f64, NamedGaussian)>]) -> Vec<Weighed> {
    let mut all = vec![(0.0, Vec::new())];
    for maxima in stages {
        let with = |(ln, known): (f64, Vec<NamedGaussian>)| {
            maxima.iter().map(move |(share, found)| {
                (ln + share.ln(), known.iter().cloned().chain([found.clone()]).collect())
            })
        };
        all = all.into_iter().flat_map(with).collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        all.truncate(MOST);
    }
    all.into_iter().map(|(ln, known)| (ln, Arc::new(known))).collect()
}

/// Trains on every maximum; takes the one that is most probable with these data, and the evidence of the
/// mixture: the sum of that of each, weighed by its probability before.
///
/// # Errors
/// That of the most probable if none can be trained.
pub(in crate::run) fn of_all(
    maxima: &[Weighed],
    trusted: Trusted,
    on: &Train<'_>,
) -> Result<Chosen, EngineError> {
    let results: Vec<Result<Chosen, EngineError>> =
        maxima.par_iter().map(|(_, known)| on(known, Trusted::Laplace)).collect();
    let (mut first_error, mut found) = (None, Vec::new());
    for ((ln, _), result) in maxima.iter().zip(results) {
        match result {
            Ok(chosen) => found.push((*ln, chosen)),
            Err(error) => first_error = first_error.or(Some(error)),
        }
    }
    let worth = |(ln, c): &(f64, Chosen)| ln + c.trained.evidence.ln_marginal;
    let Some(best) = (0..found.len()).max_by(|a, b| worth(&found[*a]).total_cmp(&worth(&found[*b]))) else {
        return Err(first_error.unwrap_or(EngineError::Stopped));
    };
    if trusted != Trusted::Laplace {
        found[best].1 = on(&found[best].1.known.clone(), trusted)?;
    }
    let all: Vec<f64> = found.iter().map(worth).collect();
    let shares = probabilities(&all);
    let total = all[best] - shares[best].ln();
    let beside = not_told(&found, best, &shares);
    let own = found[best].1.trained.own;
    let others = (0..found.len()).filter(|k| *k != best && shares[*k] > SMALL);
    let elsewhere = |k: usize| {
        let (odds, (_, c)) = (shares[k] / shares[best], &found[k]);
        Elsewhere { odds, at: c.trained.values[..own].to_vec(), known: c.known.clone() }
    };
    let open: Vec<Elsewhere> = others.map(elsewhere).collect();
    let mut chosen = found.swap_remove(best).1;
    // Theirs are odds against all that it found there.
    let all = 1.0 + chosen.maxima.iter().map(|m| m.odds).sum::<f64>();
    let open = open.into_iter().map(|m| Elsewhere { odds: m.odds * all, ..m });
    chosen.maxima.extend(open);
    let trained = Arc::make_mut(&mut chosen.trained);
    let evidence = trained.evidence;
    // Equation (9), summed over maxima.
    trained.evidence = Evidence { ln_marginal: total, ln_occam: total - evidence.ln_best_fit, ..evidence };
    trained.warnings.extend(beside.clone());
    chosen.beside = beside;
    Ok(chosen)
}

/// Says which other maxima the data leave open, and at which values.
fn not_told(found: &[(f64, Chosen)], best: usize, shares: &[f64]) -> Option<String> {
    let own = &found[best].1.trained;
    let sds = own.sd();
    let apart = |k: usize| {
        let other = &found[k].1.trained;
        let far = |i: &usize| {
            let value = other.values.get(*i).copied().unwrap_or(own.values[*i]);
            (value - own.values[*i]).abs() > APART * sds[*i]
        };
        let value = |i: usize| {
            let p = &own.parameters[i];
            let unit = unit_behind(&p.unit);
            format!("{} = {}{unit} (not {})", p.name, precise(other.values[i]), precise(own.values[i]))
        };
        (0..own.own).filter(far).take(2).map(value).collect::<Vec<_>>().join(", ")
    };
    let mut others: Vec<usize> = (0..found.len()).filter(|k| *k != best && shares[*k] > SMALL).collect();
    others.sort_by(|a, b| shares[*b].total_cmp(&shares[*a]));
    let places = others.into_iter().map(|k| (k, apart(k))).filter(|(_, at)| !at.is_empty());
    let named: Vec<String> =
        places.take(4).map(|(k, at)| format!("{at}, probability {:.3}", shares[k])).collect();
    (!named.is_empty()).then(|| {
        format!(
            "earlier stages leave several maxima open, and these data do not decide between them. The values and standard deviations stated are \
             those of one maximum (probability {:.3}); others: {}",
            shares[best],
            named.join("; ")
        )
    })
}
