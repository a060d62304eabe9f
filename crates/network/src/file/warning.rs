//! What is doubtful about a network but possible.

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
        "line {line}: {place}: |R| = {modulus} at {frequency_hz} Hz is above 1: this end feeds the modes"
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
        "line {line}: {place}: the phase of the table rises by {rise:.1} rad in all, but a delay lowers it: rijke takes numbers that vary as \
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
        "line {line}: {place}: half of the steps of the table's phase are larger than {step:.1} rad: such steps cannot tell a delay from one that \
         is {other_ms:.2} ms longer or shorter, nor numbers that vary as exp(i omega t), which are taken, from those for exp(-i omega t); give \
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
        "line {line}: {place}: the table ends at {low_hz} and {high_hz} Hz, but the search does not: modes beyond rest \
         on extrapolation"
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
