//! A unit, and how its numbers become SI.

use super::known::{self, BASES, Dimension};
use std::fmt::{Display, Formatter};

/// A unit as a file names it, and how its numbers become SI.
///
/// A number x in the unit is x * [`Unit::factor`] + [`Unit::offset`] in SI: kg, m, s, K, A, mol, rad and what
/// is made of them. A frequency in Hz stays in Hz; rpm becomes Hz.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    pub(super) text: String,
    pub(super) factor: f64,
    pub(super) offset: f64,
    pub(super) dimension: Dimension,
}

impl Unit {
    /// The unit of a pure number.
    #[must_use]
    pub fn one() -> Self {
        Self { text: "1".into(), factor: 1.0, offset: 0.0, dimension: [0; BASES] }
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

    /// The unit in base units, as formulas read it: `kg m^2 s^-3`.
    #[must_use]
    pub fn in_base_units(&self) -> String {
        let names = ["kg", "m", "s", "K", "A", "mol"];
        let parts: Vec<String> = (names.iter().zip(self.dimension()))
            .filter(|(_, power)| *power != 0)
            .map(|(name, power)| if power == 1 { (*name).to_owned() } else { format!("{name}^{power}") })
            .collect();
        if parts.is_empty() { "1".to_owned() } else { parts.join(" ") }
    }

    /// The unit in SI: itself where one of it is one in SI, as in W; else in base units.
    #[must_use]
    pub fn in_si(&self) -> String {
        let one = self.factor == 1.0 && self.offset == 0.0;
        if one { self.text.clone() } else { self.in_base_units() }
    }

    /// Exponents of kg, m, s, K, A and mol. Angles and cycles count as numbers.
    #[must_use]
    pub fn dimension(&self) -> [i32; 6] {
        std::array::from_fn(|k| self.dimension[k])
    }
}

impl Display for Unit {
    fn fmt(&self, out: &mut Formatter<'_>) -> std::fmt::Result {
        out.write_str(&self.text)
    }
}
