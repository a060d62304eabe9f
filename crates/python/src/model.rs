//! The model of a study's observations as a function of its parameters, with exact first and second
//! derivatives.

use crate::convert::{WORK, array, complex};
use crate::fault::{Answer, Fault};
use numpy::{AllowTypeChange, PyArrayLikeDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;
use rayon::prelude::*;
use rijke_engine::{Assembly, EngineError, Observed, PointModel};
use rijke_network::Response;
use rijke_numerics::{C64, InOrder, Order};
use std::sync::Arc;

type Points<'a> = Vec<PointModel<'a>>;

self_cell::self_cell! {
    /// The networks of all observations, laid out once, beside the assembly on whose laws they are.
    struct Laid {
        owner: Arc<Assembly>,
        #[covariant]
        dependent: Points,
    }
}

/// See `rijke.Model`.
#[pyclass(frozen, module = "rijke._native")]
pub(crate) struct Model {
    laid: Laid,
    observed: Arc<Vec<Observed>>,
}

/// Values from Python, of any shape whose last axis is the parameters.
type Values<'py> = PyArrayLikeDyn<'py, f64, AllowTypeChange>;

/// Fewer solutions than this are not worth the other threads.
const FEW: usize = 8;

impl Model {
    pub(crate) fn of(assembly: Arc<Assembly>, observed: Arc<Vec<Observed>>) -> Answer<Self> {
        let laid = Laid::try_new(assembly, |assembly| -> Result<Points<'_>, EngineError> {
            // As the records of stages are made: cuts of the network at microphones enter where the gas
            // varies along x.
            let microphones = &assembly.rig.microphones;
            let heard: Vec<usize> =
                if microphones.at.is_empty() { Vec::new() } else { vec![microphones.reference] };
            let point = |o: &Observed| {
                Ok(PointModel::new(assembly, &o.conditions, &heard)?.starting_from(o.near).prepared())
            };
            observed.iter().map(point).collect()
        })?;
        Ok(Self { laid, observed })
    }

    fn assembly(&self) -> &Assembly {
        self.laid.borrow_owner()
    }

    /// s of every observation, for every row of parameters.
    fn respond(&self, rows: &[f64], order: Order) -> Answer<Vec<Response>> {
        let (p, points) = (self.assembly().parameters().len(), self.laid.borrow_dependent());
        let n = points.len();
        let count = n * rows.len().checked_div(p).unwrap_or(1);
        let one = |task: usize| {
            let (k, o) = (task / n, task % n);
            WORK.with_borrow_mut(|work| points[o].respond(&rows[k * p..(k + 1) * p], order, work))
        };
        let found: Result<_, EngineError> = if count < FEW {
            (0..count).map(one).collect()
        } else {
            (0..count).into_par_iter().map(one).in_order()
        };
        Ok(found?)
    }

    fn check(&self, found: usize) -> Answer<()> {
        let expected = self.assembly().parameters().len();
        if found == expected {
            return Ok(());
        }
        let names: Vec<&str> = self.assembly().parameters().iter().map(|p| p.name.as_str()).collect();
        let message = format!("{found} values were given, but the model has {expected} parameters");
        Err(Fault::input(message).remedy(&format!("Give a value of each of {}.", names.join(", "))))
    }
}

#[pymethods]
impl Model {
    /// Name, symbol, unit and own prior of every parameter, as JSON.
    fn parameters(&self) -> Answer<String> {
        serde_json::to_string(self.assembly().parameters()).map_err(Fault::failed)
    }

    /// Medians of the parameters' own priors.
    #[getter]
    fn medians<'py>(&self, py: Python<'py>) -> Answer<Bound<'py, PyAny>> {
        let medians: Vec<f64> = self.assembly().parameters().iter().map(|p| p.prior.quantile(0.5)).collect();
        Ok(array(py, &[medians.len()], medians)?.into_any())
    }

    /// Operating point and label of the mode of every observation.
    #[getter]
    fn points(&self) -> Vec<(String, String)> {
        self.observed.iter().map(|o| (o.conditions.id.clone(), o.mode.label.clone())).collect()
    }

    /// Growth rate (1/s) and angular frequency (rad/s) that were measured; NaN where they were not.
    fn measured<'py>(&self, py: Python<'py>) -> Answer<Bound<'py, PyAny>> {
        let nan = |v: Option<f64>| v.unwrap_or(f64::NAN);
        let s = self.observed.iter().flat_map(|o| [nan(o.mode.growth_rate), nan(o.mode.angular_frequency)]);
        let s = complex(&s.collect::<Vec<_>>());
        Ok(array(py, &[s.len()], s)?.into_any())
    }

    /// s of every observation at `values`, with derivatives up to `order` (0, 1, 2) in the parameters.
    #[pyo3(signature = (values, order = 0))]
    fn solve<'py>(
        &self,
        py: Python<'py>,
        values: Values<'py>,
        order: usize,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let shape = values.shape().to_vec();
        let (n, p) = (self.observed.len(), self.assembly().parameters().len());
        self.check(shape.last().copied().unwrap_or(1))?;
        let wanted = match order {
            0 => Order::Value,
            1 => Order::First,
            2 => Order::Second,
            _ => {
                let fault = Fault::input(format!("order is {order}, but derivatives go from 0 to 2"));
                return Err(fault.remedy("Give 0, 1 or 2.").into());
            }
        };
        let rows: Vec<f64> = values.as_array().iter().copied().collect();
        let found = py.detach(|| self.respond(&rows, wanted))?;
        let outer = &shape[..shape.len().saturating_sub(1)];
        let shaped = |inner: &[usize]| [outer, inner].concat();
        let mut answers = vec![
            array(py, &shaped(&[n]), found.iter().map(|r| r.s.value()).collect::<Vec<C64>>())?.into_any(),
        ];
        if order >= 1 {
            let all = found.iter().flat_map(|r| r.s.gradient().iter().copied()).collect();
            answers.push(array(py, &shaped(&[n, p]), all)?.into_any());
        }
        if order == 2 {
            let entry = |r: &Response, i, j| r.s.hessian(i, j);
            let all = found
                .iter()
                .flat_map(|r| (0..p).flat_map(move |i| (0..p).map(move |j| entry(r, i, j))))
                .collect();
            answers.push(array(py, &shaped(&[n, p, p]), all)?.into_any());
        }
        Ok(answers)
    }
}
