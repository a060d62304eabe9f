//! The leading models of a stage between two trainings: what was measured since then counts to first order.
//!
//! At points that trained, the measured numbers changed: posterior and evidence follow by the model and its
//! data to first order ([`rijke_inference::Linearised::moved`]). Points that are new are read one after the
//! other as Kalman (1960) does, all at once: with y the numbers read, m and V their mean and covariance by
//! the model, and C = Sigma J' the covariance of parameters with them, the parameters move by C V^-1 (y - m),
//! their covariance falls by C V^-1 C', and the evidence gains the density of y. Noise stays as it was
//! fitted, and new growth rates and frequencies count, not new pressures: the next training counts all.

use super::place::Place;
use super::predictive::{Numbers, Predictive};
use crate::run::course::{Chosen, Done, Run};
use crate::run::parameter::TrainedParameter;
use crate::run::points::inputs::selected;
use crate::run::points::ready::Known;
use crate::run::record::ModelRecord;
use crate::{EngineError, Observed, SavedModel};
use rayon::prelude::*;
use rijke_numerics::{Cholesky, InOrder, Matrix, dot};
use rijke_rig::ChannelErrors;
use rijke_study::plan::Stage;
use rijke_study::{ObservedModes, PointState, Study};
use serde::Serialize;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// The leading models of a stage as they were trained.
pub struct Sequence {
    stage: Stage,
    states: BTreeMap<usize, PointState>,
    channels: Option<ChannelErrors>,
    models: Vec<(ModelRecord, Chosen, SavedModel)>,
}

/// A leading model with what was measured since its training.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Lead {
    /// The model as its table calls it.
    pub id: String,
    /// ln evidence, nats.
    pub ln_evidence: f64,
    /// Its own parameters.
    pub parameters: Vec<TrainedParameter>,
}

/// The leading models of a stage with what was measured since their training, the most evidence first.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Leads {
    /// The stage.
    pub stage: String,
    /// What it is called.
    pub title: String,
    /// Points that did not train and count now.
    pub new: Vec<String>,
    /// The models.
    pub models: Vec<Lead>,
}

/// What one model makes of new points.
struct Read {
    ln_density: f64,
    step: Vec<f64>,
    covariance: Matrix,
}

impl Run {
    /// The `count` models of most evidence of every stage that has run, to be followed until the next
    /// training.
    #[must_use]
    pub fn sequences(&self, count: usize) -> Vec<Sequence> {
        let of_the_stage = |(stage, done): (&Stage, &Done)| {
            let mut rows: Vec<&(ModelRecord, Chosen)> = done.rows.iter().collect();
            rows.sort_by(|a, b| b.0.ln_evidence().total_cmp(&a.0.ln_evidence()));
            let saved = |(model, chosen): &(ModelRecord, Chosen)| {
                let mut points: Vec<String> =
                    chosen.observed.iter().map(|o| o.conditions.id.clone()).collect();
                points.dedup();
                let (candidates, hold) = (model.candidates.clone(), stage.hold.clone());
                let trained = &chosen.trained;
                let measured = stage.noise.measured;
                let saved = SavedModel::of(&stage.id, candidates, hold, points, trained, None, measured);
                (model.clone(), chosen.clone(), saved)
            };
            Sequence {
                // What enters predictions only is no part of the evidence.
                stage: Stage { noise_of_predictions: None, ..stage.clone() },
                states: self.states.clone(),
                channels: self.channels.clone(),
                models: rows.into_iter().take(count).map(saved).collect(),
            }
        };
        self.study.plan.stages.iter().zip(&self.done).map(of_the_stage).collect()
    }
}

impl Sequence {
    /// The models with what is observed by now.
    ///
    /// # Errors
    /// Those of the files and of the models; new points without a temperature.
    pub fn with(&self, study: &Study, observations: &ObservedModes) -> Result<Leads, EngineError> {
        let known = Known::of_states(study, observations, self.states.clone())?;
        let place = Place::new(known, self.channels.clone());
        let now = selected(study, place.observed(), &self.stage.points);
        let known: Vec<&String> = self.models.iter().flat_map(|(.., saved)| &saved.trained_on).collect();
        let new: Vec<&Observed> = now.iter().filter(|o| !known.contains(&&o.conditions.id)).collect();
        let one = |model: &(ModelRecord, Chosen, SavedModel)| self.lead(&place, model, &now, &new);
        let mut models = self.models.par_iter().map(one).in_order::<Result<Vec<_>, _>>()?;
        models.sort_by(|a, b| b.ln_evidence.total_cmp(&a.ln_evidence));
        let mut points: Vec<String> = new.iter().map(|o| o.conditions.id.clone()).collect();
        points.dedup();
        Ok(Leads { stage: self.stage.id.clone(), title: self.stage.title.clone(), new: points, models })
    }

