//! Quantities and headings as they are written.

use super::error::UnitError;
use super::unit::Unit;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A number and its unit: `12 mm`, `-3.5e-2 m`, `20 degC`, `5 %`; `0.3` alone is a pure number.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// The number as written.
    pub value: f64,
    /// Its unit.
    pub unit: Unit,
}

/// A heading of a column or a key: `x [mm]`, `T (degC)`, `p / Pa`, `name`.
#[derive(Clone, Debug, PartialEq)]
pub struct Heading {
    /// What stands before the unit.
    pub name: String,
    /// The unit; none if the heading has none.
    pub unit: Option<Unit>,
}

/// A value of a TOML key: a number, which is in SI, or a text with a unit (`length = 0.5` or `length = "500
/// mm"`).
#[derive(Clone, Debug, PartialEq)]
pub enum Given {
    /// A number in SI units.
    Si(f64),
    /// A number with a unit.
    Stated(Quantity),
}

/// Characters of a number beyond which it is none: the longest that programs print have some three hundred.
const LONGEST: usize = 400;

impl Quantity {
    /// Reads a number with a unit.
    ///
    /// # Errors
    /// [`UnitError::NoNumber`], or those of [`Unit::parse`].
    pub fn parse(text: &str) -> Result<Self, UnitError> {
        let trimmed = text.trim();
        let plain = |b: &u8| b.is_ascii_digit() || b"+-.eE".contains(b);
        let longest = trimmed.bytes().take_while(plain).count().min(LONGEST);
        let number = |end: usize| Some((end, trimmed[..end].parse::<f64>().ok().filter(|v| v.is_finite())?));
        let none = || UnitError::NoNumber { text: trimmed.into() };
        let (end, value) = (1..=longest).rev().find_map(number).ok_or_else(none)?;
        let rest = trimmed[end..].trim();
        // What goes on like a number is one with a decimal comma, spaces or two points.
        // What goes on with a sign of multiplication is a formula.
        if rest.starts_with('*') {
            return Err(none());
        }
        if !rest.starts_with("1/") && rest.starts_with(|c: char| c.is_ascii_digit() || ",.+-".contains(c)) {
            return Err(none());
        }
        let unit = if rest.is_empty() { Unit::one() } else { Unit::parse(rest)? };
        Ok(Self { value, unit })
    }

    /// The number in `wanted`; see [`Unit::of`].
    ///
    /// # Errors
    /// As [`Unit::of`].
    pub fn of(&self, wanted: &str) -> Result<f64, UnitError> {
        Ok(self.unit.of(wanted)?.to_si(self.value))
    }
}

impl Heading {
    /// Reads a heading. The unit stands in brackets at the end, or behind a slash (ISO 80000-1: `p/hPa`,
    /// `u/(m/s)`) or a comma (`p, hPa`); where no unit follows these, they belong to the name. `p[0]` is a
    /// name: the first channel of p.
    ///
    /// # Errors
    /// [`UnitError::Heading`], or those of [`Unit::parse`]: what stands in brackets must be a unit.
    pub fn parse(text: &str) -> Result<Self, UnitError> {
        let text = text.trim();
        let wrong = |why| Err(UnitError::Heading { text: text.into(), why });
        let index = text.strip_suffix(']').map(|t| t.trim_end_matches(|c: char| c.is_ascii_digit()));
        if index.is_some_and(|t| t.ends_with('[') && !t.ends_with(" [") && text.len() > t.len() + 1) {
            return Ok(Self { name: text.into(), unit: None });
        }
        let bracket = [('[', ']'), ('(', ')')].into_iter().find(|(_, close)| text.ends_with(*close));
        let (name, unit) = match bracket {
            Some((open, close)) => {
                let Some(start) = opening(text, open, close) else {
                    return wrong("closes a bracket that is not open");
                };
                (&text[..start], Some(&text[start + 1..text.len() - 1]))
            }
            None if text.contains('[') => return wrong("has a bracket that does not close at its end"),
            None => behind_a_sign(text),
        };
        let name = if bracket.is_some() { name.trim_end().trim_end_matches('/') } else { name };
        if name.trim().is_empty() {
            return wrong("names no quantity");
        }
        // An empty bracket, or a dash in it, marks a pure number.
        let unit = unit.map(|unit| match unit.trim() {
            "" | "-" | "–" => Ok(Unit::one()),
            unit => Unit::parse(unit),
        });
        Ok(Self { name: name.trim().into(), unit: unit.transpose()? })
    }

    /// How numbers under this heading become `wanted`; those without a unit are in `wanted`.
    ///
    /// # Errors
    /// As [`Unit::of`].
    pub fn of(&self, wanted: &str) -> Result<Unit, UnitError> {
        self.unit.as_ref().map_or_else(|| Unit::parse(wanted)?.of(wanted), |unit| unit.of(wanted))
    }
}

/// Name and unit where a slash or a comma stands between them.
fn behind_a_sign(text: &str) -> (&str, Option<&str>) {
    if let Some((name, unit)) = text.split_once(" / ") {
        return (name, Some(unit));
    }
    let is_unit = |unit: &str| Unit::parse(unit.trim()).is_ok();
    let split = [text.split_once('/'), text.rsplit_once(',')].into_iter().flatten();
    let found = split.into_iter().find(|(name, unit)| !name.trim().is_empty() && is_unit(unit));
    found.map_or((text, None), |(name, unit)| (name, Some(unit)))
}

/// Where the bracket opens that closes at the end of the text.
fn opening(text: &str, open: char, close: char) -> Option<usize> {
    let mut depth = 0;
    for (k, c) in text.char_indices().rev() {
        depth += i32::from(c == close) - i32::from(c == open);
        if depth == 0 {
            return Some(k);
        }
    }
    None
}

impl Given {
    /// The number in the SI unit `wanted`.
    ///
    /// # Errors
    /// As [`Unit::of`].
    pub fn of(&self, wanted: &str) -> Result<f64, UnitError> {
        match self {
            Self::Si(value) => Ok(*value),
            Self::Stated(quantity) => quantity.of(wanted),
        }
    }
}

impl<'de> Deserialize<'de> for Given {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl serde::de::Visitor<'_> for Visitor {
            type Value = Given;
            fn expecting(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                out.write_str("a number in SI units, or a text with a unit such as \"12 mm\"")
            }
            fn visit_f64<E>(self, value: f64) -> Result<Given, E> {
                Ok(Given::Si(value))
            }
            fn visit_i64<E>(self, value: i64) -> Result<Given, E> {
                Ok(Given::Si(value as f64))
            }
            fn visit_u64<E>(self, value: u64) -> Result<Given, E> {
                Ok(Given::Si(value as f64))
            }
            fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Given, E> {
                Quantity::parse(text).map(Given::Stated).map_err(E::custom)
            }
        }
        from.deserialize_any(Visitor)
    }
}

impl Serialize for Given {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Si(value) => to.serialize_f64(*value),
            Self::Stated(Quantity { value, unit }) => to.collect_str(&format_args!("{value} {unit}")),
        }
    }
}
