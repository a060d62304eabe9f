//! The posterior near its maximum when parameters have bounds: a Gaussian likelihood, cut off by the priors.
//!
//! Readings are nearly linear in the physical parameters, not in their normal scores: near a bound a score runs to infinity
//! while the parameter hardly moves, and a Gaussian in the scores (Laplace's method) is then too narrow on one side. Here the
//! likelihood is linearised in coordinates in which it is most nearly so (the parameters themselves; the
//! conductance 1/R_m of the mounts), the priors are kept exactly, and the product is drawn from.

use crate::{FlowError, UNKNOWNS};
use rand::RngExt;
use rand_distr::StandardNormal;
use rijke_inference::{Parameter, Prior, normal_cdf, normal_quantile};
use rijke_numerics::{Cholesky, Matrix, Stream, symmetric_eigen};

/// Sweeps of the sampler: means and sd are then known to some 2 % of an sd.
const SWEEPS: usize = 6000;
/// Sweeps until the start is forgotten.
const FORGOTTEN: usize = 200;

/// Mean and covariance of the normal scores, and of the physical unknowns.
#[derive(Clone, Debug)]
pub(crate) struct Moments {
    pub(crate) scores: Vec<f64>,
    pub(crate) covariance: Matrix,
    pub(crate) physical: Vec<f64>,
    pub(crate) physical_covariance: Matrix,
}

/// A coordinate in which the likelihood is linear: offset from its value at the maximum.
struct Axis {
    low: f64,
    high: f64,
    at: f64,
    /// True for 1/p: a uniform prior on p is then a density y^-2.
    inverse: bool,
    bounds: [f64; 2],
}

