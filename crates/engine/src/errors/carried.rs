//! Errors that the points of a model share, as parameters of it.

use rijke_inference::{Forward, ForwardError, Prediction};
use rijke_numerics::{Matrix, Order};

/// A model with errors that its points share, to first order; they are parameters after its `own`.
pub(crate) struct Carried<'a> {
    pub(crate) inner: &'a dyn Forward,
    pub(crate) own: usize,
    pub(crate) slopes: &'a Matrix,
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
        // A model without parameters of its own has no second derivatives to give.
        let bends = order == Order::Second && (self.own == 0 || !curvature.is_empty());
        let mut bent = vec![0.0; if bends { values.len() * triangle } else { 0 }];
        if inner_triangle > 0 && bends {
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

    /// The errors count as their covariance does.
    #[test]
    fn exact_evidence_of_a_model_without_parameters() {
        let slopes = [[0.3, 0.1], [-0.2, 0.2], [0.4, 0.0], [0.1, -0.3], [0.2, 0.2], [-0.1, 0.4]];
        let slopes = Matrix::from_fn(6, 2, |i, j| slopes[i][j]);
        let carried = Carried { inner: &Known, own: 0, slopes: &slopes };
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
