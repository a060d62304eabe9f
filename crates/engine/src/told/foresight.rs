//! What is said of what a campaign could tell.

use crate::run::StageForesight;
use rijke_numerics::Tell;
use rijke_numerics::words::counted;
use rijke_study::Study;
use rijke_study::plan::Stage;
use std::collections::{BTreeMap, BTreeSet};

/// Says it of a stage.
pub fn tell_foresight(study: &Study, stage: &StageForesight, tell: &dyn Tell) {
    tell.say(format!("{} ({})", stage.title, counted(stage.points, "operating point")));
    let grounds = study.plan.stage(&stage.id).map_or_else(Vec::new, |(_, plan)| study.plan.grounds(plan));
    if !grounds.is_empty() {
        tell.say(format!("  these ratios leave out what the data of {} add", grounds.join(", ")));
    }
    if stage.observed == Some(0) && !grounds.is_empty() {
        tell.say("  none of them was observed: its modes are predicted, and nothing is trained".to_owned());
    } else if stage.observed == Some(0) {
        tell.say("  none of them was observed: `rijke rank` needs --until an earlier stage".to_owned());
    }
    if stage.assumed > 0 {
        tell.say(format!(
            "  the gas at {} of them is not inferred yet and counts as ambient and at rest: parameters that act through heat or flow are not judged",
            stage.assumed
        ));
    }
    if let Some((_, plan)) = study.plan.stage(&stage.id)
        && (&plan.noise.installation, plan.noise.varying.len()) == (&None, 0)
        && let shared = shared_installations(study, plan)
        && shared > 0
    {
        tell.say(format!(
            "  {} several of these points, which count as independent: if the rig changes from installation to installation, \
             give the size of these changes as `installation` in [stage.noise] of study.toml",
            if shared == 1 { "1 installation has".to_owned() } else { format!("{shared} installations each have") }
        ));
    }
    if study.plan.stage(&stage.id).is_some_and(|(_, plan)| plan.base_errors) {
        tell.say("  these ratios leave out the errors of the gas; `rijke rank` counts them, and its posterior can be several times wider".to_owned());
    }
    let doubled: BTreeSet<&String> = stage.models.iter().flat_map(|m| &m.doubled).collect();
    doubled.into_iter().for_each(|said| tell.note(format!("warning: {said}")));
    for model in &stage.models {
        let width = |(name, w): (&String, &f64)| match *w {
            w if w < 0.01 => format!("{name} {w:.1e}"),
            w => format!("{name} {w:.2}"),
        };
        let widths = model.widths.iter().map(|(name, w)| width((name, w))).collect::<Vec<_>>().join(", ");
        tell.say(match model.widths.is_empty() {
            _ if !model.flat.is_empty() => format!(
                "  {}: the prior of {} is flat: it has no width that data could reduce, and this model will have no evidence",
                model.id,
                model.flat.join(", ")
            ),
            true => format!("  {}: no parameters", model.id),
            false => format!(
                "  {}: sd after these data over sd of the prior (1: not determined): {widths}",
                model.id
            ),
        });
        for (direction, share) in &model.unidentified {
            tell.say(format!(
                "    not identified: {direction} keeps {:.0} % of its prior width",
                100.0 * share
            ));
        }
        if !model.lost.is_empty() {
            tell.say(format!("    no mode at the centre of the priors at {}", model.lost.join(", ")));
        }
    }
}

/// How many installations have several points of a stage.
fn shared_installations(study: &Study, stage: &Stage) -> usize {
    let mut points: BTreeMap<&str, usize> = BTreeMap::new();
    for point in study.campaign.points.iter().filter(|p| stage.points.holds(&study.campaign, p)) {
        *points.entry(&point.installation).or_default() += 1;
    }
    points.values().filter(|n| **n > 1).count()
}
