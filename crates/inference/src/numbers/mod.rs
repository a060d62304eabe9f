//! Functions of plain numbers: the normal distribution, chi-squared.
//!
//! Knows no parameter, no data and no density.

mod chi_squared;
mod normal;

pub use chi_squared::chi_squared_sds;
pub use normal::{normal_cdf, normal_quantile};
