//! `rijke rank`: trains the stages of a study on its observations, and answers its questions.

use crate::{
    failure::{Classify, Failure},
    map, number,
    study::{doubts_of, observations, of_the_engine, open, warn_of, warn_of_left_out, warn_of_records},
    ui::Ui,
};
use rijke_engine::run::{Answer, Asked, FarOff, Judgement, Missing, Run, StageRecord, verdicts};
use rijke_numerics::StagedFolder;
use rijke_study::MadeOf;
use serde::Serialize;
use serde_json::json;
use std::path::{Path, PathBuf};

use crate::results::{Trust, kept, no_stage, rank_first};
use crate::study_responses::{before_modes, shorts};

/// A misfit in growth rate (1/s), frequency (rad/s) and relative pressure that is none.
const NO_MISFIT: [f64; 3] = [1e-7, 1e-6, 1e-9];

/// Train the stages of a study, rank their models by evidence, and answer the questions of study.toml.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  rijke rank examples/quarter-wave\n\n\
    Reads DIR/observations. Writes DIR/results/numbers, from which `rijke report DIR` draws, and DIR/results/models,\n\
    with which `rijke predict DIR` predicts and\n\
    `rijke next DIR` says what to measure next.")]
pub(crate) struct Args {
    /// Folder of the study.
    pub(crate) dir: PathBuf,
    #[command(flatten)]
    pub(crate) trust: Trust,
    /// Stop after this stage, and answer only the questions about the stages that have run.
    #[arg(long, value_name = "STAGE")]
    pub(crate) until: Option<String>,
    /// Say what errors of lengths that rig.toml states as plain numbers would turn the lead of each stage;
    /// takes about as long again.
    #[arg(long)]
    pub(crate) lengths: bool,
    /// Replace DIR/results if it exists.
    #[arg(long)]
    pub(crate) force: bool,
}

