//! From observations to the most probable parameters and the evidence.

use crate::data::Blocks;
use crate::delays::delays;
use crate::errors::{Assemblies, Bends, ChannelsOfModes, LawErrors, Scatter, ThroughChannels, any_varies};
use crate::fitting::{Fitting, parameters};
use crate::gaussian::Training;
use crate::observed::{Observed, Used};
use crate::predictor::Predictor;
use crate::trained::Trained;
use crate::with_errors::WithErrors;
use crate::{Assembly, EngineError};
use rijke_inference::{AssessOptions, Forward};
use rijke_numerics::Order;

/// The fit without errors has missed a maximum if a search from elsewhere ends more nats lower than this.
const BETTER: f64 = 1.0;

/// Finds the most probable parameters of `assembly`, their covariance and the evidence.
///
/// # Errors
/// [`EngineError::NotConverged`], [`EngineError::NoEvidence`] with the reason, and whatever the model or the
/// inference cannot survive.
pub fn train(
    assembly: &Assembly,
    observed: &[Observed],
    training: &Training,
) -> Result<Trained, EngineError> {
    let rig = &assembly.rig;
    let reference = rig.microphones.reference;
    let mut used: Vec<Used> = observed.iter().map(|o| o.used(&training.microphones, reference)).collect();
    let own = assembly.parameters().len();
    let predictor = Predictor::new(assembly, observed, &used)?;
    let scans = || delays(predictor.points(), observed, assembly.parameters());
    let checks = training.checks.clone().map(|checks| AssessOptions { scans: scans(), ..checks });
    let training = &Training { checks, ..training.clone() };
    let heard_anything = used.iter().any(|u| !u.others.is_empty());
    let channels = if heard_anything {
        ChannelsOfModes::of(rig, training.channels.as_ref(), &training.microphones)
    } else {
        None
    };
    let parameters = parameters(assembly, &[], &[], channels.as_ref(), training)?;
    if let Some(channels) = &channels {
        observed.iter().zip(&mut used).for_each(|(o, u)| channels.take_from(o, u));
    }
    let (used, noise) = (&used, &training.noise);
    let heard = |inner, own| ThroughChannels::new(inner, own, channels.as_ref(), observed, used);
    let through = heard(&predictor as &dyn Forward, own);
    let fit = Fitting { assembly, training, model: &through, parameters: &parameters };
    let nothing = Assemblies::default();
    let blocks = Blocks { rig, observed, used, noise, scatter: &[], assemblies: &nothing };
    let (data, order) = blocks.apart()?;
    let mut search = training.search.clone();
    if let Some(start) = &mut search.start {
        // That of the model's own parameters is given.
        start.extend(parameters.list().iter().skip(start.len()).map(|p| p.prior.quantile(0.5)));
    }
    // A relative error of a law comes with those of the gas; the misfit of a law that was measured, always.
    let law = noise.law.as_ref().filter(|law| training.base_errors || law.added.is_some());
    let law = law.map(|error| LawErrors::of(assembly, error)).transpose()?.flatten();
    let law = law.filter(|_| !observed.is_empty());
    let of_factors = observed.iter().any(|o| !o.conditions.displaced.is_empty());
    // What earlier stages know of the causes of later ones goes through.
    let passes = training.causes.iter().any(|cause| training.knows(cause));
    let of_states = training.base_errors || passes;
    let drifts = noise.measured && observed.iter().any(|o| o.mode.drift_sd > 0.0);
    let errs = of_states || of_factors || drifts || law.is_some();
    if !errs && !any_varies(assembly, training) {
        return fit.finish(&data, order, search, observed.len());
    }
    let rough = fit.search(&data, order.clone(), &search)?;
    let values = &rough.parameters[..own];
    let mut scatter = Scatter::of(assembly, observed, used, training, values)?;
    let assemblies = match training.base_errors {
        true => Assemblies::of(observed, used, training, &scatter),
        false => Assemblies::default(),
    };
    for (k, scatter) in scatter.iter_mut().enumerate() {
        scatter.leave_out(|p| assemblies.knows(2 + k, &observed[p]));
    }
    let blocks = Blocks { scatter: &scatter, assemblies: &assemblies, ..blocks };
    if !errs {
        let (data, order) = blocks.apart()?;
        return fit.finish(&data, order, training.search.clone().from(&rough.parameters), observed.len());
    }
    let here = if of_factors { predictor.predict(values, Order::Value).ok() } else { None };
    let bends = here.map_or_else(Bends::default, |here| Bends::of(assembly, observed, used, values, &here));
    let channels = channels.as_ref();
    let with = WithErrors { assembly, predictor: &predictor, training, blocks, law, drifts, bends, channels };
    let trained = with.fit(&rough.parameters)?;
    // Other starts may have found a maximum that the fit without errors missed: then their effect is taken
    // there.
    if training.checks.is_none() || !trained.lies_elsewhere(&rough.parameters[..own]) {
        return Ok(trained);
    }
    let of_channels = &trained.values[trained.parameters.len() - (rough.parameters.len() - own)..];
    let from = [&trained.values[..own], of_channels].concat();
    match fit.search(&data, order, &training.search.clone().from(&from)) {
        Ok(better) if better.cost < rough.cost - BETTER => with.fit(&better.parameters),
        _ => Ok(trained),
    }
}
