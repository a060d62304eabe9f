//! What can be wrong with one element of a network file.

use rijke_numerics::words::to_digits;

/// What is wrong with one element.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ElementProblem {
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
    /// A duct shorter than the distance at which two places are one.
    #[error(
        "length is {length:e} m, nothing beside the {tube} m of the tube: correct it, or leave the duct out"
    )]
    TooShort {
        /// Its length, m.
        length: f64,
        /// That of the tube, m.
        tube: f64,
    },
    /// A number must not be negative.
    #[error("{key} is {value}, but must be zero or more, and finite")]
    Negative {
        /// The key.
        key: &'static str,
        /// Its value.
        value: f64,
    },
    /// A number must be finite.
    #[error("{key} is {value}, but must be finite")]
    NotFinite {
        /// The key.
        key: &'static str,
        /// Its value.
        value: f64,
    },
    /// An angle beyond a turn.
    #[error("{key} is {value} rad, more than a turn: angles are in rad")]
    Angle {
        /// The key.
        key: &'static str,
        /// Its value.
        value: f64,
    },
    /// A hole wider than its tube.
    #[error(
        "the hole is {diameter:.5} m wide, but the tube only {tube:.5} m: make it narrower, or leave it out"
    )]
    HoleTooWide {
        /// Diameter of the hole, m.
        diameter: f64,
        /// Diameter of the narrower duct beside it, m.
        tube: f64,
    },
    /// A part of an area.
    #[error("{key} is {value}, but must be above 0 and at most 1")]
    Part {
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
    /// The ratio of specific heats of no gas.
    #[error("gamma is {value}, but must be above 1")]
    Gamma {
        /// Its value.
        value: f64,
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
    /// A transfer function whose answer to a short push grows for ever.
    #[error(
        "{key} has a root with a positive real part: its answer to a short push grows for ever; turn the sign of a coefficient"
    )]
    Grows {
        /// The key.
        key: &'static str,
    },
    /// Another element has the same name.
    #[error("element {other} has that name, too: give every element a name of its own")]
    SameName {
        /// Number of the other, from 1.
        other: usize,
    },
    /// Less than one hole.
    #[error(
        "one hole of this diameter is {part:.3} of the duct's area, more than porosity = {porosity}: correct one of them, or leave `porosity` out for \
         a single hole"
    )]
    PartOfAHole {
        /// Area of one hole over that of the duct.
        part: f64,
        /// The porosity.
        porosity: f64,
    },
    /// A whole number is out of range.
    #[error("{key} is {value}, but must be from {low} to {high}")]
    Range {
        /// The key.
        key: &'static str,
        /// Its value.
        value: usize,
        /// Least value.
        low: usize,
        /// Largest value.
        high: usize,
    },
    /// A duct begins where another one still is.
    #[error("it begins at {at} m and overlaps {other} by {} m: move it, or shorten the other one", to_digits(*by, 6))]
    Overlap {
        /// Where it begins, m.
        at: f64,
        /// The other element.
        other: String,
        /// By how much, m.
        by: f64,
    },
    /// A duct begins beyond the end of the one before.
    #[error("it begins at {at} m, {} m beyond the end of what lies before it: put a duct between", to_digits(*by, 6))]
    Gap {
        /// Where it begins, m.
        at: f64,
        /// By how much, m.
        by: f64,
    },
    /// A device is not in the tube.
    #[error("it lies at {at} m, but the tube reaches from 0 to {length} m")]
    OutsideTube {
        /// Where, m.
        at: f64,
        /// Length of the tube, m.
        length: f64,
    },
    /// A flame's reference lies outside the tube.
    #[error("the velocity reference is {distance} m away, but the tube reaches {length} m on that side")]
    ReferenceOutside {
        /// Distance asked for, m.
        distance: f64,
        /// What there is, m.
        length: f64,
    },
    /// Something lies between a flame and its reference.
    #[error("{other} lies between the flame and its velocity reference: only ducts may")]
    ReferenceBlocked {
        /// What.
        other: String,
    },
    /// A flame that refers downstream shares its place.
    #[error(
        "{other} is at the same place: a flame whose velocity reference lies downstream must stand alone"
    )]
    NotAlone {
        /// With what.
        other: String,
    },
    /// With flow nothing may act at the ends.
    #[error("with [flow] nothing may act at an end of the tube: put a duct on its other side")]
    AtEnd,
    /// A table cannot be fitted.
    #[error(transparent)]
    Table(#[from] crate::laws::TableError),
    /// A flow is too fast, or not a flow.
    #[error(
        "the Mach number is {mach:.3}, but must be above 0 and below 0.3: lower it in [flow], or widen the duct; leave [flow] \
         out for gas at rest"
    )]
    TooFast {
        /// The Mach number.
        mach: f64,
    },
}
