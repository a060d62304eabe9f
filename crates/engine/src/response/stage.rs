//! Stages of responses, run in order: candidates trained on the same responses and ranked.

use super::aliases::{aliased, with_aliases};
use super::channels::ChannelsOfResponses;
use super::errors::Errors;
use super::ground::{Ground, Learned, law_error};
use super::head::Rest;
use super::measured::Measured;
use super::mistaken::mistaken;
use super::noise::{in_parts, left_by_the_fit, settled, ways, with_the_noise_asked_for};
use super::predict::Responses;
use super::record::{LoadRecord, ResponseModelRecord, ResponseStageRecord};
use super::residual::left;
use super::rows::rows_of;
use super::select::{self, Selected};
use super::train::ResponseTraining;
use super::untold::untold;
use crate::gaussian::handed_on;
use crate::rows::Row;
use crate::run::{EvidenceRecord, TrainedParameter, add_lines};
use crate::{Assembly, EngineError, NamedGaussian};
use rayon::prelude::*;
use rijke_inference::{Parameter, Parameters, student};
use rijke_numerics::{C64, InOrder, TwoPart};
use rijke_study::plan::SdSpec;
use rijke_study::responses::{ResponseKind, ResponseStage, Responses as Observed};
use rijke_study::{Candidate, Cause, ErrorTerm, Study};
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// A study with its responses, and what has been trained of it so far.
pub struct ResponseRun {
    pub(super) study: Study,
    pub(super) observed: Observed,
    /// What every stage before found.
    known: BTreeMap<String, Before>,
    grounds: Vec<Ground>,
}

/// What a stage before found.
struct Before {
    /// The candidates that it chose.
    choice: BTreeMap<String, String>,
    /// Their parameters, and errors by their causes.
    known: NamedGaussian,
    /// Those causes.
    causes: Vec<Cause>,
}

impl ResponseRun {
    /// A study with its responses, and with the ambient temperatures that were read with them.
    ///
    /// # Errors
    /// [`EngineError::NoPoint`], and [`EngineError::Refused`] for a stage that counts the data of one on
    /// which it stands again.
    pub fn new(mut study: Study, observed: Observed) -> Result<Self, EngineError> {
        study.campaign.take_ambient(&observed.ambient);
        select::check(&study, &observed)?;
        Ok(Self { study, observed, known: BTreeMap::new(), grounds: Vec::new() })
    }

    /// Runs the next stage; none after the last.
    ///
    /// # Errors
    /// [`EngineError::NoPoint`], [`EngineError::NoWinner`]. A model that cannot be
    /// fitted is a row without evidence.
    pub fn next_stage(&mut self) -> Result<Option<ResponseStageRecord>, EngineError> {
        self.next_stage_with(&|| ())
    }

