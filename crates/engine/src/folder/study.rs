//! A study folder, opened: what every step that reads one shares.

use crate::EngineError;
use rijke_numerics::words::few;
use rijke_numerics::{Failed, Tell};
use rijke_study::{ObservedModes, Study, StudyProblem, changed_records, changed_study};
use std::path::Path;

/// Reads a study.
pub fn open_study(dir: &Path) -> Result<Study, Failed> {
    if !dir.join("study.toml").exists() {
        let what = match (dir.is_dir(), dir.exists()) {
            (true, _) => "holds no study.toml, so it is no study",
            (false, true) => "is a file; give the folder of the study",
            (false, false) => "there is no such folder",
        };
        return Err(Failed::bad_input(format!("{}: {what}", dir.display())).remedy(
            "`rijke new DIR --template NAME` writes a study to fill in; docs/study-folder.md describes it.",
        ));
    }
    crate::run::open(dir).map_err(Failed::bad_input)
}

/// Refuses a study with stages of responses, for a command that runs stages of modes without them.
pub fn without_responses(study: &Study, command: &str) -> Result<(), Failed> {
    of_modes(study)?;
    if study.plan.responses.is_empty() {
        return Ok(());
    }
    Err(Failed::bad_input(format!("{command} takes no study with stages of responses, on which those of modes may stand"))
        .at(&study.folder.join("study.toml"))
        .remedy("Rank stage by stage with `rijke rank`, or keep the stages of responses in a study folder of their own."))
}

/// Refuses a study all of whose stages train on responses, for a command of modes.
pub fn of_modes(study: &Study) -> Result<(), Failed> {
    if !study.plan.stages.is_empty() {
        return Ok(());
    }
    Err(Failed::bad_input("the stages of this study train on responses, and this command is for studies of modes")
        .at(&study.folder.join("study.toml"))
        .remedy("Take `rijke check`, `rijke rank`, `rijke run` or `rijke report`; for the answers of a network file `rijke response`."))
}

/// Reads what was observed.
pub fn observations(study: &Study) -> Result<ObservedModes, Failed> {
    of_modes(study)?;
    study.observations().map_err(|error| {
        if !matches!(*error.problem, StudyProblem::Unreadable(_) | StudyProblem::Absent { .. }) {
            return Failed::bad_input(error);
        }
        Failed::bad_input(error).remedy(
            "Give observations/modes.csv and observations/observations.toml, or make them of records with `rijke process`; \
             docs/study-folder.md describes both.",
        )
    })
}

/// Whether a folder of observations holds what was measured of modes; `readings.csv` may lie there before.
pub fn is_measured(folder: &Path) -> bool {
    ["observations.toml", "modes.csv", "pings.csv"].iter().any(|name| folder.join(name).exists())
}

/// Warns of what has no effect, and of statements of a study that contradict its observations.
pub(crate) fn warn_of(study: &Study, observations: &ObservedModes, tell: &dyn Tell) -> Result<(), Failed> {
    tell.warn(&study.unused());
    tell.warn(&doubts_of(study));
    warn_of_copies(study, observations, tell);
    tell.warn(&study.idle_channels().map_err(Failed::bad_input)?);
    tell.warn(&study.between_thermometers().map_err(Failed::bad_input)?);
    tell.warn(study.copied_readings().map_err(Failed::bad_input)?.as_slice());
    study.unobserved(observations).into_iter().for_each(|said| tell.note(said));
    tell.warn(study.other_temperatures(observations).as_slice());
    Ok(())
}

/// Warns of rows that were copied, of modes that seem to be those of another label, and of growth rates of
/// zero, or of which none is negative.
pub fn warn_of_copies(study: &Study, observations: &ObservedModes, tell: &dyn Tell) {
    let (campaign, place) = (&study.campaign, study.folder.join("observations"));
    let said = [
        observations.copied(campaign),
        observations.other_labels(campaign),
        observations.steady(campaign),
        observations.none_decays(),
    ];
    for said in said.into_iter().flatten() {
        tell.note(format!("warning: {}: {said}", place.display()));
    }
}

/// What is doubtful in the files of a rig and its candidates, tables that were measured among them.
pub fn doubts_of(study: &Study) -> Vec<String> {
    let of_files = study.rig.doubts.iter().chain(&study.catalogue.doubts).cloned();
    of_files.chain(study.doubtful()).collect()
}

/// Warns of observations that are of other records.
pub fn warn_of_records(dir: &Path, tell: &dyn Tell) {
    warn_of_changed(dir, "observations", "these records", "process them", &changed_records(dir), tell);
}

/// Warns of results that are of another study.
pub fn warn_of_study(dir: &Path, tell: &dyn Tell) {
    warn_of_records(dir, tell);
    warn_of_changed(dir, "results", "these files", "rank", &changed_study(dir), tell);
}

/// Most changed files that a sentence names.
pub const FILES_NAMED: usize = 4;

fn warn_of_changed(dir: &Path, made: &str, of: &str, remedy: &str, changed: &[String], tell: &dyn Tell) {
    if !changed.is_empty() {
        let (made, changed) = (dir.join(made), few(changed, FILES_NAMED));
        tell.note(format!(
            "warning: {} is not of {of}: {changed} changed since; {remedy} again, with --force",
            made.display()
        ));
    }
}

/// Says which observed points no stage uses because nothing is known of their gas.
pub fn warn_of_left_out(points: &[String], tell: &dyn Tell) {
    if !points.is_empty() {
        tell.note(format!(
            "warning: left out, because base/states.json has no state of their gas: {}",
            points.join(", ")
        ));
    }
}

/// What the files say can be wrong in ways that are seen only when a model is built from them.
pub fn of_the_engine(error: &EngineError, dir: &Path) -> Failed {
    match error {
        EngineError::NotConverged { .. } | EngineError::Inference(_) | EngineError::Dense(_) => {
            Failed::of_work(error).at(dir)
        }
        _ => Failed::bad_input(error).at(dir),
    }
}
