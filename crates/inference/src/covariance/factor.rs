//! The factor of one block's covariance, of whichever kind: it gives the block's likelihood, and draws of its
//! noise.

use super::block::{Block, Likelihood};
use super::kernelled::KernelFactor;
use super::woodbury::Woodbury;
use crate::error::InferenceError;
use crate::problem::Observation;
use rand::RngExt;
use rand_distr::StandardNormal;
use rijke_numerics::{Cholesky, Order, Stream};

/// The factor of one block's covariance.
pub(crate) enum Factor {
    Dense(Cholesky),
    Structured(Woodbury),
    Kernelled(Box<KernelFactor>),
}

impl Factor {
    /// Of `observation`, with the standard deviations `sds` of the groups of noise.
    pub(crate) fn new(observation: &Observation, sds: &[f64]) -> Result<Self, InferenceError> {
        let factor = match &observation.structured {
            Some(structured) => match &structured.kernelled {
                Some(k) => KernelFactor::new(structured, k, sds).map(Box::new).map(Self::Kernelled),
                None => Woodbury::new(structured, sds).map(Self::Structured),
            },
            None => Cholesky::new(&observation.covariance(sds)).map(Self::Dense),
        };
        factor.map_err(|source| InferenceError::SingularCovariance {
            observation: observation.label.clone(),
            source,
        })
    }

    /// A draw of the noise of `observation`, whose factor this is.
    pub(crate) fn draw(&self, observation: &Observation, stream: &mut Stream) -> Vec<f64> {
        let n = observation.values.len();
        match (self, &observation.structured) {
            (Self::Structured(known), Some(structured)) => known.draw(structured, stream),
            (Self::Dense(factor), _) => {
                let xi: Vec<f64> = (0..n).map(|_| stream.sample(StandardNormal)).collect();
                factor.lower().times(&xi)
            }
            (Self::Kernelled(known), Some(structured)) => {
                structured.kernelled.as_ref().map_or_else(|| vec![0.0; n], |k| known.draw(k, stream))
            }
            (Self::Structured(_) | Self::Kernelled(_), None) => vec![0.0; n],
        }
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
