//! On which earlier stages a stage may stand.

use super::{Plan, Stage};
use crate::error::{EARLIER, StudyProblem};
use crate::source::listed;

/// Refuses a name of nothing that a stage may stand on: stages of modes and of responses.
pub(super) fn known_ground(plan: &Plan, id: &str) -> Result<(), StudyProblem> {
    if plan.stage(id).is_some() || plan.response(id).is_some() {
        return Ok(());
    }
    let stages = plan.stages.iter().map(|s| s.id.as_str());
    let known = listed(plan.responses.iter().map(|s| s.id.as_str()).chain(stages));
    Err(StudyProblem::Unknown { what: EARLIER, name: id.to_owned(), known })
}

/// Refuses a stage that counts what a stage of responses found twice: by itself and through another on which
/// it stands too.
pub(super) fn counted_once(plan: &Plan, stage: &Stage) -> Result<(), StudyProblem> {
    let mut below = Vec::new();
    for id in plan.grounds(stage) {
        let mut own = vec![id];
        while let Some(on) = own.pop() {
            if below.contains(&on) {
                let (key, value) = ("on".to_owned(), stage.on.join(", "));
                let need = "stages that do not stand on one another: what a stage of responses found counts once; leave out the stage that \
                            another one of them stands on";
                return Err(StudyProblem::Value { key, value, need });
            }
            below.push(on);
            own.extend(plan.response(on).iter().flat_map(|r| r.on.iter().map(String::as_str)));
        }
    }
    Ok(())
}
