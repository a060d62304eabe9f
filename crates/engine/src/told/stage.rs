//! What is said of a stage that trained on modes, and of its gas.

use super::doubts::{Remarks, far_from_prior, not_identified};
use crate::run::{Asked, Missing, ModelRecord, StageRecord};
use rijke_numerics::Tell;
use rijke_numerics::words::{counted, fixed, quantity, rounded, to_digits, with_sd};
use rijke_study::HeatedFit;

/// A misfit in growth rate (1/s), frequency (rad/s) and relative pressure that is none.
const NO_MISFIT: [f64; 3] = [1e-7, 1e-6, 1e-9];

/// A misfit is told in measured errors from so many of them on.
const SEVERAL: f64 = 3.0;

/// A line that is said of a stage.
enum Line {
    /// A result.
    Said(String),
    /// What speaks against the numbers: a sentence without its stop, and what stands before and behind it.
    Against([&'static str; 2], String),
    /// The same, said as a warning.
    Warned(String),
}

/// The models of a stage, best first.
pub fn tell_stage(stage: &StageRecord, tell: &dyn Tell) {
    for line in lines(stage) {
        match line {
            Line::Said(text) => tell.say(text),
            Line::Against([before, behind], doubt) => tell.say(format!("{before}{doubt}{behind}")),
            Line::Warned(doubt) => tell.note(format!("warning: {doubt}")),
        }
    }
}

/// All that the terminal says against the numbers of a stage, a sentence each without its stop.
#[must_use]
pub fn doubts_of_stage(stage: &StageRecord) -> Vec<String> {
    let doubt = |line: Line| match line {
        Line::Said(_) => None,
        Line::Against(_, doubt) | Line::Warned(doubt) => Some(doubt),
    };
    lines(stage).into_iter().filter_map(doubt).collect()
}

/// What stands before a line about the model that goes on.
const BELOW: &str = "      ";

/// All that is said of a stage.
fn lines(stage: &StageRecord) -> Vec<Line> {
    let against = |doubt: String| Line::Against([BELOW, ""], doubt);
    let mut all = table(stage);
    all.extend(stage.behind_by_a_prior().into_iter().map(Line::Warned));
    if let Some(model) = stage.models.iter().find(|m| m.id == stage.chosen) {
        all.extend(carried_on(stage));
        all.extend(undecided(stage, model).map(against));
        all.extend(assumed(stage).into_iter().map(|doubt| Line::Against([BELOW, "."], doubt)));
        let trained = !stage.measured.is_empty();
        all.push(Line::Said(if trained {
            misfit(stage, model)
        } else {
            "      no mode was measured: nothing was trained".to_owned()
        }));
        all.extend(stage.doubts_of_data().into_iter().map(against));
        for p in &model.parameters {
            all.push(Line::Said(format!("      {}", p.words())));
            let unknown = not_identified(p, stage.missed.is_some()).filter(|_| trained);
            all.extend(unknown.map(|doubt| Line::Against(["          ", ""], doubt)));
            all.extend(far_from_prior(p).map(Line::Warned));
        }
    }
    all.extend(stage.lengths.iter().map(|lengths| Line::Said(format!("      {}", lengths.words()))));
    if let Some(missing) = &stage.missing {
        all.extend(still_asked(missing));
        all.extend(missing.disagreeing().map(against));
        // What a missing term may have moved, and how little such terms explain.
        all.extend(stage.moved_since.iter().cloned().chain(stage.unexplained()).map(against));
    }
    all
}

/// The models with their evidence.
fn table(stage: &StageRecord) -> Vec<Line> {
    let mut all = vec![Line::Said(format!("{} ({})", stage.title, counted(stage.measured.len(), "mode")))];
    let models = stage.by_evidence();
    let best = models.first().map_or(0.0, |m| m.ln_evidence());
    let of_all = stage.remarks_of_all();
    let mut remarks = Remarks::default();
    for model in models {
        let mark = if model.id == stage.chosen { "  <- goes on" } else { "" };
        if model.evidence.is_some() {
            let behind = fixed(model.ln_evidence() - best, 1);
            all.push(Line::Said(format!("  {behind:>9} nats  {}{mark}", model.id)));
            let own = model.remarks().filter(|line| !of_all.contains(line));
            all.extend(own.map(|remark| Line::Said(format!("                  {}", remarks.next(remark)))));
        } else {
            let remark = model.remark.as_deref().unwrap_or("");
            all.push(Line::Said(format!("  no evidence     {}: {remark}", model.id)));
        }
    }
    all.extend(of_all.iter().map(|said| Line::Said(format!("      of all these: {said}"))));
    let one_start = stage.one_start.then(|| StageRecord::ONE_START.to_owned());
    all.extend(one_start.map(|doubt| Line::Against(["      of all these: ", ""], doubt)));
    all
}

/// What a model misses beyond the measured errors. What a search leaves of a noise that the data choose to be
/// none is none.
fn misfit(stage: &StageRecord, model: &ModelRecord) -> String {
    let size = |k: usize| Some(model.misfit[k].abs()).filter(|v| *v >= NO_MISFIT[k]).unwrap_or(0.0);
    let [growth, frequency, pressure] = [0, 1, 2].map(size);
    let times = |misfit: f64, measured: Vec<f64>| {
        let errors = (measured.iter().map(|sd| sd * sd).sum::<f64>() / measured.len() as f64).sqrt();
        let times = Some(misfit / errors).filter(|t| t.is_finite() && *t >= SEVERAL);
        times.map_or_else(String::new, |t| format!(" ({} times these)", to_digits(t, 2)))
    };
    let rates = stage.measured.iter().filter_map(|m| Some(m.growth_rate?[1])).collect();
    let frequencies = stage.measured.iter().filter_map(|m| Some(m.angular_frequency?[1])).collect();
    let of_pressures =
        if pressure > 0.0 { format!(", {} of relative pressures", rounded(pressure)) } else { String::new() };
    format!(
        "      misfit beyond the measured errors: {} 1/s{}, {} Hz{}{of_pressures}",
        rounded(growth),
        times(growth, rates),
        rounded(frequency / std::f64::consts::TAU),
        times(frequency, frequencies)
    )
}

/// What earlier stages took for certain though it is not decided.
fn assumed(stage: &StageRecord) -> Vec<String> {
    let one = |assumed: &String| format!("these numbers depend on an undecided choice. {assumed}");
    stage.assumes.iter().map(one).collect()
}

/// That the lead of a stage does not decide, where `model` goes on.
fn undecided(stage: &StageRecord, model: &ModelRecord) -> Option<String> {
    let (other, behind) = stage.nearest().filter(|(_, behind)| *behind < stage.decides)?;
    Some(format!(
        "{}; the numbers below are those of {}, and hold only if it is right",
        not_decided([&model.id, &other.id], behind.abs(), stage.decides),
        model.id
    ))
}

/// That two models are so many nats apart, and that it takes more to decide between them.
#[must_use]
pub fn not_decided([first, second]: [&str; 2], apart: f64, decides: f64) -> String {
    format!(
        "not decided between {first} and {second}, {apart:.1} nats apart, where {decides:.1} would decide"
    )
}

/// What later stages make of the models that a stage leaves open.
fn carried_on(stage: &StageRecord) -> Vec<Line> {
    let mut all = Vec::new();
    if !stage.carried.is_empty() {
        all.push(Line::Said("      not decided by this stage alone; evidence of this and all later stages together, with the best later models in brackets:".to_owned()));
    }
    for (open, nats) in stage.carried_below_best() {
        let later: Vec<&str> = open.later.iter().map(|l| l.model.as_str()).collect();
        let mark = if open.id == stage.chosen { "  <- goes on" } else { "" };
        all.push(Line::Said(match nats {
            Some(nats) => format!("  {:>9} nats  {} ({}){mark}", fixed(nats, 1), open.id, later.join("; ")),
            None => format!("  no evidence     {}: a later stage has no model that could be fitted", open.id),
        }));
    }
    all.extend(stage.not_carried().map(|doubt| Line::Against([BELOW, ""], doubt)));
    all
}

/// The first terms that the data still ask for.
fn still_asked(missing: &Missing) -> Vec<Line> {
    let Some(first) = missing.families.first() else { return Vec::new() };
    let tried = missing.tried;
    if !first.is_required() {
        return vec![Line::Said(format!(
            "      missing: no single further term is significant; the best of {tried} that were tried is {} (p = {:.2} by chance)",
            first.first.words(),
            first.first.probability
        ))];
    }
    let mut all = vec![
        "the data require a further term; the standard deviations above assume a complete model, and are too small:"
            .to_owned(),
    ];
    all.extend(missing.required().take(2).enumerate().map(|(k, family)| {
        let (Asked { strength: [value, sd], unit, gain, .. }, (beyond, probability)) =
            (&family.first, family.beyond);
        // The strength is that of the term alone, and says nothing of it beyond another.
        let (word, gain, strength) = match k {
            0 => ("missing", *gain, format!(" = {}", quantity(*value, *sd, unit))),
            _ => ("and beyond that", beyond, String::new()),
        };
        format!(
            "{word}: {}{strength}: {gain:+.1} nats expected, p = {probability:.3} ({})",
            family.first.words(),
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
    all.into_iter().map(|doubt| Line::Against([BELOW, ""], doubt)).collect()
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
