//! What the classes share: dictionaries of Python as TOML, arrays, and the memory of solvers.

use crate::fault::{Answer, Fault};
use numpy::PyArrayDyn;
use numpy::ndarray::{ArrayD, IxDyn};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyInt, PyList, PyString, PyTuple};
use rijke_network::Workspace;
use rijke_numerics::C64;
use std::cell::RefCell;
use toml::{Table, Value};

thread_local! {
    /// Memory of solvers, kept from call to call.
    pub(crate) static WORK: RefCell<Workspace> = RefCell::default();
}

/// A dictionary of dictionaries, lists, numbers, words and truth values as the TOML of a file. `None` is left
/// out.
pub(crate) fn toml_of(dict: &Bound<'_, PyDict>, at: &str) -> PyResult<Table> {
    let mut table = Table::new();
    for (key, value) in dict.iter() {
        let key: String = key.extract()?;
        let at = if at.is_empty() { key.clone() } else { format!("{at}.{key}") };
        if !value.is_none() {
            table.insert(key, value_of(&value, &at)?);
        }
    }
    Ok(table)
}

fn value_of(value: &Bound<'_, PyAny>, at: &str) -> PyResult<Value> {
    // True is an int, too: ask for it first.
    if let Ok(truth) = value.cast::<PyBool>() {
        return Ok(Value::Boolean(truth.is_true()));
    }
    if value.is_instance_of::<PyInt>() {
        return Ok(Value::Integer(value.extract()?));
    }
    if value.is_instance_of::<PyString>() {
        return Ok(Value::String(value.extract()?));
    }
    if let Ok(dict) = value.cast::<PyDict>() {
        return Ok(Value::Table(toml_of(dict, at)?));
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let items = value.try_iter()?.enumerate();
        let item = |(k, v): (usize, PyResult<Bound<'_, PyAny>>)| value_of(&v?, &format!("{at}.{k}"));
        return Ok(Value::Array(items.map(item).collect::<PyResult<_>>()?));
    }
    if let Ok(number) = value.extract::<f64>() {
        return Ok(Value::Float(number));
    }
    if value.hasattr("tolist")? {
        return value_of(&value.call_method0("tolist")?, at);
    }
    let kind = value.get_type().name()?;
    let message = format!("`{at}` is of type {kind}, which a network file cannot hold");
    Err(Fault::input(message).remedy("Give a number, a word, a list or a dictionary.").into())
}

/// An array of Python's of any shape.
pub(crate) fn array<'py, T: numpy::Element>(
    py: Python<'py>,
    shape: &[usize],
    values: Vec<T>,
) -> Answer<Bound<'py, PyArrayDyn<T>>> {
    let array = ArrayD::from_shape_vec(IxDyn(shape), values).map_err(Fault::failed)?;
    Ok(PyArrayDyn::from_owned_array(py, array))
}

/// Real and imaginary parts in turn as complex numbers.
pub(crate) fn complex(parts: &[f64]) -> Vec<C64> {
    parts.chunks_exact(2).map(|z| C64::new(z[0], z[1])).collect()
}
