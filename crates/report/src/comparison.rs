//! What the paper prints or states beside what these records give, with one sentence on the difference.

use crate::draw::html;
use serde_json::{Value, json};

/// One thing that can be compared.
pub(crate) struct Comparison {
    /// What is compared, such as "model chosen".
    pub(crate) what: String,
    /// What the paper prints or states.
    pub(crate) paper: String,
    /// The same from these records.
    pub(crate) ours: String,
    /// How they compare.
    pub(crate) verdict: Verdict,
    /// One honest sentence.
    pub(crate) sentence: String,
}

/// How ours compares with the paper's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// The same, within what can be expected of other data.
    Agrees,
    /// Not the same.
    Differs,
    /// The evidence here is too weak to say.
    Undecided,
    /// The records do not allow a comparison.
    CannotCompare,
}

impl Verdict {
    /// Agrees if `yes`, differs if not.
    pub(crate) fn of(yes: bool) -> Self {
        if yes { Self::Agrees } else { Self::Differs }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Agrees => "agrees",
            Self::Differs => "differs",
            Self::Undecided => "not decided",
            Self::CannotCompare => "cannot be compared",
        }
    }

    fn class(self) -> &'static str {
        match self {
            Self::Agrees => "agrees",
            Self::Differs => "differs",
            Self::Undecided | Self::CannotCompare => "cannot",
        }
    }
}

impl Comparison {
    /// For the template of the page.
    pub(crate) fn value(&self) -> Value {
        json!({
            "what": html(&self.what),
            "paper": html(&self.paper),
            "ours": html(&self.ours),
            "verdict": self.verdict.words(),
            "class": self.verdict.class(),
            "sentence": html(&self.sentence),
        })
    }
}
