//! What a kind of question is: the keys that it adds, with their checks, and its answer.

use super::super::course::Run;
use super::answer::Found;
use crate::EngineError;
use rijke_study::plan::{Question, Selection, fields_of};
use rijke_study::{Study, StudyError, StudyProblem};
use serde::de::DeserializeOwned;

/// A kind of question: a structure whose fields are the keys that it adds to those of all questions.
pub(super) trait Ask: DeserializeOwned {
    /// As `ask` names it.
    const KIND: &'static str;

    /// Checks what the keys name; roles and candidates of a key `with` are checked before.
    fn check(&self, _: &Study) -> Result<(), StudyProblem> {
        Ok(())
    }

    /// The points at which the model of its stage must be defined, whether they were measured or not.
    fn foresees(&self) -> Option<&Selection> {
        None
    }

    /// The answer, once its stage has run.
    fn answer(&self, run: &Run, question: &Question) -> Result<Found, EngineError>;
}

/// What a study knows of a kind.
pub(super) struct Kind {
    pub(super) name: &'static str,
    pub(super) keys: fn() -> &'static [&'static str],
    pub(super) check: fn(&Study, &Question) -> Result<(), StudyError>,
    pub(super) foresees: fn(&Question) -> Result<Option<Selection>, StudyError>,
    pub(super) answer: fn(&Run, &Question) -> Result<Found, EngineError>,
}

impl Kind {
    pub(super) const fn of<A: Ask>() -> Self {
        Self {
            name: A::KIND,
            keys: fields_of::<A>,
            check: |study, question| question.keys::<A>()?.check(study).map_err(|why| question.fail(why)),
            foresees: |question| Ok(question.keys::<A>()?.foresees().cloned()),
            answer: |run, question| question.keys::<A>()?.answer(run, question),
        }
    }

    /// The one `among` all that is the kind of a question.
    pub(super) fn named<'a>(among: &'a [Self], question: &Question) -> Result<&'a Self, StudyError> {
        among.iter().find(|kind| kind.name == question.kind).ok_or_else(|| {
            let known = among.iter().map(|kind| kind.name).collect::<Vec<_>>().join(", ");
            let name = question.kind.clone();
            question.fail(StudyProblem::Unknown { what: "kind of question", name, known })
        })
    }
}
