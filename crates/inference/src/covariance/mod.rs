//! The likelihood of one block of data, with derivatives, for each kind of covariance: dense (`dense`), a diagonal and columns
//! (`woodbury`), an exact misfit (`kernelled`). `factor` chooses between them.
//!
//! Knows no prior and no search: predictions and standard deviations come in as numbers.

pub(crate) mod block;
pub(crate) mod dense;
pub(crate) mod factor;
pub(crate) mod kernelled;
pub(crate) mod woodbury;
