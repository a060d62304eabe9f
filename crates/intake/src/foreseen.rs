//! The base flow of operating points that were not measured, by the posterior of those that were.

use crate::flow::{blame, flow_is_due, readings};
use rijke_flow::{BaseStates, Closures, POSITION, POWER, PROFILES, TubeObservations, settled};
use rijke_numerics::{Classify, Failed, Tell};
use rijke_rig::Observations;
use rijke_study::{PointState, States, Study, read_states};

/// Adds to the study the states of the points `places` that `base/states.json` lacks, by the fit of which
/// that file was made. Where the flow is not inferred from clicks or readings nothing is added, and the
/// points are refused later.
///
/// # Errors
/// Observations of which nothing can be foreseen, with the remedy.
pub fn foresee(study: &mut Study, places: &[usize], tell: &dyn Tell) -> Result<(), Failed> {
    let folder = study.folder.join("observations");
    let path = study.folder.join("base").join("states.json");
    if !flow_is_due(study) || !path.is_file() || folder.join(PROFILES).is_file() {
        return Ok(());
    }
    let known = read_states(&path, &study.rig).or_bad_input()?;
    let lacking = study.lacking(places, &known);
    if lacking.is_empty() {
        return Ok(());
    }
    let mut observations = Observations::read(&folder).or_bad_input()?;
    let asked = study.campaign.unmeasured(&lacking, &observations, POSITION, POWER).map_err(|why| {
        Failed::bad_input(why)
            .at(&folder)
            .remedy("Ask for points that differ from measured ones in place and power of the heat alone.")
    })?;
    observations.points.extend(asked);
    let observations = TubeObservations::of(&observations, &folder).or_bad_input()?;
    let (_, readings) = readings(&folder, &observations)?;
    let progress = tell.progress("base flow of points that were not measured", 1);
    let runs = settled::heated(&observations, &readings, &Closures::default());
    let runs = runs.or_bad_input().map_err(|f| f.at(&folder))?;
    let fit = settled::JointFit::new(&runs).map_err(blame)?;
    let points = fit.base_states().or_failed()?.into_iter().collect();
    drop(progress);
    let found = BaseStates { kind: observations.kind, source: observations.source.clone(), points };
    let mut all = States::new();
    for (id, record) in found.for_laws(&observations).points {
        let state = PointState::of(record, &id, &study.rig).or_failed()?;
        all.insert(id, state);
    }
    let lacking: Vec<String> = lacking.iter().map(|p| p.id.clone()).collect();
    if study.foresee(&lacking, &known, all) {
        return Ok(());
    }
    Err(Failed::bad_input("base/states.json was not made from the present observations, so the flow at other points cannot be predicted")
        .at(&path)
        .remedy("Run `rijke flow` without --closures and --separate, or `rijke run`, then `rijke rank`; or predict measured points."))
}
