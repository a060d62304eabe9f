//! Errors of the base states that several settings of the rig share, as parameters beside the model's.

use crate::data::{same_setting, selected};
use crate::systematic::{BaseErrors, Changes};
use crate::{BaseState, Knowledge, ModelError, Observed, Trained};
use rijke_inference::{Forward, ForwardError, Parameter, Prediction, Prior};
use rijke_numerics::{DenseError, Matrix, Order, symmetric_eigen};

/// The errors that all settings have in common: those of the flow's own parameters, say, which one calibration gave to all states.
///
/// They act on the pressures and the eigenvalues of all points at once. As a covariance they would join all numbers into one block; taken
/// as noise of each point, they would seem to vanish in the mean over points. As parameters with a prior of 0 +- 1, in which the
/// prediction is linear, they do neither, and what the sound says of the flow is not lost.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Common {
    /// The causes that more than one setting names.
    causes: Vec<String>,
    /// For each cause its shares in the directions, orthonormal columns, the most important first.
    shares: Matrix,
    /// The change of each number of each point, point after point, per direction.
    slopes: Matrix,
}

/// The place of a direction in what is known, and the change of a prediction along it.
type Along = (usize, Vec<f64>);

/// Directions that move all data together by less than the root of this, in measured standard deviations, are left out.
const NEGLIGIBLE: f64 = 0.01;

impl Common {
    /// The directions of the `errors` that settings share, and what is left of the errors.
    ///
    /// With D the changes by each cause in units of the measured standard deviations of `observed`, a column each, and D'D = U L U', direction
    /// k is D times column k of U.
    ///
    /// # Errors
    /// [`ModelError::Flow`] if the eigenvalue iteration fails.
    pub(crate) fn of(
        errors: BaseErrors,
        observed: &[Observed],
        microphones: &[usize],
    ) -> Result<(Self, BaseErrors), ModelError> {
        let same = |a: usize, b: usize| same_setting(&observed[a].conditions, &observed[b].conditions);
        let (causes, columns, rest) = errors.apart(2 * microphones.len(), same);
        let covariances = observed.iter().map(|o| selected(&o.ping, microphones).1);
        let weights: Vec<f64> =
            covariances.flat_map(|c| (0..c.rows()).map(move |k| c[(k, k)].sqrt().recip())).collect();
        let rows = weights.len();
        let gram = Matrix::from_fn(causes.len(), causes.len(), |i, j| {
            let pairs = columns[i].iter().zip(&columns[j]).zip(&weights);
            pairs.map(|((a, b), w)| a * b * w * w).sum()
        });
        let failed = |source: DenseError| ModelError::Flow {
            point: observed.first().map_or_else(String::new, |o| o.conditions.point.id.clone()),
            source: source.into(),
        };
        let (values, vectors) = symmetric_eigen(&gram).map_err(failed)?;
        let kept: Vec<usize> = (0..causes.len()).rev().filter(|&k| values[k] > NEGLIGIBLE).collect();
        let shares = Matrix::from_fn(causes.len(), kept.len(), |j, k| vectors[(j, kept[k])]);
        let slopes = Matrix::from_fn(rows, kept.len(), |row, k| {
            (0..causes.len()).map(|j| shares[(j, k)] * columns[j][row]).sum()
        });
        Ok((Self { causes, shares, slopes }, rest))
    }

    pub(crate) fn parameters(&self) -> Vec<Parameter> {
        let prior = Prior::Normal { mean: 0.0, sd: 1.0 };
        let parameter = |k: usize| Parameter::new(name(k), format!("b_{}", k + 1), "1", prior);
        (0..self.shares.columns()).map(parameter).collect()
    }

    /// Of the `changes` that causes of error make to the prediction of a point: the place of each direction in what is `known`, and the change
    /// along it; and what the other causes do. The prediction has `size` numbers.
    pub(crate) fn along(
        &self,
        known: &Knowledge,
        changes: &Changes,
        size: usize,
    ) -> (Vec<Along>, Vec<Vec<f64>>) {
        let place = |k: usize| known.names.iter().position(|n| *n == name(k));
        let mut along: Vec<_> =
            (0..self.shares.columns()).filter_map(|k| Some((k, place(k)?, vec![0.0; size]))).collect();
        let mut left = Vec::new();
        for (cause, change) in changes {
            let Some(j) = self.causes.iter().position(|c| c == cause) else {
                left.push(change.clone());
                continue;
            };
            for (k, _, sum) in &mut along {
                sum.iter_mut().zip(change).for_each(|(s, c)| *s += self.shares[(j, *k)] * c);
            }
        }
        (along.into_iter().map(|(_, place, sum)| (place, sum)).collect(), left)
    }

    pub(crate) fn has(&self, cause: &str) -> bool {
        self.causes.iter().any(|c| c == cause)
    }

