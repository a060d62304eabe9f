//! What an error of the laws of a role does to predictions: the law times 1 + e, or plus e, e complex.

use super::Changes;
use crate::assembly::LAW_ERROR;
use crate::noise::LawError;
use crate::observed::{Observed, Used};
use crate::{Assembly, Conditions, EngineError, PointModel};
use rayon::prelude::*;
use rijke_network::Workspace;
use rijke_numerics::{C64, InOrder, Order};
use rijke_study::Cause;
use std::f64::consts::TAU;

/// A model whose laws of one role are in error by e, whose parts are two more parameters.
pub(crate) struct LawErrors {
    erring: Assembly,
    /// Places of the two among the parameters of `erring`.
    places: [usize; 2],
    error: LawError,
}

impl LawErrors {
    /// Nothing for a model without that role or law.
    ///
    /// # Errors
    /// Those of an assembly.
    pub(crate) fn of(assembly: &Assembly, error: &LawError) -> Result<Option<Self>, EngineError> {
        let Some(erring) = assembly.with_law_error(&error.role, error.added.as_ref())? else {
            return Ok(None);
        };
        let place = |name: &str| erring.parameters().iter().position(|p| p.name == name);
        let [Some(re), Some(im)] = LAW_ERROR.map(place) else { return Ok(None) };
        Ok(Some(Self { erring, places: [re, im], error: error.clone() }))
    }

    /// The changes of the prediction of every point per standard deviation of the real and the imaginary part
    /// of e, which all points of one value of the factor share; of one that is added to a law, by the nodes
    /// of its frequencies ([`Added::nodes`](crate::Added)).
    ///
    /// # Errors
    /// Those of the model.
    pub(crate) fn changes(
        &self,
        observed: &[Observed],
        used: &[Used],
        values: &[f64],
    ) -> Result<Vec<Changes>, EngineError> {
        let at = |(o, u): (&Observed, &Used)| self.changes_at(&o.conditions, o.near, &u.microphones, values);
        observed.par_iter().zip(used).map(at).in_order()
    }

    /// As [`LawErrors::changes`], at one point, whose root is near `near`.
    pub(crate) fn changes_at(
        &self,
        conditions: &Conditions,
        near: C64,
        microphones: &[usize],
        values: &[f64],
    ) -> Result<Changes, EngineError> {
        let mut given = values.iter().copied();
        let values: Vec<f64> = (0..self.erring.parameters().len())
            .map(|k| if self.places.contains(&k) { 0.0 } else { given.next().unwrap_or(f64::NAN) })
            .collect();
        let point = PointModel::new(&self.erring, conditions, microphones)?.starting_from(near);
        let response = point.respond(&values, Order::First, &mut Workspace::default())?;
        let level = |k: usize| format!("{:e}", conditions.point.factors[k]);
        let level = self.error.over.map_or("all".to_owned(), level);
        // An error that is added to a law is another one at another frequency.
        let hertz = response.s.value().im / TAU;
        let apart = self.error.added.as_ref().map(|added| added.nodes(hertz));
        let sd = self.error.sd * self.error.added.as_ref().map_or(1.0, |added| added.size(hertz));
        let levels: Vec<(String, f64)> = match apart {
            None => vec![(level, 1.0)],
            Some(nodes) => nodes.into_iter().map(|(k, w)| (format!("{level} {k}"), w)).collect(),
        };
        let change = |(part, k): (usize, usize)| {
            let slope = point.slope(&response, k);
            let one = move |(level, weight): &(String, f64)| {
                let size = sd * weight;
                let (role, level) = (self.error.role.clone(), level.clone());
                (Cause::Law { role, part, level }, slope.iter().map(|d| d * size).collect())
            };
            levels.iter().map(one).collect::<Changes>()
        };
        Ok(self.places.into_iter().enumerate().flat_map(change).collect())
    }
}
