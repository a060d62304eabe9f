//! Errors of the base states that several installations of the rig share, as parameters beside the model's.

use super::{Bends, Changes, Learned, PointErrors, Scatter};
use crate::data::is_one_block;
use crate::gaussian::{Training, handed_on};
use crate::observed::{Observed, Used, same_installation};
use crate::{EngineError, NamedGaussian};
use rijke_inference::{Parameter, Prior};
use rijke_numerics::{Matrix, principal_directions};
use rijke_study::Cause;
use std::collections::{BTreeMap, BTreeSet};

/// The errors that all installations have in common: those of the flow's own parameters, say, which one
/// calibration gave to all states.
///
/// They act on the pressures and the eigenvalues of all points at once. As a covariance they would join all
/// numbers into one block; taken as noise of each point, they would seem to vanish in the mean over points.
/// As parameters with a prior of 0 +- 1, in which the prediction is linear, they do neither, and what the
/// sound says of the flow is not lost. A cause of which later stages have points is one of them, whoever
/// shares it here; what is learnt of it goes on ([`Common::learned`]), and there it is a parameter again,
/// with that for its prior.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Common {
    /// The causes: those of which earlier stages tell, then those that installations share, or a
    /// later stage.
    causes: Vec<Cause>,
    /// How many of them earlier stages tell of: each of these is a direction of its own.
    known: usize,
    /// For each cause its shares in the directions, orthonormal columns: those that are known, a drift and
    /// bent ones, then the others, the most important first, and for predictions those that stayed a
    /// covariance.
    shares: Matrix,
    /// The change of each number of each point, point after point, per direction.
    slopes: Matrix,
}

/// The place of a direction in what is known, and the change of a prediction along it.
type Along = (usize, Vec<f64>);

/// Directions that move all data together by less than the root of this, in measured standard deviations, are
/// left out.
const NEGLIGIBLE: f64 = 0.01;

/// A direction is called after its largest causes that together make this share of it, but no more than so
/// many.
const MOST: f64 = 0.8;
const NAMED: usize = 3;

impl Common {
    /// The directions of the `errors` that installations share, or that are bent, and what is left of the
    /// errors.
    ///
    /// With D the changes by each cause in units of the measured standard deviations of `observed`, a column
    /// each, and D'D = U L U', direction k is D times column k of U.
    ///
    /// # Errors
    /// [`EngineError::Dense`] if the eigenvalue iteration fails.
    pub(crate) fn of(
        errors: PointErrors,
        (observed, used, scatter): (&[Observed], &[Used], &[Scatter]),
        training: &Training,
        bends: &Bends<'_>,
    ) -> Result<(Self, PointErrors), EngineError> {
        let same = |a: usize, b: usize| same_installation(&observed[a], &observed[b]);
        let sizes: Vec<usize> = used.iter().map(Used::size).collect();
        let rows: usize = sizes.iter().sum();
        // In one block with what they move, the errors of an installation or a point are noise like others.
        let groups = if errors.are_of_factors() { errors.together(same) } else { Vec::new() };
        let groups = groups.into_iter().filter(|group| !is_one_block(&errors, group, used, scatter));
        let apart: BTreeSet<Cause> =
            groups.flatten().flat_map(|p| errors.of_factors_at(p)).cloned().collect();
        let goes_on = |cause: &Cause| {
            training.causes.contains(cause)
                || training.knows(cause)
                || apart.contains(cause)
                || bends.holds(cause)
        };
        let (causes, columns, rest) = errors.apart(&sizes, same, goes_on);
        // One that does nothing here is handed on with what the parameters, which are tied to it, learn.
        let idle = training.causes.iter().filter(|cause| training.knows(cause) && !causes.contains(cause));
        let idle: Vec<(Cause, Vec<f64>)> = idle.map(|cause| (cause.clone(), vec![0.0; rows])).collect();
        let (mut all, new): (Vec<_>, Vec<_>) =
            causes.into_iter().zip(columns).chain(idle).partition(|(cause, _)| training.knows(cause));
        let known = all.len();
        // A drift moves the data and no prediction: mixed with a cause that moves both alike, as a
        // temperature does, the difference of the two would be lost. Nor is a bent one a straight direction.
        let of_its_own = |cause: &Cause| *cause == Cause::Drift || bends.holds(cause);
        let (own, new): (Vec<_>, Vec<_>) = new.into_iter().partition(|(cause, _)| of_its_own(cause));
        let alone = known + own.len();
        all.extend(own.into_iter().chain(new));
        let (causes, columns): (Vec<Cause>, Vec<Vec<f64>>) = all.into_iter().unzip();
        let others = &columns[alone..];
        // Numbers that were not measured have no weight.
        let weigh = |u: &Used| {
            let mut weights = vec![0.0; u.size()];
            u.rows
                .iter()
                .enumerate()
                .for_each(|(k, &row)| weights[row] = u.covariance[(k, k)].sqrt().recip());
            weights
        };
        let weights: Vec<f64> = used.iter().flat_map(weigh).collect();
        let gram = Matrix::from_fn(others.len(), others.len(), |i, j| {
            let pairs = others[i].iter().zip(&others[j]).zip(&weights);
            pairs.map(|((a, b), w)| a * b * w * w).sum()
        });
        let mut kept = principal_directions(&gram)?;
        kept.retain(|(value, _)| *value > NEGLIGIBLE);
        let share = |j: usize, k: usize| match (j.checked_sub(alone), k.checked_sub(alone)) {
            (Some(j), Some(k)) => kept[k].1[j],
            (None, None) => f64::from(u8::from(j == k)),
            _ => 0.0,
        };
        let shares = Matrix::from_fn(causes.len(), alone + kept.len(), share);
        let slopes = Matrix::from_fn(rows, shares.columns(), |row, k| {
            (0..causes.len()).map(|j| shares[(j, k)] * columns[j][row]).sum()
        });
        Ok((Self { causes, known, shares, slopes }, rest))
    }

