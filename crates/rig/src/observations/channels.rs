//! What is left of delays and gains after the channels were calibrated: errors that all pings of a campaign
//! share.

use crate::error::RigError;
use crate::files::{parse_toml, read_text, write_toml};
use crate::problem::Problem;
use rijke_numerics::{Cholesky, Matrix};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Errors of the channels' calibration that all pings share. They are part of the covariance of every
/// [`crate::Ping`], too, which cannot say that they are the same from point to point.
///
/// With delays off by d and relative gains off by g against the reference microphone's, a relative pressure P
/// is measured as P (1 - s d + g).
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelErrors {
    /// Covariance of d over all microphones but the reference, in their order, s^2.
    pub delays: Matrix,
    /// Covariance of g over the same.
    pub gains: Matrix,
    /// Whether the covariances of the observations contain them.
    pub contained: bool,
}

/// `channels.toml`.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    delay_covariance_s2: Vec<Vec<f64>>,
    gain_covariance: Vec<Vec<f64>>,
    #[serde(default = "contained", skip_serializing_if = "is_contained")]
    contained: bool,
}

fn contained() -> bool {
    true
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde calls it")]
fn is_contained(contained: &bool) -> bool {
    *contained
}

const HEADER: &str = "# What the calibration leaves of the channels, all microphones but the reference, relative to it.\n\
                      # A relative pressure P is measured as P (1 - s d + g), d and g the same in every ping.\n";

impl ChannelErrors {
    pub(crate) fn write(&self, path: &Path) -> Result<(), RigError> {
        let rows = |m: &Matrix| (0..m.rows()).map(|i| m.row(i).to_vec()).collect();
        let file = File {
            delay_covariance_s2: rows(&self.delays),
            gain_covariance: rows(&self.gains),
            contained: self.contained,
        };
        write_toml(&file, HEADER, path)
    }

    /// Reads the file if there is one; it speaks of `others` microphones.
    ///
    /// # Errors
    /// The file, the key and the remedy.
    pub fn read(path: &Path, others: usize) -> Result<Option<Self>, RigError> {
        if !path.exists() {
            return Ok(None);
        }
        let file: File = parse_toml(&read_text(path)?, path)?;
        let matrix = |name: &str, rows: &[Vec<f64>]| {
            let wrong = |problem| RigError::invalid(path, name, problem);
            if rows.len() != others || rows.iter().any(|row| row.len() != others) {
                return Err(wrong(Problem::WrongSize { rows: rows.len(), need: others }));
            }
            let m = Matrix::from_fn(others, others, |i, j| rows[i][j]);
            let scaled = scaled(&m);
            let symmetric =
                (0..others).all(|i| (0..i).all(|j| (scaled[(i, j)] - scaled[(j, i)]).abs() < 1e-9));
            match Cholesky::new(&scaled) {
                Ok(_) if symmetric => Ok(m),
                _ => Err(wrong(Problem::NotPositiveDefinite)),
            }
        };
        Ok(Some(Self {
            delays: matrix("delay_covariance_s2", &file.delay_covariance_s2)?,
            gains: matrix("gain_covariance", &file.gain_covariance)?,
            contained: file.contained,
        }))
    }
}

/// The correlation matrix: growth rates and relative pressures differ by many orders of magnitude.
pub(crate) fn scaled(covariance: &Matrix) -> Matrix {
    let sd = |i: usize| covariance[(i, i)].sqrt();
    Matrix::from_fn(covariance.rows(), covariance.columns(), |i, j| covariance[(i, j)] / (sd(i) * sd(j)))
}
