//! Widths of priors that double precision can work with.

use super::prior::Prior;
use crate::error::InferenceError;

/// Smallest width: 1/sd^2 and its products with other such numbers stay finite. No quantity of physics in SI
/// units is near.
const SMALLEST: f64 = 1e-60;
/// Largest width, and largest mean or bound.
const LARGEST: f64 = 1e60;
/// Smallest width as a share of the mean: below it the numbers within the prior differ by few units in the
/// last place.
const RESOLVED: f64 = 1e-12;
/// Largest sd of a logarithm: ten of them stay within double precision.
const LARGEST_LN: f64 = 60.0;

/// Fails unless `value`, called `what`, is a width that can be worked with beside a number of the size of
/// `about`.
pub(crate) fn check(
    parameter: &str,
    what: &'static str,
    value: f64,
    about: Option<f64>,
) -> Result<(), InferenceError> {
    let low = SMALLEST.max(RESOLVED * about.unwrap_or(0.0).abs().min(LARGEST));
    between(parameter, what, value, low, LARGEST)
}

fn between(
    parameter: &str,
    what: &'static str,
    value: f64,
    low: f64,
    high: f64,
) -> Result<(), InferenceError> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(InferenceError::PriorScale { parameter: parameter.to_owned(), what, value, low, high })
}

impl Prior {
    /// Fails if a number of a prior that is sound otherwise is too small or too large to compute with.
    pub(crate) fn in_range(&self, parameter: &str) -> Result<(), InferenceError> {
        let size = |what, value: f64| between(parameter, what, value, -LARGEST, LARGEST);
        match *self {
            Self::Normal { mean, sd } => {
                size("mean", mean)?;
                check(parameter, "sd", sd, Some(mean))
            }
            Self::LogNormal { median, ln_sd } => {
                between(parameter, "median", median, SMALLEST, LARGEST)?;
                between(parameter, "ln_sd", ln_sd, RESOLVED, LARGEST_LN)
            }
            Self::Uniform { low, high } => {
                size("low", low)?;
                size("high", high)?;
                check(parameter, "width", high - low, Some(low.abs().max(high.abs())))
            }
            Self::HalfNormal { sd } => check(parameter, "sd", sd, None),
            Self::Truncated { mean, sd, low, high } => {
                size("mean", mean)?;
                check(parameter, "sd", sd, Some(mean))?;
                let largest =
                    [low, high].into_iter().filter(|b| b.is_finite()).fold(0.0, |m: f64, b| m.max(b.abs()));
                size("bound", largest)?;
                let width = if (high - low).is_finite() { high - low } else { 1.0 };
                check(parameter, "width", width, None)
            }
            Self::Flat => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Parameter, Parameters};
    use rijke_numerics::Matrix;

    fn refused(prior: Prior) -> InferenceError {
        Parameters::new(vec![Parameter::new("eta", "eta", "1", prior)]).unwrap_err()
    }

    #[test]
    fn message_widths_beyond_double_precision_name_the_parameter() {
        for sd in [1e-308, 1e-200, 1e-61, 1e61, 1e200, f64::MAX] {
            for prior in [Prior::Normal { mean: 0.0, sd }, Prior::HalfNormal { sd }] {
                let error = refused(prior);
                let InferenceError::PriorScale { parameter, value, .. } = &error else { panic!("{error}") };
                assert_eq!((parameter.as_str(), *value), ("eta", sd));
            }
        }
        for sd in [f64::INFINITY, f64::NAN, -1.0, 0.0] {
            let error = refused(Prior::Normal { mean: 0.0, sd });
            assert!(
                matches!(&error, InferenceError::BadPrior { parameter, .. } if parameter == "eta"),
                "{error}"
            );
        }
        let lost = refused(Prior::Normal { mean: 1.0, sd: 1e-14 });
        assert!(lost.to_string().contains("'eta' has sd = 1e-14, but it must lie between 1e-12"), "{lost}");
        refused(Prior::Uniform { low: -1e308, high: 1e308 });
        refused(Prior::LogNormal { median: 1.0, ln_sd: 400.0 });
        refused(Prior::Truncated { mean: 0.0, sd: 1.0, low: -1e-80, high: 1e-80 });
        refused(Prior::Truncated { mean: 0.0, sd: 1e-308, low: -1.0, high: 1.0 });
    }

    #[test]
    fn message_a_joint_prior_of_vanishing_width_names_the_parameter() {
        let one = Parameter::new("eta", "eta", "1", Prior::Normal { mean: 1.0, sd: 0.5 });
        let tiny = Matrix::diagonal(&[1e-300]);
        let error = Parameters::new(vec![one]).unwrap().with_joint(&["eta"], &[1.0], &tiny).unwrap_err();
        assert!(
            matches!(&error, InferenceError::PriorScale { parameter, .. } if parameter == "eta"),
            "{error}"
        );
    }

    #[test]
    fn behaviour_priors_of_ordinary_size_pass_in_any_unit() {
        for scale in [1e-30, 1e-6, 1.0, 1e12] {
            let prior = Prior::Truncated { mean: scale, sd: scale, low: 0.0, high: f64::INFINITY };
            assert!(prior.in_range("k").is_ok());
            assert!(Prior::Normal { mean: scale, sd: 1e-9 * scale }.in_range("k").is_ok());
        }
    }
}
