//! What a training starts from.

use crate::noise::Noise;
use rijke_inference::{AssessOptions, MapOptions};
use rijke_numerics::{Cholesky, Matrix};
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

/// Largest number that a saved model may have: its square is far from overflow, and no quantity is larger.
pub(crate) const LARGEST: f64 = 1e30;
/// By how much a correlation may exceed 1, or an eigenvalue of correlations fall short of 0, by rounding.
const ROUNDING: f64 = 1e-6;

/// Whether rows of numbers are those of a covariance: square and symmetric, with correlations between -1 and
/// 1 that have no negative eigenvalue, all to rounding.
pub(crate) fn is_covariance(rows: &[Vec<f64>]) -> bool {
    let n = rows.len();
    let sized = rows.iter().all(|row| row.len() == n && row.iter().all(|v| v.abs() <= LARGEST * LARGEST));
    if !sized || (0..n).any(|i| rows[i][i] < 0.0) {
        return false;
    }
    let scale = |i: usize, j: usize| (rows[i][i] * rows[j][j]).sqrt();
    let pair = |i: usize, j: usize| {
        let [a, b] = [rows[i][j], rows[j][i]];
        (a - b).abs() <= ROUNDING * scale(i, j) && a.abs() <= (1.0 + ROUNDING) * scale(i, j)
    };
    if !(0..n).all(|i| (0..i).all(|j| pair(i, j))) {
        return false;
    }
    let correlation = |i: usize, j: usize| match scale(i, j) {
        _ if i == j => 1.0 + n as f64 * ROUNDING,
        0.0 => 0.0,
        scale => rows[i][j] / scale,
    };
    n == 0 || Cholesky::new(&Matrix::from_fn(n, n, correlation)).is_ok()
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

/// As a cause is called from stage to stage.
pub(crate) fn handed_on(cause: &Cause) -> String {
    format!("error of the cause {cause:?}")
}

#[cfg(test)]
mod tests {
    use super::is_covariance;

    #[test]
    fn exact_a_covariance_is_symmetric_and_has_correlations_that_can_be() {
        let of = |a: f64, b: f64, c: f64| vec![vec![4.0, a, b], vec![a, 1.0, c], vec![b, c, 9.0]];
        assert!(is_covariance(&[]) && is_covariance(&of(1.0, -3.0, 0.5)));
        // To rounding: a direction that is known exactly, and a parameter that is.
        assert!(is_covariance(&of(2.0, 6.0, 3.0)));
        assert!(is_covariance(&[vec![0.0, 0.0], vec![0.0, 1e-20]]));
        // Each correlation can be, all three together cannot.
        assert!(!is_covariance(&of(1.8, -5.4, 2.7)));
        let mut skew = of(1.0, -3.0, 0.5);
        skew[0][1] = 1.1;
        assert!(!is_covariance(&skew));
        for wrong in [2.1, 1e308, f64::NAN, f64::INFINITY] {
            assert!(!is_covariance(&of(wrong, 0.0, 0.0)), "{wrong}");
        }
        assert!(!is_covariance(&[vec![-1.0]]) && !is_covariance(&[vec![1.0, 0.0], vec![0.0]]));
        assert!(!is_covariance(&[vec![0.0, 0.1], vec![0.1, 1.0]]));
    }
}
