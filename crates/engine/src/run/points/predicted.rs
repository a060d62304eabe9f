//! Predictions of an operating point, by one model or averaged over several.

use crate::BeyondTable;
use rijke_numerics::C64;
use serde::Serialize;

/// What a model says of one operating point.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Forecast {
    /// Name of the point.
    pub point: String,
    /// Label of the mode, where points have several.
    pub mode: String,
    /// Whether the mode could not be followed hither from a point where it was measured: it may be another.
    pub lost: bool,
    /// Value of every factor, SI; none where it has none.
    pub factors: Vec<Option<f64>>,
    /// Growth rate, 1/s; the standard deviation of a new measurement, and that of the model alone.
    pub growth_rate: [f64; 3],
    /// Angular frequency, rad/s, likewise.
    pub angular_frequency: [f64; 3],
    /// Standard deviation of the growth rate that counts for stability, 1/s: that of the model and the misfit
    /// that its training found ([`Misfit::of_growth`](crate::Misfit::of_growth)), without the errors of a
    /// measurement.
    pub stability_sd: f64,
    /// Probability that the growth rate of this mode is above zero, taken as normal with that deviation.
    pub unstable: f64,
    /// The same averaged over the models that the evidence leaves open, where it does.
    pub averaged: Option<Averaged>,
    /// The mode that grows fastest of those in the rig's `[search]` on which the model was not trained, at
    /// its most probable parameters: growth rate, 1/s, and frequency, Hz. None where there is no other, or
    /// where they cannot be counted.
    pub other: Option<[f64; 2]>,
    /// What its laws ask of a table beyond its frequencies: of this mode, and of the other one.
    #[serde(skip)]
    pub beyond: [Option<BeyondTable>; 2],
}

impl Forecast {
    /// Whether both are of one eigenvalue at one point, to rounding.
    pub(in crate::run) fn is_of_the_mode_of(&self, other: &Self) -> bool {
        let s = |f: &Self| C64::new(f.growth_rate[0], f.angular_frequency[0]);
        self.point == other.point && (s(self) - s(other)).norm() < 1e-6 * s(self).norm()
    }
}

/// A prediction averaged over open models.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Averaged {
    /// Growth rate, 1/s; the standard deviation of a new measurement, and that of what is not known of the
    /// model.
    pub growth_rate: [f64; 3],
    /// Angular frequency, rad/s, likewise.
    pub angular_frequency: [f64; 3],
    /// Standard deviation of the growth rate that counts for stability, 1/s.
    pub stability_sd: f64,
    /// Probability that the growth rate of this mode is above zero.
    pub unstable: f64,
}

/// The average over what the model that goes on says of a point and what those `open` beside it say, each
/// with its odds; none where one of these can say nothing.
pub(in crate::run) fn averaged(own: &Forecast, open: &[(f64, Vec<Forecast>)]) -> Option<Averaged> {
    let same = |f: &&Forecast| f.point == own.point && f.mode == own.mode;
    let of = |(odds, all): &(f64, Vec<Forecast>)| Some((*odds, all.iter().find(same)?.clone()));
    let mut all = open.iter().map(of).collect::<Option<Vec<_>>>()?;
    all.push((1.0, own.clone()));
    let over = |of: &dyn Fn(&Forecast) -> [f64; 3]| {
        let [[mean, measured], [_, model]] =
            [1, 2].map(|k| mixed(all.iter().map(|(w, f)| [*w, of(f)[0], of(f)[k]])));
        [mean, measured, model]
    };
    Some(Averaged {
        growth_rate: over(&|f| f.growth_rate),
        angular_frequency: over(&|f| f.angular_frequency),
        stability_sd: mixed(all.iter().map(|(w, f)| [*w, f.growth_rate[0], f.stability_sd]))[1],
        unstable: mixed(all.iter().map(|(w, f)| [*w, f.unstable, 0.0]))[0],
    })
}

/// Mean and standard deviation of a mixture, from the weight, mean and standard deviation of each part;
/// weights need not add up to one.
pub(in crate::run) fn mixed(parts: impl Iterator<Item = [f64; 3]> + Clone) -> [f64; 2] {
    let sum: f64 = parts.clone().map(|[w, ..]| w).sum();
    let mean = parts.clone().map(|[w, v, _]| w * v).sum::<f64>() / sum;
    let square = parts.map(|[w, v, sd]| w * (sd * sd + (v - mean).powi(2))).sum::<f64>() / sum;
    [mean, square.sqrt()]
}
