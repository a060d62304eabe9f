//! Forced responses of the network of a file at many frequencies, in parallel.

use crate::convert::{WORK, array};
use crate::fault::{Answer, Fault};
use numpy::{AllowTypeChange, PyArrayLikeDyn};
use pyo3::prelude::*;
use rayon::prelude::*;
use rijke_network::file::Built;
use rijke_network::{NetworkError, Source, Workspace};
use rijke_numerics::{C64, InOrder, Jet, Order};

/// Complex angular frequencies from Python, of any shape.
pub(crate) type Frequencies<'py> = PyArrayLikeDyn<'py, C64, AllowTypeChange>;

/// What drives the gas, by its name and place.
pub(crate) fn source(kind: &str, place: Option<usize>) -> Answer<Source> {
    match (kind, place) {
        ("upstream", None) => Ok(Source::Upstream),
        ("downstream", None) => Ok(Source::Downstream),
        ("velocity", Some(place)) => Ok(Source::Velocity(place)),
        ("pressure", Some(place)) => Ok(Source::Pressure(place)),
        _ => {
            let fault = Fault::input(format!("there is no source of kind `{kind}` with this place"));
            Err(fault
                .remedy("Give `upstream` or `downstream`, or (`velocity`, place) or (`pressure`, place)."))
        }
    }
}

/// Pressure and velocity of every place, before it and behind it: shape (s, place, side, 2).
pub(crate) fn response<'py>(
    py: Python<'py>,
    built: &Built,
    s: &Frequencies<'py>,
    source: Source,
) -> Answer<Bound<'py, PyAny>> {
    let (network, laws) = (&built.network, &built.laws);
    let (n, found) = at_each(py, built, s, |s, work| {
        let forced = network.forced(laws, s, source, Order::Value, work)?;
        let both = forced.before.iter().zip(&forced.behind);
        Ok(both.flat_map(|(a, b)| [&a[0], &a[1], &b[0], &b[1]].map(Jet::value)).collect())
    })?;
    Ok(array(py, &[n, network.segments().len() + 1, 2, 2], found)?.into_any())
}

/// p/u (Pa s/m) or, as a reflection, g/f of what lies downstream of a place: shape (s,).
pub(crate) fn seen_from<'py>(
    py: Python<'py>,
    built: &Built,
    s: &Frequencies<'py>,
    place: usize,
    reflection: bool,
) -> Answer<Bound<'py, PyAny>> {
    let (network, laws) = (&built.network, &built.laws);
    let (n, found) = at_each(py, built, s, |s, work| {
        let jet = if reflection {
            network.reflection_at(laws, s, place, Order::Value, work)
        } else {
            network.impedance_at(laws, s, place, Order::Value, work)
        };
        Ok(vec![jet?.value()])
    })?;
    Ok(array(py, &[n], found)?.into_any())
}

/// The matrix of (p, u) or the scattering matrix between two places: shape (s, 2, 2).
pub(crate) fn between<'py>(
    py: Python<'py>,
    built: &Built,
    s: &Frequencies<'py>,
    places: [usize; 2],
    scattering: bool,
) -> Answer<Bound<'py, PyAny>> {
    let (network, laws) = (&built.network, &built.laws);
    let (n, found) = at_each(py, built, s, |s, work| {
        let transfer = network.transfer(laws, s, places, Order::Value, work)?;
        let matrix = if scattering { transfer.scattering() } else { transfer.matrix };
        Ok(matrix.iter().flatten().map(Jet::value).collect())
    })?;
    Ok(array(py, &[n, 2, 2], found)?.into_any())
}

/// How many s there are, and as many complex numbers at each of them.
fn at_each(
    py: Python<'_>,
    built: &Built,
    s: &Frequencies<'_>,
    of: impl Fn(C64, &mut Workspace) -> Result<Vec<C64>, NetworkError> + Sync,
) -> Answer<(usize, Vec<C64>)> {
    if built.flow.is_some() {
        let fault = Fault::input("forced responses are those of gas at rest, but the file has [flow]");
        return Err(fault.remedy("Leave [flow] out of the file."));
    }
    let s: Vec<C64> = s.as_array().iter().copied().collect();
    let one = |s: &C64| WORK.with_borrow_mut(|work| of(*s, work));
    let found: Result<Vec<Vec<C64>>, _> = py.detach(|| s.par_iter().map(one).in_order());
    Ok((s.len(), found?.concat()))
}
