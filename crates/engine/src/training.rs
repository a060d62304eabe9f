//! From observations to the most probable parameters and the evidence.

use crate::data::{Blocks, in_one_block};
use crate::delays::delays;
use crate::errors::{
    Assemblies, Bends, Carried, ChannelsOfModes, Common, LawErrors, Learned, OF_INSTALLATION, PointErrors,
    Scatter, ThroughChannels, any_varies, changes_by_factors_of, of_drift,
};
use crate::gaussian::Training;
use crate::observed::{Observed, Used};
use crate::predictor::{Predictor, Reordered};
use crate::trained::{OfSeveral, Trained};
use crate::{Assembly, EngineError};
use rijke_inference::{
    AssessOptions, Data, Evidence, Fit, Forward, Laplace, MapOptions, Parameter, Parameters, Posterior,
};
use rijke_numerics::{Matrix, Order};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Most maxima of a delay beside the best that are named, and how many nats lower they lie at most.
const NAMED: (usize, f64) = (2, 50.0);
/// Odds below which another maximum is improbable.
const IMPROBABLE: f64 = 0.01;

/// It has missed one if that search ends more nats lower than this.
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
    let scatter = Scatter::of(assembly, observed, used, training, values)?;
    let assemblies = match training.base_errors {
        true => Assemblies::of(observed, used, training, &scatter),
        false => Assemblies::default(),
    };
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

/// A training with errors of the base states, of factors, of drifts and of laws.
struct WithErrors<'a> {
    assembly: &'a Assembly,
    predictor: &'a Predictor<'a>,
    training: &'a Training,
    blocks: Blocks<'a>,
    law: Option<LawErrors>,
    /// Whether pings that drift have errors of it.
    drifts: bool,
    bends: Bends<'a>,
    channels: Option<&'a ChannelsOfModes>,
}

impl WithErrors<'_> {
    /// The fit with the effect of the errors taken at `at`, parameters of the model and then of the channels.
    fn fit(&self, at: &[f64]) -> Result<Trained, EngineError> {
        let (training, channels, bends) = (self.training, self.channels, &self.bends);
        let Blocks { observed, used, assemblies, .. } = self.blocks;
        let assembly = self.assembly;
        let own = assembly.parameters().len();
        let (values, of_channels) = at.split_at(own);
        let (common, errors) = Common::of(self.errors_at(values)?, observed, used, training, bends)?;
        let alone = !training.base_errors && errors.is_none();
        let (data, order) = if alone { self.blocks.apart() } else { self.blocks.together(&errors) }?;
        let shared = [common.parameters(), assemblies.parameters()].concat();
        let slopes = assemblies.behind(common.slopes());
        let parameters = parameters(assembly, &shared, &common.known(), channels, training)?;
        let bent = bends.placed(used, |cause| common.direction_of(cause));
        let carried = Carried { inner: self.predictor, own, slopes: &slopes, bends: &bent };
        let through = ThroughChannels::new(&carried, own + shared.len(), channels, observed, used);
        let start = [values, &vec![0.0; shared.len()], of_channels].concat();
        let options = training.search.clone().from(&start);
        let fitting = Fitting { assembly, training, model: &through, parameters: &parameters };
        let trained = fitting.finish(&data, order, options, observed.len())?;
        let Trained { linear, noise, parameters, values, covariance, .. } = &trained;
        let learned = assemblies.learned(linear, noise, (&**parameters, &**values, covariance));
        let (for_predictions, told) = self.told(&common, &errors, &trained);
        let mut warnings = common.explained(trained.warnings);
        warnings.extend(bends.warning());
        let trained = Trained { learned, told, warnings, common: Some(for_predictions), ..trained };
        let causes = common.learned(&training.causes, own, &trained.gaussian());
        Ok(Trained { causes, ..trained })
    }

    /// The errors with their effect at `values` of the model's parameters.
    fn errors_at(&self, values: &[f64]) -> Result<PointErrors, EngineError> {
        let Blocks { observed, used, .. } = self.blocks;
        let assembly = self.assembly;
        let errors = match self.training.base_errors {
            true => PointErrors::new(assembly, observed, used, values)?,
            false => PointErrors::none(observed.len()),
        };
        let errors = match &self.law {
            Some(law) => errors.and(law.changes(observed, used, values)?),
            None => errors,
        };
        let errors = errors.and(changes_by_factors_of(assembly, observed, used, values)?);
        Ok(if self.drifts { errors.and(of_drift(observed, used)) } else { errors })
    }

    /// What the data tell of `errors` that several points share and that stayed a covariance, and `common`
    /// with these.
    fn told(&self, common: &Common, errors: &PointErrors, trained: &Trained) -> (Common, OfSeveral) {
        let Blocks { observed, used, .. } = self.blocks;
        let (linear, order) = &*trained.linear;
        let one_block = in_one_block(errors, observed, used);
        let (_, apart) =
            errors.of_several(observed, used, order, |p| if one_block[p] { 0 } else { usize::MAX });
        let (of_several, columns) =
            errors.of_several(observed, used, order, |p| if one_block[p] { usize::MAX } else { 2 });
        let (for_predictions, names) = common.with(of_several);
        let of_parameters = (&*trained.parameters, &*trained.values, &trained.covariance);
        let learned = Learned::of(linear, names, &columns, &vec![1.0; columns.len()], of_parameters);
        (for_predictions, OfSeveral { learned, columns, apart })
    }
}

