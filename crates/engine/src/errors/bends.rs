//! Errors of factors whose effect is no straight line, as that of a meter whose reading a law multiplies by
//! an unknown: the data tell the product alone, and where the product stays the same the model must. To
//! first order it does not, and many data take the difference for knowledge of both.

use super::carried::Bend;
use crate::observed::{Observed, Used};
use crate::predictor::Predictor;
use crate::{Assembly, Conditions, Displaced};
use rijke_inference::{Forward, Prediction};
use rijke_numerics::Order;
use rijke_study::{Cause, STEP};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// What the linear effect of an error may miss, in measured standard deviations of all data together: half
/// of the square are nats.
const BENT: f64 = 0.3;

/// What a polynomial may miss between its nodes, likewise, where what a parabola misses is more than this
/// part of the linear effect: of less, parameters that make up for the error make up for most.
const ASTRAY: f64 = 1.0;
const FAR: f64 = 0.5;

/// Most errors that are parameters for that reason.
const MOST: usize = 64;

/// The errors of factors that are bent, and the models at other values of them.
#[derive(Default)]
pub(crate) struct Bends<'a> {
    causes: BTreeSet<Cause>,
    factors: Vec<OfFactor<'a>>,
    /// Factors whose errors are bent and not followed, or not well.
    unfollowed: Vec<String>,
}

/// One factor: its errors at all points are moved at once, because each point has one.
struct OfFactor<'a> {
    /// The error of each observation.
    causes: Vec<Option<Cause>>,
    /// Errors, and the model of all observations there.
    nodes: Vec<(f64, Predictor<'a>)>,
}

impl<'a> Bends<'a> {
    /// Those of a training, judged at `values`, the most probable parameters without errors, where `here` is
    /// what the model predicts.
    pub(crate) fn of(
        assembly: &'a Assembly,
        observed: &[Observed],
        used: &[Used],
        values: &[f64],
        here: &Prediction,
    ) -> Self {
        let all = || observed.iter().flat_map(|o| &o.conditions.displaced);
        let mut found = Self::default();
        for factor in all().filter_map(|d| d.cause.factor()).collect::<BTreeSet<&str>>() {
            let own = |o: &Observed| {
                o.conditions.displaced.iter().find(|d| d.cause.factor() == Some(factor)).cloned()
            };
            let displaced: Vec<Option<Displaced>> = observed.iter().map(own).collect();
            let nodes = nodes(assembly, observed, used, &displaced);
            let there = nodes.as_ref().and_then(|nodes| {
                nodes
                    .iter()
                    .map(|(_, model)| model.predict(values, Order::Value).ok())
                    .collect::<Option<Vec<_>>>()
            });
            // Where the rig cannot be so, or a mode is lost on the way, the errors stay straight.
            let (Some(mut nodes), Some(there)) = (nodes, there) else {
                let near = |d: &Displaced, _| Some(d.near.clone());
                let moved = moved(assembly, observed, used, &displaced, 0, near);
                let near = moved.and_then(|model| model.predict(values, Order::Value).ok());
                if near.is_none_or(|near| is_bent_at_all(here, &near, &displaced, used)) {
                    found.unfollowed.push(factor.to_owned());
                }
                continue;
            };
            let (bent, wide, astray) = judged(here, &there, &displaced, used);
            if !wide {
                nodes.truncate(2);
            }
            if astray && !bent.is_empty() {
                found.unfollowed.push(factor.to_owned());
            }
            let causes = displaced.into_iter().map(|d| Some(d?.cause).filter(|c| bent.contains(c)));
            found.factors.push(OfFactor { causes: causes.collect(), nodes });
            found.causes.extend(bent);
        }
        if found.causes.len() > MOST {
            let unfollowed = found.causes.iter().filter_map(Cause::factor).map(str::to_owned);
            let unfollowed: BTreeSet<String> = unfollowed.chain(found.unfollowed).collect();
            return Self { unfollowed: unfollowed.into_iter().collect(), ..Self::default() };
        }
        found.factors.retain(|factor| factor.causes.iter().any(Option::is_some));
        found
    }

    /// What is to be said of errors that are not followed, in a sentence without its stop.
    pub(crate) fn warning(&self) -> Option<String> {
        let names = self.unfollowed.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        match self.unfollowed.len() {
            0 => None,
            1 => Some(format!(
                "the effect of the error of {names} is too far from linear over its standard deviation, and counts to first order or nearly so: \
                 standard deviations of parameters that can compensate it may be too small. Make this error a parameter of a candidate, with its \
                 prior"
            )),
            _ => Some(format!(
                "the effects of the errors of {names} are too far from linear over their standard deviations, and count to first order or nearly \
                 so: standard deviations of parameters that can compensate them may be too small. Make these errors parameters of a candidate, \
                 with their priors"
            )),
        }
    }

    /// Whether no error is bent.
    pub(crate) fn is_empty(&self) -> bool {
        self.causes.is_empty()
    }

    /// Whether an error is bent.
    pub(crate) fn holds(&self, cause: &Cause) -> bool {
        self.causes.contains(cause)
    }

