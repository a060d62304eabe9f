//! The numbers that studies return and reports draw.

mod hot;

pub use hot::{
    Cold, ColdSeries, Feedback, FeedbackPoint, HeatRelease, HotPoint, HotPredictions, PredictedPoint,
    TruthRow, Truths,
};

use rijke_rig::DataKind;
use serde::{Deserialize, Serialize};

/// Where the data of a study come from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Measured or virtual.
    pub data: DataKind,
    /// Name of the rig.
    pub rig: String,
    /// What the records say of their own origin.
    pub source: String,
    /// Number of operating points used.
    pub points: usize,
    /// Number of pings used.
    pub pings: u64,
    /// Records that were not used.
    pub rejected: Vec<RejectedRecord>,
}

/// A record that was not used, and why.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RejectedRecord {
    /// Which record.
    pub record: String,
    /// Why, in words with numbers.
    pub reason: String,
}

/// A statement, whether it holds, and the number that decides it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// The statement, a full sentence.
    pub statement: String,
    /// Whether it holds for these data.
    pub holds: bool,
    /// The deciding numbers, in words.
    pub figure: String,
    /// Why, if it does not hold.
    pub explanation: Option<String>,
}

/// What a parameter is called.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParameterName {
    /// Name in files.
    pub name: String,
    /// Symbol in print.
    pub symbol: String,
    /// Unit; "1" if it has none.
    pub unit: String,
}

/// A parameter with its value at the most probable point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParameterValue {
    /// Name in files.
    pub name: String,
    /// Symbol in print.
    pub symbol: String,
    /// Unit; "1" if it has none.
    pub unit: String,
    /// Most probable value.
    pub value: f64,
    /// Standard deviation of the posterior, by Laplace's method.
    pub sd: f64,
}

/// The three logarithms of a row of Tables 2 to 4, in nats per datapoint: `ln_marginal = ln_best_fit + ln_occam`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// Best-fit likelihood.
    pub ln_best_fit: f64,
    /// Occam factor.
    pub ln_occam: f64,
    /// Marginal likelihood.
    pub ln_marginal: f64,
}

/// Fig. 3: reflection coefficient and wall loss of the empty tube from one microphone and from all of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EmptyTube {
    /// Where the data come from.
    pub provenance: Provenance,
    /// The operating point.
    pub point: String,
    /// |R|, angle of R, eta; the order of every vector and matrix below.
    pub parameters: Vec<ParameterName>,
    /// One microphone first, then all.
    pub cases: Vec<Case>,
    /// Levine-Schwinger's |R| and angle at the measured frequency, and Rayleigh's eta = 1.
    pub predicted: Vec<f64>,
    /// Prior mean and standard deviation of each parameter.
    pub prior: Vec<[f64; 2]>,
    /// The values that made the data, where they mean the same thing; none for measured data.
    pub truth: Option<Vec<f64>>,
    /// The statements of the text.
    pub checks: Vec<Check>,
}

/// The posterior of one set of microphones.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// Indices of the microphones used, reference included.
    pub microphones: Vec<usize>,
    /// Most probable values.
    pub mean: Vec<f64>,
    /// Covariance of the posterior.
    pub covariance: Vec<Vec<f64>>,
    /// Correlation of the posterior.
    pub correlation: Vec<Vec<f64>>,
}

/// Fig. 12: what every set of microphones with the reference can say of the empty tube.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Microphones {
    /// Where the data come from.
    pub provenance: Provenance,
    /// The operating point.
    pub point: String,
    /// |R|, angle of R, eta; the order of every vector and matrix below.
    pub parameters: Vec<ParameterName>,
    /// Positions of all microphones, m.
    pub positions_m: Vec<f64>,
    /// Every set that holds the reference microphone, small sets first: 1, 7, 21, 35, 35, 21, 7, 1 for eight.
    pub sets: Vec<Case>,
    /// Standard deviation of relative pressures, beyond the measured one, that is assumed for every set: the one that all
    /// microphones together choose.
    pub pressure_noise_sd: f64,
    /// Levine-Schwinger's |R| and angle, and Rayleigh's eta = 1.
    pub predicted: Vec<f64>,
    /// The values that made the data, where they mean the same thing; none for measured data.
    pub truth: Option<Vec<f64>>,
    /// The statements of the text.
    pub checks: Vec<Check>,
}

