//! The likelihood of one block of data, with derivatives, for each kind of covariance: dense (`dense`), a
//! diagonal and columns (`woodbury`), an exact misfit (`kernelled`). `factor` chooses between them.
//!
//! Knows no prior and no search: predictions and standard deviations come in as numbers.

mod block;
mod dense;
mod factor;
mod kernelled;
mod woodbury;

pub(crate) use block::{Block, Likelihood, add_corner};
pub(crate) use factor::{Factor, dense_enough};
