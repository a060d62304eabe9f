//! The rig: ducts in a chain, named parts on them, two ends, and instruments. A network file with names.

use super::gas::GasModel;
use super::part::{Instruments, Part, end_numbers, own_numbers};
use super::value::Value;
use crate::law::{Candidate, Place, Words};
use rijke_formula::Scope;

/// A rig as its file describes it. What depends on factors is resolved at an operating point by [`Rig::at`].
#[derive(Clone, Debug)]
pub struct Rig {
    /// What it is called in reports.
    pub name: String,
    /// Where its numbers come from.
    pub source: String,
    /// The gas.
    pub gas: GasModel,
    /// Mean pressure, Pa.
    pub pressure: f64,
    /// Temperature where neither the base state nor the campaign says another, K.
    pub temperature: f64,
    /// Ducts and devices, in the order of the file.
    pub parts: Vec<Part>,
    /// Whether an end is a choked nozzle.
    pub is_choked: bool,
    /// Numbers that are none of a part: place in the scope, and value.
    pub loose: Vec<(usize, Value)>,
    /// Numbers of the ends, which may name those of parts: place in the scope, and value.
    pub of_ends: Vec<(usize, Value)>,
    /// What is doubtful but possible, each in a sentence with its file and line.
    pub doubts: Vec<String>,
    /// What the file itself says of coefficients, and its unknowns: a candidate that is always in use. Its
    /// role is `rig`.
    pub own: Candidate,
    /// Microphones.
    pub microphones: Instruments,
    /// Thermometers.
    pub thermometers: Instruments,
    /// Every name that a law may use.
    pub scope: Scope,
    /// Places of the factors of the campaign in the scope, in the order of its columns.
    pub factors: Vec<usize>,
    /// Places in the scope of the numbers that base states bring.
    pub brought: Vec<usize>,
    /// Growth rates (1/s) and frequencies (Hz) between which modes are sought.
    pub search: [[f64; 2]; 2],
    /// Whether the file states these: then a measured mode lies between them.
    pub search_is_stated: [bool; 2],
    /// Decay times of a ring-down that the fit of a ping uses, if stated.
    pub ping_decay_times: Option<f64>,
    /// Standard deviation of a shift of all arrival times alike between two settings of the rig, s.
    pub arrival_setting_sd_s: f64,
    /// Frequencies between which the mode of pings is sought, Hz, if `[recording]` states them.
    pub ping_band_hz: Option<[f64; 2]>,
    /// Frequency of the mains, Hz, if stated.
    pub mains_hz: Option<f64>,
}

impl Rig {
    /// The part called `name`.
    #[must_use]
    pub fn part(&self, name: &str) -> Option<(usize, &Part)> {
        self.parts.iter().enumerate().find(|(_, p)| p.name == name)
    }

    /// The factor of the campaign, by its column, that says whether a part is there; none for one that always
    /// is.
    #[must_use]
    pub fn presence(&self, part: &Part) -> Option<usize> {
        self.factors.iter().position(|place| Some(*place) == part.present)
    }

    /// Whether a length, an area, or the place of a part or a microphone is unknown.
    #[must_use]
    pub fn is_of_unknown_shape(&self) -> bool {
        self.parts.iter().any(|part| part.unknown().next().is_some())
            || self.microphones.at.iter().any(|at| at.unknown().is_some())
    }

    /// The numbers of the part or the end of a place by bare name, with their names in the scope.
    pub(crate) fn own_numbers(&self, place: &Place) -> Vec<(String, String)> {
        match place.part() {
            Some(part) => self.parts.get(part).map_or_else(Vec::new, |part| own_numbers(&self.scope, part)),
            None => end_numbers(&self.scope, place),
        }
    }

    /// What laws at `place` may name, with these parameters and definitions.
    pub(crate) fn words<'a>(
        &'a self,
        parameters: &'a [String],
        definitions: &'a [(String, String)],
        own: &'a [(String, String)],
    ) -> Words<'a> {
        Words { scope: &self.scope, parameters, definitions, own, own_first: false }
    }
}
