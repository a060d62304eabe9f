//! Models that are Python functions, fitted and ranked.

use crate::fault::{Answer, Fault};
use crate::signals::listening;
use numpy::{AllowTypeChange, PyArray1, PyArrayLikeDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyArithmeticError;
use pyo3::prelude::*;
use rijke_inference::{
    AssessOptions, Assessment, Data, Draws, Entry, Forward, ForwardError, InferenceError, InferenceRecord,
    NoiseGroup, Observation, Parameter, Parameters, Posterior, Prediction, Prior, assess,
};
use rijke_numerics::{Matrix, Order, Streams};
use serde::Deserialize;
use serde_json::json;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// A model as `rijke.rank` hands it over.
#[derive(FromPyObject)]
pub(crate) struct Own {
    name: String,
    /// JSON: a list of [`Unknown`].
    parameters_json: String,
    /// Parameters -> predicted numbers.
    predict: Py<PyAny>,
    /// Parameters -> their first derivatives, numbers x parameters.
    jacobian: Option<Py<PyAny>>,
    /// Parameters -> their second derivatives, numbers x parameters x parameters.
    hessian: Option<Py<PyAny>>,
}

#[derive(Deserialize)]
struct Unknown {
    name: String,
    symbol: String,
    unit: String,
    prior: Prior,
}

/// The data as JSON.
#[derive(Deserialize)]
struct Measured {
    blocks: Vec<Block>,
    groups: Vec<NoiseGroup>,
}

#[derive(Deserialize)]
struct Block {
    label: String,
    values: Vec<f64>,
    /// Row by row.
    covariance: Option<Vec<f64>>,
    /// Groups of noise, and the numbers of the block on which each acts.
    noise: Vec<(usize, Vec<usize>)>,
}

struct Callable<'a> {
    own: &'a Own,
    /// Scale of each parameter for difference quotients.
    scales: Vec<f64>,
    stopped: &'a AtomicBool,
    /// The first exception that ends the fit.
    raised: Mutex<Option<PyErr>>,
}

/// Step of difference quotients of fourth order, of a parameter's prior width.
const STEP: f64 = 1e-3;

impl Callable<'_> {
    /// The numbers that a function returns, and their shape.
    fn call(&self, function: &Py<PyAny>, at: &[f64]) -> Result<(Vec<usize>, Vec<f64>), ForwardError> {
        if self.stopped.load(Ordering::Relaxed) {
            return Err(ForwardError::fatal("interrupted"));
        }
        Python::attach(|py| {
            let found = function.bind(py).call1((PyArray1::from_slice(py, at),)).and_then(|found| {
                let array: PyArrayLikeDyn<'_, f64, AllowTypeChange> = found.extract()?;
                Ok((array.shape().to_vec(), array.as_array().iter().copied().collect()))
            });
            found.map_err(|error| {
                let text = error.to_string();
                if error.is_instance_of::<PyArithmeticError>(py) {
                    return ForwardError::recoverable(text);
                }
                if let Ok(mut raised) = self.raised.lock() {
                    raised.get_or_insert(error);
                }
                ForwardError::fatal(text)
            })
        })
    }

    fn slopes(&self, at: &[f64], values: usize) -> Result<Matrix, ForwardError> {
        let p = at.len();
        if let Some(jacobian) = &self.own.jacobian {
            let (shape, all) = self.call(jacobian, at)?;
            return sized(&self.own.name, "the Jacobian", &shape, &[values, p])
                .map(|()| Matrix::from_fn(values, p, |i, j| all[i * p + j]));
        }
        let mut columns = Vec::with_capacity(p);
        for (k, scale) in self.scales.iter().enumerate() {
            let h = STEP * scale;
            let moved = |steps: f64| {
                let mut other = at.to_vec();
                other[k] += steps * h;
                self.call(&self.own.predict, &other).map(|found| found.1)
            };
            let [a, b, c, d] = [moved(1.0)?, moved(-1.0)?, moved(2.0)?, moved(-2.0)?];
            let slope = |i: usize| (8.0 * (a[i] - b[i]) - (c[i] - d[i])) / (12.0 * h);
            columns.push((0..values).map(slope).collect::<Vec<f64>>());
        }
        Ok(Matrix::from_fn(values, p, |i, j| columns[j][i]))
    }
}

fn sized(model: &str, what: &str, found: &[usize], expected: &[usize]) -> Result<(), ForwardError> {
    if found == expected {
        return Ok(());
    }
    Err(ForwardError::fatal(format!(
        "{what} of `{model}` has the shape {found:?}, but {expected:?} is needed"
    )))
}

