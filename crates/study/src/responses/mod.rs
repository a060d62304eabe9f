//! Observed responses: impedances, reflection coefficients, pressures of unknown sources, transfer functions,
//! flame transfer functions over frequency.
//!
//! `observations/observations.toml` declares them in `[[response]]`. The numbers are in files of their own,
//! in the folder of the observations or, where they are other people's, in one that an environment variable
//! names.

mod columns;
mod cut_on;
mod doubts;
mod plan;
mod pressures;
mod read;

pub use plan::{MisfitSpec, ResponseStage};

use crate::Coefficient;
use crate::law::Place;
use rijke_formula::Formula;
use rijke_numerics::C64;
use rijke_rig::DataKind;
use std::collections::BTreeMap;

/// All responses of a study.
#[derive(Clone, Debug)]
pub struct Responses {
    /// Measured or virtual.
    pub kind: DataKind,
    /// Where the data come from.
    pub source: String,
    /// The responses, in the order of their declaration.
    pub list: Vec<ObservedResponse>,
    /// Ambient temperatures that were read with the records, and their standard deviations, K, by operating
    /// point. They count before those of the campaign.
    pub ambient: BTreeMap<usize, [f64; 2]>,
    /// What is doubtful about the data: file, place, and the remedy.
    pub warnings: Vec<String>,
}

/// A complex number at every frequency, at one operating point.
#[derive(Clone, Debug)]
pub struct ObservedResponse {
    /// The operating point, by its place in the campaign.
    pub point: usize,
    /// What it is.
    pub what: ResponseKind,
    /// How many numbers the file holds, within the band of the instrument or not.
    pub rows: usize,
    /// Frequencies, Hz, ascending.
    pub frequency_hz: Vec<f64>,
    /// The numbers.
    pub values: Vec<C64>,
    /// Standard deviation of the real and of the imaginary part of each, as it was measured; empty if none
    /// was. The noise of a stage comes on top, in quadrature.
    pub sd: Vec<f64>,
    /// Of pressures of unknown sources: by what each was divided, in the unit of the file; empty of all
    /// others.
    pub level: Vec<f64>,
}

/// What a response is.
#[derive(Clone, Debug)]
pub enum ResponseKind {
    /// Reflection coefficient g/f of the rig at a port, looking into it; impedances are turned into these,
    /// which have no poles.
    Reflection {
        /// The port: [`Place::Upstream`].
        at: Place,
        /// Area, m^2, of the tube whose wave impedance the data refer to; that of the rig at the port if none
        /// is stated.
        reference_area: Option<f64>,
    },
    /// Pressure at a microphone, of sources of unknown strength, over the root mean square of all microphones
    /// then.
    Pressure {
        /// The microphone.
        microphone: usize,
        /// The excitation, as the file calls it: what its microphones heard at one frequency is of the same
        /// sources.
        excitation: String,
        /// Where waves of unknown pressure enter: [`Place::Upstream`], [`Place::Downstream`], or both.
        sources: Vec<Place>,
    },
    /// Pressure at a microphone over that at another, by their places in the rig.
    Transfer {
        /// The one above.
        to: usize,
        /// The one below.
        from: usize,
    },
    /// A factor times the coefficient that the candidates give at a place: a flame transfer function from
    /// k_eu.
    Law {
        /// Where.
        at: Place,
        /// Which coefficient.
        coefficient: Coefficient,
        /// The factor, of numbers of the operating point.
        factor: Formula,
    },
}

impl ResponseKind {
    /// Whether both are the same number of the rig. A reflection coefficient is, whatever area it refers to.
    #[must_use]
    pub fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Reflection { at, .. }, Self::Reflection { at: other, .. }) => at == other,
            (
                Self::Pressure { microphone, excitation, .. },
                Self::Pressure { microphone: other, excitation: second, .. },
            ) => (microphone, excitation) == (other, second),
            (Self::Transfer { to, from }, Self::Transfer { to: other, from: below }) => {
                (to, from) == (other, below)
            }
            (Self::Law { at, coefficient, .. }, Self::Law { at: other, coefficient: second, .. }) => {
                (at, coefficient) == (other, second)
            }
            _ => false,
        }
    }

    /// What it is called.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Reflection { .. } => "reflection",
            Self::Pressure { .. } => "pressure",
            Self::Transfer { .. } => "transfer",
            Self::Law { .. } => "law",
        }
    }
}
