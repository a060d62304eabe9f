//! What an error of the law of the heat release does to predictions: the law times 1 + e, e complex.

use crate::systematic::Changes;
use crate::{Assembly, Conditions, ModelError, Observed, PointModel, Workspace};
use rayon::prelude::*;
use rijke_candidates::{Effect, Here, Law};
use rijke_inference::{Parameter, Prior};
use rijke_numerics::{C64, Jet, Order};
use std::sync::Arc;

/// The role whose laws may be in error.
const ROLE: &str = "heat-release";

/// Names of the real and the imaginary part of e: no formula can use them.
const NAMES: [&str; 2] = ["error of the law, real", "error of the law, imaginary"];

/// A model whose laws of the heat release are in error by the factor 1 + e, whose parts are two more parameters.
pub(crate) struct LawError {
    erring: Assembly,
    /// Places of the two among the parameters of `erring`.
    places: [usize; 2],
    sd: f64,
}

impl LawError {
    /// With standard deviation `sd` of both parts. Nothing for a model without heat release.
    ///
    /// # Errors
    /// Those of an assembly.
    pub(crate) fn of(assembly: &Assembly, sd: f64) -> Result<Option<Self>, ModelError> {
        if !assembly.candidates().iter().any(|c| c.role == ROLE) {
            return Ok(None);
        }
        let erring = erring(assembly)?;
        let place = |name: &str| erring.parameters().iter().position(|p| p.name == name);
        let [Some(re), Some(im)] = NAMES.map(place) else { return Ok(None) };
        Ok(Some(Self { erring, places: [re, im], sd }))
    }

    /// The changes of the prediction of every point per standard deviation of the real and the imaginary part of e, which all points of one
    /// power share, in the order of `rijke_rig::Ping::vector`.
    ///
    /// # Errors
    /// Those of the model.
    pub(crate) fn changes(
        &self,
        observed: &[Observed],
        microphones: &[usize],
        values: &[f64],
    ) -> Result<Vec<Changes>, ModelError> {
        let at = |o: &Observed| self.changes_at(&o.conditions, o.ping.s, microphones, values);
        observed.par_iter().map(at).collect()
    }

    /// As [`LawError::changes`], at one point, whose root is near `near`.
    pub(crate) fn changes_at(
        &self,
        conditions: &Conditions,
        near: C64,
        microphones: &[usize],
        values: &[f64],
    ) -> Result<Changes, ModelError> {
        let mut given = values.iter().copied();
        let values: Vec<f64> = (0..self.erring.parameters().len())
            .map(|k| if self.places.contains(&k) { 0.0 } else { given.next().unwrap_or(f64::NAN) })
            .collect();
        let point = PointModel::new(&self.erring, conditions, microphones)?.starting_from(near);
        let response = point.respond(&values, Order::First, &mut Workspace::default())?;
        let change = |(k, name): (usize, &str)| {
            let change = point.slope(&response, k).into_iter().map(|slope| slope * self.sd).collect();
            (format!("{name} at {} W", conditions.point.power), change)
        };
        Ok(self.places.into_iter().zip(NAMES).map(change).collect())
    }
}

/// The assembly with the laws of the heat release times 1 + e, whose parts are free.
fn erring(assembly: &Assembly) -> Result<Assembly, ModelError> {
    let mut candidates = assembly.candidates().to_vec();
    for candidate in candidates.iter_mut().filter(|c| c.role == ROLE) {
        for effect in &mut candidate.effects {
            *effect = Effect { law: Arc::new(Erring(effect.law.clone())), ..effect.clone() };
        }
        let prior = Prior::Normal { mean: 0.0, sd: 1.0 };
        candidate.parameters.extend(NAMES.map(|name| Parameter::new(name, "", "1", prior)));
    }
    let mut erring = Assembly::new(assembly.rig.clone(), candidates)?.with_scheme(assembly.scheme);
    for (name, value) in assembly.held() {
        erring = erring.fixed(&name, value)?;
    }
    Ok(erring)
}

/// A law times 1 + e; the parts of e are its last two parameters.
#[derive(Debug)]
struct Erring(Arc<dyn Law>);

impl Law for Erring {
    fn evaluate(&self, here: &Here<'_>, parameters: &[Jet]) -> Jet {
        let [own @ .., re, im] = parameters else { return here.space.real(f64::NAN) };
        let factor = &(&here.space.real(1.0) + re) + &im.scale(C64::I);
        &self.0.evaluate(here, own) * &factor
    }

    fn uses_wall(&self) -> bool {
        self.0.uses_wall()
    }

    fn text(&self) -> String {
        format!("(1 + e)*({})", self.0.text())
    }
}
