//! The stages of a study folder, trained on its observations, and its questions answered; numbers and models
//! kept for later steps.

use super::responses::{ResponseResults, rank_responses};
use super::results::{Results, keep, no_stage, open_of, rival_of};
use super::study::{of_the_engine, warn_of, warn_of_left_out, warn_of_records};
use crate::run::{
    Answer, AskedPoint, OpenModel, Run, Trusted, forecast, over_map, stability, verdicts, with_points,
};
use crate::told::{tell_heat, tell_stage};
use crate::{EngineError, SavedModel};
use rijke_numerics::{Classify, Failed, Tell};
use rijke_study::plan::{MapQuestion, Selection};
use rijke_study::{MadeOf, ObservedModes, Study};
use std::path::Path;

/// Adds to a study the states of the gas at points that were not measured, by their places in the campaign.
pub type Foresee<'a> = &'a dyn Fn(&mut Study, &[usize]) -> Result<(), Failed>;

/// How a study is ranked.
pub struct RankOptions<'a> {
    /// How far evidences are checked.
    pub trusted: Trusted,
    /// The last stage that is trained.
    pub until: Option<&'a str>,
    /// Whether errors of lengths that are stated as plain numbers are judged.
    pub lengths: bool,
    /// For points of maps.
    pub foresee: Foresee<'a>,
}

/// Trains the stages, answers questions and maps, and judges what others published. All of it is written into
/// `folder`, `numbers/claims.json` last. Also what stages of responses gave, if the study has any.
///
/// # Errors
/// File, place and remedy, or a search that does not end.
pub fn rank(
    mut study: Study,
    observations: &ObservedModes,
    options: &RankOptions<'_>,
    folder: &Path,
    tell: &dyn Tell,
) -> Result<(Results, Option<ResponseResults>), Failed> {
    let dir = study.folder.clone();
    let wrong = |e: EngineError| of_the_engine(&e, &dir);
    warn_of(&study, observations, tell)?;
    warn_of_records(&dir, tell);
    if let Some(id) = options.until {
        cut_after(&mut study, id)?;
    }
    let (mut responses, mut grounds) = (None, Vec::new());
    if !study.plan.responses.is_empty() {
        if matches!(options.trusted, Trusted::Sampled(..)) {
            tell.note(
                "--sampler judges the stages of modes alone: evidence of responses has no sampler".to_owned(),
            );
        }
        let within = folder.join(ResponseResults::BESIDE_MODES);
        let (found, of) = rank_responses(study.clone(), options.trusted, &within, tell)?;
        (responses, grounds) = (Some(found), of);
    }
    let (plan, claims) = (study.plan.clone(), study.claims.clone());
    // Maps add points to it.
    let mapped = (!plan.maps.is_empty()).then(|| study.clone());
    let steps = 2 * plan.stages.len() + plan.questions.len() + plan.maps.len();
    let progress = tell.progress("steps", steps as u64);
    let mut run = Run::on_responses(study, observations, options.trusted, grounds).map_err(wrong)?;
    run.lengths = options.lengths;
    warn_of_left_out(&run.left_out, tell);
    run.heat.iter().for_each(|heat| tell_heat(heat, tell));
    let (mut stages, mut answers) = (Vec::new(), Vec::new());
    let told = Told { dir: &dir, tell };
    for _ in &plan.stages {
        let stage = match run.next_stage() {
            Ok(Some(stage)) => stage,
            Ok(None) => break,
            Err(error) => {
                // What was found so far often says why.
                stages.iter().for_each(|stage| tell_stage(stage, tell));
                return Err(wrong(error));
            }
        };
        progress(1);
        answers.push(run.overview(&stage.id).map_err(wrong)?);
        told.keep_models(&run, &stage.id, &folder.join("models"))?;
        progress(1);
        stages.push(stage);
    }
    for question in &plan.questions {
        match run.answer(question) {
            Ok(answer) => answers.push(answer),
            // Defined with the medians of the priors, and not with what was trained.
            Err(error @ (EngineError::Network { .. } | EngineError::NothingToAnswer { .. })) => {
                tell.note(format!("warning: the answer to `{}` is left out: {error}", question.id));
            }
            Err(error) => told.left_out(format!("the answer to `{}`", question.id), error)?,
        }
        progress(1);
    }
    for asked in &plan.maps {
        let Some(study) = &mapped else { break };
        let trained = run.saved(&asked.stage).and_then(|model| Ok((model, run.saved_open(&asked.stage)?)));
        match trained {
            Ok((model, open)) => {
                answers.push(mapped_by(study, observations, asked, &model, &open, options.foresee)?);
            }
            Err(error) => told.left_out(format!("the map `{}`", asked.id), error)?,
        }
        progress(1);
    }
    drop(progress);
    let verdicts = verdicts(&claims, observations.kind, &stages, &answers);
    let results = Results { stages, answers, verdicts };
    keep_numbers(&results, folder, &dir)?;
    Ok((results, responses))
}

