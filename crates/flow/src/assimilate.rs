//! From click arrival times to the base state: assimilation with honest certainty.
//!
//! * [`Batch`]: the most probable unknowns given all clicks of all powers, transients included, and the posterior around
//!   them with the bounds of the priors. The default, and the cheapest. 2 sd cover U_h, the sound speed and the identifiable
//!   unknowns in 91 to 97 % of 200 twins (docs/records/flow.md).
//! * [`smooth`]: ES-MDA, an ensemble smoother, free of derivatives.
//! * [`filter`]: the ensemble Kalman filter that the paper describes, and variants that repair parts of it. Its error
//!   bars are too small; it is here to be compared.
//!
//! All three infer normal scores: every unknown has a standard normal score whose image is the physical value
//! ([`physical`]), so a uniform prior is kept exactly and its bounds cannot be crossed.

mod ambient;
mod axis;
mod batch;
mod estimate;
mod files;
mod filter;
mod members;
mod record;
mod report;
mod shape;
mod smoother;
mod tension;
mod twin;
mod whitening;

pub use ambient::{Ambient, smooth_ambient};
pub use batch::Batch;
pub use estimate::{Estimate, Health, Warning};
pub use files::Records;
pub use filter::{FilterOptions, FilterRun, Snapshot, Variant, filter};
pub(crate) use record::plausible;
pub use record::{Record, Sample, Sensor, SensorKind};
pub use report::{
    Method, NamedStates, PointReport, PowerReport, ResidualReport, RunReport, SnapshotReport, UnknownReport,
    assimilate,
};
pub use smoother::smooth;
pub use tension::Tension;
pub use twin::{Twin, TwinOptions, staircase};

use crate::number::Number;
use crate::{FlowError, UNKNOWNS, Unknowns};
use rijke_inference::{Parameter, Prior, normal_cdf};

/// What twin experiments say of each method's error bars (docs/records/flow.md): share of twins within two sd, p of the ranks, rms
/// error over sd, rms error in units of the prior sd or m/s, and posterior over prior sd. CSV with a header.
pub const CALIBRATION: &str = include_str!("assimilate/calibration.csv");

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