    /// `base` with these errors at `known` standard deviations each.
    fn state(&self, base: &BaseState, parameters: &[Parameter], values: &[f64]) -> BaseState {
        let at =
            |k: usize| parameters.iter().position(|p| p.name == name(k)).map_or(0.0, |place| values[place]);
        let known: Vec<f64> = (0..self.shares.columns()).map(at).collect();
        let z = |cause: &str| {
            let j = self.causes.iter().position(|c| c == cause)?;
            Some(known.iter().enumerate().map(|(k, b)| self.shares[(j, k)] * b).sum())
        };
        let z: Vec<f64> = base.errors.iter().map(|e| z(&e.cause).unwrap_or(0.0)).collect();
        base.displaced(&z)
    }

    /// A model whose base states have these errors, which are parameters after its `own`.
    pub(crate) fn carried_by<'a>(&'a self, inner: &'a dyn Forward, own: usize) -> Carried<'a> {
        Carried { inner, own, slopes: &self.slopes }
    }
}

impl Trained {
    /// A number that follows from the parameters (in the order of [`Trained::parameters`]) and from a base state of the same inference of the
    /// flow as those that were trained on, and its standard deviation, to first order. The base state is taken as what the training
    /// makes of `base`.
    #[must_use]
    pub fn estimate(&self, base: &BaseState, number: impl Fn(&[f64], &BaseState) -> f64) -> [f64; 2] {
        let common = self.common.as_ref();
        let at = |values: &[f64], z: &[f64]| {
            let state = common.map_or_else(|| base.clone(), |c| c.state(base, &self.parameters, values));
            number(values, &state.displaced(z))
        };
        // Half the difference over one standard deviation up and down.
        let slopes: Vec<f64> = (0..self.values.len())
            .map(|i| {
                let sd = self.covariance[(i, i)].sqrt();
                let moved = |sign: f64| {
                    let mut values = self.values.clone();
                    values[i] += sign * sd;
                    at(&values, &[])
                };
                if sd > 0.0 { 0.5 * (moved(1.0) - moved(-1.0)) / sd } else { 0.0 }
            })
            .collect();
        let known: f64 = self.covariance.times(&slopes).iter().zip(&slopes).map(|(c, s)| c * s).sum();
        let left = |k: usize| {
            if common.is_some_and(|c| c.has(&base.errors[k].cause)) {
                return 0.0;
            }
            let mut z = vec![0.0; base.errors.len()];
            let mut moved = |sign: f64| {
                z[k] = sign;
                at(&self.values, &z)
            };
            (0.5 * (moved(1.0) - moved(-1.0))).powi(2)
        };
        let left: f64 = (0..base.errors.len()).map(left).sum();
        [at(&self.values, &[]), (known + left).sqrt()]
    }
}

/// No parameter of a formula has such a name.
fn name(k: usize) -> String {
    format!("error of the base flow {}", k + 1)
}

/// A model with errors of its base states, to first order.
pub(crate) struct Carried<'a> {
    inner: &'a dyn Forward,
    own: usize,
    slopes: &'a Matrix,
}

impl Forward for Carried<'_> {
    fn predict(&self, parameters: &[f64], order: Order) -> Result<Prediction, ForwardError> {
        let (own, errors) = parameters.split_at(self.own);
        let Prediction { mut values, jacobian, curvature } = self.inner.predict(own, order)?;
        for (row, value) in values.iter_mut().enumerate() {
            *value += errors.iter().enumerate().map(|(k, e)| self.slopes[(row, k)] * e).sum::<f64>();
        }
        let p = parameters.len();
        let jacobian = if order >= Order::First {
            Matrix::from_fn(values.len(), p, |row, i| {
                if i < self.own { jacobian[(row, i)] } else { self.slopes[(row, i - self.own)] }
            })
        } else {
            jacobian
        };
        let (inner_triangle, triangle) = (self.own * (self.own + 1) / 2, p * (p + 1) / 2);
        let mut bent = vec![0.0; if curvature.is_empty() { 0 } else { values.len() * triangle }];
        if inner_triangle > 0 && !curvature.is_empty() {
            for (to, from) in bent.chunks_mut(triangle).zip(curvature.chunks(inner_triangle)) {
                to[..inner_triangle].copy_from_slice(from);
            }
        }
        Ok(Prediction { values, jacobian, curvature: bent })
    }

    fn highest_order(&self) -> Order {
        self.inner.highest_order()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rijke_inference::{Data, MapOptions, NoiseGroup, Observation, Parameters, Posterior};

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
        let causes = vec!["one".to_owned(), "two".to_owned()];
        Common { causes, shares: Matrix::identity(2), slopes: Matrix::from_fn(6, 2, |i, j| slopes[i][j]) }
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

    /// The slow way: one covariance of all numbers. The prediction is linear in the errors, so that both are the same but for the bend.
    #[test]
    fn oracle_errors_as_parameters_against_their_covariance() {
        let own: Vec<Parameter> =
            ["a", "b"].map(|n| Parameter::new(n, n, "1", Prior::Normal { mean: 0.5, sd: 1.0 })).into();
        let common = common();
        let carried = common.carried_by(&Bent, 2);
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
        let carried = common.carried_by(&Bent, 2);
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
                    let (i, j) = (k.max(j), k.min(j));
                    assert!((bend - here.curvature[row * 10 + i * (i + 1) / 2 + j]).abs() < 1e-9);
                }
            }
        }
    }
}
