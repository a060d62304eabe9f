//! What stages of responses could tell, before any work.

use super::responses::response_fault;
use crate::response::{ResponseForesight, ResponseRun};
use rijke_numerics::words::counted;
use rijke_numerics::{Classify, Failed, Tell};
use rijke_study::responses::{ObservedResponse, ResponseKind, Responses};
use rijke_study::{Study, StudyProblem};
use serde_json::{Value, json};

/// Errors that are listed by name.
const MOST: usize = 6;

/// Reads all data, and says what every stage of responses trains on and which parameters that can tell.
pub fn check_responses(study: Study, tell: &dyn Tell) -> Result<Value, Failed> {
    let dir = study.folder.clone();
    let plan = study.plan.clone();
    let head = format!(
        "{}: {}, {}, {} of responses",
        plan.name,
        counted(study.campaign.points.len(), "operating point"),
        counted(study.catalogue.candidates().len(), "candidate"),
        counted(plan.responses.len(), "stage")
    );
    tell.say(head);
    let (points, name) = (study.campaign.points.len(), plan.name);
    let Some(observed) = observed(&study, tell)? else {
        return Ok(json!({ "name": name, "points": points, "responses": null, "stages": [] }));
    };
    // Of an excitation one line: its microphones share frequencies and file.
    let named = |o: &ObservedResponse| match &o.what {
        ResponseKind::Pressure { excitation, .. } => {
            Some((o.point, excitation.clone(), o.frequency_hz.clone()))
        }
        _ => None,
    };
    let first = |k: &usize| {
        let own = named(&observed.list[*k]);
        own.is_none() || k.checked_sub(1).is_none_or(|before| named(&observed.list[before]) != own)
    };
    for o in (0..observed.list.len()).filter(first).map(|k| &observed.list[k]) {
        tell.say(format!(
            "  {} at {}: {} of {} frequencies, {:.1} to {:.1} Hz",
            match &o.what {
                ResponseKind::Pressure { excitation, .. } if excitation.is_empty() => "pressures".to_owned(),
                ResponseKind::Pressure { excitation, .. } => format!("pressures, excitation {excitation},"),
                other => other.name().to_owned(),
            },
            study.campaign.points[o.point].id,
            o.frequency_hz.len(),
            o.rows,
            o.frequency_hz.first().copied().unwrap_or(f64::NAN),
            o.frequency_hz.last().copied().unwrap_or(f64::NAN)
        ));
    }
    let responses = observed.list.len();
    let run = ResponseRun::new(study, observed).map_err(|e| response_fault(&e, &dir))?;
    let found = run.foresight().map_err(|e| response_fault(&e, &dir))?;
    found.iter().for_each(|stage| told(stage, tell));
    Ok(json!({ "name": name, "points": points, "responses": responses, "stages": found }))
}

/// The responses; none where nothing is measured yet or the data are other people's and not here.
fn observed(study: &Study, tell: &dyn Tell) -> Result<Option<Responses>, Failed> {
    if !study.folder.join("observations").is_dir() {
        let is_recorded = study.folder.join("records").is_dir();
        let said = if is_recorded { "no record is processed yet" } else { "nothing is measured yet" };
        tell.say(said.to_owned());
        return Ok(None);
    }
    match study.responses() {
        Ok(observed) => {
            tell.warn(&observed.warnings);
            Ok(Some(observed))
        }
        Err(error) if matches!(*error.problem, StudyProblem::Elsewhere { .. }) => {
            tell.note(format!("warning: {error}"));
            tell.say("the data were not checked".to_owned());
            Ok(None)
        }
        Err(error) => Err(error).or_bad_input(),
    }
}

fn told(stage: &ResponseForesight, tell: &dyn Tell) {
    tell.say(format!(
        "{} ({}, {} of the {} complex numbers in their files; noise {})",
        stage.title,
        counted(stage.responses, "response"),
        stage.numbers,
        stage.of,
        if stage.noise > 0.0 { format!("{:.1e}", stage.noise) } else { "0".to_owned() }
    ));
    if let [first, rest @ ..] = &stage.errors[..] {
        let more = if rest.len() < MOST { rest.join(", ") } else { format!("{} more", rest.len()) };
        tell.say(format!("  counted along: {first}{}{more}", if more.is_empty() { "" } else { ", " }));
    }
    for model in &stage.models {
        if let Some(remark) = &model.remark {
            tell.say(format!("  {}: no answer at the centre of the priors: {remark}", model.id));
            continue;
        }
        let all = model.widths.iter().map(|(name, w)| format!("{name} {w:.2e}")).collect::<Vec<_>>();
        tell.say(format!(
            "  {}: sd after these data over sd of the prior (1: not determined): {}",
            model.id,
            if all.is_empty() { "nothing is free".to_owned() } else { all.join(", ") }
        ));
        for (name, w) in model.not_told() {
            tell.say(format!("    not identified: {name} keeps {:.0} % of its prior width", 100.0 * w));
        }
    }
}
