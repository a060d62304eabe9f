//! Linear models with Gaussian priors: everything is known in closed form.

use crate::problems::{Linear, design, normal, numbers};
use approx::assert_relative_eq;
use rijke_inference::*;
use rijke_numerics::{Cholesky, Matrix};

fn fixed(values: Vec<f64>, sd: f64) -> Data {
    let all: Vec<usize> = (0..values.len()).collect();
    let observation = Observation::new("all", values).with_independent_noise(0, &all);
    Data::new(vec![observation], vec![NoiseGroup::fixed("noise", "V", sd)]).unwrap()
}

/// ln of a Gaussian density of mean zero.
fn ln_gaussian(x: &[f64], covariance: &Matrix) -> f64 {
    let factor = Cholesky::new(covariance).unwrap();
    let white = factor.whiten(x);
    -0.5 * (white.iter().map(|w| w * w).sum::<f64>()
        + factor.ln_det()
        + x.len() as f64 * (2.0 * std::f64::consts::PI).ln())
}

#[test]
fn exact_posterior_and_evidence_in_up_to_50_parameters() {
    for p in [0, 1, 2, 7, 20, 50] {
        let (m, sd) = (80, 0.3);
        let x = design("design", m, p);
        let prior_sd: Vec<f64> = (0..p).map(|i| 0.2 + 0.1 * (i % 7) as f64).collect();
        let y = numbers("data", m);
        let parameters =
            Parameters::new((0..p).map(|i| normal(&format!("a{i}"), 0.0, prior_sd[i])).collect()).unwrap();
        let (model, data) = (Linear(x.clone()), fixed(y.clone(), sd));
        let posterior = Posterior::new(&model, &data, &parameters).unwrap();
        // D ~ N(0, sd^2 I + X S X'), by the Cholesky factor of an m x m matrix that the fast path never forms.
        let marginal = Matrix::from_fn(m, m, |i, j| {
            let signal: f64 = (0..p).map(|k| x[(i, k)] * x[(j, k)] * prior_sd[k].powi(2)).sum();
            signal + if i == j { sd * sd } else { 0.0 }
        });
        let gain = Cholesky::new(&marginal).unwrap().solve(&y);
        for options in [MapOptions::default(), MapOptions::bfgs()] {
            let fit = posterior.map(&options).unwrap();
            assert!(fit.stop.converged(), "{p}: {:?}", fit.stop);
            let laplace = posterior.laplace(&fit).unwrap();
            // BFGS ends at 1e-12 nats, so its evidence is off by that and its mean by 1e-6 sd; Newton's by rounding.
            let newton = options.search.method == Method::Newton;
            assert_relative_eq!(
                laplace.evidence.ln_marginal,
                ln_gaussian(&y, &marginal),
                epsilon = if newton { 1e-10 } else { 1e-8 }
            );
            for k in 0..p {
                let mean: f64 = (0..m).map(|i| prior_sd[k].powi(2) * x[(i, k)] * gain[i]).sum();
                assert_relative_eq!(fit.parameters[k], mean, epsilon = if newton { 1e-10 } else { 1e-4 });
            }
        }
    }
}
