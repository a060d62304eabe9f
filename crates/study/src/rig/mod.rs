//! The rig: ducts in a chain, named parts on them, two ends, and instruments. A network file with names.

mod elements;
mod oscilos;
mod place;
mod read;
mod resolve;
mod value;

pub use place::Place;
pub use resolve::{DuctAt, Layout, PartAt};
pub use value::Value;

use crate::law::{Candidate, Words};
use crate::source::{Outcome, Source, listed};
use crate::{Campaign, Problem, StudyError};
use rijke_formula::{Formula, Scope};
use rijke_rig::{Gas, GasState};
use std::path::Path;

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
    /// What the file itself says of coefficients, and its unknowns: a candidate that is always in use. Its role is `rig`.
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
    /// Whether the file states these frequencies: then a measured mode lies between them.
    pub search_is_stated: bool,
}

/// The gas: how its properties follow from temperature and pressure.
#[derive(Clone, Debug, PartialEq)]
pub enum GasModel {
    /// Heat capacity and transport follow temperature.
    Real(Gas),
    /// Constant ratio of specific heats and Prandtl number; viscosity by the power 0.7 of temperature.
    Perfect {
        /// Ratio of specific heats.
        gamma: f64,
        /// Specific gas constant, J/(kg K).
        constant: f64,
        /// Viscosity, Pa s, and the temperature that it belongs to, K.
        viscosity: [f64; 2],
        /// Prandtl number.
        prandtl: f64,
    },
}

impl GasModel {
    /// Specific gas constant, J/(kg K).
    #[must_use]
    pub fn constant(&self) -> f64 {
        match self {
            Self::Real(gas) => gas.constant(),
            Self::Perfect { constant, .. } => *constant,
        }
    }

    /// All properties at `temperature` (K) and `pressure` (Pa).
    #[must_use]
    pub fn at(&self, temperature: f64, pressure: f64) -> GasState {
        match self {
            Self::Real(gas) => gas.at(temperature, pressure),
            Self::Perfect { gamma, constant, viscosity: [viscosity, reference], prandtl } => {
                let viscosity = viscosity * (temperature / reference).powf(0.7);
                let specific_heat = gamma * constant / (gamma - 1.0);
                GasState {
                    temperature,
                    pressure,
                    density: pressure / (constant * temperature),
                    sound_speed: (gamma * constant * temperature).sqrt(),
                    viscosity,
                    conductivity: viscosity * specific_heat / prandtl,
                    specific_heat,
                    gamma: *gamma,
                    prandtl: *prandtl,
                }
            }
        }
    }
}

/// A named piece of the rig.
#[derive(Clone, Debug)]
pub struct Part {
    /// Its name.
    pub name: String,
    /// What it is.
    pub shape: Shape,
    /// Its numbers: place in the scope, and value.
    pub numbers: Vec<(usize, Value)>,
    /// The factor that says whether it is there; always if none.
    pub present: Option<usize>,
    /// Standard deviation of relative pressures within one radius of the duct of it, where the wave is no plane one; none if
    /// its near field is not felt.
    pub near_field: Option<f64>,
}

impl Part {
    /// Whether it is a duct with a temperature that names unknowns.
    #[must_use]
    pub fn is_of_unknown_gas(&self) -> bool {
        let unknown = |t: &Value| matches!(t, Value::Unknown(..));
        matches!(&self.shape, Shape::Duct(duct) if duct.temperatures.iter().any(unknown))
    }

    /// The formulas of its lengths, areas, temperatures and places that name unknowns.
    pub fn unknown(&self) -> impl Iterator<Item = &Formula> {
        let values: Vec<&Value> = match &self.shape {
            Shape::Duct(duct) => {
                [&duct.length].into_iter().chain(&duct.area).chain(&duct.temperatures).collect()
            }
            Shape::Device(at) => at.iter().collect(),
            Shape::Insert(from, to) => vec![from, to],
        };
        values.into_iter().filter_map(Value::unknown)
    }
}

/// What a part is.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A duct of the chain.
    Duct(Duct),
    /// Acts at places; without a place of its own where the ducts before it in the file end.
    Device(Vec<Value>),
    /// Acts along the ducts between two places.
    Insert(Value, Value),
}

/// A straight or conical duct.
#[derive(Clone, Debug)]
pub struct Duct {
    /// Length, m.
    pub length: Value,
    /// Area at its two ends, m^2.
    pub area: [Value; 2],
    /// Temperatures at equally spaced places, K; empty where the gas of the base state fills it.
    pub temperatures: Vec<Value>,
    /// Standard deviation of these temperatures, K: one error that all points share.
    pub temperature_sd: f64,
    /// Number of pieces into which a cone is cut.
    pub pieces: Option<usize>,
}

/// Microphones or thermometers.
#[derive(Clone, Debug, Default)]
pub struct Instruments {
    /// Their names.
    pub names: Vec<String>,
    /// Their places.
    pub at: Vec<Value>,
    /// The one to which pressures are relative.
    pub reference: usize,
}

impl Instruments {
    /// Refuses a name that none of them has.
    pub(crate) fn have(&self, names: &[String]) -> Result<(), Problem> {
        let Some(name) = names.iter().find(|name| !self.names.contains(name)) else { return Ok(()) };
        let known = listed(self.names.iter().map(String::as_str));
        Err(Problem::Unknown { what: "microphone", name: name.clone(), known })
    }
}

impl Rig {
    /// Reads `rig.toml`; `campaign` says which factors its formulas may name.
    ///
    /// # Errors
    /// File, line and remedy.
    pub fn read(path: &Path, campaign: &Campaign) -> Result<Self, StudyError> {
        Self::parse(&Source::read(path)?, campaign)
    }

    pub(crate) fn parse(source: &Source, campaign: &Campaign) -> Result<Self, StudyError> {
        let file: read::File = source.toml()?;
        let file = match file.oscilos() {
            Some(name) => {
                let folder = Path::new(&source.file).with_file_name(name);
                file.beside(oscilos::read(&folder)?)
            }
            None => file,
        };
        let outcome: Outcome<Self> = read::rig(file, campaign);
        source.located(outcome)
    }

    /// The part called `name`.
    #[must_use]
    pub fn part(&self, name: &str) -> Option<(usize, &Part)> {
        self.parts.iter().enumerate().find(|(_, p)| p.name == name)
    }

    /// Whether a length, an area, or the place of a part or a microphone is unknown.
    #[must_use]
    pub fn is_of_unknown_shape(&self) -> bool {
        self.parts.iter().any(|part| part.unknown().next().is_some())
            || self.microphones.at.iter().any(|at| at.unknown().is_some())
    }

    /// The numbers of the part of a place by bare name, with their names in the scope.
    pub(crate) fn own_numbers(&self, place: &Place) -> Vec<(String, String)> {
        let Some(part) = place.part().and_then(|k| self.parts.get(k)) else { return Vec::new() };
        own_numbers(&self.scope, part)
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

fn own_numbers(scope: &Scope, part: &Part) -> Vec<(String, String)> {
    let bare = |(place, _): &(usize, Value)| {
        let full = scope.names().get(*place)?.name.clone();
        Some((full.rsplit('.').next()?.to_owned(), full))
    };
    part.numbers.iter().filter_map(bare).collect()
}
