//! Many operating points as one forward model.

use crate::numbers::parts;
use crate::{ModelError, PointModel};
use rayon::prelude::*;
use rijke_inference::{Forward, ForwardError, Prediction};
use rijke_network::{Response, Workspace};
use rijke_numerics::{Jet, Matrix, Order};

/// The predictions of several [`PointModel`]s, one after the other.
#[derive(Clone, Debug)]
pub struct Predictor<'a> {
    points: Vec<PointModel<'a>>,
    parameters: usize,
}

impl<'a> Predictor<'a> {
    /// Points that share one assembly with `parameters` free parameters.
    #[must_use]
    pub fn new(points: Vec<PointModel<'a>>, parameters: usize) -> Self {
        Self { points: points.into_iter().map(PointModel::prepared).collect(), parameters }
    }

    /// The response of every point, in order, computed in parallel.
    ///
    /// # Errors
    /// That of the first point that has no answer.
    pub fn respond(&self, values: &[f64], order: Order) -> Result<Vec<Response>, ModelError> {
        self.points
            .par_iter()
            .map_init(Workspace::default, |work, point| point.respond(values, order, work))
            .collect()
    }
}

impl Forward for Predictor<'_> {
    fn predict(&self, parameters: &[f64], order: Order) -> Result<Prediction, ForwardError> {
        let responses = self.respond(parameters, order).map_err(|error| {
            if error.is_recoverable() { ForwardError::recoverable(error) } else { ForwardError::fatal(error) }
        })?;
        let complex: Vec<&Jet> =
            self.points.iter().zip(&responses).flat_map(|(point, r)| point.numbers(r)).collect();
        let values = parts(complex.iter().map(|z| z.value()));
        let p = self.parameters;
        let jacobian = if order >= Order::First {
            Matrix::from_fn(2 * complex.len(), p, |row, i| {
                let z = complex[row / 2].gradient()[i];
                if row % 2 == 0 { z.re } else { z.im }
            })
        } else {
            Matrix::default()
        };
        let curvature = if order == Order::Second {
            let rows = complex.iter().flat_map(|z| {
                let packed = z.hessian_packed();
                packed.iter().map(|h| h.re).chain(packed.iter().map(|h| h.im))
            });
            rows.collect()
        } else {
            Vec::new()
        };
        Ok(Prediction { values, jacobian, curvature })
    }
}
