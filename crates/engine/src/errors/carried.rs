//! Errors that the points of a model share, as parameters of it.

use rijke_inference::{Forward, ForwardError, Prediction};
use rijke_numerics::{Matrix, Order, packed};
use std::collections::BTreeMap;

/// A model with errors that its points share, to first order or bent; they are parameters after its `own`.
pub(crate) struct Carried<'a> {
    pub(crate) inner: &'a dyn Forward,
    pub(crate) own: usize,
    /// What each error adds per standard deviation, whatever the model's own parameters are.
    pub(crate) slopes: &'a Matrix,
    /// Errors that are no straight lines, in place of their slopes.
    pub(crate) bends: &'a [Bend<'a>],
}

/// Errors of which the model is known at some values.
pub(crate) struct Bend<'a> {
    /// For each number of the prediction the place of the error that moves it.
    pub(crate) errors: Vec<Option<usize>>,
    /// Values of all these errors at once, and the model there. Between them and zero it is the polynomial
    /// through all, at the same own parameters.
    pub(crate) nodes: Vec<(f64, &'a dyn Forward)>,
}

/// Shares of the model without an error (first) and at each node in a number that the error moves, with their
/// first and second derivatives in the error.
type Shares = Vec<[f64; 3]>;

impl Bend<'_> {
    /// Lagrange's polynomials at an error.
    fn shares(&self, error: f64) -> Shares {
        let at: Vec<f64> = std::iter::once(0.0).chain(self.nodes.iter().map(|node| node.0)).collect();
        let of = |i: usize| {
            let others = (0..at.len()).filter(|j| *j != i);
            others.fold([1.0, 0.0, 0.0], |[value, slope, bend], j| {
                let c = 1.0 / (at[i] - at[j]);
                let t = (error - at[j]) * c;
                [value * t, slope * t + value * c, bend * t + 2.0 * slope * c]
            })
        };
        (0..at.len()).map(of).collect()
    }
}

/// A bend at given errors.
struct Bent<'a> {
    errors: &'a [Option<usize>],
    /// By the place of an error.
    shares: BTreeMap<usize, Shares>,
    nodes: Vec<Prediction>,
}

impl Bent<'_> {
    /// What the errors add to a number `of` the predictions of a row, of which `here` is the one without
    /// them, or the first or the second derivative of that in the row's own error.
    fn adds(&self, row: usize, derivative: usize, here: &Prediction, of: &dyn Fn(&Prediction) -> f64) -> f64 {
        let Some(shares) = self.errors[row].map(|error| &self.shares[&error]) else { return 0.0 };
        let without = shares[0][derivative] - if derivative == 0 { 1.0 } else { 0.0 };
        let nodes = self.nodes.iter().zip(&shares[1..]);
        nodes.fold(without * of(here), |sum, (node, share)| sum + share[derivative] * of(node))
    }
}