impl Forward for Callable<'_> {
    fn predict(&self, at: &[f64], order: Order) -> Result<Prediction, ForwardError> {
        let (_, values) = self.call(&self.own.predict, at)?;
        let (m, p) = (values.len(), at.len());
        let mut prediction = Prediction { values, ..Prediction::default() };
        if order >= Order::First {
            prediction.jacobian = self.slopes(at, m)?;
        }
        if let (Order::Second, Some(hessian)) = (order, &self.own.hessian) {
            let (shape, all) = self.call(hessian, at)?;
            sized(&self.own.name, "the Hessian", &shape, &[m, p, p])?;
            let triangle = (0..p).flat_map(|i| (0..=i).map(move |j| i * p + j));
            let packed: Vec<usize> = triangle.collect();
            prediction.curvature =
                (0..m).flat_map(|k| packed.iter().map(move |i| k * p * p + i)).map(|i| all[i]).collect();
        }
        Ok(prediction)
    }

    fn highest_order(&self) -> Order {
        if self.own.hessian.is_some() { Order::Second } else { Order::First }
    }
}

/// Fits every model to the data and ranks them by evidence. Returns JSON: the ranking, then a record of each
/// model that could be fitted and draws from Laplace's Gaussian.
#[pyfunction]
#[pyo3(signature = (models, data, starts, importance, draws, seed, progress))]
#[expect(clippy::too_many_arguments, reason = "those of the function of Python")]
pub(crate) fn rank(
    py: Python<'_>,
    models: Vec<Own>,
    data: &str,
    starts: usize,
    importance: usize,
    draws: usize,
    seed: u64,
    progress: Py<PyAny>,
) -> PyResult<String> {
    let data = measured(data)?;
    let streams = Streams::new(seed);
    let options =
        // The deviations are widened below.
        AssessOptions { random_starts: starts, draws: importance, few_data: false, streams, ..AssessOptions::default() };
    let (mut entries, mut found) = (Vec::new(), Vec::new());
    for (done, own) in models.iter().enumerate() {
        progress.call1(py, (done, models.len(), &own.name))?;
        let unknowns: Vec<Unknown> = serde_json::from_str(&own.parameters_json).map_err(Fault::input)?;
        let scales =
            unknowns.iter().map(|u| (u.prior.quantile(0.84) - u.prior.quantile(0.16)) / 2.0).collect();
        let parameter = |u: Unknown| Parameter::new(u.name, u.symbol, u.unit, u.prior);
        let parameters =
            Parameters::new(unknowns.into_iter().map(parameter).collect()).map_err(Fault::input)?;
        let outcome = fit(py, own, scales, &data, &parameters, &options)?;
        let entry = |outcome, warnings| Entry {
            name: own.name.clone(),
            parameters: parameters.len(),
            ln_prior_weight: 0.0,
            outcome,
            warnings,
        };
        match outcome {
            Ok((assessment, few)) => {
                let laplace = assessment.laplace.as_ref().ok();
                let drawn = laplace.map(|l| Draws::new(&parameters, l, &few, draws, streams));
                let drawn = drawn.transpose().map_err(Fault::from)?;
                entries.push(entry(assessment.evidence.clone(), assessment.health.warnings.clone()));
                let record = InferenceRecord::new(&own.name, &parameters, &assessment, &few);
                found.push(json!({ "record": record, "draws": drawn.map(|d| d.posterior) }));
            }
            Err(reason) => {
                entries.push(entry(Err(reason), Vec::new()));
                found.push(serde_json::Value::Null);
            }
        }
    }
    progress.call1(py, (models.len(), models.len(), ""))?;
    Ok(json!({ "ranking": rijke_inference::rank(entries), "models": found }).to_string())
}

/// One fit, in a thread of its own, while this one listens for Ctrl-C, with the factors on the standard
/// deviations of its parameters that few data ask for. The inner error is a model that cannot be fitted.
fn fit(
    py: Python<'_>,
    own: &Own,
    scales: Vec<f64>,
    data: &Data,
    parameters: &Parameters,
    options: &AssessOptions,
) -> PyResult<Result<(Assessment, Vec<f64>), String>> {
    let stopped = AtomicBool::new(false);
    let forward = Callable { own, scales, stopped: &stopped, raised: Mutex::default() };
    let assessed = || {
        let found = assess(&forward, data, parameters, options)?;
        let few = match &found.laplace {
            Ok(laplace) => {
                Posterior::new(&forward, data, parameters)?.linearised(&found.fit, laplace)?.few().parameters
            }
            Err(_) => vec![1.0; parameters.len()],
        };
        Ok::<_, InferenceError>((found, few))
    };
    let outcome = listening(py, &stopped, || Ok(()), assessed)?;
    let raised = forward.raised.lock().ok().and_then(|mut raised| raised.take());
    match (raised, outcome) {
        (Some(error), Err(_)) => Err(error),
        (_, outcome) => Ok(outcome.map_err(|error| error.to_string())),
    }
}

fn measured(data: &str) -> Answer<Data> {
    let Measured { blocks, groups } = serde_json::from_str(data).map_err(Fault::input)?;
    let block = |block: Block| {
        let n = block.values.len();
        let mut observation = Observation::new(block.label, block.values);
        if let Some(rows) = block.covariance {
            observation = observation.with_floor(Matrix::from_fn(n, n, |i, j| rows[i * n + j]));
        }
        block.noise.iter().fold(observation, |o, (group, which)| o.with_independent_noise(*group, which))
    };
    Data::new(blocks.into_iter().map(block).collect(), groups)
        .map_err(|error| Fault::input(error).remedy("Correct the values, sd or covariance of the data."))
}
