//! The search for the most probable scores of all runs together.
//!
//! Gauss and Newton's method, damped after Levenberg and Marquardt. The more places of the heater, the
//! better the shared scores are known, and the narrower is the valley of the cost in which they lie: a step
//! along its tangent leaves it where it bends. Residuals cost a tenth of slopes, so several steps follow on
//! slopes taken once, which each step turns by what it found (Broyden 1965, run by run). They lead back to
//! the floor, and on along it. What the floor's own bend adds to the second derivatives is learned on the
//! way. Knows neither causes nor reports.

use super::bend::Bend;
use super::joint::{Arrow, Scores};
use super::of_run::Settled;
use super::prediction::Predicted;
use super::readings::Readings;
use crate::error::FlowError;
use crate::infer::sensor::SensorKind;
use rayon::prelude::*;
use rijke_numerics::{Cholesky, InOrder, Matrix, dot};

/// Where a search ended.
pub(super) struct Found {
    pub(super) at: Trial,
    /// The slopes there, run by run.
    pub(super) slopes: Vec<Slopes>,
    pub(super) converged: bool,
    /// How often slopes were taken.
    pub(super) linearisations: usize,
}

/// All runs at some scores.
pub(super) struct Trial {
    pub(super) scores: Scores,
    pub(super) states: Vec<Vec<Predicted>>,
    /// Residuals of each run, in standard deviations of their noise.
    pub(super) white: Vec<Vec<f64>>,
    /// Half the squares of these and of the scores.
    cost: f64,
}

/// The slopes of a run in its scores.
pub(super) struct Slopes {
    /// Of the base vectors.
    pub(super) base: Matrix,
    /// Inverse covariance that the readings give.
    pub(super) information: Matrix,
    /// Of the readings in standard deviations of their noise, a row for each score.
    white: Vec<Vec<f64>>,
    /// Of each reading how far it is from the model, in standard deviations of noise and priors, and how far
    /// it would be after one step; the larger.
    off: Vec<f64>,
}

