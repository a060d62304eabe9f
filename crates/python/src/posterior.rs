//! What a stage of a study found of its parameters, and what follows for measurements.

use crate::convert::array;
use crate::fault::{Answer, Fault};
use crate::model::Model;
use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use rijke_engine::run::{Chosen, Datum};
use rijke_engine::{LawError, Misfit};
use rijke_inference::Gaussian;
use rijke_numerics::{Cholesky, InOrder, Matrix};

/// See `rijke.Posterior`.
#[pyclass(frozen, module = "rijke._native")]
pub(crate) struct Posterior {
    chosen: Chosen,
    law: Option<LawError>,
    misfit: Misfit,
    data: Vec<Datum>,
}

impl Posterior {
    pub(crate) fn of(chosen: &Chosen, law: Option<LawError>, misfit: Misfit, data: Vec<Datum>) -> Self {
        Self { chosen: chosen.clone(), law, misfit, data }
    }
}

#[pymethods]
impl Posterior {
    /// Name, symbol and unit of every parameter.
    #[getter]
    fn parameters(&self) -> Vec<(String, String, String)> {
        let words = |p: &rijke_inference::Parameter| (p.name.clone(), p.symbol.clone(), p.unit.clone());
        self.chosen.trained.parameters.iter().map(words).collect()
    }

    /// How many of the parameters are the model's; the others are errors of base states and channels.
    #[getter]
    fn own(&self) -> usize {
        self.chosen.trained.own
    }

    #[getter]
    fn mean<'py>(&self, py: Python<'py>) -> Answer<Bound<'py, PyAny>> {
        let values = self.chosen.trained.values.clone();
        Ok(array(py, &[values.len()], values)?.into_any())
    }

    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> Answer<Bound<'py, PyAny>> {
        let covariance = &self.chosen.trained.covariance;
        let n = covariance.rows();
        Ok(array(py, &[n, n], covariance.as_slice().to_vec())?.into_any())
    }

    /// Name, unit, standard deviation of each noise, and whether the data chose it.
    #[getter]
    fn noise(&self) -> Vec<(String, String, f64, bool)> {
        let noise = self.chosen.trained.noise.iter();
        noise.map(|n| (n.name.clone(), n.unit.clone(), n.sd, n.floats)).collect()
    }

    /// Physical parameters (draws x parameters) that belong to rows of standard normal numbers: Laplace's
    /// Gaussian in the working coordinates of the parameters.
    fn points<'py>(&self, py: Python<'py>, xi: PyReadonlyArray2<'py, f64>) -> Answer<Bound<'py, PyAny>> {
        let trained = &self.chosen.trained;
        let working: Vec<f64> =
            trained.parameters.iter().zip(&trained.values).map(|(p, v)| p.working(*v)).collect();
        let slopes: Vec<f64> =
            trained.parameters.iter().zip(&working).map(|(p, z)| p.physical(*z)[1]).collect();
        let n = slopes.len();
        let precision = Cholesky::new(&trained.covariance).map_err(Fault::failed)?.inverse();
        let hessian = Matrix::from_fn(n, n, |i, j| slopes[i] * precision[(i, j)] * slopes[j]);
        let gaussian = Gaussian::from_hessian(&working, 0.0, &hessian)?;
        let rows = xi.shape()[0];
        if xi.shape()[1] != n {
            return Err(Fault::input(format!("{} numbers for {n} parameters", xi.shape()[1])));
        }
        let xi = xi.as_array();
        let physical = xi.rows().into_iter().flat_map(|row| {
            let point = gaussian.point(&row.to_vec());
            trained.parameters.iter().zip(point).map(|(p, z)| p.physical(z)[0]).collect::<Vec<_>>()
        });
        Ok(array(py, &[rows, n], physical.collect())?.into_any())
    }

    /// Of every number of the data the place of its observation, and its row: 0 growth rate, 1 angular
    /// frequency, then relative pressures.
    #[getter]
    fn data(&self) -> Vec<(usize, usize)> {
        self.data.iter().map(|d| (d.observation, d.row)).collect()
    }

    /// ln of the density of each number of the data given all others, for every draw of physical parameters:
    /// (draws x parameters) in, (draws x numbers) out.
    fn ln_densities<'py>(
        &self,
        py: Python<'py>,
        draws: PyReadonlyArray2<'py, f64>,
    ) -> Answer<Bound<'py, PyAny>> {
        let rows: Vec<Vec<f64>> = draws.as_array().rows().into_iter().map(|row| row.to_vec()).collect();
        let chosen = &self.chosen;
        let found: Option<Vec<Vec<f64>>> =
            py.detach(|| rows.par_iter().map(|row| chosen.ln_densities(row)).collect());
        let Some(found) = found else {
            let parameters = self.chosen.trained.parameters.len();
            return Err(Fault::input(format!("draws have {parameters} parameters, each within its bounds")));
        };
        Ok(array(py, &[rows.len(), self.data.len()], found.concat())?.into_any())
    }

    /// The model of the observations that trained it.
    fn model(&self) -> Answer<Model> {
        Model::of(self.chosen.assembly.clone(), self.chosen.observed.clone())
    }

    /// Growth rate (1/s) and angular frequency (rad/s) of a new measurement at every operating point that was
    /// observed: columns `point`, `mode`, and mean and standard deviation of both.
    fn predictions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let Chosen { assembly, trained, observed, .. } = &self.chosen;
        let microphones = &assembly.rig.microphones;
        let reference: Vec<usize> =
            Some(microphones.reference).filter(|_| !microphones.at.is_empty()).into_iter().collect();
        let misfit = &self.misfit;
        let posterior = trained.posterior();
        let found = py.detach(|| {
            observed
                .par_iter()
                .map(|o| {
                    posterior.predict(assembly, &o.conditions, &reference, Some(o.near), self.law.as_ref())
                })
                .in_order::<Result<Vec<_>, _>>()
        });
        let found = found.map_err(Fault::from)?;
        let n = [found.len()];
        let dict = PyDict::new(py);
        dict.set_item("point", observed.iter().map(|o| o.conditions.id.as_str()).collect::<Vec<_>>())?;
        dict.set_item("mode", observed.iter().map(|o| o.mode.label.as_str()).collect::<Vec<_>>())?;
        for (k, name) in ["growth_rate", "angular_frequency"].into_iter().enumerate() {
            dict.set_item(name, array(py, &n, found.iter().map(|p| p.values[k]).collect())?)?;
            let sd = found.iter().map(|p| p.sd(k, misfit)).collect();
            dict.set_item(format!("{name}_sd"), array(py, &n, sd)?)?;
        }
        Ok(dict)
    }
}
