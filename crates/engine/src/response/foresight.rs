//! What responses can tell of the parameters, to first order at the centre of the priors and half a standard
//! deviation beside it.

use super::data::Blocks;
use super::errors::Errors;
use super::head::HeardResponses;
use super::predict::{Responses, Told};
use super::record::{ForeseenModel, ResponseForesight};
use super::rows::rows_of;
use super::select::Selected;
use super::stage::{ResponseRun, enough, unlearned};
use crate::EngineError;
use rijke_inference::{Objective, Parameters, Posterior};
use rijke_numerics::{Cholesky, Jet, Order};
use rijke_study::ErrorTerm;
use rijke_study::plan::SdSpec;
use rijke_study::responses::{MisfitSpec, ResponseStage};
use std::collections::{BTreeMap, BTreeSet};

/// Noise of the real and of the imaginary part where the study leaves it to the data.
const NOISE: f64 = 0.01;
/// Errors of a head where the study leaves their size to the data.
const HEAD: f64 = 0.05;

impl ResponseRun {
    /// For every model of every stage which parameters the responses tell, with the priors of the candidates,
    /// not those of earlier stages.
    ///
    /// # Errors
    /// [`EngineError`] for models that cannot be built. A model that has no answer at the centre of its
    /// priors is said.
    pub fn foresight(&self) -> Result<Vec<ResponseForesight>, EngineError> {
        let none = BTreeSet::new();
        let mut chosen: BTreeMap<String, BTreeMap<String, String>> = BTreeMap::new();
        let mut all = Vec::new();
        for stage in &self.study.plan.responses {
            let data = Selected::new(&self.study, &self.observed, stage)?;
            let rows = rows_of(&self.study, stage, &chosen);
            let stated = Errors::of(&self.study, &data.points, &[])?.parameters();
            let mut models = Vec::new();
            for row in &rows {
                let (assembly, errors) = self.assembled(stage, row)?;
                enough(stage, row, &assembly, &data)?;
                let responses = self.models(stage, &assembly, &data)?;
                let parameters = responses.channels.prior(unlearned(&assembly, &responses)?, &none)?;
                let id = row.id();
                let about = |values: &[f64]| self.about(&assembly, &data, &responses, values);
                let of =
                    Model { parameters: &parameters, responses: &responses, errors: &errors, about: &about };
                let (widths, remark) = match widths(stage, &data, &of) {
                    Ok(widths) => (widths, None),
                    Err(error) => (Vec::new(), Some(error.to_string())),
                };
                models.push(ForeseenModel { id, widths, remark });
            }
            chosen.extend(rows.first().map(|row| (stage.id.clone(), row.choice.clone())));
            all.push(ResponseForesight {
                id: stage.id.clone(),
                title: if stage.title.is_empty() { stage.id.clone() } else { stage.title.clone() },
                responses: data.measured.len(),
                numbers: data.numbers(),
                of: data.rows.iter().sum(),
                noise: taken(&stage.noise, NOISE),
                errors: stated.into_iter().map(|p| p.name).collect(),
                models,
            });
        }
        Ok(all)
    }
}

/// The standard deviation that stands for one that is stated, inferred or floated.
fn taken(sd: &SdSpec, floated: f64) -> f64 {
    match sd {
        SdSpec::Fixed(sd) => *sd,
        SdSpec::Inferred { median, .. } => *median,
        SdSpec::Floated | SdSpec::Like { .. } => floated,
    }
}

/// A model of a stage.
struct Model<'a, 'r> {
    parameters: &'a Parameters,
    responses: &'a Responses<'r>,
    /// Errors of its head.
    errors: &'a [ErrorTerm],
    /// The responses, with the errors of what is stated taken about values of all parameters.
    about: &'a dyn Fn(&[f64]) -> Result<Responses<'r>, EngineError>,
}

fn widths(
    stage: &ResponseStage,
    data: &Selected,
    model: &Model<'_, '_>,
) -> Result<Vec<(String, f64)>, EngineError> {
    let Model { parameters, responses, .. } = model;
    let fixed = |sd: &SdSpec, floated: f64| SdSpec::Fixed(taken(sd, floated));
    let errors: Vec<ErrorTerm> =
        model.errors.iter().map(|term| ErrorTerm { sd: fixed(&term.sd, HEAD), ..term.clone() }).collect();
    let noise = fixed(&stage.noise, NOISE);
    let misfit = stage.misfit.clone().map(|m| {
        let length_hz = fixed(&m.length_hz, 100.0);
        MisfitSpec { size: fixed(&m.size, NOISE), length_hz, ..m }
    });
    // Where a gain is nothing at the centre, what it multiplies cannot be told there: beside it, too.
    let mut least: Vec<f64> = vec![f64::INFINITY; parameters.len()];
    for beside in [0.0, 0.5, -0.5] {
        let z = parameters.from_standard_normal(&vec![beside; parameters.len()]);
        let values = parameters.physical(&z);
        let there = if responses.errors.is_none() { None } else { Some((model.about)(&values)?) };
        let at = Model { responses: there.as_ref().unwrap_or(responses), errors: &errors, ..*model };
        let found = widths_at(data, &noise, misfit.as_ref(), &at, &values)?;
        least.iter_mut().zip(found).for_each(|(least, w)| *least = least.min(w));
    }
    // What the channels do, and what errors of the campaign are, is not asked for here.
    Ok(parameters.list().iter().map(|p| p.name.clone()).zip(least).take(responses.own).collect())
}

/// Standard deviations that the responses leave at `values`, over those of the priors.
fn widths_at(
    data: &Selected,
    noise: &SdSpec,
    misfit: Option<&MisfitSpec>,
    model: &Model<'_, '_>,
    values: &[f64],
) -> Result<Vec<f64>, EngineError> {
    let Model { parameters, responses, errors, .. } = *model;
    let answers = responses.answers(values, Order::Value)?;
    let about: Vec<Vec<_>> = answers.iter().map(|a| a.iter().map(Jet::value).collect()).collect();
    let mut heard = HeardResponses::about_data(&data.measured, errors, about.clone())?;
    heard.about = about;
    let all = Blocks { measured: &data.measured, errors, heard: &heard, noise, misfit }.data()?;
    let told = Told { responses, measured: &data.measured, heard: &heard, highest: Order::First };
    let posterior = Posterior::new(&told, &all, parameters)?;
    let energy = posterior.evaluate(&parameters.working(values), Order::First)?;
    let Some(hessian) = energy.gauss_newton else { return Ok(Vec::new()) };
    let covariance = Cholesky::new(&hessian)?.inverse();
    Ok(parameters.scales().iter().enumerate().map(|(i, scale)| covariance[(i, i)].sqrt() / scale).collect())
}
