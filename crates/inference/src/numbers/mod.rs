//! Functions of plain numbers: the normal distribution, chi-squared, the scalar product.
//!
//! Knows no parameter, no data and no density.

pub(crate) mod chi_squared;
pub(crate) mod dot;
pub(crate) mod normal;