    /// As [`ResponseRun::next_stage`]; calls `trained` after every model.
    ///
    /// # Errors
    /// Those of [`ResponseRun::next_stage`].
    pub fn next_stage_with(
        &mut self,
        trained: &(dyn Fn() + Sync),
    ) -> Result<Option<ResponseStageRecord>, EngineError> {
        let Some(stage) = self.study.plan.responses.get(self.grounds.len()).cloned() else { return Ok(None) };
        let data = Selected::new(&self.study, &self.observed, &stage)?;
        let chosen = self.known.iter().map(|(id, before)| (id.clone(), before.choice.clone())).collect();
        let rows = rows_of(&self.study, &stage, &chosen);
        if rows.is_empty() {
            let problem = "every candidate that competes extends one that is in none of its models: name that one in `with`, or in a stage \
                           on which this one stands";
            return Err(EngineError::Refused { stage: stage.id, problem: problem.to_owned() });
        }
        let one = |row| {
            let found = self.row(&stage, row, &data, None);
            trained();
            found
        };
        let trained: (Vec<_>, Vec<Option<Learned>>) =
            rows.par_iter().map(one).in_order::<Result<_, EngineError>>()?;
        let again = |k: usize, noise: &TwoPart, heard: &[Vec<C64>]| {
            self.row(&stage, &rows[k], &data, Some((noise, heard)))
        };
        let (mut models, found) =
            with_the_noise_asked_for(&stage, (&data.measured, ways(&data.whats)), trained, &again)?;
        let best = (0..models.len())
            .filter(|k| found[*k].is_some())
            .max_by(|a, b| models[*a].ln_evidence().total_cmp(&models[*b].ln_evidence()));
        let Some(best) = best else {
            let remark = models.iter().find_map(|m| m.remark.clone()).unwrap_or_default();
            return Err(EngineError::NoWinner { stage: stage.id, remark });
        };
        if let Some(learned) = &found[best] {
            // Of the best model alone: it is a matter of the data.
            let said = self.turned_time(&stage, &rows[best], &data, (&models[best], learned))?;
            add_lines(&mut models[best].remark, said);
            let (choice, known, causes) =
                (rows[best].choice.clone(), learned.known.clone(), learned.causes.clone());
            self.known.insert(stage.id.clone(), Before { choice, known, causes });
        }
        let load = |((m, what), rows): ((&Measured, &ResponseKind), &usize)| LoadRecord {
            point: m.label.clone(),
            what: what.name().to_owned(),
            of: *rows,
            frequency_hz: m.frequency_hz.clone(),
            measured: pairs(&m.values),
        };
        let record = ResponseStageRecord {
            id: stage.id.clone(),
            title: if stage.title.is_empty() { stage.id.clone() } else { stage.title.clone() },
            loads: data.measured.iter().zip(&data.whats).zip(&data.rows).map(load).collect(),
            winner: models[best].id.clone(),
            models,
            decides: stage.decides,
        };
        let before = self.grounds.iter().filter(|g| stage.on.contains(&g.id));
        let assumes = |g: &Ground| {
            g.assumes.iter().cloned().chain(g.models.first().and_then(|m| g.undecided(m))).collect::<Vec<_>>()
        };
        let assumes = before.flat_map(assumes).collect();
        self.grounds.push(Ground::of(&record, found, assumes));
        Ok(Some(record))
    }

    /// How many models its stages train, all together, if the first of each goes on.
    #[must_use]
    pub fn models_of_all(&self) -> usize {
        let mut chosen = BTreeMap::new();
        let count = |stage: &ResponseStage| {
            let rows = rows_of(&self.study, stage, &chosen);
            chosen.extend(rows.first().map(|row| (stage.id.clone(), row.choice.clone())));
            rows.len()
        };
        self.study.plan.responses.iter().map(count).sum()
    }

    /// What the stages that have run found, for stages of modes that stand on them.
    #[must_use]
    pub fn grounds(&self) -> Vec<Ground> {
        self.grounds.clone()
    }

