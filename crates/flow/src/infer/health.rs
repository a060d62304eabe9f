//! What a fit says of itself: signs of trouble, and the reasons not to trust it.

use super::tension::ClosureTension;
use serde::{Deserialize, Serialize};

/// Signs of trouble. None of them proves health: model error can hide in parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FlowHealth {
    /// Chi-squared of the residuals per datum (data minus unknowns); 1 is expected.
    pub chi_squared: f64,
    /// Its sd if the model is right.
    pub chi_squared_sd: f64,
    /// Correlation of each sensor's residual with its neighbour in time; 0 is expected.
    pub whiteness: Vec<f64>,
    /// Number of residuals per sensor: the sd of the whiteness is 1/sqrt of it.
    pub bins: usize,
    /// Names of unknowns whose posterior sd exceeds 0.7 of the prior sd: the data do not identify them.
    pub unidentified: Vec<String>,
    /// Names of unknowns further than 2.5 prior sd from the centre: at a bound of the prior, or against it.
    pub at_bound: Vec<String>,
    /// What the readings say of closures that handbooks leave open; empty where these are inferred.
    #[serde(default)]
    pub tensions: Vec<ClosureTension>,
    /// Whether the minimiser converged.
    pub converged: bool,
}

/// One reason not to trust an estimate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "warning", rename_all = "snake_case")]
pub enum FlowWarning {
    /// The residuals are larger than the noise.
    PoorFit {
        /// Chi-squared per datum.
        chi_squared: f64,
    },
    /// The residuals of a sensor follow a pattern in time.
    Pattern {
        /// Number of the sensor.
        sensor: usize,
        /// Correlation of neighbours.
        correlation: f64,
    },
    /// The readings ask for another value of a closure: the model is wrong in this or in what looks like it.
    Closure {
        /// Its name.
        name: String,
        /// The value used.
        value: f64,
        /// The value that the readings prefer.
        preferred: f64,
        /// Distance in sd.
        z: f64,
    },
    /// An unknown lies at a bound of its prior, or far from its centre.
    AtBound {
        /// Its name.
        name: String,
    },
    /// The minimiser gave up.
    NotConverged,
}

impl FlowHealth {
    /// Reasons not to trust the estimate: a chi-squared or a correlation more than four sd from what is
    /// expected, a closure more than three, a bound, a search that gave up.
    #[must_use]
    pub fn warnings(&self) -> Vec<FlowWarning> {
        let mut list = Vec::new();
        if !self.converged {
            list.push(FlowWarning::NotConverged);
        }
        if self.chi_squared > 1.0 + 4.0 * self.chi_squared_sd {
            list.push(FlowWarning::PoorFit { chi_squared: self.chi_squared });
        }
        let limit = 4.0 / (self.bins as f64).sqrt();
        for (sensor, &correlation) in self.whiteness.iter().enumerate() {
            if correlation.abs() > limit {
                list.push(FlowWarning::Pattern { sensor, correlation });
            }
        }
        for t in self.tensions.iter().filter(|t| t.is_wrong()) {
            let (name, value, preferred, z) = (t.closure.clone(), t.value, t.preferred, t.z);
            list.push(FlowWarning::Closure { name, value, preferred, z });
        }
        list.extend(self.at_bound.iter().map(|name| FlowWarning::AtBound { name: name.clone() }));
        list
    }
}
