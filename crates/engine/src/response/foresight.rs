//! What responses can tell of the parameters, to first order at the centre of the priors.

use super::data::Blocks;
use super::head::Heard;
use super::predict::{Responses, Told};
use super::record::{ForeseenModel, ResponseForesight};
use super::select::Selected;
use super::stage::ResponseRun;
use crate::{Assembly, EngineError};
use rijke_inference::{Objective, Parameters, Posterior};
use rijke_numerics::{Cholesky, Jet, Order};
use rijke_study::ErrorTerm;
use rijke_study::plan::SdSpec;
use rijke_study::responses::ResponseStage;
use std::collections::BTreeMap;

/// Noise of the real and of the imaginary part where the study leaves it to the data.
const NOISE: f64 = 0.01;
/// Errors of a head where the study leaves their size to the data.
const HEAD: f64 = 0.05;

impl ResponseRun {
    /// For every model of every stage which parameters the responses tell, with the priors of the candidates, not those of earlier stages.
    ///
    /// # Errors
    /// [`EngineError`] for models that cannot be built. A model that has no answer at the centre of its priors is said.
    pub fn foresight(&self) -> Result<Vec<ResponseForesight>, EngineError> {
        let mut chosen: BTreeMap<String, BTreeMap<String, String>> = BTreeMap::new();
        let mut all = Vec::new();
        for stage in &self.study.plan.responses {
            let data = Selected::new(&self.study, &self.observed, stage)?;
            let rows = self.rows(stage, &chosen);
            let mut models = Vec::new();
            for row in &rows {
                let (assembly, errors) = self.assembled(stage, row)?;
                let responses = self.models(&assembly, &data)?;
                let id = row.own.iter().map(|c| c.id.as_str()).collect::<Vec<_>>().join(" + ");
                let (widths, remark) = match widths(stage, &data, &assembly, &responses, &errors) {
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

fn widths(
    stage: &ResponseStage,
    data: &Selected,
    assembly: &Assembly,
    responses: &Responses<'_>,
    errors: &[ErrorTerm],
) -> Result<Vec<(String, f64)>, EngineError> {
    let fixed = |sd: &SdSpec, floated: f64| SdSpec::Fixed(taken(sd, floated));
    let errors: Vec<ErrorTerm> =
        errors.iter().map(|term| ErrorTerm { sd: fixed(&term.sd, HEAD), ..term.clone() }).collect();
    let noise = fixed(&stage.noise, NOISE);
    let misfit = stage.misfit.clone().map(|m| {
        let length_hz = fixed(&m.length_hz, 100.0);
        rijke_study::responses::MisfitSpec { size: fixed(&m.size, NOISE), length_hz, ..m }
    });
    let parameters = Parameters::new(assembly.parameters().to_vec())?;
    let centre = parameters.centre();
    let answers = responses.answers(&parameters.physical(&centre), Order::Value)?;
    let mut heard = Heard::about_data(&data.measured, &errors);
    heard.about = answers.iter().map(|a| a.iter().map(Jet::value).collect()).collect();
    let blocks = Blocks {
        measured: &data.measured,
        errors: &errors,
        heard: &heard,
        noise: &noise,
        misfit: misfit.as_ref(),
    };
    let all = blocks.data()?;
    let told = Told { responses, heard: &heard, highest: Order::First };
    let energy = Posterior::new(&told, &all, &parameters)?.evaluate(&centre, Order::First)?;
    let Some(hessian) = energy.gauss_newton else { return Ok(Vec::new()) };
    let covariance = Cholesky::new(&hessian)?.inverse();
    let width =
        |(i, scale): (usize, &f64)| (parameters.list()[i].name.clone(), covariance[(i, i)].sqrt() / scale);
    Ok(parameters.scales().iter().enumerate().map(width).collect())
}
