//! What the measurements of a campaign can tell of each model that `rijke rank` would train, in words and pictures.

use super::identify::{Identified, identify};
use super::prior::figures;
use super::stages::{Stage, stages};
use crate::{
    failure::{Classify, Failure},
    staging::StagedFolder,
    ui::Ui,
};
use rayon::prelude::*;
use rijke_candidates::Candidate;
use rijke_numerics::C64;
use rijke_report::gallery;
use rijke_rig::{DataKind, Observations, OperatingPoint, Rig};
use serde_json::{Value, json};
use std::{
    collections::{BTreeMap, BTreeSet},
    fmt::Write as _,
    path::Path,
};

/// Noise of one operating point where nothing else is said: growth rate (1/s) and angular frequency (rad/s) as in section 6.1 of the
/// paper, relative pressure as cold points have it (docs/records/model.md).
pub(crate) const NOISE_SD: [f64; 3] = [0.1, 1.0, 1e-3];

/// Numbers that are needed to tell a spread.
const NOISE: usize = 2;

/// What is checked.
pub(crate) struct Subject {
    pub(super) rig: Rig,
    /// The operating points, each with its ambient temperature, K.
    pub(super) points: Vec<(OperatingPoint, f64)>,
    /// Measured or virtual; none of what is only planned.
    pub(super) kind: Option<DataKind>,
    /// Candidates of the user's own.
    pub(super) own: Vec<Candidate>,
    /// s of the operating points that were observed.
    pub(super) measured: BTreeMap<String, C64>,
}

impl Subject {
    /// What was observed, and candidates of the user's own.
    pub(crate) fn observed(observations: &Observations, own: Vec<Candidate>) -> Self {
        let points = &observations.points;
        Self {
            rig: observations.rig.clone(),
            points: points.iter().map(|p| (p.point.clone(), p.ambient.ambient_temperature)).collect(),
            kind: Some(observations.kind),
            own,
            measured: measured(observations),
        }
    }

    fn stages(&self) -> Result<(Vec<Stage>, Option<String>), Failure> {
        stages(&self.rig, &self.points, &self.own)
    }
}

/// s of the operating points with pings.
pub(super) fn measured(observations: &Observations) -> BTreeMap<String, C64> {
    observations.points.iter().filter_map(|p| Some((p.point.id.clone(), p.ping.as_ref()?.s))).collect()
}

/// Says for every stage which models would be ranked, and warns of what they could not learn.
pub(super) fn say(subject: &Subject, sd: [f64; 3], ui: &Ui) -> Result<Value, Failure> {
    let (stages, missing) = subject.stages()?;
    let total = stages.iter().map(|s| s.models.len()).sum::<usize>() as u64;
    let bar = ui.progress("identifying", total);
    let mut answers = Vec::new();
    let mut lines = Vec::new();
    for stage in &stages {
        let (models, points) = (stage.models.len(), stage.points.len());
        lines.push(format!("{}: {models} models on {points} points of their own", stage.role));
        let one = |(_, assembly): &(_, _)| {
            let found = identify(assembly, stage, sd);
            bar.advance(1);
            found
        };
        let found: Vec<_> = stage.models.par_iter().map(one).collect();
        for ((id, _), found) in stage.models.iter().zip(found) {
            match found {
                Ok(found) => {
                    lines.extend(warning(id, &found.unidentified));
                    lines.extend(boundless(&found, points).map(|why| format!("warning: {id}: {why}")));
                    answers.push(answer(stage.role, id, &found));
                }
                // Such as a prior at whose centre there is no mode: training would start there.
                Err(error) => {
                    lines.push(format!("warning: {id}: no prediction at the centre of its priors: {error}"))
                }
            }
        }
    }
    drop(bar);
    if !stages.is_empty() {
        let [growth, frequency, pressure] = sd;
        ui.say(format!(
            "what these points would tell, known to {growth} 1/s, {frequency} rad/s and {pressure} of relative pressure each:"
        ));
    }
    lines.iter().for_each(|line| ui.say(format!("  {line}")));
    if let Some(missing) = missing {
        ui.say(format!("  {missing}; it is not ranked, nor what builds on it"));
    }
    Ok(json!(answers))
}

