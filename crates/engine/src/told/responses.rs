//! What is said of a stage that trained on responses.

use super::doubts::{Remarks, far_from_prior, reasons};
use crate::response::{IN_PROPORTION, NOISE, OF_ONE_SIZE, OF_QUOTIENT, ResponseStageRecord};
use rijke_inference::NoiseEstimate;
use rijke_numerics::Tell;
use rijke_numerics::words::{counted, fixed, to_digits};

/// The models of a stage, best first.
pub fn tell_responses(stage: &ResponseStageRecord, tell: &dyn Tell) {
    let count: usize = stage.loads.iter().map(|l| l.frequency_hz.len()).sum();
    let all: usize = stage.loads.iter().map(|l| l.of).sum();
    tell.say(format!(
        "{} ({}, {count} of the {all} complex numbers in their files)",
        stage.title,
        counted(stage.loads.len(), "response")
    ));
    let models = stage.by_evidence();
    let best = models.first().map_or(0.0, |m| m.ln_evidence());
    let mut remarks = Remarks::default();
    for model in &models {
        if model.evidence.is_none() {
            tell.say(format!("  no evidence     {}: {}", model.id, model.remark.as_deref().unwrap_or("")));
            continue;
        }
        tell.say(format!("  {:>9} nats  {}", fixed(model.ln_evidence() - best, 1), model.id));
        for remark in reasons(&model.remark) {
            tell.say(format!("                  {}", remarks.next(remark)));
        }
    }
    stage.behind_by_a_prior().iter().for_each(|said| tell.note(format!("warning: {said}")));
    if let [first, second, ..] = models[..]
        && first.ln_evidence() - second.ln_evidence() < stage.decides
    {
        tell.say(format!(
            "  not decided: {} and {} are less than {} nats apart",
            first.id, second.id, stage.decides
        ));
    } else if let [first, _, ..] = models[..]
        && first.too_sure
    {
        tell.say("  the residuals of the best model are not noise, so its lead is overstated".to_owned());
    }
    if let Some(model) = models.first() {
        let (own, errors, channels) = model.by_kind();
        let told = errors.iter().filter(|p| !p.is_as_before());
        for p in own.iter().chain(told).chain(channels) {
            tell.say(format!("      {}", p.words()));
            far_from_prior(p).iter().for_each(|said| tell.note(format!("warning: {said}")));
        }
        let untold = errors.iter().filter(|p| p.is_as_before()).count();
        if untold > 0 {
            tell.say(format!(
                "      {untold} stated {} included, about which these data have no information",
                if untold == 1 { "error is" } else { "errors are" }
            ));
        }
        let grows = |n: &NoiseEstimate| match &n.name[..] {
            IN_PROPORTION => Some(format!(" + {} % of the modulus", to_digits(100.0 * n.sd, 2))),
            OF_QUOTIENT => Some(format!(
                " + {} % of 1 + |H|^2, as equal noise of both microphones has",
                to_digits(100.0 * n.sd, 2)
            )),
            OF_ONE_SIZE => {
                Some(format!(" of the level + {} in the unit of the pressures", to_digits(n.sd, 2)))
            }
            _ => None,
        };
        let grown = model.noise.iter().find_map(grows).unwrap_or_default();
        for n in model.noise.iter().filter(|n| n.floats && grows(n).is_none()) {
            let unit = if n.unit == "1" { "" } else { &n.unit };
            let grows = if n.name == NOISE { &grown[..] } else { "" };
            tell.say(format!("      {}: {:.3e} {unit}", n.name, n.sd).trim_end().to_owned() + grows);
        }
        if !grown.is_empty() {
            tell.say(
                "      that the noise has two parts was found from the residuals: a loss, a length or a place that is wrong leaves as much near resonances. \
                 A column `sd` tells the two apart"
                    .to_owned(),
            );
        }
        tell.say(format!(
            "      residual {:.3e}, correlation of neighbours {:.2}",
            model.residual, model.neighbours
        ));
    }
}
