//! Names of stages, questions and maps.

use super::Plan;
use crate::StudyProblem;
use crate::source::listed;

/// An id names files.
pub(super) fn short_id(id: &str) -> Result<(), StudyProblem> {
    const LONGEST: usize = 100;
    const SHOWN: usize = 20;
    let count = id.chars().count();
    let good = |c: char| c.is_alphanumeric() || ['-', '_', '.'].contains(&c);
    // Files of further models end so.
    let taken = id.starts_with('.') || id.ends_with(".rival") || id.ends_with(".open");
    if (1..=LONGEST).contains(&count) && id.chars().all(good) && !taken {
        return Ok(());
    }
    let rest = if count > SHOWN { "..." } else { "" };
    let (key, value) = ("id".to_owned(), id.chars().take(SHOWN).collect::<String>() + rest);
    let need = "1 to 100 letters, digits, -, _ or ., with no . in front, and not ending in .rival or .open: it is also the name of files";
    Err(StudyProblem::Value { key, value, need })
}

pub(super) fn known_stage(plan: &Plan, id: &str) -> Result<(), StudyProblem> {
    if plan.stage(id).is_some() {
        return Ok(());
    }
    let known = listed(plan.stages.iter().map(|s| s.id.as_str()));
    Err(StudyProblem::Unknown { what: "earlier stage", name: id.to_owned(), known })
}
