//! The errors of one base state along its principal directions.
//!
//! Fifty causes, many of them of other places or other hours, move the state of one point along few directions. The model is
//! asked what these do, and the causes are sums of them.

use crate::{BaseState, ModelError};
use rijke_flow::ErrorComponent;
use rijke_numerics::{Matrix, symmetric_eigen};

/// Share of a standard deviation by which states are displaced: a slope, to a tenth of a per cent of its change over the error.
pub(crate) const STEP: f64 = 0.02;

/// Share of the variance of the state, in units of its own errors, that may be left out.
const NEGLIGIBLE: f64 = 1e-5;

/// The errors of a base state.
pub(crate) struct Principal {
    /// The state displaced by [`STEP`] standard deviations of each principal error, the largest first.
    pub(crate) states: Vec<BaseState>,
    /// What each cause consists of: shares of the principal errors.
    pub(crate) causes: Vec<(String, Vec<f64>)>,
}

impl Principal {
    /// With D the displacements by each cause, a row each, and D D' = U L U', principal error k is row k of U'D, and cause j
    /// the sum over k of U_jk times it.
    ///
    /// # Errors
    /// [`ModelError::Flow`] for point `id` if the eigenvalue iteration fails.
    pub(crate) fn of(base: &BaseState, id: &str) -> Result<Self, ModelError> {
        let mut causes: Vec<&str> = base.errors.iter().map(|e| e.cause.as_str()).collect();
        causes.sort_unstable();
        causes.dedup();
        let rows: Vec<Vec<f64>> = causes.iter().map(|cause| displacement(base, cause)).collect();
        // In units of the whole error of the mass flux, of the heater's velocity and of the temperature: each counts as much.
        let size = rows.len();
        let mut gram = Matrix::zeros(size, size);
        for part in [0..1, 1..2, 2..2 + base.temperature.len()] {
            let dot = |i: usize, j: usize| -> f64 {
                rows[i][part.clone()].iter().zip(&rows[j][part.clone()]).map(|(a, b)| a * b).sum()
            };
            let whole: f64 = (0..size).map(|i| dot(i, i)).sum();
            if whole > 0.0 {
                gram = gram.plus(1.0 / whole, &Matrix::from_fn(size, size, dot));
            }
        }
        let failed = |source| ModelError::Flow { point: id.to_owned(), source };
        let (values, vectors) = symmetric_eigen(&gram).map_err(|e| failed(e.into()))?;
        let total: f64 = values.iter().sum();
        let (mut left, mut kept) = (total, Vec::new());
        for k in (0..size).rev() {
            if left <= NEGLIGIBLE * total {
                break;
            }
            left -= values[k];
            kept.push(k);
        }
        let displaced = |k: usize| {
            let mut sum = vec![0.0; 2 + base.temperature.len()];
            for (j, row) in rows.iter().enumerate() {
                sum.iter_mut().zip(row).for_each(|(s, d)| *s += vectors[(j, k)] * d);
            }
            moved(base, STEP, &sum)
        };
        Ok(Self {
            states: kept.iter().map(|&k| displaced(k)).collect(),
            causes: (0..size)
                .map(|j| (causes[j].to_owned(), kept.iter().map(|&k| vectors[(j, k)]).collect()))
                .collect(),
        })
    }
}

/// What one standard deviation of a cause does to mass flux, velocity at the heater, and temperatures.
fn displacement(base: &BaseState, cause: &str) -> Vec<f64> {
    let mut sum = vec![0.0; 2 + base.temperature.len()];
    for ErrorComponent { mass_flux, heater_velocity, temperature, .. } in
        base.errors.iter().filter(|e| e.cause == cause)
    {
        let all = [*mass_flux, *heater_velocity].into_iter().chain(temperature.iter().copied());
        sum.iter_mut().zip(all).for_each(|(s, d)| *s += d);
    }
    sum
}

/// The state, without its errors, moved by `times` a displacement.
fn moved(base: &BaseState, times: f64, by: &[f64]) -> BaseState {
    BaseState {
        gas: base.gas.clone(),
        pressure: base.pressure,
        mass_flux: base.mass_flux + times * by[0],
        heater_velocity: base.heater_velocity + times * by[1],
        places: base.places.clone(),
        temperature: base.temperature.iter().zip(&by[2..]).map(|(t, d)| t + times * d).collect(),
        errors: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rijke_rig::Gas;

    /// Whatever is kept, the causes put together again are those of the state.
    #[test]
    fn exact_causes_are_sums_of_the_principal_errors() {
        let mut base = BaseState::uniform(&Gas::air(), 101_325.0, 1.0, 300.0, 0.1).unwrap();
        (base.mass_flux, base.heater_velocity) = (0.4, 0.3);
        for k in 0..6 {
            let x = f64::from(k);
            base.errors.push(ErrorComponent {
                cause: format!("cause {k}"),
                mass_flux: 1e-3 * (x - 2.0),
                heater_velocity: 2e-3 * (x - 2.0) + 1e-4 * x * x,
                temperature: vec![0.2 * x, 1.0 - 0.3 * x],
            });
        }
        let principal = Principal::of(&base, "H7-25").unwrap();
        assert!(principal.states.len() <= 4, "seven causes span no more directions than there are numbers");
        assert_eq!(principal.causes.len(), 7);
        for (cause, shares) in &principal.causes {
            let wanted = displacement(&base, cause);
            let mut found = vec![0.0; wanted.len()];
            for (share, moved) in shares.iter().zip(&principal.states) {
                let share = share / STEP;
                found[0] += share * (moved.mass_flux - base.mass_flux);
                found[1] += share * (moved.heater_velocity - base.heater_velocity);
                for (f, (m, b)) in found[2..].iter_mut().zip(moved.temperature.iter().zip(&base.temperature))
                {
                    *f += share * (m - b);
                }
            }
            for (f, w) in found.iter().zip(&wanted) {
                assert!((f - w).abs() < 1e-10, "{cause}: {found:?} {wanted:?}");
            }
        }
    }
}
