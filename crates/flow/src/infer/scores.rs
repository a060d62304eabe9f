//! Normal scores: a standard normal number for every unknown, whose image is the physical value.

use crate::error::FlowError;
use crate::number::Number;
use crate::tube::parameters::{UNKNOWNS, Unknowns};
use rijke_inference::{Parameter, Prior, normal_cdf};

/// The physical value that belongs to a standard normal score: low + (high - low) Phi(z) for a uniform prior,
/// mean + sd z for a normal one, median e^{ln_sd z} for a log-normal one.
///
/// # Errors
/// [`FlowError::Prior`] for any other prior.
pub fn physical<N: Number>(parameter: &Parameter, z: N) -> Result<N, FlowError> {
    match parameter.prior {
        Prior::Uniform { low, high } => {
            let density = |z: f64| (-0.5 * z.powi(2)).exp() / std::f64::consts::TAU.sqrt();
            Ok(z.map(|z| (low + (high - low) * normal_cdf(z), (high - low) * density(z))))
        }
        Prior::Normal { mean, sd } => Ok(z * sd + mean),
        Prior::LogNormal { median, ln_sd } => Ok((z * ln_sd).exp() * median),
        _ => Err(FlowError::Prior { name: parameter.name.clone() }),
    }
}

/// All unknowns from their scores.
pub(crate) fn unknowns_from<N: Number>(
    priors: &[Parameter; UNKNOWNS],
    scores: &[N],
) -> Result<Unknowns<N>, FlowError> {
    let mut values = [N::constant(0.0); UNKNOWNS];
    for (value, (parameter, &z)) in values.iter_mut().zip(priors.iter().zip(scores)) {
        *value = physical(parameter, z)?;
    }
    Ok(Unknowns::from_array(values))
}
