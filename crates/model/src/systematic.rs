//! What errors of the base states do to predictions: a systematic covariance that operating points share.

use crate::numbers::parts;
use crate::principal::{Principal, STEP};
use crate::{Assembly, BaseState, Conditions, ModelError, Observed, PointModel, Workspace};
use rayon::prelude::*;
use rijke_inference::{Forward, ForwardError, Prediction};
use rijke_numerics::{C64, Matrix, Order};
use std::collections::BTreeMap;

/// Causes of error of a point, and the change of its prediction per standard deviation of each.
pub(crate) type Changes = Vec<(String, Vec<f64>)>;

/// For each operating point, the change of its prediction per standard deviation of each cause of error.
///
/// Points that name the same cause share it: it is one random number (see `rijke_flow::BaseStates`).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BaseErrors {
    points: Vec<Changes>,
}

impl BaseErrors {
    /// The changes at the parameter values `values`, in the order of `rijke_rig::Ping::vector` for `microphones`: slopes along the
    /// principal errors of each base state, by a small step.
    ///
    /// Cost: a value of the model per point and principal error, of which fifty causes have about seven; in parallel over points.
    ///
    /// # Errors
    /// Those of the model at a displaced state.
    pub fn new(
        assembly: &Assembly,
        observed: &[Observed],
        microphones: &[usize],
        values: &[f64],
    ) -> Result<Self, ModelError> {
        let at = |o: &Observed| changes(assembly, &o.conditions, o.ping.s, microphones, values);
        Ok(Self { points: observed.par_iter().map(at).collect::<Result<_, _>>()? })
    }

    /// With more causes of error, for each point.
    pub(crate) fn and(mut self, more: Vec<Changes>) -> Self {
        self.points.iter_mut().zip(more).for_each(|(list, more)| list.extend(more));
        self
    }

    /// The causes that points of different settings share (`same` tells whether two are of one), what each does to all numbers, point
    /// after point, `size` of each; and the errors without them.
    pub(crate) fn apart(
        self,
        size: usize,
        same: impl Fn(usize, usize) -> bool,
    ) -> (Vec<String>, Vec<Vec<f64>>, Self) {
        let mut first: BTreeMap<&str, (usize, bool)> = BTreeMap::new();
        for (p, list) in self.points.iter().enumerate() {
            for (cause, _) in list {
                let (other, apart) = first.entry(cause).or_insert((p, false));
                *apart |= !same(*other, p);
            }
        }
        let causes: Vec<String> =
            first.iter().filter(|(_, (_, apart))| *apart).map(|(cause, _)| (*cause).to_owned()).collect();
        let mut columns = vec![vec![0.0; size * self.points.len()]; causes.len()];
        let mut rest = Self { points: vec![Vec::new(); self.points.len()] };
        for (p, list) in self.points.into_iter().enumerate() {
            for (cause, change) in list {
                match causes.binary_search(&cause) {
                    Ok(j) => columns[j][size * p..size * (p + 1)].copy_from_slice(&change),
                    Err(_) => rest.points[p].push((cause, change)),
                }
            }
        }
        (causes, columns, rest)
    }

    /// Points that share a cause, or are `linked`, directly or through others: each list ascends, and every point is in exactly one.
    #[must_use]
    pub fn together(&self, linked: impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
        let shares = |a: usize, b: usize| {
            linked(a, b)
                || self.points[a]
                    .iter()
                    .any(|(cause, _)| self.points[b].iter().any(|(other, _)| other == cause))
        };
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for point in 0..self.points.len() {
            let (mut with, without): (Vec<_>, Vec<_>) =
                groups.into_iter().partition(|g| g.iter().any(|&other| shares(point, other)));
            with.push(vec![point]);
            groups = without;
            let mut merged = with.concat();
            merged.sort_unstable();
            groups.push(merged);
        }
        groups.sort();
        groups
    }

    /// Covariance of the numbers `rows` of each of the points `group`, point after point: the sum over causes of j j'.
    #[must_use]
    pub fn covariance(&self, group: &[usize], rows: &[usize]) -> Matrix {
        let size = group.len() * rows.len();
        let mut causes: Vec<&str> =
            group.iter().flat_map(|&p| &self.points[p]).map(|(c, _)| c.as_str()).collect();
        causes.sort_unstable();
        causes.dedup();
        let mut covariance = Matrix::zeros(size, size);
        for cause in causes {
            let mut j = vec![0.0; size];
            for (k, &point) in group.iter().enumerate() {
                if let Some((_, change)) = self.points[point].iter().find(|(c, _)| c == cause) {
                    for (l, &row) in rows.iter().enumerate() {
                        j[k * rows.len() + l] = change[row];
                    }
                }
            }
            covariance.add_outer(&j);
        }
        covariance
    }
}

/// The change of the prediction of one point per standard deviation of each cause of error of its base state, by way of the
/// state's [`Principal`] errors.
pub(crate) fn changes(
    assembly: &Assembly,
    conditions: &Conditions,
    near: C64,
    microphones: &[usize],
    values: &[f64],
) -> Result<Changes, ModelError> {
    let work = &mut Workspace::default();
    let point = &conditions.point;
    let mut predicted = |base: BaseState, near: C64| -> Result<Vec<f64>, ModelError> {
        let moved = Conditions { point: point.clone(), base, ambient: conditions.ambient };
        let model = PointModel::new(assembly, &moved, microphones)?.starting_from(near);
        let response = model.respond(values, Order::Value, work)?;
        Ok(parts(model.numbers(&response).map(|z| z.value())))
    };
    let principal = Principal::of(&conditions.base, &point.id)?;
    let mut along = Vec::with_capacity(principal.states.len());
    if !principal.states.is_empty() {
        let here = predicted(conditions.base.clone(), near)?;
        // So near that Newton's steps are one or two.
        let near = C64::new(here[0], here[1]);
        for moved in principal.states {
            let moved = predicted(moved, near)?;
            along.push(moved.iter().zip(&here).map(|(m, h)| (m - h) / STEP).collect::<Vec<f64>>());
        }
    }
    let change = |(cause, shares): (String, Vec<f64>)| {
        let mut change = vec![0.0; 2 * microphones.len()];
        for (share, along) in shares.iter().zip(&along) {
            change.iter_mut().zip(along).for_each(|(c, a)| *c += share * a);
        }
        (cause, change)
    };
    Ok(principal.causes.into_iter().map(change).collect())
}

/// A forward model whose numbers come in another order, or with fewer derivatives.
pub(crate) struct Reordered<'a> {
    pub(crate) inner: &'a dyn Forward,
    /// For each number, its place in the inner model's prediction.
    pub(crate) order: Vec<usize>,
    /// The highest derivative that it admits to have: [`Order::First`] makes a Newton search a Gauss-Newton one.
    pub(crate) highest: Order,
}

impl Forward for Reordered<'_> {
    fn predict(&self, parameters: &[f64], order: Order) -> Result<Prediction, ForwardError> {
        let Prediction { values, jacobian, curvature } = self.inner.predict(parameters, order)?;
        let p = parameters.len();
        let moved = if order >= Order::First {
            Matrix::from_fn(values.len(), p, |row, i| jacobian[(self.order[row], i)])
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