    /// For each parameter of which earlier stages tell its name there and here.
    pub(crate) fn known(&self) -> Vec<[String; 2]> {
        (0..self.known).map(|k| [handed_on(&self.causes[k]), name(k)]).collect()
    }

    /// The error of each cause where the directions have these values, `found`; behind them stand others.
    pub(crate) fn found(&self, found: &[f64]) -> impl Iterator<Item = (Cause, f64)> {
        let along = |j: usize| (0..self.shares.columns()).map(|k| self.shares[(j, k)] * found[k]).sum();
        self.causes.iter().enumerate().map(move |(j, cause)| (cause.clone(), along(j)))
    }

    /// The value of each direction that belongs to these errors; causes that are not among them have none.
    pub(crate) fn directions(&self, errors: &BTreeMap<Cause, f64>) -> Vec<f64> {
        let errors: Vec<f64> = self.causes.iter().map(|c| errors.get(c).copied().unwrap_or(0.0)).collect();
        self.shares.transpose().times(&errors)
    }

    /// What a training tells of the causes that later stages want. `found` is all that it found; these
    /// parameters stand there behind the model's `own`.
    ///
    /// The causes are c = U b, with b the directions, and a part that moves no number here and keeps its
    /// prior: c has the mean U E b and the covariance U (cov b - 1) U' + 1.
    pub(crate) fn learned(&self, wanted: &[Cause], own: usize, found: &NamedGaussian) -> Learned {
        let places: Vec<usize> =
            (0..self.causes.len()).filter(|&j| wanted.contains(&self.causes[j])).collect();
        let columns = self.shares.columns();
        let along = |j: usize, of: &dyn Fn(usize) -> f64| -> f64 {
            (0..columns).map(|k| self.shares[(j, k)] * of(own + k)).sum()
        };
        let n = places.len();
        Learned {
            names: places.iter().map(|&j| handed_on(&self.causes[j])).collect(),
            mean: places.iter().map(|&j| along(j, &|k| found.mean[k])).collect(),
            covariance: Matrix::from_fn(n, n, |a, b| {
                let (i, j) = (places[a], places[b]);
                let told = along(i, &|k| along(j, &|l| found.covariance[(k, l)]));
                let prior: f64 = (0..columns).map(|k| self.shares[(i, k)] * self.shares[(j, k)]).sum();
                told + f64::from(u8::from(i == j)) - prior
            }),
            with_parameters: Matrix::from_fn(n, found.mean.len(), |a, i| {
                along(places[a], &|k| found.covariance[(k, i)])
            }),
        }
    }

