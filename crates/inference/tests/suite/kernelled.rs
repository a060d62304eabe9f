//! Blocks with a misfit by its kernel against the same covariance as a dense matrix.

use crate::problems::numbers;
use crate::structured::{TIMES, ringing_model, structure, unknowns, values};
use approx::{assert_abs_diff_eq, assert_relative_eq};
use rijke_inference::*;
use rijke_numerics::check::{remainder_slopes, slopes_near};
use rijke_numerics::{C64, Order};
use std::f64::consts::PI;

/// The same with the misfit by its kernel, and without the nuisances of a floated size.
fn exact_structure(kernel: Kernel) -> (Structured, Vec<NoiseGroup>) {
    let (_, mut groups) = structure(kernel);
    groups.pop();
    let n = 2 * TIMES;
    let complex = |name: &str| -> Vec<C64> {
        let x = numbers(name, n);
        (0..TIMES).map(|k| C64::new(x[2 * k], x[2 * k + 1])).collect()
    };
    let coordinate: Vec<f64> = (0..n).map(|i| (i / 2) as f64).collect();
    let part: Vec<usize> = (0..n).map(|i| i % 2).collect();
    let correlated =
        Correlated { size: 2, length: 3, kernel, coordinate: &coordinate, part: &part, shortest: 0.0 };
    let odd = |i: usize| f64::from(u8::from(i.is_multiple_of(3)));
    let structured = Structured::new((0..n).map(|i| 4e-4 * (1.0 + odd(i))).collect())
        .with_noise(0, (0..n).map(|i| 1.0 + 0.1 * (i % 4) as f64).collect())
        .with_noise(1, (0..n).map(odd).collect())
        .with_nuisances(&complex_columns(&[complex("u1"), complex("u2")]), &[0.3, 0.3, 10.0, 10.0])
        .with_exact_misfit(&correlated)
        .unwrap();
    (structured, groups)
}

#[test]
fn oracle_an_exact_misfit_against_the_dense_covariance() {
    for kernel in [Kernel::SquaredExponential, Kernel::Matern52, Kernel::Matern32] {
        let (structured, groups) = exact_structure(kernel);
        let data =
            Data::new(vec![Observation::new("s", values()).with_structure(structured)], groups).unwrap();
        let (model, parameters) = (ringing_model(), unknowns());
        let posterior = Posterior::new(&model, &data, &parameters).unwrap();
        let z = [1.25, 0.45, 2.05, -2.5, -3.2, -1.8, 1.2];
        let sds = posterior.noise_sd(&z);
        let dense = posterior.covariance(0, &sds);
        // The kernel itself, at two data of one part and at two of different parts.
        let variance = sds[2].powi(2) * kernel.correlation(3.0, sds[3]);
        let u: f64 = dense[(1, 7)] - variance;
        let (other, _) = exact_structure(kernel);
        let bare = Data::new(
            vec![Observation::new("s", values()).with_structure(other)],
            vec![
                NoiseGroup::fixed("noise", "1", sds[0]),
                NoiseGroup::fixed("more noise", "1", sds[1]),
                NoiseGroup::fixed("misfit", "1", 1e-9),
                NoiseGroup::fixed("length", "s", sds[3]),
            ],
        )
        .unwrap();
        let without = Posterior::new(&model, &bare, &parameters).unwrap();
        let without = without.covariance(0, &without.noise_sd(&z[..3]));
        assert_abs_diff_eq!(u, without[(1, 7)], epsilon = 1e-12);
        assert_abs_diff_eq!(dense[(1, 6)], without[(1, 6)], epsilon = 1e-12);
        let fixed = Data::new(vec![Observation::new("d", values()).with_floor(dense)], Vec::new()).unwrap();
        let plain = Posterior::new(&model, &fixed, &parameters).unwrap();
        let expected = plain.evaluate(&z[..3], Order::Second).unwrap();
        let found = posterior.evaluate(&z, Order::Second).unwrap();
        let priors: f64 = [(-3.2, 0.05_f64, 0.5_f64), (-1.8, 0.1, 1.0), (1.2, 3.0, 0.5)]
            .map(|(u, median, sd)| 0.5 * ((u - median.ln()) / sd).powi(2) + (sd * (2.0 * PI).sqrt()).ln())
            .iter()
            .sum();
        assert_relative_eq!(found.value - priors, expected.value, max_relative = 1e-9);
        for i in 0..3 {
            assert_relative_eq!(found.gradient[i], expected.gradient[i], max_relative = 1e-7);
            for j in 0..3 {
                assert_relative_eq!(found.hessian[(i, j)], expected.hessian[(i, j)], max_relative = 1e-7);
            }
        }
    }
}

#[test]
fn order_an_exact_misfit_has_its_derivatives() {
    for kernel in [Kernel::SquaredExponential, Kernel::Matern52] {
        let (structured, groups) = exact_structure(kernel);
        let data =
            Data::new(vec![Observation::new("s", values()).with_structure(structured)], groups).unwrap();
        let (model, parameters) = (ringing_model(), unknowns());
        let posterior = Posterior::new(&model, &data, &parameters).unwrap();
        let z = [1.25, 0.45, 2.05, -2.5, -3.2, -1.8, 1.2];
        let at = posterior.evaluate(&z, Order::Second).unwrap();
        let directions: [[f64; 7]; 5] = [
            [0.1, -0.2, 0.1, 0.5, -0.4, 0.3, 0.6],
            [0.0, 0.0, 0.0, 0.6, 1.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
            [0.0, 0.0, 0.0, 0.7, 0.0, 0.5, -1.0],
        ];
        for direction in directions {
            let slope: f64 = at.gradient.iter().zip(&direction).map(|(g, d)| g * d).sum();
            let bend = 0.5 * at.hessian.quadratic(&direction);
            let moved = |h: f64| {
                let z: Vec<f64> = z.iter().zip(&direction).map(|(z, d)| z + h * d).collect();
                posterior.evaluate(&z, Order::Value).unwrap().value - at.value
            };
            slopes_near(&remainder_slopes(|h| (moved(h) - slope * h).abs()), 2.0, 0.1);
            slopes_near(&remainder_slopes(|h| (moved(h) - slope * h - bend * h * h).abs()), 3.0, 0.4);
        }
    }
}