    fn row(
        &self,
        stage: &ResponseStage,
        row: &Row,
        data: &Selected,
        noise: Option<(&TwoPart, &[Vec<C64>])>,
    ) -> Result<(ResponseModelRecord, Option<Learned>), EngineError> {
        let mut measured = Cow::Borrowed(&data.measured[..]);
        let mut record = untrained(row);
        let (assembly, errors) = self.assembled(stage, row)?;
        enough(stage, row, &assembly, data)?;
        let responses = self.models(stage, &assembly, data)?;
        let parameters = self.parameters(stage, &assembly, &responses)?;
        let aliases = aliased(&responses, &parameters, &self.told_before(stage))?;
        let parameters = with_aliases(parameters, &aliases)?;
        let starts: Vec<Vec<f64>> = aliases.iter().flat_map(|a| a.starts.clone()).collect();
        let training = ResponseTraining {
            responses: &responses,
            measured: &data.measured,
            errors: &errors,
            parameters: &parameters,
            stage,
            starts: &starts,
        };
        let about = |at: &[f64]| self.about(&assembly, data, &responses, at);
        let outcome = match noise {
            None => training.of_a_row(&about),
            Some((noise, heard)) => {
                settled(&training, noise, heard, &about).map(|(scaled, at_last, found)| {
                    measured = Cow::Owned(scaled);
                    (at_last, found)
                })
            }
        };
        let (at_last, found) = match outcome {
            Ok(found) => found,
            Err(error) => {
                record.remark = Some(error.to_string());
                return Ok((record, None));
            }
        };
        let measured = &measured[..];
        let training =
            ResponseTraining { responses: at_last.as_ref().unwrap_or(&responses), measured, ..training };
        let (fit, laplace, evidence) = (&found.fit, &found.laplace, found.evidence);
        let mut remarks = found.warnings.clone();
        record.evidence = Some(EvidenceRecord {
            ln_best_fit: evidence.ln_best_fit,
            ln_occam: evidence.ln_occam,
            ln_marginal: evidence.ln_marginal,
            observations: measured.iter().map(|m| m.values.len()).sum(),
        });
        let covariance = &laplace.physical_covariance;
        let parameter = |(i, p): (usize, &Parameter)| {
            TrainedParameter::of(p, fit.parameters[i], covariance[(i, i)].sqrt())
        };
        record.parameters = parameters.list().iter().enumerate().map(parameter).collect();
        TrainedParameter::tie(&mut record.parameters, covariance);
        record.errors = responses.errors.causes.len();
        record.channels = responses.channels.parameters.len();
        record.noise = noise.map_or_else(|| fit.noise.clone(), |(noise, _)| in_parts(&fit.noise, noise));
        record.maxima.clone_from(&found.maxima);
        remarks.extend(aliases.iter().map(ToString::to_string));
        let rest = Rest { noise: &fit.noise, kernel: stage.misfit.as_ref().map(|m| m.kernel) };
        if let Some(at_last) = &at_last {
            remarks.extend(self.bent(&assembly, data, at_last, &found, rest)?);
        }
        let left = left(measured, found.heard.clone(), rest);
        record.too_sure = left.too_sure();
        let names = &self.study.rig.microphones.names;
        let mistaken = || mistaken(&training, data, names, [evidence.ln_marginal, left.share]);
        remarks.extend(left.remarks(stage, measured, &mistaken));
        let told = record.parameters.iter().filter(|p| !p.is_as_before()).count();
        let numbers: usize = measured.iter().map(|m| 2 * m.values.len()).sum();
        remarks.extend(few(numbers, told).filter(|_| !matches!(stage.noise, SdSpec::Fixed(_))));
        remarks.extend(untold(&record.parameters[..assembly.parameters().len()], data));
        record.predicted = found.answers.iter().map(|a| pairs(a)).collect();
        record.heard = left.heard.iter().map(|a| pairs(a)).collect();
        (record.residual, record.neighbours) = (left.size, left.neighbours);
        record.remark = Some(remarks.join("\n")).filter(|r| !r.is_empty());
        let names = parameters.list().iter().map(|p| responses.errors.handed_on(&p.name)).collect();
        let known = NamedGaussian {
            names,
            mean: fit.parameters.clone(),
            covariance: laplace.physical_covariance.clone(),
        };
        let law = law_error(&self.study, &row.choice, &responses.loads, measured, &fit.noise);
        let causes = responses.errors.causes.clone();
        let undescribed = left.undescribed(stage);
        let nearly_right = left.nearly_right();
        let left = left_by_the_fit(&training, &found)?;
        let (share, beside) = (found.share, found.beside);
        Ok((record, Some(Learned { known, causes, share, beside, law, undescribed, left, nearly_right })))
    }

    /// Names of what earlier stages tell.
    fn told_before(&self, stage: &ResponseStage) -> BTreeSet<&str> {
        let told = stage.on.iter().filter_map(|id| self.known.get(id));
        told.flat_map(|before| before.known.names.iter().map(String::as_str)).collect()
    }

    /// The model of a row, and the errors of its head.
    pub(super) fn assembled(
        &self,
        stage: &ResponseStage,
        row: &Row,
    ) -> Result<(Assembly, Vec<ErrorTerm>), EngineError> {
        let candidates: Vec<Candidate> =
            row.choice.values().filter_map(|id| self.study.catalogue.get(id).cloned()).collect();
        let errors = candidates.iter().flat_map(|c| c.errors.clone()).collect();
        Ok((Assembly::new(Arc::new(self.study.rig.clone()), candidates, &stage.hold)?, errors))
    }

    pub(super) fn parameters(
        &self,
        stage: &ResponseStage,
        assembly: &Assembly,
        responses: &Responses<'_>,
    ) -> Result<Parameters, EngineError> {
        let mut parameters = unlearned(assembly, responses)?;
        let mut earlier = BTreeSet::new();
        for Before { known, causes, .. } in stage.on.iter().filter_map(|id| self.known.get(id)) {
            let here: Vec<String> = known.names.iter().map(|name| responses.errors.here(name)).collect();
            // A cause of which two of them tell is that of the first.
            let twice = |name: &String| {
                causes.iter().any(|c| handed_on(c) == *name) && earlier.contains(name.as_str())
            };
            let has = |k: &usize| parameters.index(&here[*k]).is_some() && !twice(&known.names[*k]);
            let keep: Vec<usize> = (0..known.names.len()).filter(has).collect();
            earlier.extend(known.names.iter().map(String::as_str));
            if !keep.is_empty() {
                let names: Vec<&str> = keep.iter().map(|&k| here[k].as_str()).collect();
                let mean: Vec<f64> = keep.iter().map(|&k| known.mean[k]).collect();
                parameters =
                    parameters.with_physical_joint(&names, &mean, &known.covariance.select(&keep))?;
            }
        }
        Ok(responses.channels.prior(parameters, &earlier)?)
    }