    pub(crate) fn parameters(&self) -> Vec<Parameter> {
        let prior = Prior::Normal { mean: 0.0, sd: 1.0 };
        let parameter = |k: usize| Parameter::new(name(k), format!("b_{}", k + 1), "1", prior);
        (0..self.shares.columns()).map(parameter).collect()
    }

    /// As predictions have it: with causes that stayed a covariance, each a direction of its own behind the
    /// others; and what the directions are called.
    pub(crate) fn with(&self, causes: Vec<Cause>) -> (Self, Vec<String>) {
        let (first, rows) = (self.shares.columns(), self.causes.len());
        let share = |j: usize, k: usize| match (j.checked_sub(rows), k.checked_sub(first)) {
            (None, None) => self.shares[(j, k)],
            (Some(j), Some(k)) => f64::from(u8::from(j == k)),
            _ => 0.0,
        };
        let columns = first + causes.len();
        let names = (first..columns).map(name).collect();
        let causes = [&self.causes[..], &causes].concat();
        let shares = Matrix::from_fn(causes.len(), columns, share);
        (Self { causes, shares, known: self.known, slopes: Matrix::default() }, names)
    }

    /// Of the `changes` that causes of error make to the prediction of a point: the place of each direction
    /// in what is `known`, and the change along it; and what the other causes do. The prediction has `size`
    /// numbers.
    pub(crate) fn along(
        &self,
        known: &NamedGaussian,
        changes: &Changes,
        size: usize,
    ) -> (Vec<Along>, Changes) {
        let place = |k: usize| known.names.iter().position(|n| *n == name(k));
        let mut along: Vec<_> =
            (0..self.shares.columns()).filter_map(|k| Some((k, place(k)?, vec![0.0; size]))).collect();
        let mut left = Vec::new();
        for (cause, change) in changes {
            let Some(j) = self.causes.iter().position(|c| c == cause) else {
                left.push((cause.clone(), change.clone()));
                continue;
            };
            for (k, _, sum) in &mut along {
                sum.iter_mut().zip(change).for_each(|(s, c)| *s += self.shares[(j, *k)] * c);
            }
        }
        (along.into_iter().map(|(_, place, sum)| (place, sum)).collect(), left)
    }

    /// The most probable error of a cause and its standard deviation, both in standard deviations of the
    /// cause, by what is `known`; none of a cause that no training inferred.
    ///
    /// As in [`Common::learned`], what of the cause moves no number keeps its prior.
    pub(crate) fn error(&self, cause: &Cause, known: &NamedGaussian) -> Option<[f64; 2]> {
        let j = self.causes.iter().position(|c| c == cause)?;
        let place = |k: usize| known.names.iter().position(|n| *n == name(k));
        let along: Vec<(f64, usize)> =
            (0..self.shares.columns()).filter_map(|k| Some((self.shares[(j, k)], place(k)?))).collect();
        let mean = along.iter().map(|(share, at)| share * known.mean[*at]).sum();
        let told: f64 = along
            .iter()
            .flat_map(|(a, i)| along.iter().map(move |(b, k)| a * b * known.covariance[(*i, *k)]))
            .sum();
        let prior: f64 = along.iter().map(|(share, _)| share * share).sum();
        Some([mean, (told + 1.0 - prior).max(0.0).sqrt()])
    }

    /// For each cause its shares in the directions.
    pub(crate) fn causes_and_shares(&self) -> Vec<(Cause, Vec<f64>)> {
        let shares = |j: usize| (0..self.shares.columns()).map(|k| self.shares[(j, k)]).collect();
        self.causes.iter().enumerate().map(|(j, cause)| (cause.clone(), shares(j))).collect()
    }

