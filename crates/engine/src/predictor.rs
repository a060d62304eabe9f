//! Many observations as one forward model.

use crate::observed::{Observed, Used};
use crate::point::{parts, respond_together};
use crate::{Assembly, EngineError, PointModel};
use rayon::prelude::*;
use rijke_inference::{Forward, ForwardError, Prediction};
use rijke_network::{Response, Workspace};
use rijke_numerics::{InOrder, Jet, Matrix, Order};

/// The predictions of several [`PointModel`]s, one after the other: s, then relative pressures, real and
/// imaginary parts in turn.
#[derive(Clone, Debug)]
pub struct Predictor<'a> {
    points: Vec<PointModel<'a>>,
    parameters: usize,
}

impl<'a> Predictor<'a> {
    pub(crate) fn new(
        assembly: &'a Assembly,
        observed: &[Observed],
        used: &[Used],
    ) -> Result<Self, EngineError> {
        let point = |(o, u): (&Observed, &Used)| {
            Ok(PointModel::new(assembly, &o.conditions, &u.microphones)?.starting_from(o.near).prepared())
        };
        let points = observed.par_iter().zip(used).map(point).in_order::<Result<_, EngineError>>()?;
        Ok(Self { points, parameters: assembly.parameters().len() })
    }

    /// The model of every observation.
    pub(crate) fn points(&self) -> &[PointModel<'a>] {
        &self.points
    }

    /// Modes of one point stand side by side.
    fn respond(&self, values: &[f64], order: Order) -> Result<Vec<Response>, EngineError> {
        let groups: Vec<&[PointModel<'_>]> = self.points.chunk_by(|a, b| a.id() == b.id()).collect();
        let found: Vec<Vec<Response>> = groups
            .par_iter()
            .map_init(Workspace::default, |work, group| respond_together(group, values, order, work))
            .in_order::<Result<_, EngineError>>()?;
        Ok(found.into_iter().flatten().collect())
    }
}

impl Forward for Predictor<'_> {
    fn predict(&self, parameters: &[f64], order: Order) -> Result<Prediction, ForwardError> {
        let responses = self.respond(parameters, order)?;
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

/// A forward model of which some numbers are kept, in another order, or with fewer derivatives.
pub(crate) struct Reordered<'a> {
    pub(crate) inner: &'a dyn Forward,
    /// For each number, its place in the inner model's prediction.
    pub(crate) order: Vec<usize>,
    /// The highest derivative that it admits to have: [`Order::First`] makes a Newton search a Gauss-Newton
    /// one.
    pub(crate) highest: Order,
}

impl Forward for Reordered<'_> {
    fn predict(&self, parameters: &[f64], order: Order) -> Result<Prediction, ForwardError> {
        let Prediction { values, jacobian, curvature } = self.inner.predict(parameters, order)?;
        let p = parameters.len();
        let moved = if order >= Order::First {
            Matrix::from_fn(self.order.len(), p, |row, i| jacobian[(self.order[row], i)])
        } else {
            jacobian
        };
        let triangle = if curvature.is_empty() { 0 } else { p * (p + 1) / 2 };
        let row = |&r: &usize| curvature[r * triangle..(r + 1) * triangle].iter().copied();
        Ok(Prediction {
            values: self.order.iter().map(|&r| values[r]).collect(),
            jacobian: moved,
            curvature: self.order.iter().flat_map(row).collect(),
        })
    }

    fn highest_order(&self) -> Order {
        self.highest.min(self.inner.highest_order())
    }
}
