//! A network file, asked from Python.

use crate::convert::{WORK, array, toml_of};
use crate::fault::{Answer, Fault};
use crate::forced::{self, Frequencies};
use numpy::{AllowTypeChange, PyArrayLikeDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyComplex, PyDict, PyFloat, PyTuple};
use rayon::prelude::*;
use rijke_network::file::{Account, Built, NamedNumbers, read, samples_of_each};
use rijke_network::{Device, Mode, Newton, Region, Root};
use rijke_numerics::{C64, InOrder};
use std::f64::consts::PI;

/// See `rijke.Network`.
#[pyclass(subclass, frozen, module = "rijke._native")]
pub(crate) struct Network {
    text: String,
    source: Option<String>,
    built: Built,
    numbers: NamedNumbers,
}

impl Network {
    /// An error about this file.
    fn fault(&self, fault: impl Into<Fault>) -> Fault {
        fault.into().file(self.source.as_deref())
    }

    fn region(&self, growth_rate: Option<[f64; 2]>, frequency_hz: Option<[f64; 2]>) -> Region {
        let omega = frequency_hz.map(|f| f.map(|f| 2.0 * PI * f));
        let Region { sigma, omega: of_the_file } = self.built.region;
        Region { sigma: growth_rate.unwrap_or(sigma), omega: omega.unwrap_or(of_the_file) }
    }

    /// A place by its number, or by the name of the element that acts there.
    fn place(&self, place: &Bound<'_, PyAny>) -> PyResult<usize> {
        let Ok(name) = place.extract::<String>() else { return place.extract() };
        let found = self.built.places.iter().find(|(_, known)| *known == name);
        Ok(found.map(|(place, _)| *place).ok_or_else(|| {
            let known: Vec<&str> = self.built.places.iter().map(|(_, name)| name.as_str()).collect();
            let message = format!("no element called `{name}` acts at a place; known: {}", known.join(", "));
            self.fault(Fault::input(message).remedy("Give one of these names, or the number of a place."))
        })?)
    }

    /// Newton's iteration with other values of some numbers.
    fn solve_with(&self, guess: C64, names: &[String], values: &[f64]) -> Answer<C64> {
        let other;
        let built = if names.is_empty() {
            &self.built
        } else {
            let mut numbers = self.numbers.clone();
            for (name, value) in names.iter().zip(values) {
                numbers.set(name, *value)?;
            }
            other = numbers.build()?;
            &other
        };
        WORK.with_borrow_mut(|work| Ok(built.solve(guess, &Newton::default(), work)?.s))
    }
}

#[pymethods]
impl Network {
    #[new]
    #[pyo3(signature = (text, source = None))]
    fn new(text: String, source: Option<String>) -> Answer<Self> {
        let about = |fault: Fault| fault.file(source.as_deref());
        let built = read(&text).map_err(|error| about(error.into()))?;
        let numbers = NamedNumbers::of(&text).map_err(|error| about(error.into()))?;
        Ok(Self { text, source, built, numbers })
    }

    fn __getnewargs__(&self) -> (&str, Option<&str>) {
        (&self.text, self.source.as_deref())
    }

    #[staticmethod]
    fn text_of(file: &Bound<'_, PyDict>) -> PyResult<String> {
        Ok(toml::to_string(&toml_of(file, "")?).map_err(Fault::input)?)
    }

    #[getter]
    fn text(&self) -> &str {
        &self.text
    }

    #[getter]
    fn source(&self) -> Option<&str> {
        self.source.as_deref()
    }

    #[getter]
    fn name(&self) -> Option<&str> {
        self.built.name.as_deref()
    }

    #[getter]
    fn length(&self) -> f64 {
        self.built.network.length()
    }

    #[getter]
    fn at_rest(&self) -> bool {
        self.built.flow.is_none()
    }

    #[getter]
    fn passive(&self) -> bool {
        self.built.passive
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.built.warnings.iter().map(ToString::to_string).collect()
    }

    /// Number, name of the element that acts there, and position (m).
    #[getter]
    fn places(&self) -> Vec<(usize, String, f64)> {
        let position = |place: usize| self.built.network.position(place);
        self.built.places.iter().map(|(place, name)| (*place, name.clone(), position(*place))).collect()
    }

    /// Growth rates (1/s) and frequencies (Hz) of the search.
    #[getter(region)]
    fn limits(&self) -> ([f64; 2], [f64; 2]) {
        let Region { sigma, omega } = self.built.region;
        (sigma, omega.map(|w| w / (2.0 * PI)))
    }

