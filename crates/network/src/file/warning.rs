//! What is doubtful about a network but possible.

use super::item::Item;
use rijke_numerics::rational::{Doubt, TableRow, doubt, doubt_of_flame, too_late};
use rijke_numerics::words::to_digits;

/// What is doubtful about a network.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Warning {
    /// Density and sound speed do not belong to the pressure.
    #[error("line {line}: {place}: rho c^2/gamma is {found:.0} Pa, but the pressure is {expected:.0} Pa")]
    Pressure {
        /// Line in the file.
        line: usize,
        /// Which element.
        place: String,
        /// rho c^2/gamma, Pa.
        found: f64,
        /// The pressure of the gas, Pa.
        expected: f64,
    },
    /// A reflection coefficient above one feeds energy.
    #[error(
        "line {line}: {place}: |R| = {} at {} Hz is above 1: this end feeds the modes", to_digits(*.modulus, 6), to_digits(*.frequency_hz, 6)
    )]
    Reflection {
        /// Line in the file.
        line: usize,
        /// Which end.
        place: String,
        /// The largest |R| at the frequencies searched.
        modulus: f64,
        /// Where, Hz.
        frequency_hz: f64,
    },
    /// A number that is most often one in another unit.
    #[error("line {line}: {place}: {key} is {value} {unit}, {why}: numbers are in SI units; {remedy}")]
    Size {
        /// Line in the file.
        line: usize,
        /// Which element or table.
        place: String,
        /// The key.
        key: &'static str,
        /// Its value.
        value: f64,
        /// Its unit.
        unit: &'static str,
        /// What no rig has.
        why: String,
        /// What to write.
        remedy: String,
    },
    /// A key without effect.
    #[error("line {line}: {place}: {key} has no effect: {why}; {remedy}")]
    Idle {
        /// Line in the file.
        line: usize,
        /// Which element.
        place: String,
        /// The key.
        key: &'static str,
        /// Why.
        why: &'static str,
        /// What to write.
        remedy: &'static str,
    },
    /// A formula is asked where it does not hold.
    #[error("line {line}: {place}: {what}; {remedy}")]
    Range {
        /// Line in the file.
        line: usize,
        /// Which element or end.
        place: String,
        /// What is asked of it.
        what: String,
        /// What to write.
        remedy: String,
    },
    /// The neck of a resonator wider than the duct it stands on.
    #[error(
        "line {line}: {place}: neck_area is {neck} m^2, more than the {duct:.3e} m^2 of the duct there: check its unit"
    )]
    Neck {
        /// Line in the file.
        line: usize,
        /// Which element.
        place: String,
        /// Area of the neck, m^2.
        neck: f64,
        /// Area of the duct, m^2.
        duct: f64,
    },
    /// Two equal resonators at one place.
    #[error(
        "line {line}: {place}: it equals {other} at the same place: the two also ring against each other, at their own resonance and without sound in \
         the duct, and this mode is not counted; if they differ, as real ones do, give each its own numbers"
    )]
    Twin {
        /// Line in the file.
        line: usize,
        /// Which element.
        place: String,
        /// The other.
        other: String,
    },
    /// A phase that falls as by a delay that no flame has.
    #[error(
        "line {line}: {place}: the phase of the table falls as by a delay of {delay_ms:.0} ms: it is in rad; if these are degrees, multiply them by pi/180"
    )]
    Late {
        /// Line in the file.
        line: usize,
        /// Which element or end.
        place: String,
        /// The delay, ms.
        delay_ms: f64,
    },
    /// Phases that may be in degrees.
    #[error(
        "line {line}: {place}: the phase of the table differs by {step:.1} rad between neighbouring rows, half of them by more: it is in rad; if these \
         are degrees, multiply them by pi/180, else give more rows"
    )]
    Degrees {
        /// Line in the file.
        line: usize,
        /// Which element or end.
        place: String,
        /// Median difference of neighbours, rad.
        step: f64,
    },
    /// The phase of a table rises with frequency.
    #[error(
        "line {line}: {place}: the phase of the table rises by {rise:.2} rad in all, but a delay, and the mass of an open end, lower it: rijke takes numbers that vary as \
         exp(i omega t); if these are for exp(-i omega t), turn the signs of the phases"
    )]
    Rises {
        /// Line in the file.
        line: usize,
        /// Which element or end.
        place: String,
        /// From the first frequency to the last, by a straight line, rad.
        rise: f64,
    },
    /// The phase of a table turns far from row to row.
    #[error(
        "line {line}: {place}: half of the steps of the table's phase are larger than {step:.1} rad: such steps cannot distinguish a delay from one that \
         is {other_ms:.2} ms longer or shorter, nor the convention exp(i omega t), which is assumed, from exp(-i omega t); give \
         finer frequencies"
    )]
    Coarse {
        /// Line in the file.
        line: usize,
        /// Which element or end.
        place: String,
        /// Median difference of neighbours, to the nearest turn, rad.
        step: f64,
        /// Delay by which another reading of the phases differs, ms.
        other_ms: f64,
    },
    /// The search goes beyond a table.
    #[error(
        "line {line}: {place}: the table ends at {} and {} Hz, but the search does not: modes beyond rest on extrapolation",
        to_digits(*.low_hz, 6), to_digits(*.high_hz, 6)
    )]
    Extrapolation {
        /// Line in the file.
        line: usize,
        /// Which element or end.
        place: String,
        /// Limits of the table, Hz.
        low_hz: f64,
        /// Upper limit.
        high_hz: f64,
    },
}

/// Tables of flames that end below this, Hz, are most often in kHz.
const SLOW: f64 = 5.0;

impl Warning {
    pub(super) fn range(item: &Item, what: String, remedy: impl Into<String>) -> Self {
        Self::Range { line: item.line, place: item.place.clone(), what, remedy: remedy.into() }
    }

    pub(super) fn idle(item: &Item, key: &'static str, why: &'static str, remedy: &'static str) -> Self {
        Self::Idle { line: item.line, place: item.place.clone(), key, why, remedy }
    }

    /// Of the table of an end or of a `flame`: it answers before it is asked, or its phases seem to be in
    /// degrees.
    pub(super) fn of_table(item: &Item, rows: &[[f64; 3]], flame: bool) -> Option<Self> {
        let rows: Vec<TableRow> = rows.iter().copied().map(TableRow::from).collect();
        let Item { line, place } = item.clone();
        let late = too_late(&rows).filter(|_| flame);
        let last = rows.last().map_or(0.0, |row| row.frequency);
        if let Some(delay) = late.filter(|_| last < SLOW) {
            let what = format!(
                "the table ends at {} Hz, and its phase falls as by a delay of {:.0} ms",
                to_digits(last, 6),
                1e3 * delay
            );
            return Some(Self::range(item, what, "if its frequencies are in kHz, multiply them by 1000"));
        }
        let doubt = if flame { doubt_of_flame(&rows) } else { doubt(&rows) };
        Some(match (doubt, late) {
            // Steps beyond half a turn say so more surely than the delay.
            (Some(Doubt::Degrees { step }), _) => Self::Degrees { line, place, step },
            (_, Some(delay)) => Self::Late { line, place, delay_ms: 1e3 * delay },
            (Some(Doubt::Coarse { step, other }), None) => {
                Self::Coarse { line, place, step, other_ms: 1e3 * other }
            }
            (Some(Doubt::Rises { rise }), None) => Self::Rises { line, place, rise },
            (None, None) => return None,
        })
    }
}
