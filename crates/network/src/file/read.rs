//! From the text of a file to a network.

use super::build::{Built, Reading, build};
use super::error::FileError;
use super::schema::File;

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
    let file: File = toml::from_str(text).map_err(|error| FileError::syntax(&error))?;
    build(text, &file, Reading::default())
}
