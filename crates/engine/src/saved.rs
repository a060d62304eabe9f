//! A trained model on disk: everything that a prediction needs. One posterior for figures, `predict` and
//! `modes`.

use crate::errors::Common;
use crate::gaussian::{LARGEST, is_covariance};
use crate::{EngineError, Trained};
use rijke_inference::NoiseEstimate;
use rijke_numerics::Matrix;
use rijke_study::Cause;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What training leaves: a joint Gaussian of parameters and shared errors, and the misfit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SavedModel {
    /// The stage that trained it.
    pub stage: String,
    /// Role and candidate.
    pub candidates: BTreeMap<String, String>,
    /// Parameters that are held.
    pub hold: BTreeMap<String, f64>,
    /// The operating points that trained.
    pub trained_on: Vec<String>,
    /// Names of the parameters, the model's first.
    names: Vec<String>,
    /// How many of them are the model's.
    own: usize,
    mean: Vec<f64>,
    covariance: Vec<Vec<f64>>,
    noise: Vec<(String, f64)>,
    /// For each noise what few data leave unknown of it ([`NoiseEstimate::few`]).
    #[serde(default)]
    few: Vec<[f64; 2]>,
    /// Causes of errors that points share, and for each its shares in the directions of which something is
    /// known.
    causes: Vec<(Cause, Vec<f64>)>,
    /// The relative error of a law that enters predictions.
    pub law: Option<crate::LawError>,
    /// Whether the measured errors come on top of the noise.
    pub measured: bool,
    /// What is taken for certain, though the evidence does not decide it.
    #[serde(default)]
    pub assumes: Vec<String>,
    /// Frequencies from and to, Hz, at which stages of responses measured its laws; none if none did.
    #[serde(default)]
    pub measured_hz: Option<[f64; 2]>,
}

/// Larger noise is of no measurement: growth rates in 1/s, angular frequencies in rad/s, pressures relative.
const LARGEST_NOISE: f64 = 1e9;

impl SavedModel {
    /// Keeps what a training found.
    #[must_use]
    pub fn of(
        stage: &str,
        candidates: BTreeMap<String, String>,
        hold: BTreeMap<String, f64>,
        trained_on: Vec<String>,
        trained: &Trained,
        law: Option<crate::LawError>,
        measured: bool,
    ) -> Self {
        let known = trained.of_predictions();
        let n = known.names.len();
        Self {
            stage: stage.to_owned(),
            candidates,
            hold,
            trained_on,
            own: trained.own,
            covariance: (0..n).map(|i| (0..n).map(|j| known.covariance[(i, j)]).collect()).collect(),
            names: known.names,
            mean: known.mean,
            noise: trained.noise.iter().map(|e| (e.name.clone(), e.sd)).collect(),
            few: trained.noise.iter().map(NoiseEstimate::unknown).collect(),
            causes: trained.common.as_ref().map(Common::causes_and_shares).unwrap_or_default(),
            law,
            measured,
            assumes: Vec::new(),
            measured_hz: None,
        }
    }

    /// As it was before it was kept, as far as predictions need it.
    ///
    /// # Errors
    /// [`EngineError::Damaged`] if its lists do not fit together, or a number in them is none.
    pub fn posterior(&self) -> Result<crate::TrainedPosterior, EngineError> {
        let n = self.names.len();
        let whole = self.mean.len() == n
            && self.own <= n
            && self.covariance.len() == n
            && self.causes.windows(2).all(|w| w[0].1.len() == w[1].1.len())
            && self.causes.iter().flat_map(|c| &c.1).chain(&self.mean).all(|v| v.abs() <= LARGEST)
            && is_covariance(&self.covariance)
            && self.noise.iter().all(|(_, sd)| (0.0..=LARGEST_NOISE).contains(sd));
        if !whole {
            return Err(EngineError::Damaged { stage: self.stage.clone() });
        }
        let gaussian = crate::NamedGaussian {
            names: self.names.clone(),
            mean: self.mean.clone(),
            covariance: Matrix::from_fn(n, n, |i, j| self.covariance[i][j]),
        };
        let noise = |(k, (name, sd)): (usize, &(String, f64))| NoiseEstimate {
            name: name.clone(),
            unit: String::new(),
            sd: *sd,
            floats: false,
            few: self.few.get(k).copied(),
        };
        let common = (!self.causes.is_empty()).then(|| Common::of_shares(&self.causes));
        Ok(crate::TrainedPosterior {
            gaussian,
            common,
            noise: self.noise.iter().enumerate().map(noise).collect(),
        })
    }
}
