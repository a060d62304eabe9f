//! Functions of plain numbers: the normal distribution, chi-squared, sums of numbers known by logarithms.
//!
//! Knows no parameter, no data and no density.

mod chi_squared;
mod normal;
mod shares;

pub use chi_squared::chi_squared_sds;
pub use normal::{normal_cdf, normal_quantile};

pub(crate) use shares::shares;
