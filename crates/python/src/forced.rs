//! Forced responses of a network file, asked from Python.

use crate::convert::array;
use crate::fault::{Answer, Fault};
use crate::network::{Network, WORK};
use numpy::{AllowTypeChange, PyArrayLikeDyn};
use pyo3::prelude::*;
use rayon::prelude::*;
use rijke_network::{NetworkError, Source, Workspace};
use rijke_numerics::{C64, Order};

/// Complex angular frequencies from Python, of any shape.
pub(crate) type Frequencies<'py> = PyArrayLikeDyn<'py, C64, AllowTypeChange>;

impl Network {
    /// As many complex numbers at every s, in parallel.
    fn at_each(
        &self,
        py: Python<'_>,
        s: &Frequencies<'_>,
        of: impl Fn(C64, &mut Workspace) -> Result<Vec<C64>, NetworkError> + Sync,
    ) -> Answer<(usize, Vec<C64>)> {
        if self.built.flow.is_some() {
            let fault = Fault::input("forced responses are those of gas at rest, but the file has [flow]");
            return Err(self.fault(fault.remedy("Leave [flow] out of the file.")));
        }
        let s: Vec<C64> = s.as_array().iter().copied().collect();
        let one = |s: &C64| WORK.with_borrow_mut(|work| of(*s, work));
        let found: Result<Vec<Vec<C64>>, _> = py.detach(|| s.par_iter().map(one).collect());
        Ok((s.len(), found.map_err(|e| self.fault(e))?.concat()))
    }
}

impl Network {
    /// Pressure and velocity at every s, of every place, before it and behind it: shape (s, place, side, 2).
    pub(crate) fn forced_at<'py>(
        &self,
        py: Python<'py>,
        s: &Frequencies<'py>,
        kind: &str,
        place: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let place = place.map(|place| self.place(&place)).transpose()?;
        let source = match (kind, place) {
            ("upstream", None) => Source::Upstream,
            ("downstream", None) => Source::Downstream,
            ("velocity", Some(place)) => Source::Velocity(place),
            ("pressure", Some(place)) => Source::Pressure(place),
            _ => {
                let fault = Fault::input(format!("there is no source of kind `{kind}` with this place"));
                let remedy =
                    "Give `upstream` or `downstream`, or (`velocity`, place) or (`pressure`, place).";
                return Err(fault.remedy(remedy).into());
            }
        };
        let (network, laws) = (&self.built.network, &self.built.laws);
        let (n, found) = self.at_each(py, s, |s, work| {
            let forced = network.forced(laws, s, source, Order::Value, work)?;
            let both = forced.before.iter().zip(&forced.behind);
            Ok(both.flat_map(|(a, b)| [&a[0], &a[1], &b[0], &b[1]].map(rijke_numerics::Jet::value)).collect())
        })?;
        Ok(array(py, &[n, network.segments().len() + 1, 2, 2], found)?.into_any())
    }

    /// p/u (Pa s/m) or, as a reflection, g/f of what lies downstream of a place.
    pub(crate) fn seen_at<'py>(
        &self,
        py: Python<'py>,
        s: &Frequencies<'py>,
        place: &Bound<'py, PyAny>,
        reflection: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let place = self.place(place)?;
        let (network, laws) = (&self.built.network, &self.built.laws);
        let (n, found) = self.at_each(py, s, |s, work| {
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
    pub(crate) fn between_at<'py>(
        &self,
        py: Python<'py>,
        s: &Frequencies<'py>,
        places: &(Bound<'py, PyAny>, Bound<'py, PyAny>),
        scattering: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let places = [self.place(&places.0)?, self.place(&places.1)?];
        let (network, laws) = (&self.built.network, &self.built.laws);
        let (n, found) = self.at_each(py, s, |s, work| {
            let transfer = network.transfer(laws, s, places, Order::Value, work)?;
            let matrix = if scattering { transfer.scattering() } else { transfer.matrix };
            Ok(matrix.iter().flatten().map(rijke_numerics::Jet::value).collect())
        })?;
        Ok(array(py, &[n, 2, 2], found)?.into_any())
    }
}
