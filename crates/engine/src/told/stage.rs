//! What is said of a stage that trained on modes, and of its gas.

use super::doubts::{far_from_prior, not_identified};
use crate::run::{Asked, Missing, ModelRecord, StageRecord};
use rijke_numerics::Tell;
use rijke_numerics::words::{counted, fixed, quantity, rounded, with_sd};
use rijke_study::HeatedFit;

/// A misfit in growth rate (1/s), frequency (rad/s) and relative pressure that is none.
const NO_MISFIT: [f64; 3] = [1e-7, 1e-6, 1e-9];

/// The models of a stage, best first.
pub fn tell_stage(stage: &StageRecord, tell: &dyn Tell) {
    tell.say(format!("{} ({})", stage.title, counted(stage.measured.len(), "mode")));
    let say = |all: Vec<String>| all.iter().for_each(|said| tell.say(format!("      {said}")));
    let models = stage.by_evidence();
    let best = models.first().map_or(0.0, |m| m.ln_evidence());
    let of_all = stage.remarks_of_all();
    for model in models {
        let mark = if model.id == stage.chosen { "  <- goes on" } else { "" };
        match model.evidence {
            Some(_) => {
                tell.say(format!("  {:>9} nats  {}{mark}", fixed(model.ln_evidence() - best, 1), model.id));
                for remark in model.remarks().filter(|line| !of_all.contains(line)) {
                    tell.say(format!("                  {remark}"));
                }
            }
            None => {
                tell.say(format!(
                    "  no evidence     {}: {}",
                    model.id,
                    model.remark.as_deref().unwrap_or("")
                ));
            }
        }
    }
    of_all.iter().for_each(|said| tell.say(format!("      of all these: {said}")));
    if stage.one_start {
        tell.say(format!("      of all these: {}", StageRecord::ONE_START));
    }
    stage.behind_by_a_prior().iter().for_each(|said| tell.note(format!("warning: {said}")));
    if let Some(model) = stage.models.iter().find(|m| m.id == stage.chosen) {
        carried_on(stage, tell);
        say(undecided(stage, model).into_iter().collect());
        say(assumed(stage).into_iter().map(|said| said + ".").collect());
        // What a search leaves of a noise that the data choose to be none.
        let size = |k: usize| Some(model.misfit[k].abs()).filter(|v| *v >= NO_MISFIT[k]).unwrap_or(0.0);
        let [growth, frequency, pressure] = [0, 1, 2].map(size);
        let trained = !stage.measured.is_empty();
        let of_pressures = if pressure > 0.0 {
            format!(", {} of relative pressures", rounded(pressure))
        } else {
            String::new()
        };
        let misfit = format!(
            "      misfit beyond the measured errors: {} 1/s, {} Hz{of_pressures}",
            rounded(growth),
            rounded(frequency / std::f64::consts::TAU)
        );
        tell.say(if trained { misfit } else { "      no mode was measured: nothing was trained".to_owned() });
        say(stage.doubts_of_data());
        for p in &model.parameters {
            tell.say(format!("      {}", p.words()));
            if trained {
                not_identified(p, stage.missed.is_some())
                    .iter()
                    .for_each(|said| tell.say(format!("          {said}")));
            }
            far_from_prior(p).iter().for_each(|said| tell.note(format!("warning: {said}")));
        }
    }
    if let Some(lengths) = &stage.lengths {
        tell.say(format!("      {}", lengths.words()));
    }
    if let Some(missing) = &stage.missing {
        say(still_asked(missing));
        say(missing.disagreeing().collect());
        say(moved_or_unexplained(stage));
    }
}

/// All that the terminal says against the numbers of a stage, a sentence each without its stop.
#[must_use]
pub fn doubts_of_stage(stage: &StageRecord) -> Vec<String> {
    let mut all = stage.behind_by_a_prior();
    all.extend(stage.one_start.then(|| StageRecord::ONE_START.to_owned()));
    all.extend(stage.not_carried());
    if let Some(model) = stage.models.iter().find(|m| m.id == stage.chosen) {
        all.extend(undecided(stage, model));
        all.extend(assumed(stage));
        all.extend(stage.doubts_of_data());
        let trained = model.parameters.iter().filter(|_| !stage.measured.is_empty());
        all.extend(trained.filter_map(|p| not_identified(p, stage.missed.is_some())));
        all.extend(model.parameters.iter().filter_map(far_from_prior));
    }
    if let Some(missing) = stage.missing.as_ref().filter(|m| m.required().next().is_some()) {
        all.extend(still_asked(missing));
    }
    all.extend(stage.missing.iter().flat_map(Missing::disagreeing));
    all.extend(moved_or_unexplained(stage));
    all
}