/// Leaves out the stages of a study behind `id`.
fn cut_after(study: &mut Study, id: &str) -> Result<(), Failed> {
    let dir = study.folder.clone();
    if study.plan.response(id).is_some() {
        let why =
            format!("--until {id}: that stage trains on responses, and these all run before those of modes");
        let remedy = "Name a stage of modes, or keep the stages of responses in a study folder of their own.";
        return Err(Failed::bad_input(why).at(&dir.join("study.toml")).remedy(remedy));
    }
    let (place, _) = study.plan.stage(id).ok_or_else(|| no_stage(id, &study.plan, &dir))?;
    study.plan.end_after(place);
    Ok(())
}

/// To whom it is told what a ranking of the study in `dir` leaves out.
struct Told<'a> {
    dir: &'a Path,
    tell: &'a dyn Tell,
}

impl Told<'_> {
    /// A search that does not end costs what stands on it, and nothing else; any other error ends the
    /// ranking.
    fn left_out(&self, what: String, error: EngineError) -> Result<(), Failed> {
        match error {
            EngineError::NotConverged { .. } => {
                self.tell.note(format!("warning: {what} is left out: {error}"));
                Ok(())
            }
            other => Err(of_the_engine(&other, self.dir)),
        }
    }

    /// Keeps the model of a stage, the second one, and those that it leaves open.
    fn keep_models(&self, run: &Run, id: &str, models: &Path) -> Result<(), Failed> {
        match run.saved(id) {
            Ok(model) => keep(models, id, &model)?,
            Err(error) => self.left_out(format!("the model of stage {id}"), error)?,
        }
        match run.saved_rival(id) {
            Ok(Some(rival)) => keep(models, &rival_of(id), &rival)?,
            Ok(None) => {}
            Err(error) => self.left_out(format!("the second model of stage {id}"), error)?,
        }
        match run.saved_open(id) {
            Ok(open) if open.is_empty() => {}
            Ok(open) => keep(models, &open_of(id), &open)?,
            Err(error) => self.left_out(format!("the average over models of stage {id}"), error)?,
        }
        Ok(())
    }
}

/// Keeps what was found, and of which files of the study in `dir`.
fn keep_numbers(results: &Results, folder: &Path, dir: &Path) -> Result<(), Failed> {
    let numbers = folder.join("numbers");
    for stage in &results.stages {
        keep(&numbers, &format!("stage-{}", stage.id), stage)?;
    }
    for answer in &results.answers {
        keep(&numbers, &format!("answer-{}", answer.id), answer)?;
    }
    let of = MadeOf::study(dir).or_bad_input().map_err(|f| f.at(dir))?;
    of.write(folder).or_failed()?;
    // Last: a folder with this file is finished.
    keep(&numbers, "claims", &results.verdicts)
}

/// The map that a study asks for, by the model of its stage and those that are open beside it.
fn mapped_by(
    study: &Study,
    observed: &ObservedModes,
    asked: &MapQuestion,
    model: &SavedModel,
    open: &[OpenModel],
    foresee: Foresee<'_>,
) -> Result<Answer, Failed> {
    let wrong = |e: EngineError| of_the_engine(&e, &study.folder);
    let all = Selection::default();
    let among = study.plan.stage(&asked.stage).map_or(&all, |(_, stage)| &stage.points);
    let points = over_map(study, among, &asked.grid, &AskedPoint::default()).map_err(wrong)?;
    let (mut wider, places) = with_points(study, among, &points).map_err(wrong)?;
    foresee(&mut wider, &places)?;
    let (found, mut left_out) = forecast(&wider, observed, model, open, &places).map_err(wrong)?;
    if found.is_empty() && !left_out.is_empty() {
        return Err(wrong(left_out.swap_remove(0).why));
    }
    Ok(stability(&wider, asked, &places, &found, model).0)
}
