//! The most probable unknowns, and the posterior around them.

use super::axis::Axis;
use super::model::Batch;
use super::shape::Shape;
use crate::error::FlowError;
use crate::infer::assimilate::estimate::Estimate;
use crate::infer::health::FlowHealth;
use crate::tube::parameters::UNKNOWNS;
use rijke_inference::{
    Data, Forward, ForwardError, MapOptions, Observation, Parameter, Parameters, Posterior, Prediction,
    Prior, TrustRegion,
};
use rijke_numerics::{Matrix, Order, Streams};

/// Drop in J that a search may leave, nats: 2 % of an sd.
const CLOSE: f64 = 2e-4;
/// Searches with the rough model before the true one.
const ROUGH_ROUNDS: usize = 3;

impl Batch<'_> {
    /// The most probable scores, then the posterior around them: draws of the model taken to second order
    /// there. The draws are the same in every run.
    ///
    /// # Errors
    /// [`FlowError::Inference`] with the words of the minimiser.
    pub fn fit(&self) -> Result<Estimate, FlowError> {
        let (scores, covariance, converged) = self.search()?;
        let predicted = self.run(&scores)?;
        let draws =
            self.shape(&scores, &covariance)?.draws(&mut Streams::new(0).stream("flow/batch/shape"))?;
        let mut estimate = Estimate::of_draws(&self.priors, self.names(), &draws)?;
        let slopes =
            self.predict(&scores, Order::First).map_err(|e| FlowError::Inference(e.to_string()))?.jacobian;
        let health = self.health(&scores, &estimate.covariance, &predicted, &slopes, converged)?;
        estimate.health = Some(health);
        Ok(estimate)
    }

    /// The most probable scores, Laplace's covariance there, and whether the search converged.
    fn search(&self) -> Result<(Vec<f64>, Matrix, bool), FlowError> {
        let words = |e: rijke_inference::InferenceError| FlowError::Inference(e.to_string());
        let prior = Prior::Normal { mean: 0.0, sd: 1.0 };
        let score = |name: String| Parameter::new(&name, &name, "1", prior);
        let parameters = Parameters::new(self.names().into_iter().map(score).collect()).map_err(words)?;
        let sensors = self.record.sensors.len();
        let unit = Matrix::identity(sensors);
        let data = |white: &[f64]| {
            let observations = white.chunks(sensors).enumerate().map(|(k, values)| {
                Observation::new(format!("bin {k}"), values.to_vec()).with_floor(unit.clone())
            });
            Data::new(observations.collect(), Vec::new()).map_err(words)
        };
        let white = self.whitening.apply(self.means.clone());
        let search = TrustRegion { tolerance: CLOSE, ..TrustRegion::default() };
        // The rough model finds the neighbourhood, with its own error taken from the data where the search
        // last ended.
        let rough = self.rough();
        let mut start = vec![0.0; self.scores()];
        for _ in 0..ROUGH_ROUNDS {
            let pairs = self.whitened(&start)?.into_iter().zip(rough.whitened(&start)?);
            let shifted: Vec<f64> =
                white.iter().zip(pairs).map(|(w, (fine, rough))| w - fine + rough).collect();
            let data = data(&shifted)?;
            let posterior = Posterior::new(&rough, &data, &parameters).map_err(words)?;
            start = posterior.map(&MapOptions { search, start: Some(start) }).map_err(words)?.working;
        }
        let data = data(&white)?;
        let posterior = Posterior::new(self, &data, &parameters).map_err(words)?;
        let fit = posterior.map(&MapOptions { search, start: Some(start) }).map_err(words)?;
        let laplace = posterior.laplace(&fit).map_err(words)?;
        let converged = fit.stop.converged();
        Ok((fit.working, laplace.covariance, converged))
    }

    /// What the fit says of itself, at the most probable `scores` with the readings `predicted` and the
    /// whitened `slopes` there.
    fn health(
        &self,
        scores: &[f64],
        covariance: &Matrix,
        predicted: &[f64],
        slopes: &Matrix,
        converged: bool,
    ) -> Result<FlowHealth, FlowError> {
        let sensors = self.record.sensors.len();
        let (mut chi, mut lagged, mut squares) = (0.0, vec![0.0; sensors], vec![0.0; sensors]);
        let mut last = vec![0.0; sensors];
        let residual = self.means.iter().zip(predicted).map(|(m, p)| m - p).collect();
        for white in self.whitening.apply(residual).chunks(sensors) {
            for j in 0..sensors {
                chi += white[j] * white[j];
                squares[j] += white[j] * white[j];
                lagged[j] += white[j] * last[j];
            }
            last.copy_from_slice(white);
        }
        let data = self.means.len() as f64;
        let named = |test: &dyn Fn(usize) -> bool| {
            (0..UNKNOWNS).filter(|&i| test(i)).map(|i| self.priors[i].name.clone()).collect()
        };
        Ok(FlowHealth {
            chi_squared: chi / (data - scores.len() as f64),
            chi_squared_sd: (2.0 / data).sqrt(),
            whiteness: lagged.iter().zip(&squares).map(|(l, s)| l / s).collect(),
            bins: self.means.len() / sensors,
            unidentified: named(&|i| covariance[(i, i)].sqrt() > 0.7),
            at_bound: named(&|i| scores[i].abs() > 2.5),
            tensions: self.tensions(scores, slopes)?,
            converged,
        })
    }

    /// The posterior's shape around `scores`: derivatives there, and second derivatives by differences of
    /// rough ones over an sd on both sides.
    pub(crate) fn shape(&self, scores: &[f64], covariance: &Matrix) -> Result<Shape, FlowError> {
        let axes: Vec<Axis> =
            self.priors.iter().map(|p| Axis::new(p, self.pipe)).collect::<Result<_, _>>()?;
        let errors: Vec<Vec<f64>> = self.record.biased().map(|bias| self.by_error(bias)).collect();
        let mut unbiased = scores.to_vec();
        unbiased[UNKNOWNS..].fill(0.0);
        let (values, slopes) = self.slopes(&unbiased)?;
        let white = self.whitening.apply(self.means.clone());
        let residual = white.iter().zip(&values).map(|(m, p)| m - p).collect();
        let per_axis = |k: usize, at: &[f64]| axes[k].at(at[k]).1;
        let minus = |column: &[f64], scale: f64| column.iter().map(|c| -c / scale).collect::<Vec<f64>>();
        let linear = slopes.iter().enumerate().map(|(k, c)| minus(c, per_axis(k, scores))).collect();
        let rough = self.rough();
        let mut differences: Vec<Vec<Vec<f64>>> = Vec::with_capacity(axes.len());
        for k in 0..axes.len() {
            let (y, slope) = axes[k].at(scores[k]);
            let step = (slope * covariance[(k, k)].sqrt()).abs();
            let side = |y: f64| -> Result<_, FlowError> {
                let mut moved = unbiased.clone();
                moved[k] = axes[k].score(y);
                let columns = rough.slopes(&moved)?.1;
                let scaled = columns.iter().enumerate().map(|(l, c)| minus(c, per_axis(l, &moved)));
                Ok((axes[k].at(moved[k]).0, scaled.collect::<Vec<_>>()))
            };
            let ((high, up), (low, down)) = (side(y + step)?, side(y - step)?);
            let difference = |(up, down): (&Vec<f64>, &Vec<f64>)| {
                up.iter().zip(down).map(|(u, d)| (u - d) / (high - low)).collect()
            };
            differences.push(up.iter().zip(&down).map(difference).collect());
        }
        // Both orders of differentiation are the same.
        let second = |k: usize| {
            let mean = |l: usize| {
                let pairs = differences[k][l].iter().zip(&differences[l][k]);
                pairs.map(|(a, b)| 0.5 * (a + b)).collect()
            };
            (k..axes.len()).map(mean).collect()
        };
        let second = (0..axes.len()).map(second).collect();
        Shape::new(axes, scores[..UNKNOWNS].to_vec(), residual, linear, second, &errors)
    }
}

impl Forward for Batch<'_> {
    fn predict(&self, scores: &[f64], order: Order) -> Result<Prediction, ForwardError> {
        if order == Order::Value {
            let values = self.whitened(scores).map_err(ForwardError::recoverable)?;
            return Ok(Prediction { values, jacobian: Matrix::zeros(0, 0), curvature: Vec::new() });
        }
        let (values, slopes) = self.slopes(scores).map_err(ForwardError::recoverable)?;
        // The constant errors act linearly.
        let errors = self.record.biased().map(|bias| self.by_error(bias));
        let columns: Vec<Vec<f64>> = slopes.into_iter().chain(errors).collect();
        let jacobian = Matrix::from_fn(values.len(), scores.len(), |k, i| columns[i][k]);
        Ok(Prediction { values, jacobian, curvature: Vec::new() })
    }

    fn highest_order(&self) -> Order {
        Order::First
    }
}
