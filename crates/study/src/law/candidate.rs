//! What a candidate is: parameters, and laws that act on coefficients at places of the rig.

use super::place::Place;
use crate::head::ErrorTerm;
use rijke_formula::Formula;
use rijke_inference::Parameter;

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
    /// The candidate, of another role, whose place it takes in a model; it can be part of no model without
    /// that one.
    pub extends: Option<String>,
    /// Its parameters, in the order of the file.
    pub parameters: Vec<Parameter>,
    /// What it does.
    pub effects: Vec<Effect>,
    /// Error terms, if it is a measuring head; none for a perfect one.
    pub errors: Vec<ErrorTerm>,
    /// The mean flow of which its waves are; none for waves of a gas at rest.
    pub mean_flow: Option<MeanFlow>,
    /// The largest stated error of its measured tables, over their largest gains; none without any.
    pub tolerance: Option<f64>,
}

/// Waves in a gas that flows: convection, and the balances of mass, momentum and energy across every jump of
/// area and temperature.
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
    /// The velocity that `eu` is of, where it is not that at the place itself.
    pub hears: Option<Hears>,
    /// The measured tables that the law uses.
    pub tables: Vec<TableUse>,
}

/// A measured function of frequency in a law.
#[derive(Clone, Debug)]
pub struct TableUse {
    /// What the file calls it; empty for the table of an element.
    pub name: String,
    /// Frequencies from and to at which it was measured, Hz.
    pub band_hz: [f64; 2],
    /// What stands in the place of s, 1/s.
    pub argument: Formula,
}

/// A velocity elsewhere to which a source of heat answers.
#[derive(Clone, Debug, PartialEq)]
pub struct Hears {
    /// The name in the scope of how far away it is, m.
    pub distance: usize,
    /// On which side.
    pub downstream: bool,
    /// Whether the law is per heat of the mean flow through the place itself, (rho/rho_2 - 1) A/A_2:
    /// elsewhere the density and the area are those that are there.
    pub of_mean: bool,
    /// Along what the heat is released, if not at the place itself.
    pub spread: Option<Spread>,
}

/// A stretch along which a source releases its heat, in the middles of equal pieces.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// The name in the scope of its length, m.
    pub length: usize,
    /// The name in the scope of where a piece is, 0 at the beginning and 1 at the end; its value is that of
    /// the piece.
    pub along: usize,
    /// Heat per length at equally spaced points from end to end, up to a factor.
    pub density: Vec<f64>,
    /// Number of pieces.
    pub pieces: usize,
}

/// The coefficient that an effect adds to: equations (1) and (2) of Juniper & Yoko 2022, p2 - p1 = -k_mu u1 -
/// k_mp p1, u2 - u1 = -k_eu u1 - k_ep p1; per metre where the law acts along a stretch.
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