    pub(super) fn models<'a>(
        &self,
        stage: &ResponseStage,
        assembly: &'a Assembly,
        data: &Selected,
    ) -> Result<Responses<'a>, EngineError> {
        let before = stage.on.iter().filter_map(|id| self.known.get(id));
        let known: Vec<Cause> = before.flat_map(|before| before.causes.iter().cloned()).collect();
        let errors = Errors::of(&self.study, &data.points, &known)?;
        let loads = self.loads(assembly, data, &errors)?;
        let channels = ChannelsOfResponses::of(&self.study, stage, &data.whats, &data.points)?;
        Ok(Responses { loads, own: assembly.parameters().len(), errors, channels })
    }
}

/// Refuses a model with more free parameters than real numbers train it.
pub(super) fn enough(
    stage: &ResponseStage,
    row: &Row,
    assembly: &Assembly,
    data: &Selected,
) -> Result<(), EngineError> {
    let (numbers, free) = (2 * data.numbers(), assembly.parameters().len());
    if numbers >= free {
        return Ok(());
    }
    let problem = format!(
        "the model of `{}` has {free} free parameters, and {numbers} real numbers train it: take more frequencies (`band_hz`, `step_hz`), \
         or hold parameters",
        row.id()
    );
    Err(EngineError::Refused { stage: stage.id.clone(), problem })
}

/// The parameters of a model, of the errors of its points, and of the channels by which it is heard, each by
/// itself.
pub(super) fn unlearned(assembly: &Assembly, of: &Responses<'_>) -> Result<Parameters, EngineError> {
    let all = assembly.parameters().iter().cloned().chain(of.errors.parameters());
    Ok(Parameters::new(all.chain(of.channels.parameters.iter().cloned()).collect())?)
}

fn pairs(values: &[C64]) -> Vec<[f64; 2]> {
    values.iter().map(|z| [z.re, z.im]).collect()
}

/// What few data make of standard deviations whose noise they chose, in a sentence; none where that is less
/// than a tenth. With n numbers and q parameters that they tell, the most probable variance of the noise is
/// too small by (n - q)/n, and the errors have Student's t of n - q degrees of freedom.
fn few(numbers: usize, told: usize) -> Option<String> {
    let (n, q) = (numbers as f64, told as f64);
    let freedom = (n - q).max(1.0);
    let times = (n / freedom).sqrt() * student(freedom);
    (told > 0 && times > FEW).then(|| {
        format!(
            "{numbers} real numbers determine {told} parameters and the noise: standard deviations are about {times:.1} times too small; measure at more frequencies, or state \
             the noise"
        )
    })
}

/// Standard deviations that are so many times too small are said.
const FEW: f64 = 1.1;

/// A row as it is before training.
fn untrained(row: &Row) -> ResponseModelRecord {
    ResponseModelRecord {
        id: row.id(),
        label: row.own.iter().map(|c| c.name.as_str()).collect::<Vec<_>>().join("; "),
        candidates: row.choice.clone(),
        parameters: Vec::new(),
        errors: 0,
        channels: 0,
        noise: Vec::new(),
        evidence: None,
        predicted: Vec::new(),
        heard: Vec::new(),
        residual: f64::NAN,
        neighbours: f64::NAN,
        too_sure: false,
        maxima: Vec::new(),
        remark: None,
    }
}

#[cfg(test)]
mod tests {
    use super::few;

    /// Six numbers and three parameters, whose two standard deviations missed the truth in a third of data
    /// sets: root two times half of 3.3.
    #[test]
    fn message_few_numbers_are_said() {
        let said = few(6, 3).unwrap();
        assert!(
            said.contains("6 real numbers determine 3 parameters") && said.contains("about 2.4 times"),
            "{said}"
        );
        assert_eq!(few(60, 3), None);
        assert_eq!(few(6, 0), None);
    }
}