    fn lead(
        &self,
        place: &Place<'_>,
        (model, chosen, saved): &(ModelRecord, Chosen, SavedModel),
        now: &[Observed],
        new: &[&Observed],
    ) -> Result<Lead, EngineError> {
        let trained = &chosen.trained;
        let (linear, change) = (&trained.linear.0, changes(place, chosen, &self.stage, now));
        let moved = linear.moved(&change);
        let working = |k: usize| trained.parameters[k].working(trained.values[k]);
        let slopes: Vec<f64> = (0..trained.values.len()).map(|k| trained.slope(k)).collect();
        let mut step = moved.step;
        let (mut ln_evidence, mut sd) = (model.ln_evidence() + moved.ln_evidence, trained.sd());
        if !new.is_empty() {
            let columns = &trained.told.columns;
            let told = linear.causes_moved(columns, &vec![1.0; columns.len()], &change);
            let physical: Vec<f64> = step.iter().zip(&slopes).map(|(z, s)| z * s).chain(told).collect();
            let read = self.read(place, saved, &physical, new)?;
            ln_evidence += read.ln_density;
            for (k, sd) in sd.iter_mut().enumerate() {
                step[k] += read.step[k] / slopes[k];
                *sd = read.covariance[(k, k)].max(0.0).sqrt();
            }
        }
        let after = |k: usize| trained.parameters[k].physical(working(k) + step[k])[0];
        let parameters = (0..trained.own)
            .map(|k| (&trained.parameters[k], after(k), sd[k]))
            .map(|(p, value, sd)| TrainedParameter::of(p, value, sd))
            .collect();
        Ok(Lead { id: model.id.clone(), ln_evidence, parameters })
    }

    /// New points by a model whose parameters were moved by `step`.
    fn read(
        &self,
        place: &Place<'_>,
        saved: &SavedModel,
        step: &[f64],
        new: &[&Observed],
    ) -> Result<Read, EngineError> {
        let sigma = saved.posterior()?.gaussian.covariance;
        let campaign = &place.study().campaign;
        let at: Vec<usize> =
            new.iter().filter_map(|o| campaign.point(&o.conditions.id).map(|(k, _)| k)).collect();
        let (mut points, mut residual) = (Vec::new(), Vec::new());
        for (visit, observed) in place.expected(&self.stage, saved, &at, &[])?.into_iter().zip(new) {
            // Where the model has one mode in place of two, it says nothing of the second.
            let of_the_mode = |(label, _): &(String, Numbers)| *label == observed.mode.label;
            let Some((_, numbers)) = visit?.0.into_iter().find(of_the_mode) else { continue };
            let used = observed.used(&[], usize::MAX);
            let keep = Matrix::from_fn(used.rows.len(), numbers.values.len(), |i, j| {
                f64::from(u8::from(used.rows[i] == j))
            });
            let numbers = numbers.through(&keep);
            for (row, value) in used.values.iter().enumerate() {
                let moved: f64 = numbers.along.iter().map(|(k, slope)| slope[row] * step[*k]).sum();
                residual.push(value - numbers.values[row] - moved);
            }
            points.push(numbers);
        }
        read(points, &residual, &sigma)
    }
}

