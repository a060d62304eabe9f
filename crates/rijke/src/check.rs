//! `rijke check`: reads everything that the other steps will read, before any work, and says what the
//! measurements can tell.

use crate::{number, ui::Ui};
use rijke_engine::folder::{
    check_responses, doubts_of, is_measured, observations, of_the_engine, open_study, warn_of_copies,
    warn_of_records,
};
use rijke_engine::run::{answerable, foresight, recognised};
use rijke_engine::told::tell_foresight;
use rijke_intake::check_records;
use rijke_numerics::{Failed, Tell, words::counted};
use rijke_study::Study;
use rijke_study::plan::Base;
use serde_json::json;
use std::path::PathBuf;

/// Check a study: its files, every record, and whether the campaign can identify the parameters of each
/// model.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  rijke check examples/quarter-wave\n  rijke check my-rig --names\n\n\
    For every model of every stage it says which parameters the measurements cannot determine (posterior as wide as the prior). The\n\
    estimate is to first order at the centres of the priors; the first model of each earlier stage stands for that stage. It works\n\
    before anything is recorded. Stages that train on\n\
    responses are judged by the frequencies that were measured, with the stated noise, at the centre of the priors and half a standard\n\
    deviation beside it.")]
pub(crate) struct Args {
    /// Folder of the study, or of records with their manifest.toml.
    dir: PathBuf,
    /// Instead, list all names that formulas of this study may use, with their units.
    #[arg(long)]
    names: bool,
    /// Noise of one operating point, model error included: growth rate (1/s), angular frequency (rad/s),
    /// relative pressure.
    #[arg(long, value_names = ["GROWTH", "OMEGA", "PRESSURE"], num_args = 3, default_values_t = NOISE_SD, value_parser = number::positive)]
    sd: Vec<f64>,
}

/// Growth rate and angular frequency as in section 6.1 of Juniper & Yoko 2022, relative pressure as its cold
/// points have it.
const NOISE_SD: [f64; 3] = [0.1, 1.0, 1e-3];

/// Ambient temperature of a campaign that states none, K.
const PLANNED_AMBIENT: f64 = 293.15;

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failed> {
    let dir = &args.dir;
    if dir.join("manifest.toml").exists() && !dir.join("study.toml").exists() {
        return ui.result(&check_records(dir, &open_study, ui)?);
    }
    let study = open_study(dir)?;
    if args.names {
        return names(&study, ui);
    }
    study
        .possible(PLANNED_AMBIENT)
        .map_err(|problem| Failed::bad_input(problem).at(&dir.join("rig.toml")))?;
    let [growth, frequency, pressure] = args.sd[..] else {
        return Err(Failed::bad_input("--sd takes three numbers"));
    };
    let recorded = dir.join("records");
    let there = is_measured(&dir.join("observations"));
    // A folder of other things does not matter once there are observations.
    let is_due = recorded.is_dir()
        && (!study.plan.stages.is_empty() || !there || recorded.join("manifest.toml").exists());
    let recorded = if is_due { Some(check_records(&recorded, &open_study, ui)?) } else { None };
    let mut of_responses = None;
    if !study.plan.responses.is_empty() {
        let mut found = check_responses(study.clone(), ui)?;
        if study.plan.stages.is_empty() {
            ui.warn(&study.unused());
            ui.warn(&doubts_of(&study));
            found["records"] = json!(recorded);
            return ui.result(&found);
        }
        of_responses = Some(found);
    }
    if matches!(study.plan.base, Base::HeatedFlow(_)) {
        study.readings(there || recorded.is_some()).map_err(Failed::bad_input)?;
    }
    let observed = there.then(|| observations(&study)).transpose()?;
    let plan = &study.plan;
    ui.say(format!(
        "{}: {}, {}, {}, {}{}",
        plan.name,
        counted(study.campaign.points.len(), "operating point"),
        counted(study.catalogue.candidates().len(), "candidate"),
        counted(plan.stages.len(), "stage"),
        counted(plan.questions.len(), "question"),
        if plan.maps.is_empty() { String::new() } else { format!(", {}", counted(plan.maps.len(), "map")) }
    ));
    ui.warn(&study.unused());
    ui.warn(&doubts_of(&study));
    study.taken_as_exact().iter().for_each(|said| ui.say(said));
    match (&observed, &recorded) {
        (Some(o), _) => {
            ui.say(format!("observations: {}", counted(o.modes.len(), "mode")));
            warn_of_copies(&study, o, ui);
            warn_of_records(dir, ui);
            ui.warn(&study.idle_channels().map_err(Failed::bad_input)?);
        }
        (None, Some(_)) => ui.say("no record is processed yet"),
        (None, None) => ui.say("nothing is measured yet"),
    }
    if let Some(observed) = &observed {
        answerable(&study, observed).map_err(|e| of_the_engine(&e, &dir.join("study.toml")))?;
        recognised(&study, observed).map_err(|e| of_the_engine(&e, dir))?;
    }
    let found = foresight(&study, observed.as_ref(), [growth, frequency, pressure], PLANNED_AMBIENT)
        .map_err(|e| of_the_engine(&e, dir))?;
    if found.iter().any(|stage| stage.alone > 0) {
        ui.say("Points without a measured mode are judged by one mode: the lowest in the band of [recording] or [search], or, where no band is stated, the one nearest to the half-wave mode.");
    }
    found.iter().for_each(|stage| tell_foresight(&study, stage, ui));
    let mut result = json!({ "name": plan.name, "points": study.campaign.points.len(), "records": recorded, "stages": found });
    if let Some(found) = of_responses {
        result["responses"] = found;
    }
    ui.result(&result)
}

/// What formulas may name.
fn names(study: &Study, ui: &Ui) -> Result<(), Failed> {
    let all = study.rig.scope.names();
    let row = |n: &rijke_formula::Name| [&n.name, &n.unit, &n.meaning].map(|text| text.to_string());
    ui.table(["name", "unit", "meaning"], all.iter().map(row));
    let list = all.iter().map(|n| json!({ "name": n.name, "unit": n.unit, "meaning": n.meaning }));
    ui.result(&list.collect::<Vec<_>>())
}