impl Axis {
    /// Of a parameter with a uniform prior at the score `z`, and dy/dz there.
    fn new(parameter: &Parameter, z: f64) -> Option<(Self, f64)> {
        let Prior::Uniform { low, high } = parameter.prior else { return None };
        let value = low + (high - low) * normal_cdf(z);
        let slope = (high - low) * (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt();
        let inverse = parameter.name == "mount_resistance";
        let (at, slope) = if inverse { (1.0 / value, -slope / value.powi(2)) } else { (value, slope) };
        let ends = if inverse { [1.0 / high, 1.0 / low] } else { [low, high] };
        Some((Self { low: ends[0] - at, high: ends[1] - at, at, inverse, bounds: [low, high] }, slope))
    }

    fn physical(&self, offset: f64) -> f64 {
        let y = self.at + offset;
        if self.inverse { 1.0 / y } else { y }
    }

    fn score(&self, offset: f64) -> f64 {
        let [low, high] = self.bounds;
        normal_quantile(((self.physical(offset) - low) / (high - low)).clamp(1e-12, 1.0 - 1e-12))
    }

    fn ln_density(&self, offset: f64) -> f64 {
        if self.inverse { -2.0 * (self.at + offset).ln() } else { 0.0 }
    }
}

/// Moments of the posterior whose whitened residual at the scores `z` is `residual`, with slopes `jacobian` of the
/// prediction in the scores. Parameters with uniform priors come first; all others are normal, and so are the scores
/// beyond `priors`.
pub(crate) fn moments(
    priors: &[Parameter; UNKNOWNS],
    z: &[f64],
    residual: &[f64],
    jacobian: &Matrix,
    stream: &mut Stream,
) -> Result<Moments, FlowError> {
    let axes: Vec<(Axis, f64)> = priors.iter().zip(z).map_while(|(p, &z)| Axis::new(p, z)).collect();
    let (n, u) = (z.len(), axes.len());
    let slope = |k: usize| axes.get(k).map_or(1.0, |a| a.1);
    let scaled = Matrix::from_fn(jacobian.rows(), n, |r, k| jacobian[(r, k)] / slope(k));
    let mut precision = scaled.transpose().product(&scaled);
    let mut pull = scaled.transpose().times(residual);
    for k in u..n {
        precision[(k, k)] += 1.0;
        pull[k] -= z[k];
    }
    // The normal ones integrated out.
    let rest: Vec<usize> = (u..n).collect();
    let normal = Cholesky::new(&precision.select(&rest))?;
    let cross = |i: usize| -> Vec<f64> { rest.iter().map(|&k| precision[(k, i)]).collect() };
    let solved: Vec<Vec<f64>> = (0..u).map(|i| normal.solve(&cross(i))).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let marginal = Matrix::from_fn(u, u, |i, j| precision[(i, j)] - dot(&solved[i], &cross(j)));
    let marginal_pull: Vec<f64> = (0..u).map(|i| pull[i] - dot(&solved[i], &pull[u..])).collect();
    let centre = normal.solve(&pull[u..]);

    let mut sampler = Sampler::new(axes.into_iter().map(|a| a.0).collect(), marginal, marginal_pull)?;
    let (mut scores, mut physical) = (Vec::with_capacity(SWEEPS), Vec::with_capacity(SWEEPS));
    for sweep in 0..SWEEPS + FORGOTTEN {
        sampler.sweep(stream);
        if sweep < FORGOTTEN {
            continue;
        }
        let at = &sampler.at;
        let white: Vec<f64> = rest.iter().map(|_| stream.sample(StandardNormal)).collect();
        let noise = back_substitute(&normal, &white);
        let others = (0..n - u)
            .map(|k| z[u + k] + centre[k] - (0..u).map(|i| solved[i][k] * at[i]).sum::<f64>() + noise[k]);
        let drawn: Vec<f64> = sampler.axes.iter().zip(at).map(|(a, &d)| a.score(d)).chain(others).collect();
        let mut values: Vec<f64> = sampler.axes.iter().zip(at).map(|(a, &d)| a.physical(d)).collect();
        for k in u..UNKNOWNS {
            values.push(super::physical(&priors[k], drawn[k])?);
        }
        scores.push(drawn);
        physical.push(values);
    }
    let (scores, covariance) = mean_and_covariance(&scores);
    let (physical, physical_covariance) = mean_and_covariance(&physical);
    Ok(Moments { scores, covariance, physical, physical_covariance })
}

/// L'^-1 w: a draw with covariance (L L')^-1 from white noise w.
fn back_substitute(factor: &Cholesky, white: &[f64]) -> Vec<f64> {
    let l = factor.lower();
    let mut x = white.to_vec();
    for i in (0..x.len()).rev() {
        for k in i + 1..x.len() {
            x[i] -= l[(k, i)] * x[k];
        }
        x[i] /= l[(i, i)];
    }
    x
}

fn mean_and_covariance(draws: &[Vec<f64>]) -> (Vec<f64>, Matrix) {
    let (n, size) = (draws.len() as f64, draws.first().map_or(0, Vec::len));
    let mean: Vec<f64> = (0..size).map(|k| draws.iter().map(|d| d[k]).sum::<f64>() / n).collect();
    let covariance = Matrix::from_fn(size, size, |i, j| {
        draws.iter().map(|d| (d[i] - mean[i]) * (d[j] - mean[j])).sum::<f64>() / (n - 1.0)
    });
    (mean, covariance)
}

/// Draws from exp(b'd - d'A d/2) within a box, times the densities of the axes: along the eigenvectors of A and along the axes
/// in turn, each conditional drawn exactly (hit and run), a density accepted after Metropolis.
struct Sampler {
    axes: Vec<Axis>,
    precision: Matrix,
    pull: Vec<f64>,
    directions: Vec<Vec<f64>>,
    at: Vec<f64>,
}

impl Sampler {
    fn new(axes: Vec<Axis>, precision: Matrix, pull: Vec<f64>) -> Result<Self, FlowError> {
        let n = axes.len();
        // In units of the width of the box, so that no axis hides another.
        let width: Vec<f64> = axes.iter().map(|a| a.high - a.low).collect();
        let (_, vectors) =
            symmetric_eigen(&Matrix::from_fn(n, n, |i, j| precision[(i, j)] * width[i] * width[j]))?;
        let mut directions: Vec<Vec<f64>> =
            (0..n).map(|k| (0..n).map(|i| vectors[(i, k)] * width[i]).collect()).collect();
        for k in 0..n {
            directions.push((0..n).map(|i| if i == k { width[i] } else { 0.0 }).collect());
        }
        Ok(Self { at: vec![0.0; n], axes, precision, pull, directions })
    }