/// Everything that ranking finds.
pub(crate) struct Results {
    pub(crate) stages: Vec<StageRecord>,
    pub(crate) answers: Vec<Answer>,
    pub(crate) verdicts: Vec<Judgement>,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failure> {
    let dir = &args.dir;
    let mut study = open(dir)?;
    if study.plan.stages.is_empty() {
        return crate::study_responses::run(study, args.trust, args.until.as_deref(), args.force, ui);
    }
    let (observations, doubts) = (observations(&study)?, doubts_of(&study));
    let staged = ui.started(StagedFolder::new(&dir.join("results"), "numbers/claims.json", args.force)?);
    warn_of(ui, &study, &observations)?;
    warn_of_records(dir, ui);
    if let Some(id) = args.until.as_ref().filter(|id| study.plan.response(id).is_some()) {
        return Err(Failure::bad_input(format!(
            "--until {id}: that stage trains on responses, and these all run before those of modes"
        ))
        .at(&dir.join("study.toml"))
        .remedy("Name a stage of modes, or keep the stages of responses in a study folder of their own."));
    }
    if let Some(id) = &args.until {
        let Some((k, _)) = study.plan.stage(id) else { return Err(no_stage(id, &study.plan, dir)) };
        let whole = study.plan.clone();
        study.plan.stages.truncate(k + 1);
        let has_run = |stage: &str| whole.stage(stage).is_some_and(|(at, _)| at <= k);
        study.plan.questions.retain(|q| has_run(&q.stage));
        study.plan.maps.retain(|m| has_run(&m.stage));
    }
    let (mut responses, mut grounds) = (Vec::new(), Vec::new());
    if !study.plan.responses.is_empty() {
        (responses, grounds) = before_modes(study.clone(), args.trust, staged.path(), ui)?;
    }
    let (plan, claims) = (study.plan.clone(), study.claims.clone());
    // Maps add points to it.
    let mapped = (!plan.maps.is_empty()).then(|| study.clone());
    let steps = 2 * plan.stages.len() + plan.questions.len() + plan.maps.len();
    let progress = ui.progress("stages", steps as u64);
    let wrong = |e: rijke_engine::EngineError| of_the_engine(&e, dir);
    let mut run = Run::on_responses(study, &observations, args.trust.trusted()?, grounds).map_err(wrong)?;
    run.lengths = args.lengths;
    warn_of_left_out(ui, &run.left_out);
    if let Some(heat) = &run.heat {
        ui.note(format!(
            "the gas gets {} of the power, and gives {} W/(m^2 K) to the wall, by the readings",
            number::with_sd(heat.share[0], heat.share[1]),
            number::with_sd(heat.cooling[0], heat.cooling[1])
        ));
        if let Some([ratio, sd]) = heat.near {
            ui.note(format!(
                "one diameter behind the part it gives {} times that",
                number::with_sd(ratio, sd)
            ));
        }
        ui.note(format!(
            "the rise of the gas scatters from point to point by {:.2} % (root mean square of the posterior; 95 % of it from {:.2} to {:.2} %)",
            100.0 * heat.scatter,
            100.0 * heat.scatter_within[0],
            100.0 * heat.scatter_within[1]
        ));
        let [offset, sd, before] = heat.common;
        if before > 0.0 && !heat.thermometers.is_empty() {
            ui.note(format!(
                "the thermometers together read {} K too much, by readings and heat (0 +- {} before them)",
                number::with_sd(offset, sd),
                number::rounded(before)
            ));
        }
        heat.warnings().iter().for_each(|warning| ui.note(format!("warning: {warning}")));
    }
    let (mut stages, mut answers) = (Vec::new(), Vec::new());
    let models = staged.path().join("models");
    for _ in &plan.stages {
        let Some(stage) = run.next_stage().map_err(wrong)? else { break };
        progress.advance(1);
        answers.push(run.overview(&stage.id).map_err(wrong)?);
        match run.saved(&stage.id) {
            Ok(model) => keep(&models, &stage.id, &model)?,
            Err(error) => left_out(ui, &format!("the model of stage {}", stage.id), error, &wrong)?,
        }
        match run.saved_rival(&stage.id) {
            Ok(Some(rival)) => keep(&models, &rival_of(&stage.id), &rival)?,
            Ok(None) => {}
            Err(error) => left_out(ui, &format!("the second model of stage {}", stage.id), error, &wrong)?,
        }
        match run.saved_open(&stage.id) {
            Ok(open) if open.is_empty() => {}
            Ok(open) => keep(&models, &open_of(&stage.id), &open)?,
            Err(error) => {
                left_out(ui, &format!("the average over models of stage {}", stage.id), error, &wrong)?
            }
        }
        progress.advance(1);
        stages.push(stage);
    }
    for question in &plan.questions {
        match run.answer(question) {
            Ok(answer) => answers.push(answer),
            // Defined with the medians of the priors, and not with what was trained.
            Err(error @ rijke_engine::EngineError::Network { .. }) => {
                ui.note(format!("warning: the answer to `{}` is left out: {error}", question.id));
            }
            Err(error) => left_out(ui, &format!("the answer to `{}`", question.id), error, &wrong)?,
        }
        progress.advance(1);
    }
    for asked in &plan.maps {
        let Some(study) = &mapped else { break };
        let trained = run.saved(&asked.stage).and_then(|model| Ok((model, run.saved_open(&asked.stage)?)));
        match trained {
            Ok((model, open)) => {
                answers.push(map::answered(study, &observations, asked, &model, &open, ui)?);
            }
            Err(error) => left_out(ui, &format!("the map `{}`", asked.id), error, &wrong)?,
        }
        progress.advance(1);
    }
    drop(progress);
    let verdicts = verdicts(&claims, observations.kind, &stages, &answers);
    let numbers = staged.path().join("numbers");
    for stage in &stages {
        keep(&numbers, &format!("stage-{}", stage.id), stage)?;
    }
    for answer in &answers {
        keep(&numbers, &format!("answer-{}", answer.id), answer)?;
    }
    let of = MadeOf::study(dir).or_bad_input().map_err(|f| f.at(dir))?;
    of.write(staged.path()).or_failed()?;
    // Last: a folder with this file is finished.
    keep(&numbers, "claims", &verdicts)?;
    staged.commit()?;
    stages.iter().for_each(|stage| table(ui, stage));
    for v in &verdicts {
        ui.say(format!("{}: {} ({})", if v.holds { "holds" } else { "fails" }, v.statement, v.figure));
    }
    let mut result =
        json!({ "dir": dir.join("results"), "stages": stages, "claims": verdicts, "doubts": doubts });
    if !responses.is_empty() {
        result["responses"] = shorts(&responses).into();
    }
    ui.result(&result)
}

/// A search that does not end costs what stands on it, and nothing else; any other error ends the ranking.
fn left_out(
    ui: &Ui,
    what: &str,
    error: rijke_engine::EngineError,
    wrong: &dyn Fn(rijke_engine::EngineError) -> Failure,
) -> Result<(), Failure> {
    if !matches!(error, rijke_engine::EngineError::NotConverged { .. }) {
        return Err(wrong(error));
    }
    ui.note(format!("warning: {what} is left out: {error}"));
    Ok(())
}

/// Where the best model of a stage but the one that goes on is kept.
pub(crate) fn rival_of(stage: &str) -> String {
    format!("{stage}.rival")
}

/// Where the models are kept that are open beside the one that goes on from a stage.
pub(crate) fn open_of(stage: &str) -> String {
    format!("{stage}.open")
}

fn keep(folder: &Path, name: &str, what: &impl Serialize) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).or_failed().map_err(|f| f.at(folder))?;
    let path = folder.join(format!("{name}.json"));
    let text = serde_json::to_string_pretty(what).or_failed()?;
    std::fs::write(&path, text + "\n").or_failed().map_err(|f| f.at(&path))
}

