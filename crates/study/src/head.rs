//! Errors of a measuring head.

use crate::plan::SdSpec;

/// An error term of a measuring head: R_measured = R + sum of b(f) R^power, where b is a smooth complex
/// function of frequency, a sum of Legendre polynomials over the band that trains, with independent complex
/// coefficients.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorTerm {
    /// The power of R.
    pub power: i32,
    /// Number of polynomials, of degrees 0, 1, 2 and so on.
    pub functions: usize,
    /// Root mean square of the real and of the imaginary part of b over the band, before the data.
    pub sd: SdSpec,
}