    fn numbers<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        self.numbers.list().into_iter().try_for_each(|(name, value)| dict.set_item(name, value))?;
        Ok(dict)
    }

    /// The file's text with other values of some numbers.
    fn text_with(&self, values: Vec<(String, f64)>) -> Answer<String> {
        let mut numbers = self.numbers.clone();
        for (name, value) in values {
            numbers.set(&name, value).map_err(|e| self.fault(e))?;
        }
        Ok(numbers.text())
    }

    #[pyo3(signature = (growth_rate = None, frequency_hz = None))]
    fn find_modes<'py>(
        &self,
        py: Python<'py>,
        growth_rate: Option<[f64; 2]>,
        frequency_hz: Option<[f64; 2]>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let region = self.region(growth_rate, frequency_hz);
        let (found, accounts) = py
            .detach(|| -> Answer<_> {
                let found = self.built.modes(&region)?;
                let accounts: Result<Vec<Account>, _> =
                    found.modes.iter().map(|mode| self.built.account(mode)).collect();
                Ok((found, accounts?))
            })
            .map_err(|e| self.fault(e))?;
        let modes = &found.modes;
        let n = [modes.len()];
        let dict = PyDict::new(py);
        dict.set_item("s", array(py, &n, modes.iter().map(|m| m.s).collect())?)?;
        // As the program `rijke modes` prints it, to the last bit.
        let hertz = modes.iter().map(|m| m.s.im / (2.0 * PI)).collect();
        dict.set_item("frequency_hz", array(py, &n, hertz)?)?;
        dict.set_item("residual", array(py, &n, modes.iter().map(|m| m.residual).collect())?)?;
        dict.set_item("multiplicity", array(py, &n, modes.iter().map(|m| m.multiplicity).collect())?)?;
        dict.set_item("condition", array(py, &n, accounts.iter().map(|a| a.condition).collect())?)?;
        let shares = accounts.iter().map(|account| shares(py, account)).collect::<PyResult<Vec<_>>>()?;
        dict.set_item("shares", shares)?;
        dict.set_item("counted", found.counted)?;
        dict.set_item("poles", found.poles)?;
        Ok(dict)
    }

    /// The eigenvalue to which Newton's iteration from ``guess`` leads.
    ///
    /// Parameters
    /// ----------
    /// guess : complex or array of complex
    ///     Growth rate + i angular frequency, 1/s and rad/s.
    /// numbers : mapping of str to float or array, optional
    ///     Other values of some :meth:`numbers`. They are broadcast with ``guess``; all cases are solved in
    ///     parallel.
    ///
    /// Returns
    /// -------
    /// complex, or array of complex of the broadcast shape
    ///
    /// Raises
    /// ------
    /// ComputationError
    ///     No mode near the guess.
    #[pyo3(signature = (guess, numbers = None))]
    fn solve<'py>(
        &self,
        py: Python<'py>,
        guess: &Bound<'py, PyAny>,
        numbers: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        if numbers.is_none() && (guess.is_instance_of::<PyComplex>() || guess.is_instance_of::<PyFloat>()) {
            let guess: C64 = guess.extract()?;
            let s = py.detach(|| self.solve_with(guess, &[], &[])).map_err(|e| self.fault(e))?;
            return Ok(PyComplex::from_doubles(py, s.re, s.im).into_any());
        }
        let mut all = vec![guess.clone()];
        let mut names: Vec<String> = Vec::new();
        if let Some(numbers) = numbers {
            for item in numbers.call_method0("items")?.try_iter()? {
                let (name, values): (String, Bound<'py, PyAny>) = item?.extract()?;
                names.push(name);
                all.push(values);
            }
        }
        let alike: Vec<Bound<'py, PyAny>> = if names.is_empty() {
            all
        } else {
            py.import("numpy")?.call_method1("broadcast_arrays", PyTuple::new(py, all)?)?.extract()?
        };
        let guesses: PyArrayLikeDyn<'py, C64, AllowTypeChange> = alike[0].extract()?;
        let shape = guesses.shape().to_vec();
        let guesses: Vec<C64> = guesses.as_array().iter().copied().collect();
        let columns = alike[1..].iter().map(|column| {
            let column: PyArrayLikeDyn<'py, f64, AllowTypeChange> = column.extract()?;
            Ok(column.as_array().iter().copied().collect())
        });
        let columns: Vec<Vec<f64>> = columns.collect::<PyResult<_>>()?;
        let one = |(k, guess): (usize, &C64)| {
            let row: Vec<f64> = columns.iter().map(|column| column[k]).collect();
            self.solve_with(*guess, &names, &row)
        };
        let found: Answer<Vec<C64>> = py.detach(|| guesses.par_iter().enumerate().map(one).in_order());
        let found = found.map_err(|e| self.fault(e))?;
        Ok(match (shape.is_empty(), found.first()) {
            (true, Some(s)) => PyComplex::from_doubles(py, s.re, s.im).into_any(),
            _ => array(py, &shape, found)?.into_any(),
        })
    }

    fn derivatives<'py>(&self, py: Python<'py>, s: C64, names: Vec<String>) -> PyResult<Bound<'py, PyAny>> {
        let one = |name: &String| self.numbers.derivative(s, name);
        let found: Result<Vec<C64>, _> = py.detach(|| names.par_iter().map(one).in_order());
        Ok(array(py, &[names.len()], found.map_err(|e| self.fault(e))?)?.into_any())
    }

    /// Condition and shares of the growth rate of one mode.
    fn account<'py>(&self, py: Python<'py>, s: C64) -> PyResult<(f64, Bound<'py, PyDict>)> {
        let mode = Mode { s, residual: 0.0, multiplicity: 1 };
        let account = py.detach(|| self.built.account(&mode)).map_err(|e| self.fault(e))?;
        Ok((account.condition, shares(py, &account)?))
    }

    #[pyo3(signature = (growth_rate = None, frequency_hz = None))]
    fn find_poles<'py>(
        &self,
        py: Python<'py>,
        growth_rate: Option<[f64; 2]>,
        frequency_hz: Option<[f64; 2]>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let region = self.region(growth_rate, frequency_hz);
        let poles = py.detach(|| self.built.poles(&region)).map_err(|e| self.fault(e))?;
        Ok(array(py, &[poles.len()], poles)?.into_any())
    }

    /// The mode and the effect of small changes, by station along x.
    #[pyo3(signature = (s, samples = None))]
    fn stations<'py>(&self, py: Python<'py>, s: C64, samples: Option<usize>) -> PyResult<Bound<'py, PyDict>> {
        let samples = samples.unwrap_or_else(|| samples_of_each(self.built.ducts()));
        if samples < 2 {
            let fault = Fault::input(format!("samples is {samples}, but each duct needs 2 or more"));
            return Err(self.fault(fault).into());
        }
        let root = Root { s, steps: 0, residual: 0.0 };
        let found = py.detach(|| self.built.along(&root, samples)).map_err(|e| self.fault(e))?;
        let (dict, n) = (PyDict::new(py), [found.len()]);
        dict.set_item("x", array(py, &n, found.iter().map(|f| f.x).collect())?)?;
        let column = |name: &str, of: &dyn Fn(&rijke_network::Station) -> C64| -> PyResult<()> {
            dict.set_item(name, array(py, &n, found.iter().map(of).collect())?)
        };
        column("pressure", &|f| f.pressure)?;
        column("velocity", &|f| f.velocity)?;
        column("by_screen", &|f| f.device(Device::Drag))?;
        column("by_heat", &|f| f.device(Device::Heat))?;
        column("by_leak", &|f| f.device(Device::Leak))?;
        column("by_area", &|f| f.area)?;
        column("by_temperature", &|f| f.temperature)?;
        Ok(dict)
    }

    #[pyo3(signature = (s, kind, place = None))]
    fn forced<'py>(
        &self,
        py: Python<'py>,
        s: Frequencies<'py>,
        kind: &str,
        place: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let place = place.map(|place| self.place(&place)).transpose()?;
        let found =
            forced::source(kind, place).and_then(|source| forced::response(py, &self.built, &s, source));
        Ok(found.map_err(|e| self.fault(e))?)
    }

    fn seen_from<'py>(
        &self,
        py: Python<'py>,
        s: Frequencies<'py>,
        place: Bound<'py, PyAny>,
        reflection: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let found = forced::seen_from(py, &self.built, &s, self.place(&place)?, reflection);
        Ok(found.map_err(|e| self.fault(e))?)
    }

    fn between<'py>(
        &self,
        py: Python<'py>,
        s: Frequencies<'py>,
        places: (Bound<'py, PyAny>, Bound<'py, PyAny>),
        scattering: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let places = [self.place(&places.0)?, self.place(&places.1)?];
        let found = forced::between(py, &self.built, &s, places, scattering);
        Ok(found.map_err(|e| self.fault(e))?)
    }

    /// Position of every place, m from the upstream end.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let network = &self.built.network;
        let all: Vec<f64> = (0..=network.segments().len()).map(|place| network.position(place)).collect();
        Ok(array(py, &[all.len()], all)?.into_any())
    }
}

fn shares<'py>(py: Python<'py>, account: &Account) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("upstream end", account.upstream)?;
    dict.set_item("downstream end", account.downstream)?;
    dict.set_item("viscous wall", account.viscous)?;
    dict.set_item("thermal wall", account.thermal)?;
    account.elements.iter().try_for_each(|(name, share)| dict.set_item(name, share))?;
    Ok(dict)
}