/// What `residual`, measured less predicted, tells of parameters that are known to `sigma`.
fn read(points: Vec<Numbers>, residual: &[f64], sigma: &Matrix) -> Result<Read, EngineError> {
    let along: Vec<Vec<f64>> = (0..sigma.rows())
        .map(|k| {
            let of = |p: &Numbers| {
                let slope = p.along.iter().find(|(place, _)| *place == k);
                slope.map_or_else(|| vec![0.0; p.values.len()], |(_, slope)| slope.clone())
            };
            points.iter().flat_map(of).collect()
        })
        .collect();
    let all: Vec<usize> = (0..points.len()).collect();
    let covariance = Predictive::new(points, sigma).covariance(&all);
    let factor = Cholesky::new(&covariance)?;
    let white = factor.whiten(residual);
    // L^-1 J Sigma, a column for each parameter.
    let crossed: Vec<Vec<f64>> = (0..sigma.rows())
        .map(|k| {
            let of = |row: usize| (0..sigma.rows()).map(|j| along[j][row] * sigma[(j, k)]).sum();
            factor.whiten(&(0..residual.len()).map(of).collect::<Vec<f64>>())
        })
        .collect();
    let told = |i: usize, j: usize| sigma[(i, j)] - dot(&crossed[i], &crossed[j]);
    Ok(Read {
        ln_density: -0.5 * (dot(&white, &white) + factor.ln_det() + residual.len() as f64 * TAU.ln()),
        step: crossed.iter().map(|c| dot(c, &white)).collect(),
        covariance: Matrix::from_fn(sigma.rows(), sigma.rows(), told),
    })
}

/// By how much the growth rates and frequencies that trained read more by now, in the order of the data.
fn changes(place: &Place<'_>, chosen: &Chosen, stage: &Stage, now: &[Observed]) -> Vec<f64> {
    let before = chosen.used(&place.study().rig, stage);
    let change = |(k, row): (usize, usize)| {
        let then = &chosen.observed[k];
        let same = |o: &&Observed| o.conditions.id == then.conditions.id && o.mode.label == then.mode.label;
        let of = |o: &Observed| match row {
            0 => o.mode.growth_rate,
            1 => o.mode.angular_frequency,
            _ => None,
        };
        now.iter().find(same).and_then(|o| Some(of(o)? - of(then)?)).unwrap_or(0.0)
    };
    chosen.rows(&before).into_iter().map(change).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two points that share an error, two parameters, against the joint Gaussian of parameters and numbers,
    /// conditioned by hand.
    #[test]
    fn exact_new_points_are_read_as_one() {
        let slopes = [[1.0, 0.4], [0.3, -0.8]];
        let (noise, shared) = (0.25, 0.7);
        let sigma = Matrix::from_fn(2, 2, |i, j| [[1.0, 0.3], [0.3, 0.6]][i][j]);
        let point = |k: usize| Numbers {
            values: vec![0.0],
            along: (0..2).map(|i| (i, vec![slopes[k][i]])).collect(),
            shared: BTreeMap::from([(super::super::predictive::Shared::Calibration(0), vec![shared])]),
            noise: Matrix::diagonal(&[noise]),
            stays: Matrix::zeros(1, 1),
        };
        let residual = [0.5, -1.1];
        let found = read(vec![point(0), point(1)], &residual, &sigma).unwrap();
        let cross = |k: usize, i: usize| slopes[k][0] * sigma[(0, i)] + slopes[k][1] * sigma[(1, i)];
        let v = |a: usize, b: usize| {
            cross(a, 0) * slopes[b][0]
                + cross(a, 1) * slopes[b][1]
                + shared * shared
                + noise * f64::from(u8::from(a == b))
        };
        let det = v(0, 0) * v(1, 1) - v(0, 1) * v(0, 1);
        let inverse = [[v(1, 1) / det, -v(0, 1) / det], [-v(0, 1) / det, v(0, 0) / det]];
        let pull = |a: usize| inverse[a][0] * residual[0] + inverse[a][1] * residual[1];
        for i in 0..2 {
            let step = cross(0, i) * pull(0) + cross(1, i) * pull(1);
            assert!((found.step[i] - step).abs() < 1e-12, "{i}");
            let mut variance = sigma[(i, i)];
            (0..2).for_each(|a| {
                (0..2).for_each(|b| variance -= cross(a, i) * inverse[a][b] * cross(b, i));
            });
            assert!((found.covariance[(i, i)] - variance).abs() < 1e-12, "{i}");
        }
        let square = residual[0] * pull(0) + residual[1] * pull(1);
        let ln_density = -0.5 * (square + det.ln()) - TAU.ln();
        assert!((found.ln_density - ln_density).abs() < 1e-12);
    }
}