/// What earlier stages took for certain though it is not decided.
fn assumed(stage: &StageRecord) -> Vec<String> {
    let one = |assumed: &String| format!("these numbers depend on an undecided choice. {assumed}");
    stage.assumes.iter().map(one).collect()
}

/// What a missing term may have moved, and how little such terms explain.
fn moved_or_unexplained(stage: &StageRecord) -> Vec<String> {
    stage.moved_since.iter().cloned().chain(stage.unexplained()).collect()
}

/// That the lead of a stage does not decide, where `model` goes on.
fn undecided(stage: &StageRecord, model: &ModelRecord) -> Option<String> {
    let (other, behind) = stage.nearest().filter(|(_, behind)| *behind < stage.decides)?;
    let (leader, lead) = if behind < 0.0 { (other, -behind) } else { (model, behind) };
    let right = if behind < 0.0 { model.id.as_str() } else { "it" };
    Some(format!(
        "not decided: {} leads by {lead:.1} nats, and {:.1} would decide; the numbers below hold only if {right} is right",
        leader.id, stage.decides
    ))
}

/// What later stages make of the models that a stage leaves open.
fn carried_on(stage: &StageRecord, tell: &dyn Tell) {
    if !stage.carried.is_empty() {
        tell.say("      not decided by this stage alone; evidence of this and all later stages together, with the best later models in brackets:".to_owned());
    }
    for (open, nats) in stage.carried_below_best() {
        let later: Vec<&str> = open.later.iter().map(|l| l.model.as_str()).collect();
        let mark = if open.id == stage.chosen { "  <- goes on" } else { "" };
        tell.say(match nats {
            Some(nats) => format!("  {:>9} nats  {} ({}){mark}", fixed(nats, 1), open.id, later.join("; ")),
            None => format!("  no evidence     {}: a later stage has no model that could be fitted", open.id),
        });
    }
    stage.not_carried().iter().for_each(|said| tell.say(format!("      {said}")));
}

/// The first terms that the data still ask for.
fn still_asked(missing: &Missing) -> Vec<String> {
    let Some(first) = missing.families.first() else { return Vec::new() };
    let tried = missing.tried;
    if !first.is_required() {
        return vec![format!(
            "missing: no further term is significant; the best of {tried} that were tried is {} (p = {:.2} by chance)",
            first.first.words(),
            first.first.probability
        )];
    }
    let mut all = vec![
        "the data require a further term; the standard deviations above assume a complete model, and are too small:"
            .to_owned(),
    ];
    all.extend(missing.required().take(2).enumerate().map(|(k, family)| {
        let (Asked { strength: [value, sd], unit, gain, .. }, (beyond, probability)) =
            (&family.first, family.beyond);
        let (word, gain) = if k == 0 { ("missing", *gain) } else { ("and beyond that", beyond) };
        format!(
            "{word}: {} = {}: {gain:+.1} nats expected, p = {probability:.3} ({})",
            family.first.words(),
            quantity(*value, *sd, unit),
            match family.like.len() {
                0 => format!(
                    "the data distinguish it from the other {} terms that were tried",
                    tried.saturating_sub(1)
                ),
                1 => format!(
                    "the data cannot distinguish it from one other of the {tried} terms that were tried"
                ),
                like => format!(
                    "the data cannot distinguish it from {like} others of the {tried} terms that were tried"
                ),
            }
        )
    }));
    all
}

/// What thermometers say of the heat of a stream.
pub fn tell_heat(heat: &HeatedFit, tell: &dyn Tell) {
    tell.note(format!(
        "from the readings: share of the power in the gas {}, heat transfer coefficient at the wall {} W/(m^2 K)",
        with_sd(heat.share[0], heat.share[1]),
        with_sd(heat.cooling[0], heat.cooling[1])
    ));
    if let Some([ratio, sd]) = heat.near {
        tell.note(format!(
            "one diameter downstream of the part the coefficient is {} times that",
            with_sd(ratio, sd)
        ));
    }
    let (scatter, [low, high]) = (100.0 * heat.scatter, heat.scatter_within.map(|v| 100.0 * v));
    // Where all of the posterior lies at one value, nothing is known of its width.
    let within = if (low..=high).contains(&scatter) && low < high {
        format!(" (root mean square of the posterior; 95 % of it from {low:.2} to {high:.2} %)")
    } else {
        String::new()
    };
    tell.note(format!("the rise of the gas scatters from point to point by {scatter:.2} %{within}"));
    let [offset, sd, before] = heat.common;
    if before > 0.0 && !heat.thermometers.is_empty() {
        tell.note(format!(
            "the thermometers together read {} K too much, by readings and heat (0 +- {} before them)",
            with_sd(offset, sd),
            rounded(before)
        ));
    }
    tell.warn(&heat.warnings());
}
