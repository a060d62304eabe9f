//! Networks in a TOML file.

mod account;
mod build;
mod compact;
mod duct;
mod ends;
mod flow;
mod layout;
mod named;
mod oscilos;
mod problem;
mod schema;

pub use account::{Account, samples_of_each};
pub use build::{Built, Warning};
pub use named::{NamedNumbers, NumberError};
pub use oscilos::{OscilosError, OscilosTexts, read_oscilos};
pub use problem::Problem;

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
#[non_exhaustive]
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
        #[source]
        problem: Problem,
    },
    /// There is no duct.
    #[error("the file has no duct: add an [[element]] with type = \"duct\" and a length")]
    NoDuct,
    /// The search region is empty.
    #[error("line {line}: [search]: {key} must be two increasing finite numbers")]
    Search {
        /// Line of its table, from 1.
        line: usize,
        /// Which key.
        key: &'static str,
    },
    /// The mean flow is no flow.
    #[error("line {line}: [flow]: {problem}")]
    Flow {
        /// Line of its table, from 1.
        line: usize,
        /// What is wrong with it.
        #[source]
        problem: Problem,
    },
    /// The network that the elements make is refused.
    #[error(transparent)]
    Network(#[from] crate::NetworkError),
}

impl FileError {
    fn syntax(error: &toml::de::Error) -> Self {
        Self::Syntax { message: error.to_string().trim_end().to_owned() }
    }
}