fn warning(id: &str, unidentified: &[(String, f64)]) -> Option<String> {
    let one = |(what, width): &(String, f64)| format!("{what} at {width:.2}");
    let list = unidentified.iter().map(one).collect::<Vec<_>>().join(", ");
    (!list.is_empty()).then(|| format!("warning: {id}: of its prior width, the data would leave {list}"))
}

/// Why the noise of a model cannot be learnt from `points` points of its own, if it cannot.
fn boundless(found: &Identified, points: usize) -> Option<String> {
    let [growth, frequency] = found.left_to_noise;
    let lacking = NOISE.saturating_sub(growth.min(frequency));
    (lacking > 0).then(|| {
        format!(
            "{points} points, of which the model leaves {growth} growth rates and {frequency} frequencies to tell its noise; \
             {NOISE} of each are needed: measure at {} positions or more",
            points + lacking
        )
    })
}

/// Refuses observations with a cold stage none of whose models can be fitted, because its noise would float to zero.
pub(crate) fn refuse_boundless(observations: &Observations, own: &[Candidate]) -> Result<(), Failure> {
    let points = observations.points.iter().filter(|p| p.ping.is_some());
    let points: Vec<_> = points.map(|p| (p.point.clone(), p.ambient.ambient_temperature)).collect();
    let (stages, _) = stages(&observations.rig, &points, own)?;
    for stage in stages.iter().filter(|s| s.points.iter().all(|c| c.point.power == 0.0)) {
        let one = |(_, assembly): &(_, _)| match identify(assembly, stage, NOISE_SD) {
            Ok(found) => boundless(&found, stage.points.len()),
            // The fit will say what is wrong with it.
            Err(_) => None,
        };
        let reasons: Vec<Option<String>> = stage.models.par_iter().map(one).collect();
        if let Some(Some(first)) = reasons.iter().find(|_| reasons.iter().all(Option::is_some)) {
            let (id, _) = &stage.models[0];
            let rows: BTreeSet<&str> = stage.points.iter().map(|c| c.point.row.as_str()).collect();
            let rows = rows.into_iter().collect::<Vec<_>>().join(", ");
            return Err(Failure::bad_input(format!(
                "row {rows}: no model of the {} can be fitted: {id}: {first}",
                stage.role
            ))
            .remedy(format!("Measure row {rows} at more positions, or leave it out of the observations.")));
        }
    }
    Ok(())
}

fn answer(role: &str, id: &str, found: &Identified) -> Value {
    json!({ "role": role, "id": id, "posterior_over_prior_width": found.widths, "unidentified": found.unidentified })
}

/// Draws the prior predictions of every stage into a folder.
pub(crate) fn draw(subject: &Subject, out: &Path, force: bool, ui: &Ui) -> Result<Value, Failure> {
    let (stages, _) = subject.stages()?;
    // Every campaign that can be drawn has this stage.
    let folder = StagedFolder::new(out, "prongs.svg", force)?;
    let bar = ui.progress("drawing", stages.iter().map(|s| s.models.len()).sum::<usize>() as u64);
    let (mut names, mut lost, mut page) = (Vec::new(), 0, String::new());
    for stage in &stages {
        let (figures, without) = figures(stage, &subject.measured, subject.kind, &|| bar.advance(1))?;
        lost += without;
        for (name, figure) in figures {
            let path = folder.path().join(&name);
            std::fs::write(&path, figure.svg()).or_failed().map_err(|f| f.at(&path))?;
            let _ = writeln!(page, "<p><img src=\"{name}\" alt=\"{}\"></p>", figure.title);
            names.push(out.join(name));
        }
    }
    drop(bar);
    if names.is_empty() {
        return Err(Failure::bad_input(
            "--plots: the campaign teaches no model, so there is nothing to draw",
        )
        .remedy("Plan the empty tube and prongs alone at two positions, or leave out --plots."));
    }
    let index = folder.path().join("index.html");
    std::fs::write(&index, gallery("What the priors allow", &page)).or_failed().map_err(|f| f.at(&index))?;
    folder.commit()?;
    if lost > 0 {
        ui.say(format!("{lost} draws from the priors have no mode near that of the centre; they are left out of the pictures"));
    }
    ui.note(format!("wrote {}", out.display()));
    Ok(json!(names))
}
