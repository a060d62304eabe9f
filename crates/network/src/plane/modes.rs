//! What a search finds: modes, and the count that certifies them.

use super::newton::Root;
use rijke_numerics::C64;

/// One mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    /// s = sigma + i omega.
    pub s: C64,
    /// |F/F'|/|s| at s: the relative error that Newton still sees.
    pub residual: f64,
    /// 1, or more for roots too close for rounding to tell apart; s is then their mean, to about the square
    /// root of rounding.
    pub multiplicity: usize,
}

impl Mode {
    /// The eigenvalue, to ask for its response, sensitivities and budget.
    #[must_use]
    pub fn root(&self) -> Root {
        Root { s: self.s, steps: 0, residual: self.residual }
    }
}

/// All modes of a region, with the count that certifies them: `found == counted` always, or there is an
/// error.
#[derive(Clone, Debug, PartialEq)]
pub struct Modes {
    /// The modes in order of frequency.
    pub modes: Vec<Mode>,
    /// Modes by the winding number, with multiplicity.
    pub counted: usize,
    /// Declared poles of laws inside the region, with their orders; they are not modes.
    pub poles: usize,
    /// How often the chain was swept.
    pub evaluations: usize,
}
