//! What can be wrong with a unit as it is written.

use super::known;
use thiserror::Error;

/// A unit that is not known, or not the one that is needed; or a number with a unit that is none.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum UnitError {
    /// A word that is no unit.
    #[error("`{word}` in `{text}` is not a unit; known: {}{hint}", known::listed())]
    Unknown {
        /// The word.
        word: String,
        /// The unit or heading that has it.
        text: String,
        /// What may have been meant, or nothing.
        hint: &'static str,
    },
    /// Units put together in a way that can be read in two ways, or in none.
    #[error("the unit `{text}` {why}; write it as in m/s, W/(m K), m^3/h, kg s^-1")]
    Form {
        /// The unit.
        text: String,
        /// What is wrong with it.
        why: &'static str,
    },
    /// A unit of another quantity.
    #[error("`{have}` is not a unit of this quantity, which is in {wanted}{hint}")]
    OtherQuantity {
        /// The unit found.
        have: String,
        /// The SI unit of the quantity.
        wanted: String,
        /// What may have been meant, or nothing.
        hint: &'static str,
    },
    /// A text that does not begin with a finite number.
    #[error(
        "`{text}` is not a number with a unit; write it as in `12 mm` or `-3.5e-2 m`, with a decimal point"
    )]
    NoNumber {
        /// The text.
        text: String,
    },
    /// A heading whose brackets do not close, or that names no quantity.
    #[error("the heading `{text}` {why}; write it as in `x [mm]` or `T (degC)`")]
    Heading {
        /// The heading.
        text: String,
        /// What is wrong with it.
        why: &'static str,
    },
}
