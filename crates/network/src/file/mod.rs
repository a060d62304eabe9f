//! Networks in a TOML file.

mod build;
mod duct;
mod oscilos;
mod schema;

pub use build::{Built, Warning};
pub use oscilos::{OscilosError, OscilosTexts, read_oscilos};

use crate::contour::Region;
use std::f64::consts::PI;

/// A network read from a file, ready to solve.
///
/// ```
/// let text = r#"
/// [gas]
/// temperature = 293.15
/// [upstream]
/// type = "unflanged"
/// [downstream]
/// type = "unflanged"
/// [[element]]
/// type = "duct"
/// length = 1.0
/// diameter = 0.0474
/// wall = "paper"
/// "#;
/// let built = rijke_network::file::read(text).unwrap();
/// let modes = built.network.modes(&built.laws, &built.region, &mut Default::default()).unwrap();
/// assert_eq!(modes.modes.len(), 6); // below 1 kHz
/// ```
///
/// # Errors
/// [`FileError`], which names the line or the element, by index and name, and the remedy.
pub fn read(text: &str) -> Result<Built, FileError> {
    let file: schema::File = toml::from_str(text).map_err(|error| FileError::syntax(&error))?;
    build::build(text, &file)
}

/// The default region of a search: growth rates from -500 to 500 1/s, frequencies from 10 Hz to 1 kHz.
const REGION: Region = Region { sigma: [-500.0, 500.0], omega: [2.0 * PI * 10.0, 2.0 * PI * 1000.0] };

/// What is wrong with a network file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FileError {
    /// It is not TOML, or a key is unknown or has the wrong type. The message carries line, column and known keys.
    #[error("{message}")]
    Syntax {
        /// What the reader says.
        message: String,
    },
    /// An element or an end cannot be built.
    #[error("line {line}: {place}: {problem}")]
    Element {
        /// Line in the file, from 1.
        line: usize,
        /// Which element: its index from 1, its name and its type.
        place: String,
        /// What is wrong with it, and the remedy.
        problem: Problem,
    },
    /// There is no duct.
    #[error("the file has no duct: add an [[element]] with type = \"duct\" and a length")]
    NoDuct,
    /// The search region is empty.
    #[error("[search]: {key} must be two increasing numbers")]
    Search {
        /// Which key.
        key: &'static str,
    },
    /// The network that the elements make is refused.
    #[error(transparent)]
    Network(#[from] crate::NetworkError),
}

/// What is wrong with one element.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Problem {
    /// An unknown key or type, or a value of the wrong type.
    #[error("{message}")]
    Keys {
        /// What the reader says.
        message: String,
    },
    /// A number must be positive.
    #[error("{key} is {value}, but must be positive and finite")]
    NotPositive {
        /// The key.
        key: &'static str,
        /// Its value.
        value: f64,
    },
    /// A number must not be negative.
    #[error("{key} is {value}, but must be zero or more, and finite")]
    Negative {
        /// The key.
        key: &'static str,
        /// Its value.
        value: f64,
    },
    /// Exactly one of two keys is needed.
    #[error("give either {one} or {other}")]
    OneOf {
        /// A key.
        one: &'static str,
        /// The other.
        other: &'static str,
    },
    /// Two keys belong together.
    #[error("give {one} and {other} together")]
    Together {
        /// A key.
        one: &'static str,
        /// The other.
        other: &'static str,
    },
    /// A polynomial is empty or zero.
    #[error("{key} must hold at least one coefficient, not all zero")]
    Polynomial {
        /// The key.
        key: &'static str,
    },
    /// A flame's reference lies outside the duct before it.
    #[error(
        "the velocity reference is {distance} m upstream, but the uniform duct before it is {length} m long"
    )]
    ReferenceOutside {
        /// Distance asked for, m.
        distance: f64,
        /// Length of the duct, m.
        length: f64,
    },
    /// A flow is too fast.
    #[error("the Mach number is {mach}, but must be below 0.3")]
    TooFast {
        /// The Mach number.
        mach: f64,
    },
}

impl FileError {
    fn syntax(error: &toml::de::Error) -> Self {
        Self::Syntax { message: error.to_string().trim_end().to_owned() }
    }
}
