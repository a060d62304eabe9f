//! How far the data lie from the prediction of a fit.

use super::map::Fit;
use super::posterior::Posterior;
use crate::error::InferenceError;
use crate::problem::Prediction;
use rijke_numerics::Order;

/// The mean of squares of residuals over their variances at which a model misses the data.
const MISSED: f64 = 10.0;

impl Posterior<'_> {
    /// r' C^-1 r of every observation, r being what the prediction of a fit leaves and C the covariance
    /// there: twice the drop of ln likelihood against data that lie on the prediction.
    ///
    /// # Errors
    /// Those of the model, and [`InferenceError::SingularCovariance`].
    pub(crate) fn chi_squared(&self, fit: &Fit) -> Result<Vec<f64>, InferenceError> {
        let sds = self.noise_sd(&fit.working);
        let ln = |values: Vec<f64>| -> Result<Vec<f64>, InferenceError> {
            let prediction = Prediction { values, ..Prediction::default() };
            let blocks = self.blocks(&prediction, 0, &sds, Order::Value, None)?;
            Ok(blocks.iter().map(|block| block.ln_likelihood).collect())
        };
        let exact = ln(self.data().observations().iter().flat_map(|o| o.values.iter().copied()).collect())?;
        let fitted = ln(self.predict(&fit.parameters, Order::Value)?.values)?;
        Ok(exact.iter().zip(&fitted).map(|(exact, fitted)| 2.0 * (exact - fitted)).collect())
    }

    /// Whether the residuals of a fit are far larger than their measured errors, or than these and the noise.
    ///
    /// # Errors
    /// Those of [`Posterior::chi_squared`].
    pub(crate) fn misses(&self, fit: &Fit) -> Result<bool, InferenceError> {
        let predicted = self.predict(&fit.parameters, Order::Value)?.values;
        let missed = MISSED * self.data().size() as f64;
        Ok(self.leaves(&predicted, MISSED) || self.chi_squared(fit)?.iter().sum::<f64>() > missed)
    }
}