    /// What [`Common::causes_and_shares`] says, without the slopes of the points that trained: enough to
    /// predict.
    pub(crate) fn of_shares(all: &[(Cause, Vec<f64>)]) -> Self {
        let columns = all.first().map_or(0, |(_, shares)| shares.len());
        let shares = Matrix::from_fn(all.len(), columns, |j, k| all[j].1[k]);
        let causes = all.iter().map(|(cause, _)| cause.clone()).collect();
        Self { causes, known: 0, shares, slopes: Matrix::default() }
    }

    /// Warnings of inference, which knows a direction by its number: with the causes that make most of it.
    pub(crate) fn explained(&self, warnings: Vec<String>) -> Vec<String> {
        let explain = |text: String| {
            let of = |k: usize| text.strip_prefix(&format!("{} = ", name(k)))?.split_once(" lies ");
            let found = (0..self.shares.columns()).find_map(|k| Some((k, of(k)?.1)));
            if let Some((k, rest)) = found {
                return format!("the error of the base states by {} lies {rest}", self.most_of(k));
            }
            let named = |text: String, k: usize| {
                let by = format!("error of the base states by {}", self.most_of(k));
                text.replace(&format!("{} = ", name(k)), &format!("{by}, in standard deviations = "))
            };
            (0..self.shares.columns()).fold(text, named)
        };
        warnings.into_iter().map(explain).collect()
    }

    /// The causes that make most of a direction, the largest first.
    fn most_of(&self, direction: usize) -> String {
        let mut shares: Vec<(f64, &Cause)> =
            self.causes.iter().enumerate().map(|(j, c)| (self.shares[(j, direction)].powi(2), c)).collect();
        shares.sort_by(|a, b| b.0.total_cmp(&a.0));
        let all: f64 = shares.iter().map(|(share, _)| share).sum();
        let mut sum = 0.0;
        let most = shares.iter().take(NAMED).take_while(|(share, _)| {
            let more = sum < MOST * all;
            sum += share;
            more
        });
        most.map(|(_, cause)| cause.to_string()).collect::<Vec<_>>().join(", ")
    }

    /// The direction that is one cause alone.
    pub(crate) fn direction_of(&self, cause: &Cause) -> Option<usize> {
        let k = self.causes.iter().position(|known| known == cause)?;
        (k < self.shares.columns() && self.shares[(k, k)] == 1.0).then_some(k)
    }

    pub(crate) fn has(&self, cause: &Cause) -> bool {
        self.causes.contains(cause)
    }

    /// The change of each number of each point, point after point, per direction.
    pub(crate) fn slopes(&self) -> &Matrix {
        &self.slopes
    }
}

/// No parameter of a formula has such a name.
fn name(k: usize) -> String {
    format!("error of the base states {}", k + 1)
}

#[cfg(test)]
mod tests {
    use super::super::carried::Carried;
    use super::*;
    use rijke_inference::{
        Data, Forward, ForwardError, MapOptions, NoiseGroup, Observation, Parameters, Posterior, Prediction,
    };
    use rijke_numerics::{Order, packed};

    /// Two parameters, six numbers: y = A a, and a bend of the first parameter.
    struct Bent;

    const A: [[f64; 2]; 6] = [[1.0, 0.3], [0.2, -0.7], [0.5, 0.9], [-0.4, 0.6], [0.8, 0.1], [-0.3, 0.4]];

    impl Forward for Bent {
        fn predict(&self, p: &[f64], _: Order) -> Result<Prediction, ForwardError> {
            Ok(Prediction {
                values: A.iter().map(|a| a[0] * p[0] + a[1] * p[1] + 0.05 * a[1] * p[0] * p[0]).collect(),
                jacobian: Matrix::from_fn(6, 2, |row, i| {
                    A[row][i] + if i == 0 { 0.1 * A[row][1] * p[0] } else { 0.0 }
                }),
                curvature: A.iter().flat_map(|a| [0.1 * a[1], 0.0, 0.0]).collect(),
            })
        }
    }

