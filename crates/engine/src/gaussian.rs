//! What a training starts from.

use crate::errors::handed_on;
use crate::noise::Noise;
use rijke_inference::{AssessOptions, MapOptions};
use rijke_numerics::Matrix;
use rijke_rig::ChannelErrors;
use rijke_study::Cause;

/// What earlier data say of some parameters: a joint Gaussian, the posterior of one stage and the prior of
/// the next.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NamedGaussian {
    /// Names of the parameters.
    pub names: Vec<String>,
    /// Most probable values.
    pub mean: Vec<f64>,
    /// Covariance.
    pub covariance: Matrix,
}

/// How a model is trained.
#[derive(Clone, Debug)]
pub struct Training {
    /// Which microphones are used.
    pub microphones: Vec<usize>,
    /// What is assumed of noise and model error.
    pub noise: Noise,
    /// What earlier stages found; parameters that the assembly does not have are ignored.
    pub known: Vec<NamedGaussian>,
    /// What the observations share of the channels' calibration, if that is known: delays and gains are then
    /// parameters beside the model's.
    pub channels: Option<ChannelErrors>,
    /// How the most probable parameters are searched; a start is of the parameters of the model.
    pub search: MapOptions,
    /// Whether the errors of the base states enter: those that all installations share as parameters, the
    /// others as a systematic covariance. Costs a second fit: their effect is taken at the result of a first
    /// one that ignores them.
    pub base_errors: bool,
    /// Assemblies of the rig of which later stages have points too: what is learnt of their errors goes on.
    pub assemblies: Vec<String>,
    /// Causes of error of which later stages have points too: what is learnt of them goes on.
    pub causes: Vec<Cause>,
    /// Whether and how the evidence is checked: other starts, importance sampling, doubled priors. Costs some
    /// hundred calls of the model.
    pub checks: Option<AssessOptions>,
}

impl Training {
    /// Whether earlier stages tell of a cause of error.
    pub(crate) fn knows(&self, cause: &Cause) -> bool {
        let name = handed_on(cause);
        self.known.iter().any(|known| known.names.contains(&name))
    }
}
