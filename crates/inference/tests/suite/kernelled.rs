//! Blocks with a misfit against the same covariance as a dense matrix.

use crate::problems::{Linear, normal, numbers};
use crate::structured::{TIMES, ringing_model, structure, unknowns, values};
use approx::{assert_abs_diff_eq, assert_relative_eq};
use rand::RngExt;
use rijke_inference::*;
use rijke_numerics::check::{remainder_slopes, slopes_near};
use rijke_numerics::{C64, Matrix, Order, Streams};
use std::f64::consts::PI;

/// As [`structure`], with a misfit of both parts instead of the nuisances of a floated size.
fn with_misfit(kernel: Kernel) -> (Structured, Vec<NoiseGroup>) {
    let (_, mut groups) = structure();
    groups.pop();
    groups.push(NoiseGroup::inferred("misfit", "1", 0.1, 1.0));
    groups.push(NoiseGroup::inferred("length", "s", 3.0, 0.5));
    let n = 2 * TIMES;
    let complex = |name: &str| -> Vec<C64> {
        let x = numbers(name, n);
        (0..TIMES).map(|k| C64::new(x[2 * k], x[2 * k + 1])).collect()
    };
    let coordinate: Vec<f64> = (0..n).map(|i| (i / 2) as f64).collect();
    let part: Vec<usize> = (0..n).map(|i| i % 2).collect();
    let correlated = Correlated { size: 2, length: 3, kernel, coordinate: &coordinate, part: &part };
    let odd = |i: usize| f64::from(u8::from(i.is_multiple_of(3)));
    let structured = Structured::new((0..n).map(|i| 4e-4 * (1.0 + odd(i))).collect())
        .with_noise(0, (0..n).map(|i| 1.0 + 0.1 * (i % 4) as f64).collect())
        .with_noise(1, (0..n).map(odd).collect())
        .with_nuisances(&complex_columns(&[complex("u1"), complex("u2")]), &[0.3, 0.3, 10.0, 10.0])
        .with_misfit(&correlated)
        .unwrap();
    (structured, groups)
}

#[test]
fn oracle_a_misfit_against_the_dense_covariance() {
    for kernel in [Kernel::SquaredExponential, Kernel::Matern52, Kernel::Matern32] {
        let (structured, groups) = with_misfit(kernel);
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
        let (other, _) = with_misfit(kernel);
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
fn order_a_misfit_has_its_derivatives() {
    for kernel in [Kernel::SquaredExponential, Kernel::Matern52] {
        let (structured, groups) = with_misfit(kernel);
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

/// ln evidence of a straight line for data along 0..1 with noise of 0.01 and a model error of 0.05 sin, of
/// `n` data, with the misfit or with noise alone; against that of the model without slope.
fn nats(n: usize, correlated: bool) -> f64 {
    let x: Vec<f64> = (0..n).map(|i| (i as f64 + 0.5) / n as f64).collect();
    let mut stream = Streams::new(4).stream("thinning");
    // Noise is drawn on the finest grid, and thinned.
    let noise: Vec<f64> =
        (0..1600).map(|_| 0.01 * stream.sample::<f64, _>(rand_distr::StandardNormal)).collect();
    let y: Vec<f64> =
        x.iter().enumerate().map(|(i, x)| 0.2 * x + 0.05 * (9.0 * x).sin() + noise[i * 1600 / n]).collect();
    let part = vec![0; n];
    let structured = Structured::new(vec![1e-4; n]).with_noise(0, vec![1.0; n]);
    let kernel = Kernel::SquaredExponential;
    let misfit = Correlated { size: 1, length: 2, kernel, coordinate: &x, part: &part };
    let structured = if correlated { structured.with_misfit(&misfit).unwrap() } else { structured };
    let mut groups = vec![NoiseGroup::floated("noise", "1")];
    if correlated {
        groups.push(NoiseGroup::inferred("misfit", "1", 0.05, 1.0));
        groups.push(NoiseGroup::inferred("length", "1", 0.2, 0.5));
    }
    let data = Data::new(vec![Observation::new("line", y).with_structure(structured)], groups).unwrap();
    let ln = |columns: usize| {
        let model = Linear(Matrix::from_fn(n, columns, |i, j| x[i].powi(j as i32)));
        let list = (0..columns).map(|i| normal(&format!("a{i}"), 0.0, 1.0));
        let parameters = Parameters::new(list.collect()).unwrap();
        let posterior = Posterior::new(&model, &data, &parameters).unwrap();
        let fit = posterior.map(&MapOptions::default()).unwrap();
        assert!(fit.stop.converged(), "{n} {columns}: {}", fit.stop);
        posterior.laplace(&fit).unwrap().evidence.ln_marginal
    };
    ln(2) - ln(1)
}

#[test]
fn behaviour_twice_the_data_do_not_double_the_nats_of_a_model_error() {
    let table: Vec<[f64; 2]> = [50, 100, 200, 400].map(|n| [nats(n, false), nats(n, true)]).to_vec();
    println!("nats for a slope at 50, 100, 200, 400 data, noise alone and with misfit: {table:.2?}");
    // With noise alone the model error counts as many times as there are data.
    for pair in table.windows(2) {
        assert!(pair[1][0] / pair[0][0] > 1.8, "{table:?}");
        assert!((pair[1][1] - pair[0][1]).abs() < 1.0, "{table:?}");
    }
}

#[test]
fn message_a_misfit_along_one_place_is_refused() {
    let flat =
        Correlated { size: 0, length: 0, kernel: Kernel::Matern32, coordinate: &[1.0, 1.0], part: &[0, 0] };
    let said = Structured::new(vec![1.0; 2]).with_misfit(&flat).unwrap_err().to_string();
    assert!(said.contains("runs from 1 to 1"), "{said}");
}

#[test]
fn message_a_noise_of_few_data_is_hardly_determined() {
    let coordinate: Vec<f64> = (0..2 * TIMES).map(|i| (i / 2) as f64).collect();
    let part: Vec<usize> = (0..2 * TIMES).map(|i| i % 2).collect();
    let correlated =
        Correlated { size: 2, length: 3, kernel: Kernel::Matern52, coordinate: &coordinate, part: &part };
    let structured = Structured::new(vec![4e-4; 2 * TIMES])
        .with_noise(0, vec![1.0; 2 * TIMES])
        .with_noise(1, (0..2 * TIMES).map(|i| f64::from(u8::from(i < 1))).collect())
        .with_misfit(&correlated)
        .unwrap();
    let (_, groups) = with_misfit(Kernel::Matern52);
    let data = Data::new(vec![Observation::new("s", values()).with_structure(structured)], groups).unwrap();
    let options = AssessOptions { random_starts: 0, draws: 100, ..AssessOptions::default() };
    let words = assess(&ringing_model(), &data, &unknowns(), &options).unwrap().health.warnings.join("; ");
    // A misfit and its length act on all data.
    assert!(words.contains("the noise of 'more noise' (1 data) can hardly be estimated"), "{words}");
}
