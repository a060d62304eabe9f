//! The errors of one base state along its principal directions.
//!
//! Fifty causes, many of them of other places or other hours, move the state of one point along few
//! directions. The model is asked what these do, and the causes are sums of them.

use crate::EngineError;
use rijke_numerics::{Matrix, principal_directions};
use rijke_study::{Cause, PointState, STEP};

/// Share of the variance of the state, in units of its own errors, that may be left out.
const NEGLIGIBLE: f64 = 1e-5;

/// The errors of a base state.
pub(crate) struct Principal {
    /// The state displaced by [`STEP`] standard deviations of each principal error, the largest first.
    pub(crate) states: Vec<PointState>,
    /// What each cause consists of: shares of the principal errors.
    pub(crate) causes: Vec<(Cause, Vec<f64>)>,
}

impl Principal {
    /// With D the displacements by each cause, a row each, and D D' = U L U', principal error k is row k of
    /// U'D, and cause j the sum over k of U_jk times it.
    ///
    /// # Errors
    /// [`EngineError::Dense`] if the eigenvalue iteration fails.
    pub(crate) fn of(base: &PointState) -> Result<Self, EngineError> {
        let mut causes: Vec<&Cause> = base.errors.iter().map(|e| &e.cause).collect();
        causes.sort_unstable();
        causes.dedup();
        let rows: Vec<Vec<f64>> = causes.iter().map(|cause| displacement(base, cause)).collect();
        // In units of the whole error of the mass flow, of the base state's own numbers and of the
        // temperature: each counts as much.
        let size = rows.len();
        let mut gram = Matrix::zeros(size, size);
        let own = 1 + base.numbers.len();
        for part in [0..1, 1..own, own..own + base.temperature.len()] {
            let dot = |i: usize, j: usize| -> f64 {
                rows[i][part.clone()].iter().zip(&rows[j][part.clone()]).map(|(a, b)| a * b).sum()
            };
            let whole: f64 = (0..size).map(|i| dot(i, i)).sum();
            if whole > 0.0 {
                gram = gram.plus(1.0 / whole, &Matrix::from_fn(size, size, dot));
            }
        }
        let mut kept = principal_directions(&gram)?;
        let total: f64 = kept.iter().map(|(value, _)| value).sum();
        let mut left = total;
        let enough = kept.iter().position(|(value, _)| {
            let negligible = left <= NEGLIGIBLE * total;
            left -= value;
            negligible
        });
        kept.truncate(enough.unwrap_or(size));
        let displaced = |along: &[f64]| {
            let mut sum = vec![0.0; 1 + base.numbers.len() + base.temperature.len()];
            for (row, share) in rows.iter().zip(along) {
                sum.iter_mut().zip(row).for_each(|(s, d)| *s += share * d);
            }
            moved(base, STEP, &sum)
        };
        Ok(Self {
            states: kept.iter().map(|(_, along)| displaced(along)).collect(),
            causes: (0..size)
                .map(|j| (causes[j].clone(), kept.iter().map(|(_, along)| along[j]).collect()))
                .collect(),
        })
    }
}

/// What one standard deviation of a cause does to mass flow, numbers of the base state, and temperatures.
fn displacement(base: &PointState, cause: &Cause) -> Vec<f64> {
    let mut sum = vec![0.0; 1 + base.numbers.len() + base.temperature.len()];
    for error in base.errors.iter().filter(|e| e.cause == *cause) {
        let all = [error.mass_flow].into_iter().chain(error.numbers.iter().copied());
        let all = all.chain(error.temperature.iter().copied());
        sum.iter_mut().zip(all).for_each(|(s, d)| *s += d);
    }
    sum
}

/// The state, without its errors, moved by `times` a displacement.
fn moved(base: &PointState, times: f64, by: &[f64]) -> PointState {
    let (own, temperatures) = by.split_at(1 + base.numbers.len());
    PointState {
        gas: base.gas.clone(),
        other_gases: base.other_gases.clone(),
        mass_flow: base.mass_flow + times * own[0],
        numbers: base.numbers.iter().zip(&own[1..]).map(|((n, v), d)| (*n, v + times * d)).collect(),
        places: base.places.clone(),
        temperature: base.temperature.iter().zip(temperatures).map(|(t, d)| t + times * d).collect(),
        kinks: base.kinks.clone(),
        errors: Vec::new(),
        moved: Vec::new(),
        ..*base
    }
}
