//! Where the numbers of one mode stand in lists, covariances and derivatives.

/// Rows of the numbers of one mode: growth rate, angular frequency, then real and imaginary part of every
/// pressure in turn, without that of the reference.
#[derive(Clone, Copy, Debug)]
pub struct ModeRows;

impl ModeRows {
    /// Row of the real part of pressure `k`; that of the imaginary part follows.
    #[must_use]
    pub const fn pressure(k: usize) -> usize {
        2 + 2 * k
    }

    /// Number of rows with so many pressures.
    #[must_use]
    pub const fn count(pressures: usize) -> usize {
        Self::pressure(pressures)
    }
}
