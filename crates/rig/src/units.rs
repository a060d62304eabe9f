//! Units of quantities in files: `x [mm]`, `T (degC)`, `"12 mm"`. A file's number is converted once, where it
//! is read.
//!
//! Of the kept crates, `uom` knows units as types, not as words in a file; the table here has the units that
//! rigs and their recorders use.

mod known;
mod words;

use known::{BASES, Dimension, RADIAN, TURN};
use std::f64::consts::TAU;
use std::fmt::{Display, Formatter};
use thiserror::Error;

pub use words::{Given, Heading, Quantity};

/// A unit as a file names it, and how its numbers become SI.
///
/// A number x in the unit is x * [`Unit::factor`] + [`Unit::offset`] in SI: kg, m, s, K, A, mol, rad and what
/// is made of them. A frequency in Hz stays in Hz; rpm becomes Hz.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    text: String,
    factor: f64,
    offset: f64,
    dimension: Dimension,
}

/// A unit that is not known, or not the one that is needed; or a number with a unit that is none.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum UnitError {
    /// A word that is no unit.
    #[error("`{word}` in `{text}` is not a unit; known: {}", Unit::known())]
    Unknown {
        /// The word.
        word: String,
        /// The unit or heading that has it.
        text: String,
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

impl Unit {
    /// The unit of a pure number.
    #[must_use]
    pub fn one() -> Self {
        Self { text: "1".into(), factor: 1.0, offset: 0.0, dimension: [0; BASES] }
    }

    /// Reads a unit: `mm`, `degC`, `L/min`, `mV/Pa`, `W/(m K)`, `m^3/h`, `m³/h`, `kg s^-1`, `1`, `%`.
    ///
    /// Factors stand beside one another or have `*` or `·` between them; one factor or a bracket follows `/`.
    /// A temperature in degC or degF has an offset when it stands alone, and none inside a product (`W/(m
    /// degC)`).
    ///
    /// # Errors
    /// [`UnitError::Unknown`] with the units that are known, or [`UnitError::Form`].
    pub fn parse(text: &str) -> Result<Self, UnitError> {
        words::unit(text)
    }

    /// The units that are known, with the prefixes that each may have.
    #[must_use]
    pub fn known() -> String {
        known::listed()
    }

    /// The unit as the file has it.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// SI units per unit.
    #[must_use]
    pub fn factor(&self) -> f64 {
        self.factor
    }

    /// What the number 0 of this unit is in SI: 273.15 K for degC, 0 for most.
    #[must_use]
    pub fn offset(&self) -> f64 {
        self.offset
    }

    /// A number of this unit in SI.
    #[must_use]
    pub fn to_si(&self, value: f64) -> f64 {
        self.times(value) + self.offset
    }

    /// A difference of two numbers of this unit, or a standard deviation, in SI.
    #[must_use]
    pub fn difference_to_si(&self, difference: f64) -> f64 {
        self.times(difference)
    }

    /// Divides by 1000 rather than multiplies by 0.001, so that `23.7 mm` and 0.0237 are the same to the last
    /// bit.
    fn times(&self, value: f64) -> f64 {
        let inverse = (1.0 / self.factor).round();
        if inverse > 1.0 && 1.0 / inverse == self.factor { value / inverse } else { value * self.factor }
    }

    /// Exponents of kg, m, s, K, A and mol. Angles and cycles count as numbers.
    #[must_use]
    pub fn dimension(&self) -> [i32; 6] {
        std::array::from_fn(|k| self.dimension[k])
    }

    /// This unit for a quantity that is wanted in the SI unit `wanted`: [`Unit::to_si`] of what is returned
    /// gives numbers in `wanted`. Cycles become radians where `wanted` has radians, and the reverse: 100 Hz
    /// is 628.3 rad/s. `rad/s` and `1/s` are the same; `Hz` and `1/s` are not.
    ///
    /// # Errors
    /// [`UnitError::OtherQuantity`] if the units have not the same dimension; those of [`Unit::parse`] on
    /// `wanted`.
    pub fn of(&self, wanted: &str) -> Result<Self, UnitError> {
        let target = Self::parse(wanted)?;
        let (have, need) = (&self.dimension, &target.dimension);
        let (turns, angles) = (have[TURN] - need[TURN], have[RADIAN] - need[RADIAN]);
        let converted = turns + angles == 0;
        let alike = have[..RADIAN] == need[..RADIAN] && (turns == 0 || converted);
        if !alike {
            let hint = match have[..RADIAN] == need[..RADIAN] {
                true => "; cycles and radians differ by 2 pi: write Hz or rad/s",
                false if have[..] == [0; BASES] => "; a pure number was given",
                false => "",
            };
            return Err(UnitError::OtherQuantity { have: self.text.clone(), wanted: wanted.into(), hint });
        }
        // A word of the program's own, such as `mm` where SI would be m, is honoured, too.
        let scale = TAU.powi(turns) / target.factor;
        let offset = (self.offset - target.offset) / target.factor;
        Ok(Self { factor: self.factor * scale, offset, ..self.clone() })
    }
}

impl Display for Unit {
    fn fmt(&self, out: &mut Formatter<'_>) -> std::fmt::Result {
        out.write_str(&self.text)
    }
}
