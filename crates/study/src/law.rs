//! What a candidate is: parameters, and laws that act on coefficients at places of the rig.

use crate::head::ErrorTerm;
use crate::names::{LEVINE_SCHWINGER, WALL_EP, WALL_MU};
use crate::rig::Place;
use crate::source::Outcome;
use crate::{Problem, names};
use rijke_formula::{Context, Formula, Scope};
use rijke_inference::Parameter;
use std::collections::BTreeSet;
use std::ops::Range;

/// One competing model of one role.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Unique name, `"gauze.king"`.
    pub id: String,
    /// What it models; candidates of one role compete.
    pub role: String,
    /// What it is called in tables.
    pub name: String,
    /// Where it comes from.
    pub cite: Vec<String>,
    /// Anything else that a reader should know.
    pub note: String,
    /// The candidate, of another role, whose place it takes in a model; it can be part of no model without that one.
    pub extends: Option<String>,
    /// Its parameters, in the order of the file.
    pub parameters: Vec<Parameter>,
    /// What it does.
    pub effects: Vec<Effect>,
    /// Error terms, if it is a measuring head; none for a perfect one.
    pub errors: Vec<ErrorTerm>,
    /// The mean flow of which its waves are; none for waves of a gas at rest.
    pub mean_flow: Option<MeanFlow>,
}

/// Waves in a gas that flows: convection, and the balances of mass, momentum and energy across every jump of area and temperature.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MeanFlow {
    /// With entropy waves, which the flow carries without loss.
    Full,
    /// With entropy waves that are lost in every duct, as in slow flows.
    WithoutEntropy,
}

/// One law that acts on one coefficient at one kind of place.
#[derive(Clone, Debug)]
pub struct Effect {
    /// Where.
    pub place: Place,
    /// The place as the file has it.
    pub place_text: String,
    /// On what.
    pub coefficient: Coefficient,
    /// By how much.
    pub law: Formula,
}

/// The coefficient that an effect adds to: equations (1) and (2) of Juniper & Yoko 2022, p2 - p1 = -k_mu u1 - k_mp p1,
/// u2 - u1 = -k_eu u1 - k_ep p1; per metre where the law acts along a stretch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Coefficient {
    /// k_mu: velocity into momentum, kg/(m^2 s); per metre kg/(m^3 s).
    Mu,
    /// k_mp: pressure into momentum, 1; per metre 1/m.
    Mp,
    /// k_eu: velocity into energy, 1; per metre 1/m.
    Eu,
    /// k_ep: pressure into energy, m/(Pa s); per metre 1/(Pa s).
    Ep,
    /// R at an end, both including the minus sign of an open end.
    Reflection,
    /// Propagation constant of the wave that runs downstream, which goes like exp(-forward x), 1/m.
    Forward,
    /// That of the wave that runs upstream, which goes like exp(backward x), 1/m.
    Backward,
}

impl Coefficient {
    /// All of them, as files call them.
    pub const ALL: [(&'static str, Self); 7] = [
        ("mu", Self::Mu),
        ("mp", Self::Mp),
        ("eu", Self::Eu),
        ("ep", Self::Ep),
        ("reflection", Self::Reflection),
        ("forward", Self::Forward),
        ("backward", Self::Backward),
    ];

    /// The name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].0
    }

    /// Whether it is the propagation constant of a wave.
    #[must_use]
    pub fn is_wave(self) -> bool {
        matches!(self, Self::Forward | Self::Backward)
    }

    /// The SI unit at a place, or per metre along a stretch.
    #[must_use]
    pub fn unit(self, along: bool) -> &'static str {
        match (self, along) {
            (Self::Mu, false) => "kg/(m^2 s)",
            (Self::Mu, true) => "kg/(m^3 s)",
            (Self::Ep, false) => "m/(Pa s)",
            (Self::Ep, true) => "1/(Pa s)",
            (Self::Mp | Self::Eu, true) | (Self::Forward | Self::Backward, _) => "1/m",
            (Self::Mp | Self::Eu | Self::Reflection, _) => "1",
        }
    }
}

/// What a law's text may name besides the scope: parameters, named subexpressions, and the numbers of its part by their bare names.
pub(crate) struct Words<'a> {
    pub(crate) scope: &'a Scope,
    pub(crate) parameters: &'a [String],
    /// Named subexpressions, in order.
    pub(crate) definitions: &'a [(String, String)],
    /// Bare name, and name in the scope.
    pub(crate) own: &'a [(String, String)],
    /// Whether a number of the part comes before a parameter of the same name: in the laws that an element brings.
    pub(crate) own_first: bool,
}

impl Words<'_> {
    /// Reads the law of `coefficient` at `place`; `at` is where its text stands. Adds the definitions that it needs to `used`.
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
            .map_err(|source| (at, Problem::Formula { key: key.to_owned(), source }))
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

/// The words of a formula that could be names.
pub(crate) fn words(text: &str) -> impl Iterator<Item = &str> {
    let inside = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
    text.split(move |c| !inside(c)).filter(|w| w.starts_with(|c: char| c.is_alphabetic() || c == '_'))
}
