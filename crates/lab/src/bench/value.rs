//! A number of the truth file that may change from point to point.

use super::campaign::Point;
use super::error::BenchError;
use serde::Deserialize;

/// A number, or the factor of the campaign that holds it.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
pub(crate) enum Value {
    Number(f64),
    Factor(String),
}

impl Value {
    /// The number at `point`.
    pub(crate) fn at(&self, point: &Point) -> Result<f64, BenchError> {
        match self {
            Self::Number(number) => Ok(*number),
            Self::Factor(factor) => point.factors.get(factor).copied().ok_or_else(|| BenchError::Factor {
                point: point.id.clone(),
                factor: factor.clone(),
                known: point.factors.keys().cloned().collect(),
            }),
        }
    }
}

/// Whether a part whose factor is `present` is there: always without a factor, else where it is not 0 and not
/// empty.
pub(crate) fn is_present(present: Option<&String>, point: &Point) -> bool {
    present.is_none_or(|factor| point.factors.get(factor).is_some_and(|value| *value != 0.0))
}