impl Results {
    /// Reads what `rijke rank` wrote for a study, up to the stage after which it stopped.
    pub(crate) fn read(dir: &Path, plan: &rijke_study::plan::Plan) -> Result<Self, Failure> {
        let verdicts = kept(dir, "numbers", "claims")?;
        let numbers = dir.join("results/numbers");
        let there = |name: &String| numbers.join(format!("{name}.json")).is_file();
        let stages = plan.stages.iter().map(|s| format!("stage-{}", s.id)).filter(there);
        let answers = plan.answers().map(|id| format!("answer-{id}")).filter(there);
        let whole = |name: String| {
            let answer: Answer = kept(dir, "numbers", &name)?;
            for frame in &answer.frames {
                let count = frame.columns.len();
                if let Some(row) = frame.rows.iter().find(|row| row.values.len() > count) {
                    let what =
                        format!("row `{}` has {} values for {count} columns", row.label, row.values.len());
                    let file = numbers.join(format!("{name}.json"));
                    return Err(Failure::bad_input(what).at(&file).remedy(rank_first(dir)));
                }
            }
            Ok(answer)
        };
        Ok(Self {
            stages: stages.map(|name| kept(dir, "numbers", &name)).collect::<Result<_, _>>()?,
            answers: answers.map(whole).collect::<Result<_, _>>()?,
            verdicts,
        })
    }
}

