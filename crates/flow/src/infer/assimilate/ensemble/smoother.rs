//! ES-MDA on the whole record.

use crate::error::FlowError;
use crate::infer::assimilate::batch::model::Batch;
use crate::infer::assimilate::estimate::Estimate;
use rijke_inference::ensemble::{Ensemble, NoiseCovariance, Smoother, smooth as smooth_ensemble};
use rijke_numerics::{Matrix, Streams};

/// The estimate from `members` members (100 by default in the paper) and the passes of `smoother`.
///
/// Data are whitened first, so that their noise is independent.
///
/// # Errors
/// [`FlowError::Ensemble`].
pub fn smooth(
    batch: &Batch<'_>,
    members: usize,
    smoother: &Smoother,
    streams: &Streams,
) -> Result<Estimate, FlowError> {
    let measured = batch.whitening.apply(batch.means.clone());
    let noise = NoiseCovariance::Independent(vec![1.0; measured.len()]);
    let prior =
        Ensemble::standard_normal(members, batch.scores(), &mut streams.stream("flow/smoother/prior"))?;
    let smoothed = smooth_ensemble(prior, &measured, &noise, smoother, streams, |scores| {
        batch.run(scores).map(|predicted| batch.whitening.apply(predicted))
    })?;
    let (mean, covariance): (Vec<f64>, Matrix) = (smoothed.ensemble.mean(), smoothed.ensemble.covariance());
    Estimate::new(&batch.priors, batch.names(), mean, covariance)
}
