//! Columns that the files of all measured curves share.

use crate::sheet::Cell;
use rijke_studies::{MeasuredPoint, PredictedPoint};

/// Names of the columns of [`measured`].
pub(crate) const MEASURED: [&str; 7] = [
    "point",
    "position_m",
    "ambient_temperature_k",
    "growth_rate_per_s",
    "growth_rate_sd_per_s",
    "angular_frequency_rad_per_s",
    "angular_frequency_sd_rad_per_s",
];

/// Names of the columns of [`predicted`].
pub(crate) const PREDICTED: [&str; 4] = [
    "predicted_growth_rate_per_s",
    "predicted_growth_rate_sd_per_s",
    "predicted_angular_frequency_rad_per_s",
    "predicted_angular_frequency_sd_rad_per_s",
];

/// One operating point as measured.
pub(crate) fn measured(m: &MeasuredPoint) -> Vec<Cell> {
    let numbers = [
        m.position_m,
        m.ambient_temperature,
        m.growth_rate,
        m.growth_rate_sd,
        m.angular_frequency,
        m.angular_frequency_sd,
    ];
    [Cell::from(&*m.id)].into_iter().chain(numbers.map(Cell::from)).collect()
}

/// The same as predicted.
pub(crate) fn predicted(p: &PredictedPoint) -> [Cell; 4] {
    [p.growth_rate, p.growth_rate_sd, p.angular_frequency, p.angular_frequency_sd].map(Cell::from)
}