/// Table 2 and Fig. 4: models of the prongs; or Table 3: models of the cold heater.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Prongs {
    /// Where the data come from.
    pub provenance: Provenance,
    /// The measured points: means over the repeats.
    pub measured: Vec<MeasuredPoint>,
    /// The models, in the order of the table.
    pub models: Vec<ProngModel>,
    /// Identifier of the model with the highest marginal likelihood.
    pub winner: String,
    /// That of the paper.
    pub published_winner: String,
    /// Kendall's tau between our order and the published one, over the models that the paper has.
    pub kendall_tau: f64,
    /// The statements of the text.
    pub checks: Vec<Check>,
}

/// One operating point as measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasuredPoint {
    /// Operating point.
    pub id: String,
    /// Where the prongs end, m; 0 for the empty tube.
    pub position_m: f64,
    /// Growth rate, 1/s.
    pub growth_rate: f64,
    /// Its standard deviation, 1/s.
    pub growth_rate_sd: f64,
    /// Angular frequency, rad/s.
    pub angular_frequency: f64,
    /// Its standard deviation, rad/s.
    pub angular_frequency_sd: f64,
    /// Ambient temperature of the day, K: it moves the frequency from day to day.
    pub ambient_temperature: f64,
}

/// One model of the prongs or of the heater, trained.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProngModel {
    /// Identifier of the candidate.
    pub id: String,
    /// Row of Table 2; none for candidates beyond the paper.
    pub number: Option<u32>,
    /// What it is called.
    pub label: String,
    /// Its laws as text, `(where and which coefficient, formula)`.
    pub laws: Vec<(String, String)>,
    /// Its parameters.
    pub parameters: Vec<ParameterValue>,
    /// Inferred measurement noise of the growth rate, 1/s: Fig. 4's coloured bars. Zero, like the next two, if the fit
    /// failed.
    pub growth_rate_noise_sd: f64,
    /// Inferred measurement noise of the angular frequency, rad/s.
    pub angular_frequency_noise_sd: f64,
    /// Inferred measurement noise of the relative pressures.
    pub pressure_noise_sd: f64,
    /// Prediction at the conditions of each measured point, in their order.
    pub at_points: Vec<CurvePoint>,
    /// Prediction at many positions, for the lines of Fig. 4, at the ambient temperature interpolated between the
    /// measured points: the lines are as jagged as the days were different.
    pub line: Vec<CurvePoint>,
    /// Evidence per datapoint; none if the fit failed.
    pub evidence: Option<Evidence>,
    /// Why there is no evidence, or what to know about it.
    pub remark: Option<String>,
    /// The published row.
    pub published: Option<Evidence>,
}

/// One predicted point of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurvePoint {
    /// Where the prongs end, m.
    pub position_m: f64,
    /// Growth rate, 1/s.
    pub growth_rate: f64,
    /// Angular frequency, rad/s.
    pub angular_frequency: f64,
}

/// Section 6.1: the two printed fits of the same two measurements, compared through our chain. No rig data enter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Consistency {
    /// Ambient temperature assumed, K.
    pub temperature: f64,
    /// One row per scheme and printed reflection coefficient.
    pub rows: Vec<ConsistencyRow>,
    /// What was found.
    pub checks: Vec<Check>,
}

/// One printed reflection coefficient, turned into the eta that explains the same eigenvalue.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConsistencyRow {
    /// How the wall loss was discretised: exact line or lumped.
    pub scheme: String,
    /// Printed |R| and angle (eta = 1).
    pub reflection: [f64; 2],
    /// Growth rate and angular frequency that they imply.
    pub eigenvalue: [f64; 2],
    /// Our eta with R = R_LS.
    pub eta: f64,
    /// Smallest and largest eta within the rounding of the printed |R| and angle.
    pub eta_range: [f64; 2],
    /// The published eta.
    pub published: f64,
}
