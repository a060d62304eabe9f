//! What a model leaves of the data, once the head's errors are taken at their most probable values.

use super::data::{Blocks, Measured};
use crate::EngineError;
use rijke_numerics::{C64, Cholesky, Matrix};

/// What is left of a training.
pub(super) struct Left {
    /// What the head makes of the model's answers, load after load.
    pub(super) heard: Vec<Vec<C64>>,
    /// Root mean square of the residuals, both parts together.
    pub(super) size: f64,
    /// Correlation between neighbouring frequencies.
    pub(super) neighbours: f64,
    /// That correlation over its standard deviation for independent residuals.
    pub(super) neighbours_sds: f64,
}

/// What is left of `measured` by `answers`. `sd` is that of a datum's noise and misfit together, `sizes` those of the coefficients of
/// each error term.
pub(super) fn left(
    blocks: &Blocks<'_>,
    answers: &[Vec<C64>],
    sd: f64,
    sizes: &[f64],
) -> Result<Left, EngineError> {
    let mut heard: Vec<Vec<C64>> = answers.to_vec();
    let mut first = 0;
    for loads in blocks.measured.chunk_by(|a, b| a.session == b.session) {
        let range = first..first + loads.len();
        first = range.end;
        let columns = blocks.columns(loads);
        if columns.is_empty() {
            continue;
        }
        let residuals: Vec<f64> = loads
            .iter()
            .zip(&answers[range.clone()])
            .flat_map(|(m, a)| m.values.iter().zip(a).flat_map(|(m, a)| [m.re - a.re, m.im - a.im]))
            .collect();
        let added = explained(&columns, sizes, sd, &residuals)?;
        let mut parts = added.chunks_exact(2);
        for answer in heard[range].iter_mut().flatten() {
            if let Some([re, im]) = parts.next() {
                *answer += C64::new(*re, *im);
            }
        }
    }
    let residuals: Vec<Vec<C64>> = blocks
        .measured
        .iter()
        .zip(&heard)
        .map(|(m, h)| m.values.iter().zip(h).map(|(m, h)| m - h).collect())
        .collect();
    let square: f64 = residuals.iter().flatten().map(|z| z.norm_sqr()).sum();
    let pairs: f64 = residuals.iter().flat_map(|r| r.windows(2)).map(|w| (w[1] * w[0].conj()).re).sum();
    let count: usize = blocks.measured.iter().map(|m: &Measured| m.values.len()).sum();
    let neighbours = pairs / square.max(f64::MIN_POSITIVE);
    Ok(Left {
        heard,
        size: (square / count.max(1) as f64).sqrt(),
        neighbours,
        neighbours_sds: neighbours * (2.0 * count as f64).sqrt(),
    })
}

/// The part of `residuals` that the columns explain, whose coefficients are normal about zero with these standard deviations: the
/// posterior mean U (U'U/sd^2 + K^-1)^-1 U' r/sd^2.
fn explained(columns: &[Matrix], sizes: &[f64], sd: f64, residuals: &[f64]) -> Result<Vec<f64>, EngineError> {
    let wide: Vec<(usize, usize)> =
        columns.iter().enumerate().flat_map(|(k, m)| (0..m.columns()).map(move |j| (k, j))).collect();
    let n = residuals.len();
    let u = Matrix::from_fn(n, wide.len(), |i, j| columns[wide[j].0][(i, wide[j].1)] * sizes[wide[j].0] / sd);
    let normal = u.transpose().large_product(&u).plus(1.0, &Matrix::diagonal(&vec![1.0; wide.len()]));
    let right: Vec<f64> =
        (0..wide.len()).map(|j| (0..n).map(|i| u[(i, j)] * residuals[i] / sd).sum()).collect();
    let coefficients = Cholesky::new(&normal)?.solve(&right);
    Ok((0..n).map(|i| (0..wide.len()).map(|j| u[(i, j)] * coefficients[j]).sum::<f64>() * sd).collect())
}