/// From the centre of the priors.
///
/// # Errors
/// [`FlowError::FarOff`] for readings that no flow near the priors has, and those of the model.
pub(super) fn search(runs: &[Settled<'_>], noise: &[Cholesky]) -> Result<Found, FlowError> {
    let centre = Scores::centre(runs.iter().map(|run| run.priors.len()));
    let mut at = Trial::new(runs, noise, centre, None)?;
    let (mut damping, mut linearisations) = (0.0, 0);
    let mut bend = Bend::default();
    // Where the last step began, and the slope at its end with the slopes of its begin.
    let mut before: Option<(Scores, Scores)> = None;
    loop {
        let one = |((run, trial), noise): ((usize, &Vec<Predicted>), &Cholesky)| {
            Slopes::new(&runs[run], &at.scores.of(run), trial, &at.white[run], noise)
        };
        let slopes: Vec<Slopes> = at
            .states
            .par_iter()
            .enumerate()
            .zip(noise)
            .map(one)
            .in_order::<Result<_, _>>()
            .map_err(pulled)?;
        if linearisations == 0 {
            near_the_prior(runs, &at, &slopes)?;
        }
        linearisations += 1;
        let down = at.down(slopes.iter().map(|run| &run.white));
        // The first step, from the priors to the data, is too long to tell.
        if let Some((from, stale)) = before.take().filter(|_| linearisations > 2) {
            bend.learn(&at.scores.plus(-1.0, &from), &stale.plus(-1.0, &down));
        }
        let left = 0.5 * down.dot(&Arrow::new(slopes.iter().map(|run| &run.information), 0.0)?.step(&down))
            / runs.len() as f64;
        if left < CLOSE || linearisations > STEPS {
            return Ok(Found { at, slopes, converged: left < CLOSE, linearisations });
        }
        let mut better = None;
        while better.is_none() && damping < HELD {
            better = at.steps(runs, noise, &slopes, damping, &mut bend)?;
            if better.is_none() {
                // The model is piecewise smooth: so near, its kinks alone are left.
                if left < KINKS {
                    break;
                }
                damping = (10.0 * damping).max(1.0);
            }
        }
        let Some(next) = better else {
            return Ok(Found { at, slopes, converged: left < KINKS, linearisations });
        };
        before = Some((at.scores, next.down(slopes.iter().map(|run| &run.white))));
        at = next;
        damping = if damping > 1.0 { 0.1 * damping } else { 0.0 };
    }
}

impl Trial {
    fn new(
        runs: &[Settled<'_>],
        noise: &[Cholesky],
        scores: Scores,
        near: Option<&Self>,
    ) -> Result<Self, FlowError> {
        let one = |(p, run): (usize, &Settled<'_>)| {
            run.states(&scores.of(p), near.map(|near| near.states[p].as_slice()))
        };
        let states: Vec<Vec<Predicted>> = runs.par_iter().enumerate().map(one).in_order::<Result<_, _>>()?;
        let white: Vec<Vec<f64>> = (runs.iter().zip(&states).zip(noise))
            .map(|((run, s), noise)| noise.whiten(&run.residual(s)))
            .collect();
        let misfit: f64 = white.iter().map(|white| dot(white, white)).sum();
        let cost = 0.5 * (misfit + scores.dot(&scores));
        Ok(Self { scores, states, white, cost })
    }

    /// The negative gradient of the cost, with the `white` slopes of each run, taken here or near.
    fn down<'a>(&self, white: impl Iterator<Item = &'a Vec<Vec<f64>>>) -> Scores {
        let one = |(white, left): (&Vec<Vec<f64>>, &Vec<f64>)| white.iter().map(|w| dot(w, left)).collect();
        let by_run: Vec<Vec<f64>> = white.zip(&self.white).map(one).collect();
        self.scores.descent(by_run.iter().map(Vec::as_slice))
    }

    /// The last of some steps on `slopes`, if it is better than here. The first may lead up, off the floor of
    /// the valley; where no flow exists they end.
    fn steps(
        &self,
        runs: &[Settled<'_>],
        noise: &[Cholesky],
        slopes: &[Slopes],
        damping: f64,
        bend: &mut Bend,
    ) -> Result<Option<Self>, FlowError> {
        let mut white: Vec<Vec<Vec<f64>>> = slopes.iter().map(|run| run.white.clone()).collect();
        let mut arrow = Arrow::new(slopes.iter().map(|run| &run.information), damping)?;
        let mut last: Option<Self> = None;
        for k in 0..MOST {
            let now = last.as_ref().unwrap_or(self);
            let down = now.down(white.iter());
            let step = bend.step(&arrow, &down);
            let promised = 0.5 * down.dot(&step);
            // Not worth it, or too far up to come back.
            if promised < CLOSE * runs.len() as f64 || (k > 0 && now.cost - 1.1 * promised > self.cost) {
                break;
            }
            let Ok(next) = Self::new(runs, noise, now.scores.plus(1.0, &step), Some(now)) else { break };
            let gained = now.cost - next.cost;
            if k > 0 && gained < WORTH * promised {
                break;
            }
            let turned = |(p, white): (usize, &mut Vec<Vec<f64>>)| {
                let step = next.scores.of(p).into_iter().zip(now.scores.of(p)).map(|(b, a)| b - a).collect();
                turn(white, step, &now.white[p], &next.white[p]);
                information(white)
            };
            let turned: Vec<Matrix> = white.iter_mut().enumerate().map(turned).collect();
            arrow = Arrow::new(turned.iter(), damping)?;
            last = Some(next);
        }
        Ok(last.filter(|last| last.cost < self.cost))
    }
}

/// Turns the slopes `white` so that `step` explains by what the residuals changed.
fn turn(white: &mut [Vec<f64>], step: Vec<f64>, before: &[f64], after: &[f64]) {
    let size = dot(&step, &step);
    if size > 0.0 {
        for (j, change) in before.iter().zip(after).map(|(a, b)| a - b).enumerate() {
            let known: f64 = step.iter().zip(&*white).map(|(s, w)| s * w[j]).sum();
            white.iter_mut().zip(&step).for_each(|(w, s)| w[j] += (change - known) / size * s);
        }
    }
}

/// Inverse covariance of scores that readings with these slopes give.
fn information(white: &[Vec<f64>]) -> Matrix {
    Matrix::from_fn(white.len(), white.len(), |i, j| dot(&white[i], &white[j]))
}

impl Slopes {
    fn new(
        run: &Settled<'_>,
        scores: &[f64],
        states: &[Predicted],
        white_residual: &[f64],
        noise: &Cholesky,
    ) -> Result<Self, FlowError> {
        let (readings, base) = run.slopes(scores, states)?;
        let columns = readings.transpose();
        let white: Vec<Vec<f64>> = (0..columns.rows()).map(|k| noise.whiten(columns.row(k))).collect();
        let information = information(&white);
        let down: Vec<f64> = white.iter().map(|w| dot(w, white_residual)).collect();
        let step = Cholesky::new(&Matrix::identity(down.len()).plus(1.0, &information))?.solve(&down);
        let residual = run.residual(states);
        let off = residual.iter().enumerate().map(|(j, r)| {
            let [noise, slopes] = [noise.lower().row(j), readings.row(j)];
            let left = white_residual[j] - white.iter().zip(&step).map(|(w, s)| w[j] * s).sum::<f64>();
            left.abs().max(r.abs() / (dot(noise, noise) + dot(slopes, slopes)).sqrt())
        });
        let off = off.collect();
        Ok(Self { base, information, white, off })
    }
}

/// The search moves closures: one that is out of its range is none that a user gave.
fn pulled(error: FlowError) -> FlowError {
    match error {
        FlowError::Closure { name, value, need } => FlowError::Pulled { name, value, need },
        other => other,
    }
}

/// Refuses a run most of whose readings lie farther from the model than unknowns near their priors can move
/// it, before the search tries. A few that are wrong are left to the fit and its warnings.
fn near_the_prior(runs: &[Settled<'_>], at: &Trial, slopes: &[Slopes]) -> Result<(), FlowError> {
    for ((run, states), slopes) in runs.iter().zip(&at.states).zip(slopes) {
        let far = slopes.off.iter().filter(|z| **z > FAR).count();
        if 2 * far <= slopes.off.len() {
            continue;
        }
        let readings = run.run.states.iter().zip(states).flat_map(|(state, predicted)| {
            let each = state.sensors.iter().zip(&state.readings).zip(&predicted.readings);
            each.map(|((sensor, reading), model)| (&state.id, *sensor, *reading, *model))
        });
        let far = |r: f64, m: f64| (r / m).ln().abs();
        let worst = readings.max_by(|a, b| far(a.2, a.3).total_cmp(&far(b.2, b.3)));
        if let Some((id, sensor, reading, model)) = worst {
            let file = match sensor {
                SensorKind::Arrival { .. } => "clicks.csv",
                _ => Readings::FILE,
            };
            return Err(FlowError::FarOff {
                id: id.clone(),
                file,
                sensor: sensor.to_string(),
                reading,
                model,
            });
        }
    }
    Ok(())
}

/// Drop in J that may be left of each run, nats: a two-hundredth of an sd, which differences still resolve.
const CLOSE: f64 = 1e-5;
/// The same where no full step is better: a seventieth of an sd.
const KINKS: f64 = 1e-4;
/// Most linearisations after the first; two to five are usual.
const STEPS: usize = 30;
/// Most steps on slopes taken once, and the share of the drop promised that one of them must keep to be
/// followed by another.
const MOST: usize = 10;
const WORTH: f64 = 0.05;
/// Damping, in precisions of the prior, at which a search that finds nothing better ends.
const HELD: f64 = 1e10;
/// Standard deviations by which half of the readings may miss the model.
const FAR: f64 = 5.0;

#[cfg(test)]
mod tests {
    use super::pulled;
    use crate::error::FlowError;

    #[test]
    fn message_a_closure_that_the_search_moved_is_no_key_of_the_user() {
        let said =
            pulled(FlowError::Closure { name: "emissivity", value: 1.5, need: "at most 1" }).to_string();
        assert!(said.starts_with("the readings pull the closure emissivity to 1.500000"), "{said}");
        let other = FlowError::Power { watts: -1.0 };
        assert_eq!(pulled(other.clone()), other);
    }
}
