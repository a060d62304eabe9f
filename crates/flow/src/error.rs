//! What can go wrong, with numbers.

/// Why the flow has no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FlowError {
    /// A temperature that is not a positive number of kelvin.
    #[error("the temperature at x = {x} m is {kelvin} K; it must be positive (give kelvin, not Celsius)")]
    Temperature {
        /// Where, m.
        x: f64,
        /// The value.
        kelvin: f64,
    },
    /// A profile whose lists do not fit together.
    #[error(
        "a base state needs at least two ascending places with one temperature each and a positive pressure; \
         it has {places} places and {temperatures} temperatures"
    )]
    Profile {
        /// Number of places.
        places: usize,
        /// Number of temperatures.
        temperatures: usize,
    },
}
