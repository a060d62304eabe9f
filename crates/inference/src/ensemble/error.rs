//! What can go wrong with an ensemble, with numbers.

use rijke_numerics::DenseError;

/// Why an ensemble has no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EnsembleError {
    /// Fewer members than the operation needs.
    #[error("the ensemble has {have} members; this needs at least {need}")]
    TooFewMembers {
        /// Members given.
        have: usize,
        /// Members needed.
        need: usize,
    },
    /// A NaN or an infinity.
    #[error("variable {variable} of member {member} is not finite")]
    NotFinite {
        /// Row.
        member: usize,
        /// Column.
        variable: usize,
    },
    /// A measured number that is none.
    #[error("datum {datum} is not finite")]
    Datum {
        /// Its place in the list.
        datum: usize,
    },
    /// A variance that is negative or not a number.
    #[error("variance {place} is {value}: give one that is at least zero and finite")]
    Variance {
        /// Its place in the list.
        place: usize,
        /// Its value.
        value: f64,
    },
    /// Lists that do not fit together.
    #[error("{what}: expected {expected}, got {got}")]
    Shape {
        /// Which list.
        what: &'static str,
        /// Length it must have.
        expected: usize,
        /// Length it has.
        got: usize,
    },
    /// Too many members failed in one forecast.
    #[error("{failed} of {members} members failed in step {step}; the first says: {reason}")]
    Failed {
        /// Members that failed.
        failed: usize,
        /// Members in the ensemble.
        members: usize,
        /// The caller's number of the forecast.
        step: usize,
        /// The model's words.
        reason: String,
    },
    /// The coefficients of a smoother do not satisfy sum 1/alpha = 1, each at least 1.
    #[error("the coefficients must be at least 1 with reciprocals that sum to 1; the sum is {sum}")]
    Coefficients {
        /// Sum of the reciprocals.
        sum: f64,
    },
    /// The noise covariance is not positive definite, or an eigenvalue iteration failed.
    #[error(transparent)]
    Dense(#[from] DenseError),
}
