//! Coordinates in which readings are most nearly linear.

use crate::error::FlowError;
use crate::tube::pipe::Pipe;
use rijke_inference::{Parameter, Prior, normal_cdf, normal_quantile};

/// One unknown by its score z and by a coordinate y(z): the score itself for a normal prior; for a uniform
/// one the physical value, except for the mounts.
///
/// The resistance of a mount lies in series with that of the wall around it, so the heat through it is linear
/// in 1/(R_m + R_fin) with the wall as a fin on both sides, R_fin = 1/(2 sqrt(k_w A_w h')).
#[derive(Clone, Copy, Debug)]
pub(crate) enum Axis {
    Score,
    Value { low: f64, high: f64 },
    Conductance { low: f64, high: f64, series: f64 },
}

/// Loss of the wall per length and kelvin, W/(m K), a typical value inside and outside together.
const LOSS: f64 = 2.4;

impl Axis {
    pub(crate) fn new(parameter: &Parameter, pipe: &Pipe) -> Result<Self, FlowError> {
        let series = 0.5 / (pipe.closures.wall_conductivity * pipe.wall_area * LOSS).sqrt();
        match parameter.prior {
            Prior::Uniform { low, high } if parameter.name == "mount_resistance" => {
                Ok(Self::Conductance { low, high, series })
            }
            Prior::Uniform { low, high } => Ok(Self::Value { low, high }),
            Prior::Normal { .. } => Ok(Self::Score),
            _ => Err(FlowError::Prior { name: parameter.name.clone() }),
        }
    }

    /// y and dy/dz.
    pub(crate) fn at(self, z: f64) -> (f64, f64) {
        let uniform = |low: f64, high: f64| {
            let density = (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt();
            (low + (high - low) * normal_cdf(z), (high - low) * density)
        };
        match self {
            Self::Score => (z, 1.0),
            Self::Value { low, high } => uniform(low, high),
            Self::Conductance { low, high, series } => {
                let (value, slope) = uniform(low, high);
                let y = 1.0 / (value + series);
                (y, -slope * y * y)
            }
        }
    }

    /// The score at `y`, which is kept a hundredth of the range away from the bounds.
    pub(crate) fn score(self, y: f64) -> f64 {
        let inside = |low: f64, high: f64, value: f64| {
            normal_quantile(((value - low) / (high - low)).clamp(0.01, 0.99))
        };
        match self {
            Self::Score => y,
            Self::Value { low, high } => inside(low, high, y),
            Self::Conductance { low, high, series } => {
                let value = if y > 0.0 { 1.0 / y - series } else { high };
                inside(low, high, value)
            }
        }
    }
}
