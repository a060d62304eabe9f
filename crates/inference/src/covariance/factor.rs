//! The factor of one block's covariance, of whichever kind: it gives the block's likelihood.

use super::block::{Block, Likelihood};
use super::kernelled::KernelFactor;
use super::woodbury::Woodbury;
use crate::error::InferenceError;
use crate::problem::Data;
use rijke_numerics::{Cholesky, Order};

/// The factor of one block's covariance.
pub(crate) enum Factor {
    Dense(Cholesky),
    Structured(Woodbury),
    Kernelled(Box<KernelFactor>),
}

impl Factor {
    /// Of block `k` of the data, with the standard deviations `sds` of the groups of noise.
    pub(crate) fn new(data: &Data, k: usize, sds: &[f64]) -> Result<Self, InferenceError> {
        let observation = &data.observations()[k];
        let factor = match &observation.structured {
            Some(structured) => match &structured.kernelled {
                Some(k) => KernelFactor::new(structured, k, sds).map(Box::new).map(Self::Kernelled),
                None => Woodbury::new(structured, sds).map(Self::Structured),
            },
            None => Cholesky::new(&data.covariance(k, sds)).map(Self::Dense),
        };
        factor.map_err(|source| InferenceError::SingularCovariance {
            observation: observation.label.clone(),
            source,
        })
    }
}

impl Likelihood<'_> {
    /// What the block adds, with derivatives up to `order`.
    pub(crate) fn block(&self, factor: &Factor, order: Order) -> Block {
        match (factor, &self.observation.structured) {
            (Factor::Structured(known), Some(structured)) => self.structured_block(structured, known, order),
            (Factor::Kernelled(known), Some(structured)) => {
                structured.kernelled.as_ref().map_or_else(Block::default, |k| {
                    self.kernelled_block(structured, (k, known.as_ref()), order)
                })
            }
            (Factor::Dense(factor), _) => self.dense_block(factor, order),
            // A structured factor is made from a structure.
            (Factor::Structured(_) | Factor::Kernelled(_), None) => Block::default(),
        }
    }
}

/// Most data of a block whose covariance is formed as a dense matrix: half a gigabyte.
const MOST_DENSE: usize = 8000;

/// Fails for a block that is too large for what needs its covariance as a dense matrix.
pub(crate) fn dense_enough(label: &str, size: usize) -> Result<(), InferenceError> {
    if size <= MOST_DENSE {
        return Ok(());
    }
    Err(InferenceError::TooLarge { observation: label.to_owned(), size, limit: MOST_DENSE })
}