    fn sweep(&mut self, stream: &mut Stream) {
        for direction in &self.directions {
            let along = self.precision.times(direction);
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
            let (curvature, force) =
                (dot(&along, direction), dot(&self.pull, direction) - dot(&along, &self.at));
            let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
            for ((axis, d), v) in self.axes.iter().zip(&self.at).zip(direction) {
                if *v != 0.0 {
                    let ends = [(axis.low - d) / v, (axis.high - d) / v];
                    low = low.max(ends[0].min(ends[1]));
                    high = high.min(ends[0].max(ends[1]));
                }
            }
            let uniform: f64 = stream.random();
            let step = cut_normal(force, curvature, low.min(0.0), high.max(0.0), uniform);
            let density = |t: f64| -> f64 {
                let moved = self.axes.iter().zip(&self.at).zip(direction);
                moved.map(|((a, d), v)| a.ln_density((d + t * v).clamp(a.low, a.high))).sum()
            };
            let chance: f64 = stream.random();
            if chance.ln() < density(step) - density(0.0) {
                for ((d, v), axis) in self.at.iter_mut().zip(direction).zip(&self.axes) {
                    *d = (*d + step * v).clamp(axis.low, axis.high);
                }
            }
        }
    }
}

/// The number at the quantile `uniform` of the density exp(force t - curvature t^2/2) on [low, high].
fn cut_normal(force: f64, curvature: f64, low: f64, high: f64, uniform: f64) -> f64 {
    if curvature * (high - low).powi(2) < 1e-12 && (force * (high - low)).abs() < 1e-6 {
        return low + uniform * (high - low);
    }
    let (mean, sd) = (force / curvature, curvature.sqrt().recip());
    let (a, b) = ((low - mean) / sd, (high - mean) / sd);
    // In the lower tail, where probabilities keep their digits.
    let t = if a + b > 0.0 {
        let (p, q) = (normal_cdf(-b), normal_cdf(-a));
        -normal_quantile(p + (1.0 - uniform) * (q - p))
    } else {
        let (p, q) = (normal_cdf(a), normal_cdf(b));
        normal_quantile(p + uniform * (q - p))
    };
    if t.is_finite() {
        (mean + sd * t).clamp(low, high)
    } else if force > 0.0 {
        high
    } else {
        low
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::unknowns;
    use rijke_numerics::Streams;

    /// One bounded parameter read with noise that puts its likelihood across a bound: the truncated normal's moments.
    #[test]
    fn oracle_truncated_normal_and_conductance_by_quadrature() {
        let priors = unknowns();
        let n = UNKNOWNS;
        // Readings: phi with sd 0.03, 1/R_m with sd 0.2, centred on 0.01 and 0.3; the rest unseen.
        let z = vec![0.0; n];
        let (share, mount) = (0.15, 10.5);
        let density = 1.0 / std::f64::consts::TAU.sqrt();
        let (by_share, by_mount) = (0.30 * density, -19.0 * density / (mount * mount));
        let mut jacobian = Matrix::zeros(2, n);
        jacobian[(0, 3)] = by_share / 0.03;
        jacobian[(1, 2)] = by_mount / 0.2;
        let residual = [(0.01 - share) / 0.03, (0.3 - 1.0 / mount) / 0.2];
        let found = moments(&priors, &z, &residual, &jacobian, &mut Streams::new(1).stream("test")).unwrap();
        let quadrature = |low: f64, high: f64, weight: &dyn Fn(f64) -> f64| {
            let points = (0..200_000).map(|k| low + (high - low) * (f64::from(k) + 0.5) / 2e5);
            let sums = points.fold([0.0; 3], |s, p| {
                let w = weight(p);
                [s[0] + w, s[1] + w * p, s[2] + w * p * p]
            });
            let mean = sums[1] / sums[0];
            (mean, (sums[2] / sums[0] - mean * mean).sqrt())
        };
        let share = quadrature(0.0, 0.30, &|p| (-0.5 * ((p - 0.01) / 0.03).powi(2)).exp());
        let mount = quadrature(1.0, 20.0, &|p| (-0.5 * ((1.0 / p - 0.3) / 0.2).powi(2)).exp());
        for (k, (mean, sd)) in [(3, share), (2, mount)] {
            let found_sd = found.physical_covariance[(k, k)].sqrt();
            assert!((found.physical[k] - mean).abs() < 0.06 * sd, "{k}: {} {mean}", found.physical[k]);
            assert!((found_sd / sd - 1.0).abs() < 0.05, "{k}: {found_sd} {sd}");
        }
        // What is unseen keeps its prior.
        for k in [0, 1, 4, 5, 6, 9] {
            assert!(found.scores[k].abs() < 0.06 && (found.covariance[(k, k)] - 1.0).abs() < 0.08, "{k}");
        }
    }
}
