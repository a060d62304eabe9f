//! Names of stages, questions and maps.

use super::Plan;
use crate::StudyProblem;
use crate::source::listed;

/// An id names files.
pub(super) fn short_id(id: &str) -> Result<(), StudyProblem> {
    const LONGEST: usize = 100;
    let (key, value) = ("id".to_owned(), id.chars().take(20).collect::<String>() + "...");
    let need = "at most 100 characters without / and \\, and no path; it names files";
    let path = id.contains(['/', '\\']) || id.chars().any(char::is_control) || [".", ".."].contains(&id);
    if id.len() > LONGEST || path { Err(StudyProblem::Value { key, value, need }) } else { Ok(()) }
}

pub(super) fn known_stage(plan: &Plan, id: &str) -> Result<(), StudyProblem> {
    if plan.stage(id).is_some() {
        return Ok(());
    }
    let known = listed(plan.stages.iter().map(|s| s.id.as_str()));
    Err(StudyProblem::Unknown { what: "earlier stage", name: id.to_owned(), known })
}
