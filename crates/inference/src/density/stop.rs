//! Why a search ended, and what it cost.

use rijke_numerics::Order;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Why a search ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Stop {
    /// The drop in J that is left is below the tolerance, or below what rounding lets the gradient resolve,
    /// or below 1e-3 nats when the evaluations were used up.
    Converged {
        /// Half of g' H^-1 g at the end, nats.
        decrement: f64,
    },
    /// The cap on evaluations was reached.
    EvaluationCap {
        /// Half of g' H^-1 g at the end, nats; infinite if the Hessian is not positive definite.
        decrement: f64,
    },
    /// J is flat to rounding along a direction in which the Hessian is not positive: there is no isolated
    /// minimum here.
    Flat {
        /// Lowest eigenvalue of the Hessian as a fraction of the highest, in scaled coordinates.
        eigenvalue_ratio: f64,
    },
    /// No shorter step helps although the gradient is not zero: a bound, or a model that fails beyond this
    /// point.
    Blocked {
        /// What the last refused step met.
        reason: String,
    },
}

/// In words, as the end of a sentence: "the search ended without converging: ...".
impl fmt::Display for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Converged { decrement } => write!(f, "converged to {decrement:.1e} nats"),
            Self::EvaluationCap { decrement } if decrement.is_finite() => {
                write!(f, "too many evaluations, with {decrement:.1e} nats still to gain")
            }
            Self::EvaluationCap { .. } => f.write_str("too many evaluations, and no minimum near"),
            Self::Flat { eigenvalue_ratio } => write!(
                f,
                "neither data nor priors determine one combination of the parameters (curvature {eigenvalue_ratio:.1e} of the largest)"
            ),
            Self::Blocked { reason } => write!(f, "no shorter step helps: {reason}"),
        }
    }
}

/// How often the objective was evaluated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Calls {
    /// To value only.
    pub value: usize,
    /// With the gradient.
    pub first: usize,
    /// With gradient and Hessian.
    pub second: usize,
    /// Of all these, how many failed recoverably.
    pub failed: usize,
}

impl Stop {
    /// True for [`Stop::Converged`].
    #[must_use]
    pub fn converged(&self) -> bool {
        matches!(self, Self::Converged { .. })
    }
}

impl Calls {
    /// Evaluations of any order.
    #[must_use]
    pub fn total(&self) -> usize {
        self.value + self.first + self.second
    }

    /// Counts one evaluation to `order`.
    pub fn count(&mut self, order: Order) {
        match order {
            Order::Value => self.value += 1,
            Order::First => self.first += 1,
            Order::Second => self.second += 1,
        }
    }

    /// The sum of both counts.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            first: self.first + other.first,
            second: self.second + other.second,
            failed: self.failed + other.failed,
        }
    }
}