impl Forward for Carried<'_> {
    fn predict(&self, parameters: &[f64], order: Order) -> Result<Prediction, ForwardError> {
        let (own, errors) = parameters.split_at(self.own);
        let here = self.inner.predict(own, order)?;
        let mut bends = Vec::with_capacity(self.bends.len());
        for bend in self.bends {
            let nodes = bend.nodes.iter().map(|(_, model)| model.predict(own, order));
            let shares = bend.errors.iter().flatten().map(|k| (*k, bend.shares(errors[*k]))).collect();
            bends.push(Bent { errors: &bend.errors, shares, nodes: nodes.collect::<Result<_, _>>()? });
        }
        let bent = |row: usize, k: usize| bends.iter().find(|bend| bend.errors[row] == Some(k));
        let added = |row: usize, of: &dyn Fn(&Prediction) -> f64| -> f64 {
            bends.iter().map(|bend| bend.adds(row, 0, &here, of)).sum()
        };
        let straight = |row: usize| -> f64 {
            let all = errors.iter().enumerate().filter(|(k, _)| bent(row, *k).is_none());
            all.map(|(k, e)| self.slopes[(row, k)] * e).sum()
        };
        let rows = here.values.len();
        let value = |row: usize| here.values[row] + straight(row) + added(row, &|f| f.values[row]);
        let values = (0..rows).map(value).collect();
        let (n, p) = (self.own, parameters.len());
        let slope = |row: usize, i: usize| match i.checked_sub(n) {
            None => here.jacobian[(row, i)] + added(row, &|f| f.jacobian[(row, i)]),
            Some(k) => match bent(row, k) {
                None => self.slopes[(row, k)],
                Some(bend) => bend.adds(row, 1, &here, &|f| f.values[row]),
            },
        };
        let jacobian =
            if order >= Order::First { Matrix::from_fn(rows, p, slope) } else { Matrix::default() };
        // A model without parameters of its own has no second derivatives to give.
        let curves = order == Order::Second && (n == 0 || !here.curvature.is_empty());
        let (inner_triangle, triangle) = (n * (n + 1) / 2, p * (p + 1) / 2);
        let mut curvature = vec![0.0; if curves { rows * triangle } else { 0 }];
        for (row, to) in curvature.chunks_mut(triangle.max(1)).enumerate() {
            for (k, to) in to[..inner_triangle].iter_mut().enumerate() {
                let at = row * inner_triangle + k;
                *to = here.curvature[at] + added(row, &|f| f.curvature[at]);
            }
            for bend in &bends {
                let Some(k) = bend.errors[row] else { continue };
                for i in 0..n {
                    to[packed(n + k, i)] = bend.adds(row, 1, &here, &|f| f.jacobian[(row, i)]);
                }
                to[packed(n + k, n + k)] = bend.adds(row, 2, &here, &|f| f.values[row]);
            }
        }
        Ok(Prediction { values, jacobian, curvature })
    }

    fn highest_order(&self) -> Order {
        self.inner.highest_order()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rijke_inference::{
        Data, MapOptions, NoiseGroup, Observation, Parameter, Parameters, Posterior, Prior,
    };
    use rijke_numerics::Cholesky;
    use std::f64::consts::TAU;

    /// Six numbers, no parameters.
    struct Known;

    impl Forward for Known {
        fn predict(&self, _: &[f64], _: Order) -> Result<Prediction, ForwardError> {
            let jacobian = Matrix::from_fn(6, 0, |_, _| 0.0);
            Ok(Prediction { values: vec![0.1; 6], jacobian, curvature: Vec::new() })
        }
    }

    /// Two numbers, a b (1 + 0.3 e) and a (1 + 0.3 e)^2, of parameters a and b.
    struct Product {
        e: f64,
    }

    impl Forward for Product {
        fn predict(&self, p: &[f64], _: Order) -> Result<Prediction, ForwardError> {
            let t = 1.0 + 0.3 * self.e;
            let jacobian = [[p[1] * t, p[0] * t], [t * t, 0.0]];
            Ok(Prediction {
                values: vec![p[0] * p[1] * t, p[0] * t * t],
                jacobian: Matrix::from_fn(2, 2, |i, j| jacobian[i][j]),
                curvature: vec![0.0, t, 0.0, 0.0, 0.0, 0.0],
            })
        }
    }

    /// Each number has an error of its own, of which three models are known, and moves with that of the other
    /// along a straight line of slope 9.
    #[test]
    fn exact_polynomials_are_followed_with_their_derivatives() {
        let [without, lower, upper] = [0.0, -1.0, 1.0].map(|e| Product { e });
        let nodes: Vec<(f64, &dyn Forward)> = vec![(-1.0, &lower), (1.0, &upper)];
        let bends = [Bend { errors: vec![Some(0), Some(1)], nodes }];
        let carried =
            Carried { inner: &without, own: 2, slopes: &Matrix::from_fn(2, 2, |_, _| 9.0), bends: &bends };
        let (a, b, e, f) = (1.7, -0.6, 2.2, -1.4);
        let (t, u) = (1.0 + 0.3 * e, 1.0 + 0.3 * f);
        let found = carried.predict(&[a, b, e, f], Order::Second).unwrap();
        let near = |found: f64, exact: f64| assert!((found - exact).abs() < 1e-12, "{found} {exact}");
        let straight = [9.0 * f, 9.0 * e];
        for (k, exact) in [a * b * t, a * u * u].into_iter().enumerate() {
            near(found.values[k], exact + straight[k]);
        }
        let slopes = [[b * t, a * t, 0.3 * a * b, 9.0], [u * u, 0.0, 9.0, 0.6 * a * u]];
        // Packed: aa, ab, bb, ea, eb, ee, fa, fb, fe, ff.
        let bends = [
            [0.0, t, 0.0, 0.3 * b, 0.3 * a, 0.0, 0.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.6 * u, 0.0, 0.0, 0.18 * a],
        ];
        for row in 0..2 {
            for i in 0..4 {
                near(found.jacobian[(row, i)], slopes[row][i]);
            }
            for (k, exact) in bends[row].iter().enumerate() {
                near(found.curvature[row * 10 + k], *exact);
            }
        }
    }

    /// The errors count as their covariance does.
    #[test]
    fn exact_evidence_of_a_model_without_parameters() {
        let slopes = [[0.3, 0.1], [-0.2, 0.2], [0.4, 0.0], [0.1, -0.3], [0.2, 0.2], [-0.1, 0.4]];
        let slopes = Matrix::from_fn(6, 2, |i, j| slopes[i][j]);
        let carried = Carried { inner: &Known, own: 0, slopes: &slopes, bends: &[] };
        let values = vec![0.9, -0.2, 1.3, 0.1, 0.7, 0.4];
        let all: Vec<usize> = (0..6).collect();
        let block = Observation::new("all", values.clone()).with_independent_noise(0, &all);
        let data = Data::new(vec![block], vec![NoiseGroup::fixed("noise", "1", 0.2)]).unwrap();
        let error = |name: &str| Parameter::new(name, name, "1", Prior::Normal { mean: 0.0, sd: 1.0 });
        let parameters = Parameters::new(vec![error("one"), error("two")]).unwrap();
        let posterior = Posterior::new(&carried, &data, &parameters).unwrap();
        let fit = posterior.map(&MapOptions::default()).unwrap();
        let evidence = posterior.laplace(&fit).unwrap().evidence.ln_marginal;
        let covariance = slopes.product(&slopes.transpose()).plus(0.04, &Matrix::identity(6));
        let factor = Cholesky::new(&covariance).unwrap();
        let left: Vec<f64> = values.iter().map(|y| y - 0.1).collect();
        let squares: f64 = factor.whiten(&left).iter().map(|w| w * w).sum();
        let exact = -0.5 * (squares + factor.ln_det() + 6.0 * TAU.ln());
        assert!((evidence - exact).abs() < 1e-9, "{evidence} {exact}");
    }
}
