//! The maxima of a posterior side by side: how far below the best each is, and its share of the evidence.

use super::explore::{Explored, MODE_LIMIT};
use super::terrain::Peak;
use crate::density::Gaussian;
use crate::evidence::{Evidence, Laplace};
use crate::fit::Fit;
use crate::numbers::shares;
use crate::problem::Parameters;
use rijke_numerics::words::precise;
use serde::{Deserialize, Serialize};

/// A maximum of the posterior beside the best one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OtherMaximum {
    /// Physical parameters.
    pub parameters: Vec<f64>,
    /// Its Laplace evidence, nats; nothing if its Hessian is not positive definite, or if its likelihood is
    /// too low for its evidence to matter.
    pub ln_marginal: Option<f64>,
    /// How far below the best maximum it is, nats: by evidence, or by the height of the posterior where that
    /// is not known.
    #[serde(default)]
    pub below: f64,
    /// Its share of the summed evidence, 0..1.
    #[serde(default)]
    pub share: f64,
    /// The parameters that tell it from the best one, those with the most posterior standard deviations
    /// between them first; at least one.
    #[serde(default)]
    pub apart: Vec<Apart>,
}

/// A parameter with different values at two maxima.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Apart {
    /// Its name.
    pub parameter: String,
    /// Its unit.
    pub unit: String,
    /// Its value at the other maximum.
    pub value: f64,
    /// Its value at the best one.
    pub best: f64,
    /// How many posterior standard deviations of the best lie between them, in the working coordinate.
    pub sds: f64,
}

/// One maximum in full.
#[derive(Clone, Debug)]
pub struct Maximum {
    /// Where it is.
    pub fit: Fit,
    /// Laplace's method there, or why it does not apply.
    pub laplace: Result<Laplace, String>,
    /// How far below the best maximum it is, nats of evidence, or of the height of the posterior where there
    /// is no evidence.
    pub below: f64,
    /// Its share of the summed evidence, 0..1.
    pub share: f64,
}

/// "tau = 0.0093 s (best 0.0031 s)".
impl std::fmt::Display for Apart {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let unit = if self.unit == "1" { String::new() } else { format!(" {}", self.unit) };
        write!(f, "{} = {}{unit} (best {}{unit})", self.parameter, precise(self.value), precise(self.best))
    }
}

impl OtherMaximum {
    /// Whether it holds so much of the evidence of the best one that [`further_maxima`] names it.
    #[must_use]
    pub fn is_heavy(&self) -> bool {
        self.ln_marginal.is_some() && -self.below > MODE_LIMIT
    }

    /// Whether a parameter of it lies outside of what the best maximum leaves open.
    #[must_use]
    pub fn is_elsewhere(&self) -> bool {
        self.apart.first().is_some_and(|first| first.sds > APART)
    }
}

/// "another maximum at tau = 0.0093 s (best 0.0031 s), 29.0 nats lower".
impl std::fmt::Display for OtherMaximum {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("another maximum at ")?;
        for (k, apart) in self.apart.iter().take(3).enumerate() {
            let comma = if k > 0 { ", " } else { "" };
            write!(f, "{comma}{apart}")?;
        }
        write!(f, ", {:.1} nats lower", self.below)
    }
}

/// Parameters closer than this to those of the best, in posterior standard deviations, do not tell a maximum
/// from it.
const APART: f64 = 3.0;

/// The parameters whose coordinates differ at `other` and `best`; `sds` are those of the best.
fn apart(
    parameters: &Parameters,
    best: (&[f64], &[f64]),
    other: (&[f64], &[f64]),
    sds: &[f64],
) -> Vec<Apart> {
    let gap = |i: usize| (other.0[i] - best.0[i]).abs() / sds[i].max(f64::MIN_POSITIVE);
    let mut order: Vec<usize> = (0..parameters.len()).collect();
    order.sort_by(|&i, &j| gap(j).total_cmp(&gap(i)));
    let one = |(k, i): (usize, usize)| {
        let q = &parameters.list()[i];
        (k == 0 || gap(i) > APART).then(|| Apart {
            parameter: q.name.clone(),
            unit: q.unit.clone(),
            value: other.1[i],
            best: best.1[i],
            sds: gap(i),
        })
    };
    order.into_iter().enumerate().filter_map(one).collect()
}

/// All maxima side by side.
pub(crate) struct Sorted {
    /// Best first.
    pub(crate) maxima: Vec<Maximum>,
    /// The share and the Gaussian of those that matter.
    pub(crate) proposal: Vec<(f64, Gaussian)>,
    /// All but the best.
    pub(crate) modes: Vec<OtherMaximum>,
    /// Summed, if the best has one.
    pub(crate) evidence: Option<Evidence>,
}

