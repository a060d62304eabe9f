//! The eigenvalue nearest a guess.

use crate::chain::checked::beyond_range;
use crate::chain::coefficients::Coefficients;
use crate::chain::network::Network;
use crate::chain::workspace::Workspace;
use crate::error::NetworkError;
use crate::plane::newton::{Newton, Root, iterate};
use rijke_numerics::C64;

impl Network {
    /// The eigenvalue to which Newton's iteration from `guess` leads.
    ///
    /// # Errors
    /// [`NetworkError::NotConverged`] after too many steps, [`NetworkError::NotFinite`] where a law has no
    /// value, [`NetworkError::LostBranch`] if the root is farther from the guess than [`Newton::radius`],
    /// [`NetworkError::NoLaw`] for a law that is attached and not there, [`NetworkError::Property`] where
    /// laws make a length, an area, a speed of sound or a density that is not positive,
    /// [`NetworkError::Overflow`], [`NetworkError::Tolerance`].
    pub fn solve<K: Coefficients + ?Sized>(
        &self,
        coefficients: &K,
        guess: C64,
        settings: &Newton,
        work: &mut Workspace,
    ) -> Result<Root, NetworkError> {
        let spacing = std::f64::consts::PI / self.travel_time();
        self.check(coefficients, guess, &mut work.laws)?;
        iterate(guess, spacing, settings, |s| self.characteristic(coefficients, s, &mut work.laws))
            .map_err(|error| beyond_range(error, guess.re, self.travel_time()))
    }

    /// F(s) and dF/ds of the characteristic function whose zeros are the eigenvalues; entire in s if all laws
    /// are.
    ///
    /// # Panics
    /// If a law is attached that `coefficients` do not have.
    #[must_use]
    pub fn characteristic_function<K: Coefficients + ?Sized>(
        &self,
        coefficients: &K,
        s: C64,
        work: &mut Workspace,
    ) -> [C64; 2] {
        let f = self.characteristic(coefficients, s, &mut work.laws);
        [f.value, f.slope]
    }
}
