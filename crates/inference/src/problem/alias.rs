//! How a model repeats itself: changes of parameters that leave its prediction nearly as it was.

use serde::{Deserialize, Serialize};

/// A change of parameters that leaves what a model predicts nearly as it was, so that one maximum of the
/// posterior announces others. All moves are made at once, and may be repeated.
///
/// ```
/// use rijke_inference::Alias;
/// // A delay of a wave of 160 Hz; and the same wave of the other sign half a period later.
/// let whole = Alias::period("tau", 1.0 / 160.0);
/// let half = Alias::period("tau", 0.5 / 160.0).and(Alias::mirror("gain", 0.0));
/// assert_eq!((whole.moves.len(), half.moves.len()), (1, 2));
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Alias {
    /// What changes.
    pub moves: Vec<Move>,
}

/// One change of a physical value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Move {
    /// The value grows or falls by a step: a delay by the period of its wave.
    Shift {
        /// Name of the parameter.
        parameter: String,
        /// The step, in its unit.
        by: f64,
    },
    /// The value is reflected: it becomes twice `about` less itself. About zero it changes its sign.
    Mirror {
        /// Name of the parameter.
        parameter: String,
        /// Where the mirror stands, in its unit.
        about: f64,
    },
    /// Two values change places.
    Exchange {
        /// Name of the one.
        parameter: String,
        /// Name of the other.
        with: String,
    },
}

impl Alias {
    /// The model repeats whenever the parameter grows by `period`.
    pub fn period(parameter: impl Into<String>, period: f64) -> Self {
        Self { moves: vec![Move::Shift { parameter: parameter.into(), by: period }] }
    }

    /// The model repeats on the other side of `about`; zero for a sign.
    pub fn mirror(parameter: impl Into<String>, about: f64) -> Self {
        Self { moves: vec![Move::Mirror { parameter: parameter.into(), about }] }
    }

    /// Two parts of the model are alike, and may change places.
    pub fn exchange(parameter: impl Into<String>, with: impl Into<String>) -> Self {
        Self { moves: vec![Move::Exchange { parameter: parameter.into(), with: with.into() }] }
    }

    /// Both changes at once: neither alone leaves the prediction as it was.
    #[must_use]
    pub fn and(mut self, other: Self) -> Self {
        self.moves.extend(other.moves);
        self
    }
}
