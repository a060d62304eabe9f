//! The numbers of the hot campaign: Figs. 5 to 11 and Table 4.

use super::{Check, MeasuredPoint, ParameterValue, ProngModel, Provenance};
use serde::{Deserialize, Serialize};

/// Fig. 5: the model of all cold components against every cold experiment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cold {
    /// Where the data come from.
    pub provenance: Provenance,
    /// The candidates of the model: wall, ends, prongs, heater, thermocouples.
    pub candidates: Vec<String>,
    /// All their parameters after the last cold stage.
    pub parameters: Vec<ParameterValue>,
    /// Rows C1, C2, C3 and H0, each ascending in position.
    pub series: Vec<ColdSeries>,
    /// The statements of the text.
    pub checks: Vec<Check>,
}

/// One row of Table 1 with cold gas.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ColdSeries {
    /// Row of Table 1.
    pub row: String,
    /// What is in the tube, for the legend.
    pub label: String,
    /// What was measured; position 0 is the empty tube.
    pub measured: Vec<MeasuredPoint>,
    /// Prediction at each measured point, in their order.
    pub predicted: Vec<PredictedPoint>,
}

/// A prediction with its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PredictedPoint {
    /// Growth rate, 1/s.
    pub growth_rate: f64,
    /// Its standard deviation for a new measurement: parameters, base state, and the misfit that the data chose, 1/s.
    pub growth_rate_sd: f64,
    /// Angular frequency, rad/s.
    pub angular_frequency: f64,
    /// Its standard deviation, likewise, rad/s.
    pub angular_frequency_sd: f64,
}

/// One hot operating point as measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HotPoint {
    /// Ping; `position_m` is the position of the heater X_h.
    pub measured: MeasuredPoint,
    /// Power of the heater Q_h, W.
    pub power_w: f64,
    /// Velocity at the heater U_h, m/s, from the base flow.
    pub heater_velocity: f64,
    /// Its standard deviation, m/s.
    pub heater_velocity_sd: f64,
}

/// Fig. 6 or Fig. 7: the feedback coefficient k_eu inferred at each hot point by itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Feedback {
    /// Where the data come from.
    pub provenance: Provenance,
    /// What the model of the other components is, in words.
    pub model: String,
    /// One entry per hot point: ascending power, then ascending position.
    pub points: Vec<FeedbackPoint>,
    /// The statements of the text.
    pub checks: Vec<Check>,
}

/// k_eu at one hot point, written k_eu = -|k_eu| e^{-i lag}: heat that follows velocity after the angle `lag`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FeedbackPoint {
    /// Operating point.
    pub id: String,
    /// Position of the heater X_h, m.
    pub position_m: f64,
    /// Power Q_h, W.
    pub power_w: f64,
    /// Velocity at the heater U_h, m/s.
    pub heater_velocity: f64,
    /// Real and imaginary part of k_eu.
    pub k_eu: [f64; 2],
    /// Covariance of the two.
    pub covariance: [[f64; 2]; 2],
    /// |k_eu|/Q_h, 1/W.
    pub modulus_per_watt: f64,
    /// Its standard deviation, 1/W.
    pub modulus_per_watt_sd: f64,
    /// Lag of the heat release behind the velocity, rad: the paper's angle of k_eu. In (-pi, pi].
    pub lag: f64,
    /// Its standard deviation, rad; by the delta method, so above about 1 it says only "unknown".
    pub lag_sd: f64,
}

/// Table 4: models of the hot heater.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeatRelease {
    /// Where the data come from.
    pub provenance: Provenance,
    /// The measured hot points: ascending power, then ascending position.
    pub measured: Vec<HotPoint>,
    /// The nine models of the table, then the candidates beyond the paper (`published` is none). `at_points` follows the
    /// order of `measured`; `line` is empty, because the base flow is known at the measured points only.
    pub models: Vec<ProngModel>,
    /// The model of the table with the highest marginal likelihood.
    pub winner: String,
    /// That of the paper.
    pub published_winner: String,
    /// The model with the highest marginal likelihood of all, which is saved as `model.json` and drawn in Figs. 10 and 11.
    pub chosen: String,
    /// Kendall's tau between our order and the published one, over the nine models.
    pub kendall_tau: f64,
    /// The statements of the text, and what the evidence says of candidates beyond the paper.
    pub checks: Vec<Check>,
}

/// Figs. 8 to 11: one trained model against all hot points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HotPredictions {
    /// Where the data come from.
    pub provenance: Provenance,
    /// Number of the figure in the paper, 8 to 11.
    pub figure: u32,
    /// The candidates of the model.
    pub candidates: Vec<String>,
    /// What the model is, in words.
    pub model: String,
    /// Its parameters; those held fixed have sd 0.
    pub parameters: Vec<ParameterValue>,
    /// Misfit of the growth rate that the data chose, 1/s: the figure's error bars are twice this.
    pub growth_rate_noise_sd: f64,
    /// Misfit of the angular frequency, rad/s.
    pub angular_frequency_noise_sd: f64,
    /// The measured hot points: ascending power, then ascending position.
    pub measured: Vec<HotPoint>,
    /// Prediction at each measured point, in their order.
    pub predicted: Vec<PredictedPoint>,
    /// Operating points that trained the model: all, or eight.
    pub trained_on: Vec<String>,
    /// Share of the points, trained on or not, whose measured value lies within two predicted sd: growth rate, angular
    /// frequency.
    pub coverage: [f64; 2],
    /// The same over points that were not used in training; none if all were.
    pub coverage_elsewhere: Option<[f64; 2]>,
    /// The statements of the text.
    pub checks: Vec<Check>,
}

/// Trained parameters against the values that made virtual data, where the two mean the same thing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Truths {
    /// One row per comparison.
    pub rows: Vec<TruthRow>,
    /// Whether each lies within three standard deviations.
    pub checks: Vec<Check>,
}

/// One trained quantity and its truth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TruthRow {
    /// What it is, with its unit.
    pub quantity: String,
    /// Trained value.
    pub value: f64,
    /// Its standard deviation.
    pub sd: f64,
    /// The value of the virtual laboratory.
    pub truth: f64,
}
