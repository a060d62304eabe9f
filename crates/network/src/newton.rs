//! The eigenvalue nearest a guess, by Newton's iteration.

use crate::chain::Network;
use crate::coefficients::{Coefficients, Laws};
use crate::error::NetworkError;
use crate::response::Tangents;
use rijke_numerics::C64;

/// How Newton's iteration is bounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Newton {
    /// Most steps taken; 30 unless set.
    pub max_steps: usize,
    /// The iteration ends after a step below this part of |s|; 1e-9 unless set. Convergence is quadratic, so the
    /// error that remains after that step is of the order of its square, that is, of rounding.
    pub tolerance: f64,
    /// No step is longer than this, 1/s. Half the spacing of modes, pi/(2 travel time), unless set.
    pub max_step: Option<f64>,
    /// A root farther than this from the guess is [`NetworkError::LostBranch`], 1/s. The spacing of modes unless set.
    pub radius: Option<f64>,
}

impl Default for Newton {
    fn default() -> Self {
        Self { max_steps: 30, tolerance: 1e-9, max_step: None, radius: None }
    }
}

/// An eigenvalue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Root {
    /// s = sigma + i omega, 1/s and rad/s.
    pub s: C64,
    /// Newton steps taken.
    pub steps: usize,
    /// Length of the last Newton step relative to |s|, before that step was taken: the error of s is of the order of
    /// its square.
    pub residual: f64,
}

/// Memory that is reused from call to call; after the first call with a network of the same size, root searches
/// allocate nothing.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    pub(crate) laws: Laws,
    pub(crate) tangents: Tangents,
}

impl Network {
    /// The eigenvalue to which Newton's iteration from `guess` leads.
    ///
    /// # Errors
    /// [`NetworkError::NotConverged`] after too many steps, [`NetworkError::NotFinite`] where a law has no value,
    /// [`NetworkError::LostBranch`] if the root is farther from the guess than [`Newton::radius`].
    pub fn solve<K: Coefficients + ?Sized>(
        &self,
        coefficients: &K,
        guess: C64,
        settings: &Newton,
        work: &mut Workspace,
    ) -> Result<Root, NetworkError> {
        let spacing = std::f64::consts::PI / self.travel_time();
        let longest = settings.max_step.unwrap_or(0.5 * spacing);
        let mut s = guess;
        let mut residual = f64::INFINITY;
        for steps in 1..=settings.max_steps {
            let f = self.characteristic(coefficients, s, &mut work.laws);
            let step = -f.v / f.d;
            if !step.is_finite() {
                return Err(NetworkError::NotFinite { s });
            }
            let length = step.norm();
            s += if length > longest { step * (longest / length) } else { step };
            residual = length / s.norm();
            if residual <= settings.tolerance {
                let radius = settings.radius.unwrap_or(spacing);
                return if (s - guess).norm() > radius {
                    Err(NetworkError::LostBranch { from: guess, to: s })
                } else {
                    Ok(Root { s, steps, residual })
                };
            }
        }
        Err(NetworkError::NotConverged { steps: settings.max_steps, residual })
    }

    /// F(s) and dF/ds of the characteristic function whose zeros are the eigenvalues; entire in s if all laws are.
    #[must_use]
    pub fn characteristic_function<K: Coefficients + ?Sized>(
        &self,
        coefficients: &K,
        s: C64,
        work: &mut Workspace,
    ) -> [C64; 2] {
        let f = self.characteristic(coefficients, s, &mut work.laws);
        [f.v, f.d]
    }
}
