//! The slow route of tests with three parameters: a cost that is written out, by differences.

use rijke_numerics::{Cholesky, Matrix};
use std::f64::consts::PI;

/// Newton's steps: the cost is nearly quadratic, and the first is from the maximum of the fast route.
const STEPS: usize = 5;

/// Values and standard deviations at the maximum next to `near` (likewise), and ln of the evidence by
/// Laplace's method. `cost` is minus the ln posterior, nats, of parameters in standard deviations of their
/// `priors` (mean and sd) from the means.
pub(crate) fn maximum(
    priors: &[[f64; 2]; 3],
    near: &[[f64; 2]; 3],
    cost: &dyn Fn([f64; 3]) -> f64,
) -> ([[f64; 2]; 3], f64) {
    let h = [0, 1, 2].map(|i| 0.1 * near[i][1] / priors[i][1]);
    let mut x = [0, 1, 2].map(|i| (near[i][0] - priors[i][0]) / priors[i][1]);
    let mut hessian = Matrix::zeros(3, 3);
    for _ in 0..STEPS {
        let at = |steps: &[(usize, f64)]| {
            let mut y = x;
            steps.iter().for_each(|(i, t)| y[*i] += t * h[*i]);
            cost(y)
        };
        let slope: Vec<f64> = (0..3).map(|i| (at(&[(i, 1.0)]) - at(&[(i, -1.0)])) / (2.0 * h[i])).collect();
        hessian = Matrix::from_fn(3, 3, |i, j| {
            let corner = |a: f64, b: f64| at(&[(i, a), (j, b)]);
            (corner(0.5, 0.5) - corner(0.5, -0.5) - corner(-0.5, 0.5) + corner(-0.5, -0.5)) / (h[i] * h[j])
        });
        let step = Cholesky::new(&hessian).unwrap().solve(&slope);
        (0..3).for_each(|i| x[i] -= step[i]);
    }
    let factor = Cholesky::new(&hessian).unwrap();
    let covariance = factor.inverse();
    let ends =
        [0, 1, 2].map(|i| [priors[i][0] + priors[i][1] * x[i], priors[i][1] * covariance[(i, i)].sqrt()]);
    (ends, -cost(x) - 0.5 * factor.ln_det() + 1.5 * (2.0 * PI).ln())
}