/// The parameters of the model, those of the base states that all installations share, and those of the
/// channels, with what earlier stages know; `renamed` are causes of error, as they are called there and here.
fn parameters(
    assembly: &Assembly,
    common: &[Parameter],
    renamed: &[[String; 2]],
    channels: Option<&ChannelsOfModes>,
    training: &Training,
) -> Result<Parameters, EngineError> {
    let all = assembly.parameters().iter().chain(common).chain(channels.iter().flat_map(|c| &c.parameters));
    let mut parameters = Parameters::new(all.cloned().collect())?;
    if let Some(channels) = channels {
        parameters = channels.prior(parameters, training)?;
    }
    // Not the directions of base states, which are others in each training.
    let shared = channels.iter().flat_map(|c| &c.parameters);
    let assemblies = common.iter().filter(|p| training.known.iter().any(|k| k.names.contains(&p.name)));
    let assemblies = assemblies.filter(|p| p.name.contains(OF_INSTALLATION));
    let shared = shared.chain(assemblies);
    let handed_on: Vec<&str> = assembly.parameters().iter().chain(shared).map(|p| p.name.as_str()).collect();
    let mut renamed: BTreeMap<&str, &str> =
        renamed.iter().map(|[there, here]| (there.as_str(), here.as_str())).collect();
    for known in &training.known {
        // A cause of which two of them tell is that of the first.
        let here = |name: &'_ String| match handed_on.iter().find(|n| *n == name) {
            Some(own) => Some(*own),
            None => renamed.remove(name.as_str()),
        };
        let (keep, names): (Vec<usize>, Vec<&str>) = {
            let here = known.names.iter().map(here);
            here.enumerate().filter_map(|(k, name)| Some((k, name?))).unzip()
        };
        if !keep.is_empty() {
            let mean: Vec<f64> = keep.iter().map(|&k| known.mean[k]).collect();
            parameters = parameters.with_physical_joint(&names, &mean, &known.covariance.select(&keep))?;
        }
    }
    Ok(parameters)
}

/// What the fits of one training share.
struct Fitting<'a> {
    assembly: &'a Assembly,
    training: &'a Training,
    model: &'a dyn Forward,
    parameters: &'a Parameters,
}

