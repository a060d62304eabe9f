//! Localisation: observations act on nearby variables only.

use super::gain::Gain;
use super::observed::White;
use super::{Ensemble, EnsembleData, EnsembleError, NoiseCovariance, forcing};
use rijke_numerics::{Cholesky, Matrix, Stream};

/// The compactly supported correlation function of Gaspari & Cohn (1999, eq. 4.10): 1 at distance 0, 0 from
/// distance 2 on, in units of the half-width; shaped like a normal density with sd sqrt(0.3).
#[must_use]
pub fn gaspari_cohn(distance: f64) -> f64 {
    let z = distance.abs();
    if z <= 1.0 {
        1.0 + z * z * (-5.0 / 3.0 + z * (5.0 / 8.0 + z * (0.5 - 0.25 * z)))
    } else if z < 2.0 {
        4.0 - 2.0 / (3.0 * z) + z * (-5.0 + z * (5.0 / 3.0 + z * (5.0 / 8.0 + z * (-0.5 + z / 12.0))))
    } else {
        0.0
    }
}

/// Perturbed observations with the gain multiplied element by element by the taper.
pub(super) fn stochastic(
    ensemble: &mut Ensemble,
    white: &White,
    observed: &EnsembleData<'_>,
    taper: &Matrix,
    stream: &mut Stream,
) -> Result<(), EnsembleError> {
    check(ensemble, observed, taper)?;
    if matches!(observed.noise, NoiseCovariance::Full(_)) {
        return Err(EnsembleError::CorrelatedNoise);
    }
    let (s, data) = (&white.anomalies, observed.measured.len());
    let innovation = s.transpose().product(s).plus(1.0, &Matrix::identity(data));
    let factor = Cholesky::new(&innovation)?;
    let cross = ensemble.anomalies().transpose().product(s); // PH' R^{-1/2} sqrt(N - 1)
    let mut gain = Matrix::zeros(cross.rows(), data);
    for i in 0..cross.rows() {
        for (j, g) in factor.solve(cross.row(i)).into_iter().enumerate() {
            gain[(i, j)] = taper[(i, j)] * g / white.root;
        }
    }
    let perturbations = forcing::centred_normal(ensemble.size(), data, stream);
    let pull = Matrix::from_fn(ensemble.size(), data, |i, j| {
        white.departure[j] + perturbations[(i, j)] - s[(i, j)] * white.root
    });
    let change = pull.product(&gain.transpose());
    ensemble.members = ensemble.members.plus(1.0, &change);
    Ok(())
}

/// A local square root per variable, with the inverse variance of every observation multiplied by the taper
/// (the LETKF of Hunt, Kostelich & Szunyogh 2007).
pub(super) fn square_root(
    ensemble: &mut Ensemble,
    observed: &EnsembleData<'_>,
    taper: &Matrix,
) -> Result<(), EnsembleError> {
    check(ensemble, observed, taper)?;
    let NoiseCovariance::Independent(variances) = observed.noise else {
        return Err(EnsembleError::CorrelatedNoise);
    };
    let mut updated = ensemble.members.clone();
    for variable in 0..ensemble.members.columns() {
        let near: Vec<usize> =
            (0..observed.measured.len()).filter(|&j| taper[(variable, j)] > 1e-6).collect();
        if near.is_empty() {
            continue;
        }
        let predicted = Matrix::from_fn(ensemble.size(), near.len(), |i, k| observed.predicted[(i, near[k])]);
        let measured: Vec<f64> = near.iter().map(|&j| observed.measured[j]).collect();
        let noise =
            NoiseCovariance::Independent(near.iter().map(|&j| variances[j] / taper[(variable, j)]).collect());
        let column = Matrix::from_fn(ensemble.size(), 1, |i, _| ensemble.members[(i, variable)]);
        let observed = EnsembleData { predicted: &predicted, measured: &measured, noise: &noise };
        let white = White::new(ensemble.size(), &observed)?;
        let moved = Gain::new(&white.anomalies)?.square_root(&column, &white);
        for i in 0..ensemble.size() {
            updated[(i, variable)] = moved[(i, 0)];
        }
    }
    ensemble.members = updated;
    Ok(())
}

fn check(ensemble: &Ensemble, observed: &EnsembleData<'_>, taper: &Matrix) -> Result<(), EnsembleError> {
    let (variables, data) = (ensemble.members.columns(), observed.measured.len());
    if taper.rows() != variables {
        let what = "rows of the localisation (one per variable)";
        return Err(EnsembleError::Shape { what, expected: variables, got: taper.rows() });
    }
    if taper.columns() != data {
        let what = "columns of the localisation (one per datum)";
        return Err(EnsembleError::Shape { what, expected: data, got: taper.columns() });
    }
    Ok(())
}
