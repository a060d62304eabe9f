//! From the words of a file to a unit, and from one unit to another.

use super::error::UnitError;
use super::known::{BASES, KELVIN, Known, RADIAN, TURN, find};
use super::unit::Unit;
use std::f64::consts::TAU;

/// Longest unit that is read, bytes; keeps exponents small.
const LONGEST: usize = 64;
/// Largest exponent of one factor.
const STEEPEST: i32 = 9;

impl Unit {
    /// Reads a unit: `mm`, `degC`, `L/min`, `mV/Pa`, `W/(m K)`, `m^3/h`, `m³/h`, `kg s^-1`, `1`, `%`.
    ///
    /// Factors stand beside one another or have `*` or `·` between them; one factor or a bracket follows `/`.
    /// A temperature in degC or degF has an offset when it stands alone, and none inside a product (`W/(m
    /// degC)`).
    ///
    /// # Errors
    /// [`UnitError::Unknown`] with the units that are known, or [`UnitError::Form`].
    pub fn parse(text: &str) -> Result<Self, UnitError> {
        unit(text)
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
                false if have[..3] == [1, 0, -1] && need[..3] == [0, 3, -1] => OF_MASS_FLOWS,
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

/// For mass flows where volumes are wanted.
const OF_MASS_FLOWS: &str = "; a volume flow is the mass flow over the density of the gas where it enters, p/(R T_amb): 1.20 kg/m^3 for air at 20 degC \
     and 101 325 Pa";

/// What mass-flow controllers show, which is a mass.
const NORMAL: [&str; 10] = ["nl", "ln", "nlpm", "nlm", "sl", "slpm", "slm", "sccm", "scc", "scfm"];

/// What may have been meant by a word that is no unit.
fn hint_of(word: &str) -> &'static str {
    match NORMAL.contains(&word.to_lowercase().as_str()) {
        true => {
            ". Normal and standard litres are a mass: those of 273.15 K and 101 325 Pa (look up what the meter's are of) times T_amb/(273.15 K) \
             times (101 325 Pa)/p are the litres that flow; write these in L/min"
        }
        false => "",
    }
}

/// Reads a unit; see [`Unit::parse`].
fn unit(text: &str) -> Result<Unit, UnitError> {
    let text = text.trim();
    let form = |why| UnitError::Form { text: text.chars().take(LONGEST).collect(), why };
    if text.is_empty() {
        return Err(form("is empty"));
    }
    if text.len() > LONGEST {
        return Err(form("is longer than 64 bytes"));
    }
    let mut unit = Unit { text: text.into(), ..Unit::one() };
    if let Some((scale, known)) = find(bare(text).unwrap_or(text)) {
        times(&mut unit, scale, known, 1);
        unit.offset = known.offset;
        return Ok(unit);
    }
    let mut parts = split(text).ok_or_else(|| form("has brackets that do not match"))?.into_iter();
    let above = parts.next().unwrap_or_default();
    product(bare(above).unwrap_or(above), 1, &mut unit)?;
    for below in parts {
        let bracket = bare(below);
        let count = product(bracket.unwrap_or(below), -1, &mut unit)?;
        if count > 1 && bracket.is_none() {
            return Err(form("has several factors behind a slash"));
        }
    }
    if !unit.factor.is_normal() {
        return Err(form("is too large or too small for a number"));
    }
    // In a product, degC is a difference; where nothing is left beside it, as in `1 degC`, either could be
    // meant.
    let mut kelvin = [0; BASES];
    kelvin[KELVIN] = 1;
    if unit.dimension == kelvin && !text.contains('K') {
        return Err(form("is a temperature in a product"));
    }
    Ok(unit)
}

/// What stands between slashes outside brackets; none if brackets do not match.
fn split(text: &str) -> Option<Vec<&str>> {
    let (mut parts, mut start, mut depth) = (Vec::new(), 0, 0);
    for (k, c) in text.char_indices() {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            '/' if depth == 0 => {
                parts.push(text[start..k].trim());
                start = k + 1;
            }
            _ => {}
        }
        if !(0..=1).contains(&depth) {
            return None;
        }
    }
    parts.push(text[start..].trim());
    (depth == 0).then_some(parts)
}

/// The inside of a bracket that is all of the text.
fn bare(text: &str) -> Option<&str> {
    text.strip_prefix('(').and_then(|t| t.strip_suffix(')'))
}

/// Multiplies the unit by factors to a power; how many there were.
fn product(text: &str, power: i32, unit: &mut Unit) -> Result<usize, UnitError> {
    let whole = unit.text.clone();
    let form = |why| UnitError::Form { text: whole.clone(), why };
    let factors = text.split([' ', '*', '·', '⋅']).filter(|f| !f.is_empty());
    let mut count = 0;
    for factor in factors {
        let (word, exponent) =
            exponent(factor).ok_or_else(|| form("has an exponent that is not a whole number"))?;
        if !(1..=STEEPEST).contains(&exponent.abs()) {
            return Err(form("has an exponent beyond 1 to 9"));
        }
        let unknown = || UnitError::Unknown { word: word.into(), text: whole.clone(), hint: hint_of(word) };
        let (scale, known) = find(word).ok_or_else(unknown)?;
        times(unit, scale, known, power * exponent);
        count += 1;
    }
    if count == 0 {
        return Err(form("has nothing beside a slash"));
    }
    Ok(count)
}

fn times(unit: &mut Unit, scale: f64, known: &Known, power: i32) {
    unit.factor *= (scale * known.factor).powi(power);
    for k in 0..BASES {
        unit.dimension[k] += power * known.dimension[k];
    }
}

/// A word and its exponent: `m^3`, `m3`, `m³`, `s^-1`, `s-1`, `s⁻¹`, `mmH2O`.
fn exponent(factor: &str) -> Option<(&str, i32)> {
    if find(factor).is_some() {
        return Some((factor, 1));
    }
    if let Some((word, power)) = factor.split_once('^') {
        return Some((word, power.trim_matches(['(', ')']).parse().ok()?));
    }
    const RAISED: [char; 12] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹', '⁻', '⁺'];
    let plain = |c: char| match RAISED.iter().position(|r| *r == c) {
        Some(10) => '-',
        Some(11) => '+',
        Some(k) => char::from(b'0' + k as u8),
        None => c,
    };
    let word =
        factor.trim_end_matches(|c: char| c.is_ascii_digit() || "+-".contains(c) || RAISED.contains(&c));
    match &factor[word.len()..] {
        "" => Some((word, 1)),
        power => Some((word, power.chars().map(plain).collect::<String>().parse().ok()?)),
    }
}
