//! Fits of one training: its parameters with what earlier stages know, the search, and what follows from its
//! end.

use crate::errors::{ChannelsOfModes, Learned, OF_INSTALLATION};
use crate::gaussian::Training;
use crate::predictor::Reordered;
use crate::trained::{OfSeveral, Trained};
use crate::{Assembly, EngineError};
use rijke_inference::{
    AssessOptions, Data, Evidence, Fit, Forward, Laplace, Linearised, MapOptions, Parameter, Parameters,
    Posterior,
};
use rijke_numerics::{Matrix, Order};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Most maxima of a delay beside the best that are named, and how many nats lower they lie at most.
const NAMED: (usize, f64) = (2, 50.0);
/// Odds below which another maximum is improbable.
const IMPROBABLE: f64 = 0.01;

/// What the fits of one training share.
pub(crate) struct Fitting<'a> {
    pub(crate) assembly: &'a Assembly,
    pub(crate) training: &'a Training,
    pub(crate) model: &'a dyn Forward,
    pub(crate) parameters: &'a Parameters,
}

impl Fitting<'_> {
    /// The most probable parameters. Second derivatives of the model cost several times the first and change
    /// the path of the search, not its end: a Newton search is done without them.
    pub(crate) fn search(
        &self,
        data: &Data,
        order: Vec<usize>,
        options: &MapOptions,
    ) -> Result<Fit, EngineError> {
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

    /// The model and its data to first order about `fit`, with first derivatives alone.
    pub(crate) fn linearised(
        &self,
        data: &Data,
        order: Vec<usize>,
        fit: &Fit,
    ) -> Result<(Laplace, Linearised), EngineError> {
        let quick = Reordered { inner: self.model, order, highest: Order::First };
        let posterior = Posterior::new(&quick, data, self.parameters)?;
        let laplace = posterior.laplace_of_likelihood(fit)?;
        let linear = posterior.linearised(fit, &laplace)?;
        Ok((laplace, linear))
    }

    /// The fit that counts, and what follows from it; the evidence is per observation, of which there are
    /// `points`.
    pub(crate) fn finish(
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

/// The parameters of the model, those of the base states that all installations share, and those of the
/// channels, with what earlier stages know; `renamed` are causes of error, as they are called there and here.
pub(crate) fn parameters(
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
