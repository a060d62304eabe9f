//! The pieces of a rig.

use super::value::Value;
use crate::StudyProblem;
use crate::law::Place;
use crate::source::listed;
use rijke_formula::{Formula, Scope};
use rijke_numerics::Matrix;
use rijke_rig::ChannelErrors;

/// A named piece of the rig.
#[derive(Clone, Debug)]
pub struct Part {
    /// Its name.
    pub name: String,
    /// What it is.
    pub shape: Shape,
    /// Its numbers: place in the scope, and value.
    pub numbers: Vec<(usize, Value)>,
    /// The place in the scope of the factor that says whether it is there; always if none. A duct that is not
    /// there has no length.
    pub present: Option<usize>,
    /// Standard deviation of relative pressures within one radius of the duct of it, where the wave is no
    /// plane one; none if its near field is not felt.
    pub near_field: Option<f64>,
    /// Its hole, if it is one or a plate with some.
    pub(crate) hole: Option<Hole>,
}

/// A hole of a part: the places in the scope of its diameter, m, and of the open part of the area, where it
/// is one of many.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hole {
    pub(crate) diameter: usize,
    pub(crate) porosity: Option<usize>,
}

impl Part {
    /// Whether it is there, where the names of the scope have these values.
    pub(super) fn is_there(&self, numbers: &[f64]) -> bool {
        self.present.is_none_or(|factor| numbers[factor] > 0.0)
    }

    /// Whether it is a duct of which a temperature, the ratio of specific heats or the gas constant names
    /// unknowns.
    #[must_use]
    pub fn is_of_unknown_gas(&self) -> bool {
        let unknown = |t: &Value| matches!(t, Value::Unknown(..));
        matches!(&self.shape, Shape::Duct(duct)
            if duct.temperatures.iter().chain(duct.gas.iter().flatten()).any(unknown))
    }

    /// Whether it is a duct of another gas than that of the rig.
    #[must_use]
    pub fn is_of_other_gas(&self) -> bool {
        matches!(&self.shape, Shape::Duct(duct) if duct.gas.iter().any(Option::is_some))
    }

    /// The formulas of its lengths, areas, temperatures, gas and places that name unknowns.
    pub fn unknown(&self) -> impl Iterator<Item = &Formula> {
        let values: Vec<&Value> = match &self.shape {
            Shape::Duct(duct) => [&duct.length]
                .into_iter()
                .chain(&duct.area)
                .chain(&duct.temperatures)
                .chain(duct.gas.iter().flatten())
                .collect(),
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
    /// Standard deviation of these temperatures, K: one error that all points share. A temperature that
    /// depends on the point is wrong by no more than it differs from the ambient one.
    pub temperature_sd: f64,
    /// Ratio of specific heats and gas constant (J/(kg K)) where they are not those of the rig's gas.
    pub gas: Box<[Option<Value>; 2]>,
    /// Number of pieces into which it is cut, if the file says it.
    pub pieces: Option<usize>,
}

/// Pieces of a cone whose file does not say a number.
const PIECES_OF_A_CONE: usize = 160;

impl Duct {
    /// Numbers of pieces into which it is cut: where it is straight, and where it is a cone. Where the gas
    /// varies along it, each piece is cut further.
    #[must_use]
    pub fn pieces(&self) -> [usize; 2] {
        self.pieces.map_or([1, PIECES_OF_A_CONE], |stated| [stated; 2])
    }
}

/// Microphones or thermometers.
#[derive(Clone, Debug, Default)]
pub struct Instruments {
    /// Their names.
    pub names: Vec<String>,
    /// Their places.
    pub at: Vec<Value>,
    /// Line of their table in the file, from 1; 0 without a table.
    pub line: usize,
    /// The one to which pressures are relative.
    pub reference: usize,
    /// Relative standard deviation of the gain of each, independent of the others; empty if not stated.
    pub gain_sds: Vec<f64>,
    /// Standard deviation of the delay of each, s; empty if not stated.
    pub delay_sds: Vec<f64>,
}

impl Instruments {
    /// What is not known of gains and delays against those of the reference, zero where nothing is stated;
    /// none if nothing is stated at all.
    #[must_use]
    pub fn channel_errors(&self) -> Option<ChannelErrors> {
        let others: Vec<usize> = (0..self.names.len()).filter(|m| *m != self.reference).collect();
        let of = |sds: &[f64]| {
            let variance = |m: usize| sds.get(m).map_or(0.0, |sd| sd * sd);
            Matrix::from_fn(others.len(), others.len(), |i, j| {
                variance(self.reference) + if i == j { variance(others[i]) } else { 0.0 }
            })
        };
        let stated = !self.gain_sds.is_empty() || !self.delay_sds.is_empty();
        stated.then(|| ChannelErrors {
            delays: of(&self.delay_sds),
            gains: of(&self.gain_sds),
            contained: true,
        })
    }

    /// Refuses a name that none of them has.
    ///
    /// # Errors
    /// [`StudyProblem::Unknown`].
    pub fn have(&self, names: &[String]) -> Result<(), StudyProblem> {
        let Some(name) = names.iter().find(|name| !self.names.contains(name)) else { return Ok(()) };
        let known = listed(self.names.iter().map(String::as_str));
        Err(StudyProblem::Unknown { what: "microphone", name: name.clone(), known })
    }
}

/// The numbers of an end: bare name, and name in the scope. Both ends together have none.
pub(super) fn end_numbers(scope: &Scope, place: &Place) -> Vec<(String, String)> {
    match place {
        Place::Upstream => numbers_of(scope, "upstream"),
        Place::Downstream => numbers_of(scope, "downstream"),
        _ => Vec::new(),
    }
}

/// The numbers of which the names in the scope begin with that of their owner.
pub(super) fn numbers_of(scope: &Scope, owner: &str) -> Vec<(String, String)> {
    let of_it = |name: &str| Some((name.strip_prefix(owner)?.strip_prefix('.')?.to_owned(), name.to_owned()));
    scope.names().iter().filter_map(|name| of_it(&name.name)).collect()
}

/// The numbers of a part: bare name, and name in the scope.
pub(super) fn own_numbers(scope: &Scope, part: &Part) -> Vec<(String, String)> {
    let bare = |(place, _): &(usize, Value)| {
        let full = scope.names().get(*place)?.name.clone();
        Some((full.rsplit('.').next()?.to_owned(), full))
    };
    part.numbers.iter().filter_map(bare).collect()
}