/// The maxima with their shares, and the evidence summed over them.
pub(crate) fn sorted(parameters: &Parameters, found: Explored) -> Sorted {
    // The first may not have converged; a further end that has not is no maximum.
    let peaks: Vec<Peak> =
        found.peaks.into_iter().enumerate().filter(|(k, p)| *k == 0 || p.converged).map(|(_, p)| p).collect();
    let ln = |p: &Peak| p.ln_marginal.unwrap_or(f64::NEG_INFINITY);
    let (shares, total) = shares(&peaks.iter().map(ln).collect::<Vec<_>>());
    let (best_ln, best_cost) = (peaks[0].ln_marginal, peaks[0].cost);
    let below = |ln: Option<f64>, cost: f64| match (best_ln, ln) {
        (Some(best), Some(ln)) => best - ln,
        _ => cost - best_cost,
    };
    let p = parameters.len();
    let best = (peaks[0].fit.working[..p].to_vec(), peaks[0].fit.parameters.clone());
    let sds: Vec<f64> = match &peaks[0].laplace {
        Ok(l) => (0..p).map(|i| l.covariance[(i, i)].sqrt()).collect(),
        Err(_) => parameters.scales(),
    };
    let differs = |z: &[f64], a: &[f64]| apart(parameters, (&best.0, &best.1), (z, a), &sds);
    let mut modes: Vec<OtherMaximum> = (1..peaks.len())
        .map(|k| OtherMaximum {
            apart: differs(&peaks[k].fit.working, &peaks[k].fit.parameters),
            parameters: peaks[k].fit.parameters.clone(),
            ln_marginal: peaks[k].ln_marginal,
            below: below(peaks[k].ln_marginal, peaks[k].cost),
            share: shares[k],
        })
        .collect();
    modes.extend(found.unpursued.iter().map(|u| {
        let values = parameters.physical(&u.z[..p]);
        let apart = differs(&u.z, &values);
        OtherMaximum { parameters: values, ln_marginal: None, below: u.cost - best_cost, share: 0.0, apart }
    }));
    let several = shares.iter().filter(|s| **s > 0.0).count() > 1;
    let evidence = peaks[0].laplace.as_ref().ok().map(|l| match several {
        false => l.evidence,
        // Equation (9), summed over maxima: what the others add is prior volume that survives the data.
        true => Evidence { ln_occam: total - l.evidence.ln_best_fit, ln_marginal: total, ..l.evidence },
    });
    let heavy = peaks.iter().zip(&shares).filter(|(p, s)| **s > SMALL && p.ln_marginal.is_some());
    let proposal = heavy.filter_map(|(p, s)| Some((*s, p.gaussian.clone()?))).collect();
    let maxima = peaks.into_iter().zip(shares).map(|(p, share)| Maximum {
        below: below(p.ln_marginal, p.cost),
        share,
        fit: p.fit,
        laplace: p.laplace,
    });
    Sorted { maxima: maxima.collect(), proposal, modes, evidence }
}

/// Share of the evidence below which a maximum is not sampled.
const SMALL: f64 = 1e-4;

/// Most maxima that are named in a warning.
const NAMED: usize = 4;

/// A warning if maxima beside the best hold more than 5 % of its evidence, in words: the heaviest with their
/// places and probabilities.
#[must_use]
pub fn further_maxima(modes: &[OtherMaximum]) -> Option<String> {
    let mut heavy: Vec<&OtherMaximum> = modes.iter().filter(|m| m.is_heavy()).collect();
    heavy.sort_by(|a, b| a.below.total_cmp(&b.below));
    let heaviest = heavy.first()?;
    let place = |m: &&OtherMaximum| {
        let at: Vec<String> = m.apart.iter().take(2).map(ToString::to_string).collect();
        format!("{}, probability {:.2}", at.join(", "), m.share)
    };
    let places: Vec<String> = heavy.iter().take(NAMED).map(place).collect();
    let further = match modes.len() {
        1 => "1 further maximum".to_owned(),
        count => format!("{count} further maxima"),
    };
    Some(format!(
        "the posterior has {further}; values and standard deviations are those of the best one. The evidence of the next is {:+.2} nats relative to \
         it: {}",
        -heaviest.below,
        places.join("; ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::{Parameter, Prior};

    #[test]
    fn exact_parameters_that_tell_two_maxima_apart_are_listed_furthest_first() {
        let parameter = |name: &str| Parameter::new(name, name, "m", Prior::Normal { mean: 0.0, sd: 1.0 });
        let parameters = Parameters::new(["a", "b", "c", "d"].map(parameter).to_vec()).unwrap();
        let (best, sds) = ([0.0; 4], [1.0, 2.0, 1.0, 0.1]);
        let named = |other: [f64; 4]| -> Vec<(String, f64, f64)> {
            let values = other.map(|z| 10.0 * z);
            let all = apart(&parameters, (&best, &best), (&other, &values), &sds);
            all.into_iter().map(|a| (a.parameter, a.value, a.sds)).collect()
        };
        let expected = [("d".to_owned(), 8.0, 8.0), ("a".to_owned(), -31.0, 3.1)];
        for (found, expected) in named([-3.1, 5.9, 2.9, 0.8]).iter().zip(&expected) {
            assert!(found.0 == expected.0 && (found.1 - expected.1).abs() < 1e-12, "{found:?}");
            assert!((found.2 - expected.2).abs() < 1e-12, "{found:?}");
        }
        assert_eq!(named([-3.1, 5.9, 2.9, 0.8]).len(), 2);
        // The furthest in any case.
        assert_eq!(named([0.1, 0.0, -2.0, 0.0]), [("c".to_owned(), -20.0, 2.0)]);
    }
}
