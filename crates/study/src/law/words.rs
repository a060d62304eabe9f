//! What a law may name, and the law read with these names.

use super::place::Place;
use crate::names::{LEVINE_SCHWINGER, WALL_EP, WALL_MU};
use crate::source::Outcome;
use crate::{StudyProblem, names};
use rijke_formula::{Context, Formula, Scope};
use std::collections::BTreeSet;
use std::ops::Range;

/// What a law's text may name besides the scope: parameters, named subexpressions, and the numbers of its
/// part by their bare names.
pub(crate) struct Words<'a> {
    pub(crate) scope: &'a Scope,
    pub(crate) parameters: &'a [String],
    /// Named subexpressions, in order.
    pub(crate) definitions: &'a [(String, String)],
    /// Bare name, and name in the scope.
    pub(crate) own: &'a [(String, String)],
    /// Whether a number of the part comes before a parameter of the same name: in the laws that an element
    /// brings.
    pub(crate) own_first: bool,
}

impl Words<'_> {
    /// Reads the law of `coefficient` at `place`; `at` is where its text stands. Adds the definitions that it
    /// needs to `used`.
    pub(crate) fn law(
        &self,
        text: &str,
        place: &Place,
        at: Range<usize>,
        key: &str,
        used: &mut BTreeSet<String>,
    ) -> Outcome<Formula> {
        let (scope, end, wall) = (self.scope, place.is_end(), place.is_duct());
        let here = |name: usize| match name {
            WALL_MU | WALL_EP => !wall,
            LEVINE_SCHWINGER | names::FLANGED => end,
            _ => true,
        };
        let definitions = self.needed(text, used);
        // A parameter that a number hides keeps its place in the list, under a name that no formula has.
        let hidden = |name: &String| self.own_first && self.own.iter().any(|(own, _)| own == name);
        let parameters: Vec<String> =
            self.parameters.iter().map(|p| if hidden(p) { format!("${p}") } else { p.clone() }).collect();
        let context = Context { scope, here: &here, parameters: &parameters, definitions: &definitions };
        Formula::parse(text, &context)
            .map_err(|source| (at, StudyProblem::Formula { key: key.to_owned(), source }))
    }

    /// The definitions that `text` needs, directly or through others, in order; numbers of the part first.
    fn needed(&self, text: &str, used: &mut BTreeSet<String>) -> Vec<(String, String)> {
        let mut wanted: BTreeSet<String> = words(text).map(str::to_owned).collect();
        for (name, text) in self.definitions.iter().rev() {
            if wanted.contains(name) {
                used.insert(name.clone());
                wanted.extend(words(text).map(str::to_owned));
            }
        }
        let taken = |name: &String| {
            let parameter = !self.own_first && self.parameters.contains(name);
            parameter || self.definitions.iter().any(|(defined, _)| defined == name)
        };
        let own = self.own.iter().filter(|(name, _)| wanted.contains(name) && !taken(name));
        let defined = self.definitions.iter().filter(|(name, _)| wanted.contains(name));
        own.chain(defined).cloned().collect()
    }
}

/// Those of the definitions, each a name and its text, that a formula names.
pub(crate) fn named_in(text: &str, definitions: &[(String, String)]) -> Vec<(String, String)> {
    definitions.iter().filter(|(name, _)| words(text).any(|word| word == name)).cloned().collect()
}

/// The words of a formula that could be names.
pub(crate) fn words(text: &str) -> impl Iterator<Item = &str> {
    let inside = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
    text.split(move |c| !inside(c)).filter(|w| w.starts_with(|c: char| c.is_alphabetic() || c == '_'))
}