    fn common() -> Common {
        let slopes = [[0.3, 0.1], [-0.2, 0.2], [0.4, 0.0], [0.1, -0.3], [0.2, 0.2], [-0.1, 0.4]];
        let causes = ["one", "two"].map(|c| Cause::Inferred(c.to_owned())).to_vec();
        Common {
            causes,
            known: 0,
            shares: Matrix::identity(2),
            slopes: Matrix::from_fn(6, 2, |i, j| slopes[i][j]),
        }
    }

    fn posterior_of(
        model: &dyn Forward,
        parameters: Vec<Parameter>,
        floor: Option<Matrix>,
    ) -> (f64, Vec<f64>, Matrix) {
        let values = vec![0.9, -0.2, 1.3, 0.1, 0.7, 0.4];
        let all: Vec<usize> = (0..6).collect();
        let block = Observation::new("all", values).with_independent_noise(0, &all);
        let block = floor.into_iter().fold(block, Observation::with_floor);
        let data = Data::new(vec![block], vec![NoiseGroup::fixed("noise", "1", 0.2)]).unwrap();
        let parameters = Parameters::new(parameters).unwrap();
        let posterior = Posterior::new(model, &data, &parameters).unwrap();
        let fit = posterior.map(&MapOptions::default()).unwrap();
        let laplace = posterior.laplace(&fit).unwrap();
        (laplace.evidence.ln_marginal, fit.parameters, laplace.physical_covariance)
    }

    /// The slow way: one covariance of all numbers. The prediction is linear in the errors, so that both are
    /// the same but for the bend.
    #[test]
    fn oracle_errors_as_parameters_against_their_covariance() {
        let own: Vec<Parameter> =
            ["a", "b"].map(|n| Parameter::new(n, n, "1", Prior::Normal { mean: 0.5, sd: 1.0 })).into();
        let common = common();
        let carried = Carried { inner: &Bent, own: 2, slopes: common.slopes(), bends: &[] };
        let (evidence, values, covariance) =
            posterior_of(&carried, [own.clone(), common.parameters()].concat(), None);
        let shared = common.slopes.product(&common.slopes.transpose());
        let (slow_evidence, slow_values, slow_covariance) = posterior_of(&Bent, own, Some(shared));
        assert!((evidence - slow_evidence).abs() < 1e-3, "{evidence} {slow_evidence}");
        for i in 0..2 {
            assert!((values[i] - slow_values[i]).abs() < 1e-6, "{values:?} {slow_values:?}");
            for j in 0..2 {
                assert!((covariance[(i, j)] - slow_covariance[(i, j)]).abs() < 1e-3 * covariance[(i, i)]);
            }
        }
        assert!(covariance[(3, 3)] < 0.9, "the data say something of the errors: {values:?} {covariance:?}");
    }

    #[test]
    fn exact_derivatives_of_a_carried_model_are_those_of_its_parts() {
        let common = common();
        let carried = Carried { inner: &Bent, own: 2, slopes: common.slopes(), bends: &[] };
        let at = [0.4, 0.7, 0.5, -0.2];
        let here = carried.predict(&at, Order::Second).unwrap();
        let h = 1e-4;
        for k in 0..4 {
            let moved = |sign: f64| {
                let mut p = at;
                p[k] += sign * h;
                carried.predict(&p, Order::Second).unwrap()
            };
            let (up, down) = (moved(1.0), moved(-1.0));
            for row in 0..6 {
                let slope = (up.values[row] - down.values[row]) / (2.0 * h);
                assert!((slope - here.jacobian[(row, k)]).abs() < 1e-9);
                for j in 0..4 {
                    let bend = (up.jacobian[(row, j)] - down.jacobian[(row, j)]) / (2.0 * h);
                    assert!((bend - here.curvature[row * 10 + packed(k, j)]).abs() < 1e-9);
                }
            }
        }
    }
}
