//! Names of stages, questions and maps.

use super::Plan;
use crate::Problem;
use crate::source::listed;

/// An id names files.
pub(super) fn short_id(id: &str) -> Result<(), Problem> {
    const LONGEST: usize = 100;
    let (key, value) = ("id".to_owned(), id.chars().take(20).collect::<String>() + "...");
    let need = "at most 100 characters without / and \\, and no path; it names files";
    let path = id.contains(['/', '\\']) || id.chars().any(char::is_control) || [".", ".."].contains(&id);
    if id.len() > LONGEST || path { Err(Problem::Value { key, value, need }) } else { Ok(()) }
}

pub(super) fn known_stage(plan: &Plan, id: &str) -> Result<(), Problem> {
    if plan.stage(id).is_some() {
        return Ok(());
    }
    let known = listed(plan.stages.iter().map(|s| s.id.as_str()));
    Err(Problem::Unknown { what: "earlier stage", name: id.to_owned(), known })
}
