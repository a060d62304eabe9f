//! Names of stages, questions and maps.

use super::Plan;
use crate::error::{EARLIER, StudyProblem};
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

/// The problem, or where a stage of the file is named too early, that.
pub(super) fn or_later(problem: StudyProblem, of_the_file: &[String]) -> StudyProblem {
    match problem {
        StudyProblem::Unknown { what: EARLIER, name, known } if of_the_file.contains(&name) => {
            StudyProblem::Later { name, known }
        }
        problem => problem,
    }
}

/// Refuses a name that no stage of modes has; `what` the name should be.
pub(super) fn known_stage(plan: &Plan, what: &'static str, id: &str) -> Result<(), StudyProblem> {
    if plan.stage(id).is_some() {
        return Ok(());
    }
    let known = listed(plan.stages.iter().map(|s| s.id.as_str()));
    Err(StudyProblem::Unknown { what, name: id.to_owned(), known })
}