impl Fitting<'_> {
    /// The most probable parameters. Second derivatives of the model cost several times the first and change
    /// the path of the search, not its end: a Newton search is done without them.
    fn search(&self, data: &Data, order: Vec<usize>, options: &MapOptions) -> Result<Fit, EngineError> {
        let quick = Reordered { inner: self.model, order, highest: Order::First };
        let fit = Posterior::new(&quick, data, self.parameters)?.map(options)?;
        if fit.stop.converged() {
            return Ok(fit);
        }
        // From where residuals are next to nothing a noise that floats may run to nothing, and never end.
        if options.start.is_some() {
            let middle = MapOptions { start: None, ..options.clone() };
            let again = Posterior::new(&quick, data, self.parameters)?.map(&middle)?;
            if again.stop.converged() {
                return Ok(again);
            }
        }
        Err(EngineError::NotConverged { model: self.assembly.ids().join(" + "), stop: fit.stop })
    }

    /// The fit that counts, and what follows from it; the evidence is per observation, of which there are
    /// `points`.
    fn finish(
        &self,
        data: &Data,
        order: Vec<usize>,
        options: MapOptions,
        points: usize,
    ) -> Result<Trained, EngineError> {
        let exact = Reordered { inner: self.model, order: order.clone(), highest: Order::Second };
        let posterior = Posterior::new(&exact, data, self.parameters)?;
        let mut elsewhere = Vec::new();
        let (fit, laplace, summed, warnings, sampler) = match &self.training.checks {
            None => (self.search(data, order.clone(), &options)?, None, None, Vec::new(), None),
            Some(checks) => {
                let starts = options.start.into_iter().chain(checks.starts.iter().cloned()).collect();
                let found = posterior.assess(&AssessOptions { starts, ..checks.clone() })?;
                let own = self.assembly.parameters().len();
                let odds = |share: f64| share / found.maxima[0].share;
                let others = found.maxima.iter().skip(1).filter(|m| odds(m.share) >= IMPROBABLE);
                elsewhere.extend(others.map(|m| (odds(m.share), m.fit.parameters[..own].to_vec())));
                let mut health = found.health;
                // Where the checks refuse Laplace's evidence, a sampler that was asked and ended has it.
                let evidence = match (found.evidence, &found.laplace, &health.sampler) {
                    (Ok(evidence), ..) => Some(evidence),
                    (Err(_), Ok(laplace), Some(by)) if by.finished => Some(Evidence {
                        ln_marginal: by.ln_marginal,
                        ln_occam: by.ln_marginal - laplace.evidence.ln_best_fit,
                        ..laplace.evidence
                    }),
                    (Err(why), Ok(_), _) => {
                        let model = self.assembly.ids().join(" + ");
                        return Err(EngineError::NoEvidence { model, why });
                    }
                    (Err(_), Err(_), _) => None,
                };
                if !checks.scans.is_empty() {
                    // One whose parameters are those of the best differs by a noise that floats.
                    let near = health
                        .other_modes
                        .iter()
                        .filter(|other| other.below < NAMED.1 && !other.is_heavy() && other.is_elsewhere());
                    health.warnings.extend(near.take(NAMED.0).map(ToString::to_string));
                }
                (found.fit, found.laplace.ok(), evidence, health.warnings, health.sampler)
            }
        };
        let laplace: Laplace = laplace.map_or_else(|| posterior.laplace(&fit), Ok)?;
        let linear = posterior.linearised(&fit, &laplace)?;
        let few = linear.few();
        let wide = |i: usize, j: usize| few.parameters[i] * few.parameters[j];
        let covariance = &laplace.physical_covariance;
        let covariance =
            Matrix::from_fn(covariance.rows(), covariance.columns(), |i, j| wide(i, j) * covariance[(i, j)]);
        let mut noise = fit.noise;
        few.noises.iter().for_each(|(g, few)| noise[*g].few = Some(*few));
        let linear = Arc::new((linear, order));
        // Blocks of data may hold several operating points or parts of one; all maxima that were found count.
        let evidence = Evidence { datapoints: points, ..summed.unwrap_or(laplace.evidence) };
        Ok(Trained {
            parameters: self.parameters.list().to_vec(),
            own: self.assembly.parameters().len(),
            common: None,
            learned: Learned::default(),
            causes: Learned::default(),
            told: OfSeveral::default(),
            values: fit.parameters,
            covariance,
            noise: noise.into_iter().chain(self.training.noise.of_the_law()).collect(),
            evidence,
            stop: fit.stop,
            linear,
            warnings,
            sampler,
            elsewhere,
            calls: fit.calls,
        })
    }
}
