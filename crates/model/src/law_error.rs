//! What an error of the law of the heat release does to predictions: the law times 1 + e, e complex.

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

/// For each point the derivatives of its prediction with respect to the real and the imaginary part of e, in the order of
/// `rijke_rig::Ping::vector`; none for a model without heat release.
///
/// # Errors
/// Those of the model.
pub(crate) fn slopes(
    assembly: &Assembly,
    observed: &[Observed],
    microphones: &[usize],
    values: &[f64],
) -> Result<Vec<Option<[Vec<f64>; 2]>>, ModelError> {
    let at = |o: &Observed| slopes_at(assembly, &o.conditions, o.ping.s, microphones, values);
    observed.par_iter().map(at).collect()
}

/// As [`slopes`], at one point, whose root is near `near`.
pub(crate) fn slopes_at(
    assembly: &Assembly,
    conditions: &Conditions,
    near: C64,
    microphones: &[usize],
    values: &[f64],
) -> Result<Option<[Vec<f64>; 2]>, ModelError> {
    if !assembly.candidates().iter().any(|c| c.role == ROLE) {
        return Ok(None);
    }
    let erring = erring(assembly)?;
    let mut given = values.iter().copied();
    let values: Vec<f64> = erring
        .parameters()
        .iter()
        .map(|p| if NAMES.contains(&p.name.as_str()) { 0.0 } else { given.next().unwrap_or(f64::NAN) })
        .collect();
    let place = |name: &str| erring.parameters().iter().position(|p| p.name == name).unwrap_or(0);
    let point = PointModel::new(&erring, conditions, microphones)?.starting_from(near);
    let response = point.respond(&values, Order::First, &mut Workspace::default())?;
    let reference = assembly.rig.microphones.reference;
    let others = microphones.iter().zip(&response.pressures).filter(|(m, _)| **m != reference);
    let complex: Vec<&Jet> = std::iter::once(&response.s).chain(others.map(|(_, p)| p)).collect();
    Ok(Some(NAMES.map(|name| {
        let k = place(name);
        complex.iter().flat_map(|z| [z.gradient()[k].re, z.gradient()[k].im]).collect()
    })))
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