/// The models of a stage, best first.
fn table(ui: &Ui, stage: &StageRecord) {
    ui.say(format!("{} ({})", stage.title, number::counted(stage.measured.len(), "mode")));
    let models = stage.by_evidence();
    let best = models.first().map_or(0.0, |m| m.ln_evidence());
    let of_all = stage.remarks_of_all();
    for model in models {
        let mark = if model.id == stage.chosen { "  <- goes on" } else { "" };
        match model.evidence {
            Some(_) => {
                ui.say(format!("  {:>9.1} nats  {}{mark}", model.ln_evidence() - best, model.id));
                for remark in model.remarks().filter(|line| !of_all.contains(line)) {
                    ui.say(format!("                  {remark}"));
                }
            }
            None => {
                ui.say(format!("  no evidence     {}: {}", model.id, model.remark.as_deref().unwrap_or("")));
            }
        }
    }
    of_all.iter().for_each(|said| ui.say(format!("      of all these: {said}")));
    if let Some(model) = stage.models.iter().find(|m| m.id == stage.chosen) {
        carried_on(ui, stage);
        if let Some((other, behind)) = stage.nearest().filter(|(_, behind)| *behind < stage.decides) {
            let (leader, lead) = if behind < 0.0 { (other, -behind) } else { (model, behind) };
            let right = if behind < 0.0 { model.id.as_str() } else { "it" };
            ui.say(format!(
                "      not decided: {} leads by {lead:.1} nats, fewer than the {:.1} that decide; the numbers below hold if {right} is right",
                leader.id, stage.decides
            ));
        }
        for assumed in &stage.assumes {
            ui.say(format!("      these numbers stand on a choice that is not decided. {assumed}."));
        }
        // What a search leaves of a noise that the data choose to be none.
        let size = |k: usize| Some(model.misfit[k].abs()).filter(|v| *v >= NO_MISFIT[k]).unwrap_or(0.0);
        let [growth, frequency, pressure] = [0, 1, 2].map(size);
        let trained = !stage.measured.is_empty();
        let misfit = format!(
            "      misfit beyond the measured errors: {} 1/s, {} Hz, {} of relative pressures",
            number::rounded(growth),
            number::rounded(frequency / std::f64::consts::TAU),
            number::rounded(pressure)
        );
        ui.say(if trained { misfit } else { "      no mode was measured: nothing was trained".to_owned() });
        if let Some(far) = FarOff::of(&stage.measured, model) {
            ui.say(format!("      {}", far.words()));
        }
        for p in &model.parameters {
            let averaged = p.averaged.map_or(String::new(), |[value, sd]| {
                format!("; {} averaged over what earlier stages leave open", number::with_sd(value, sd))
            });
            ui.say(format!("      {} = {}{averaged}", p.name, number::quantity(p.value, p.sd, &p.unit)));
            if trained {
                crate::results::not_identified(ui, p);
            }
            crate::results::warn_of_prior(ui, p);
        }
    }
    if let Some(lengths) = &stage.lengths {
        ui.say(format!("      {}", lengths.words()));
    }
    if let Some(missing) = &stage.missing {
        still_asked(ui, missing);
    }
}

/// What later stages make of the models that a stage leaves open.
fn carried_on(ui: &Ui, stage: &StageRecord) {
    if !stage.carried.is_empty() {
        ui.say("      these points leave models open; with the best models of later stages (in brackets) they have:");
    }
    for (open, nats) in stage.carried_below_best() {
        let later: Vec<&str> = open.later.iter().map(|l| l.model.as_str()).collect();
        let mark = if open.id == stage.chosen { "  <- goes on" } else { "" };
        ui.say(match nats {
            Some(nats) => format!("  {nats:>9.1} nats  {} ({}){mark}", open.id, later.join("; ")),
            None => format!("  no evidence     {}: a later stage has no model that could be fitted", open.id),
        });
    }
    stage.not_carried().iter().for_each(|said| ui.say(format!("      {said}")));
}

/// The first terms that the data still ask for.
fn still_asked(ui: &Ui, missing: &Missing) {
    let Some(first) = missing.families.first() else { return };
    let tried = missing.tried;
    if first.first.probability > Missing::CHANCE {
        ui.say(format!(
            "      missing: nothing beyond chance; the best of {tried} terms is {} (p = {:.2})",
            first.first.words(),
            first.first.probability
        ));
        return;
    }
    ui.say("      the data ask for more than this model; the deviations above take it for complete:");
    for (k, family) in
        missing.families.iter().take(2).enumerate().filter(|(_, f)| f.beyond.1 <= Missing::CHANCE)
    {
        let (Asked { strength: [value, sd], unit, gain, .. }, (beyond, probability)) =
            (&family.first, family.beyond);
        let (word, gain) = if k == 0 { ("missing", *gain) } else { ("and beyond that", beyond) };
        ui.say(format!(
            "      {word}: {} = {}: {gain:+.1} nats expected, p = {probability:.3} ({} of {tried} terms cannot be told from it)",
            family.first.words(),
            number::quantity(*value, *sd, unit),
            family.like.len()
        ));
    }
}