    /// The bends, with errors by their `place` among the parameters.
    pub(crate) fn placed(&self, used: &[Used], place: impl Fn(&Cause) -> Option<usize>) -> Vec<Bend<'_>> {
        let errors = |factor: &OfFactor<'_>| {
            let of = |(cause, u): (&Option<Cause>, &Used)| vec![cause.as_ref().and_then(&place); u.size()];
            factor.causes.iter().zip(used).flat_map(of).collect()
        };
        let mut all = Vec::with_capacity(self.factors.len());
        for factor in &self.factors {
            let nodes = factor.nodes.iter().map(|(error, model)| (*error, model as &dyn Forward));
            all.push(Bend { errors: errors(factor), nodes: nodes.collect() });
        }
        all
    }
}

/// The models at [`Displaced::FAR`]; none if a point cannot be there.
fn nodes<'a>(
    assembly: &'a Assembly,
    observed: &[Observed],
    used: &[Used],
    displaced: &[Option<Displaced>],
) -> Option<Vec<(f64, Predictor<'a>)>> {
    let far = |d: &Displaced, k: usize| Some(d.far.as_ref()?[k].clone());
    let at = |(k, error)| Some((error, moved(assembly, observed, used, displaced, k, far)?));
    Displaced::FAR.into_iter().enumerate().map(at).collect()
}

/// The model of all observations under the conditions that `to` gives those with an error.
fn moved<'a>(
    assembly: &'a Assembly,
    observed: &[Observed],
    used: &[Used],
    displaced: &[Option<Displaced>],
    k: usize,
    to: impl Fn(&Displaced, usize) -> Option<Arc<Conditions>>,
) -> Option<Predictor<'a>> {
    let one = |(o, d): (&Observed, &Option<Displaced>)| match d {
        None => Some(o.clone()),
        Some(d) => Some(Observed { conditions: to(d, k)?, ..o.clone() }),
    };
    let moved: Vec<Observed> = observed.iter().zip(displaced).map(one).collect::<Option<_>>()?;
    Predictor::new(assembly, &moved, used).ok()
}

/// As [`judged`], by a small step alone, where the model is known no further.
fn is_bent_at_all(
    here: &Prediction,
    near: &Prediction,
    displaced: &[Option<Displaced>],
    used: &[Used],
) -> bool {
    let straight: Vec<Prediction> = Displaced::FAR
        .iter()
        .map(|error| Prediction {
            values: here.values.iter().zip(&near.values).map(|(h, n)| h + error * (n - h) / STEP).collect(),
            ..Prediction::default()
        })
        .collect();
    !judged(here, &straight, displaced, used).0.is_empty()
}

/// The errors that are bent, all of a factor or none, whether a parabola is too little for them, and whether
/// five nodes are. `here` is
/// the prediction without errors, `there` those at [`Displaced::FAR`].
///
/// An error e adds B e + C e^2. B changes with the parameters: where these make up for an error r of the
/// factor, by about r B, and they make up for so much of one error among several as its root mean square
/// share in what all of them do.
fn judged(
    here: &Prediction,
    there: &[Prediction],
    displaced: &[Option<Displaced>],
    used: &[Used],
) -> (BTreeSet<Cause>, bool, bool) {
    // Sums of squares of B, r B, C, what a parabola leaves at two standard deviations, and what is then left
    // between the nodes of a polynomial through all: where numbers turn by an angle a per standard deviation
    // the former is a^2 B, and the latter 0.03 a^4 B.
    let mut all: BTreeMap<&Cause, [f64; 5]> = BTreeMap::new();
    let mut offset = 0;
    for (d, u) in displaced.iter().zip(used) {
        let first = offset;
        offset += u.size();
        let Some(d) = d else { continue };
        let sums = all.entry(&d.cause).or_default();
        for (k, row) in u.rows.iter().enumerate() {
            let value = |f: &Prediction| f.values[first + row];
            let f = value(here);
            let [down, up, lower, upper] = [0, 1, 2, 3].map(|k| value(&there[k]) - f);
            let (slope, bend) = (0.5 * (up - down), 0.5 * (up + down));
            let left = (lower + 2.0 * slope - 4.0 * bend).abs().max((upper - 2.0 * slope - 4.0 * bend).abs());
            let variance = u.covariance[(k, k)];
            let between = 0.03 * left * left / slope.abs().max(left);
            for (sum, missed) in sums.iter_mut().zip([slope, d.relative * slope, bend, left, between]) {
                *sum += missed * missed / variance;
            }
        }
    }
    let slopes: f64 = all.values().map(|sums| sums[0]).sum();
    let missed: f64 = all.values().map(|[b, rb, c, ..]| c + rb * b / slopes.max(f64::MIN_POSITIVE)).sum();
    let [left, between] = [3, 4].map(|k| all.values().map(|sums| sums[k]).sum::<f64>().sqrt());
    let bent = missed.sqrt() > BENT;
    let bent = all.into_keys().filter(|_| bent).cloned();
    (bent.collect(), left > BENT, between > ASTRAY && left > FAR * slopes.sqrt())
}
