//! `rijke check`: reads everything that the other steps will read, before any work, and says what the
//! measurements can tell.

mod records;

use crate::{
    failure::Failure,
    number,
    study::{measured, observations, of_the_engine, open, warn_of_copies, warn_of_doubts, warn_of_records},
    study_responses,
    ui::Ui,
};
use rijke_engine::run::{answerable, foresight, recognised};
use rijke_study::Study;
use rijke_study::plan::{Base, Stage};
use serde_json::json;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Check a study: its files, every record, and whether the campaign can identify the parameters of each
/// model.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  rijke check examples/quarter-wave\n  rijke check my-rig --names\n\n\
    Says, for every model of every stage, which parameters the measurements would leave as uncertain as the priors: to first order at\n\
    the centre of the priors, on top of the first model of each earlier stage. Works before anything is recorded. Stages that train on\n\
    responses are judged by the frequencies that were measured, with the stated noise, at the centre of the priors and half a standard\n\
    deviation beside it.")]
pub(crate) struct Args {
    /// Folder of the study, or of records with their manifest.toml.
    dir: PathBuf,
    /// List what the formulas of this study may name, with units, instead.
    #[arg(long)]
    names: bool,
    /// Noise of one operating point, model error included: growth rate (1/s), angular frequency (rad/s),
    /// relative pressure.
    #[arg(long, value_name = "SD", num_args = 3, default_values_t = NOISE_SD, value_parser = number::positive)]
    sd: Vec<f64>,
}

/// Growth rate and angular frequency as in section 6.1 of Juniper & Yoko 2022, relative pressure as its cold
/// points have it.
const NOISE_SD: [f64; 3] = [0.1, 1.0, 1e-3];

/// Ambient temperature of a campaign that states none, K.
const PLANNED_AMBIENT: f64 = 293.15;

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failure> {
    let dir = &args.dir;
    if dir.join("manifest.toml").exists() && !dir.join("study.toml").exists() {
        return ui.result(&records::records_of(dir, ui)?);
    }
    let study = open(dir)?;
    if args.names {
        return names(&study, ui);
    }
    study
        .possible(PLANNED_AMBIENT)
        .map_err(|problem| Failure::bad_input(problem).at(&dir.join("rig.toml")))?;
    let [growth, frequency, pressure] = args.sd[..] else {
        return Err(Failure::bad_input("--sd takes three numbers"));
    };
    let recorded = dir.join("records");
    let there = measured(&dir.join("observations"));
    // A folder of other things does not matter once there are observations.
    let is_due = recorded.is_dir()
        && (!study.plan.stages.is_empty() || !there || recorded.join("manifest.toml").exists());
    let recorded = if is_due { Some(records::records_of(&recorded, ui)?) } else { None };
    let mut of_responses = None;
    if !study.plan.responses.is_empty() {
        let mut found = study_responses::check(study.clone(), ui)?;
        if study.plan.stages.is_empty() {
            found["records"] = json!(recorded);
            return ui.result(&found);
        }
        of_responses = Some(found);
    }
    if matches!(study.plan.base, Base::HeatedFlow(_)) {
        study.readings(there || recorded.is_some()).map_err(Failure::bad_input)?;
    }
    let observed = there.then(|| observations(&study)).transpose()?;
    let plan = &study.plan;
    ui.say(format!(
        "{}: {}, {}, {}, {}{}",
        plan.name,
        number::counted(study.campaign.points.len(), "operating point"),
        number::counted(study.catalogue.candidates().len(), "candidate"),
        number::counted(plan.stages.len(), "stage"),
        number::counted(plan.questions.len(), "question"),
        if plan.maps.is_empty() {
            String::new()
        } else {
            format!(", {}", number::counted(plan.maps.len(), "map"))
        }
    ));
    study.unused().iter().for_each(|said| ui.note(format!("warning: {said}")));
    warn_of_doubts(ui, &study);
    match (&observed, &recorded) {
        (Some(o), _) => {
            ui.say(format!("observations: {}", number::counted(o.modes.len(), "mode")));
            warn_of_copies(ui, &study, o);
            warn_of_records(dir, ui);
            let idle = study.idle_channels().map_err(Failure::bad_input)?;
            idle.iter().for_each(|said| ui.note(format!("warning: {said}")));
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
    for stage in &found {
        ui.say(format!("{} ({})", stage.title, number::counted(stage.points, "operating point")));
        let grounds = study.plan.stage(&stage.id).map_or_else(Vec::new, |(_, plan)| study.plan.grounds(plan));
        if !grounds.is_empty() {
            ui.say(format!("  these widths leave out what {} tells", grounds.join(", ")));
        }
        if stage.observed == Some(0) && !grounds.is_empty() {
            ui.say("  none of them was observed: its modes are predicted, and nothing is trained");
        } else if stage.observed == Some(0) {
            ui.say("  none of them was observed: `rijke rank` needs --until an earlier stage");
        }
        if stage.assumed > 0 {
            ui.say(format!(
                "  the gas at {} of them is not inferred yet: taken as ambient and at rest, so that what depends on heat or flow is not judged",
                stage.assumed
            ));
        }
        if let Some((_, plan)) = study.plan.stage(&stage.id)
            && (&plan.noise.installation, plan.noise.varying.len()) == (&None, 0)
            && let shared = shared_installations(&study, plan)
            && shared > 0
        {
            ui.say(format!(
                "  {shared} installations hold several of these points each, which count as independent: if assemblies differ, state `installation` in the noise of this stage"
            ));
        }
        if study.plan.stage(&stage.id).is_some_and(|(_, plan)| plan.base_errors) {
            ui.say("  these widths leave out the errors of the gas, which training counts: the posterior can be several times wider");
        }
        for model in &stage.models {
            let widths =
                model.widths.iter().map(|(name, w)| format!("{name} {w:.2}")).collect::<Vec<_>>().join(", ");
            ui.say(format!("  {}: width after the measurements over that of the prior: {widths}", model.id));
            for (direction, share) in &model.unidentified {
                ui.say(format!(
                    "    not identified: {direction} keeps {:.0} % of its prior width",
                    100.0 * share
                ));
            }
            if !model.lost.is_empty() {
                ui.say(format!("    no mode at the centre of the priors at {}", model.lost.join(", ")));
            }
        }
    }
    let mut result = json!({ "name": plan.name, "points": study.campaign.points.len(), "records": recorded, "stages": found });
    if let Some(found) = of_responses {
        result["responses"] = found;
    }
    ui.result(&result)
}

/// How many installations have several points of a stage.
fn shared_installations(study: &Study, stage: &Stage) -> usize {
    let mut points: BTreeMap<&str, usize> = BTreeMap::new();
    for point in study.campaign.points.iter().filter(|p| stage.points.holds(&study.campaign, p)) {
        *points.entry(&point.installation).or_default() += 1;
    }
    points.values().filter(|n| **n > 1).count()
}

/// What formulas may name.
fn names(study: &Study, ui: &Ui) -> Result<(), Failure> {
    let all = study.rig.scope.names();
    let row = |n: &rijke_formula::Name| [&n.name, &n.unit, &n.meaning].map(|text| text.to_string());
    ui.table(["name", "unit", "meaning"], all.iter().map(row));
    let list = all.iter().map(|n| json!({ "name": n.name, "unit": n.unit, "meaning": n.meaning }));
    ui.result(&list.collect::<Vec<_>>())
}
