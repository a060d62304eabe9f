//! Blocks with a diagonal and columns against the same covariance as a dense matrix; nuisances.

use crate::problems::{Linear, Ringing, normal, numbers, simulate};
use approx::{assert_abs_diff_eq, assert_relative_eq};
use rand::RngExt;
use rijke_inference::*;
use rijke_numerics::check::{remainder_slopes, slopes_near};
use rijke_numerics::{C64, Matrix, Order, Streams};
use std::f64::consts::PI;
use std::time::Instant;

pub(crate) const TIMES: usize = 20;

pub(crate) fn ringing_model() -> Ringing {
    Ringing { times: (0..TIMES).map(|k| 0.15 * k as f64).collect() }
}

pub(crate) fn unknowns() -> Parameters {
    Parameters::new(vec![normal("a", 1.2, 0.5), normal("b", 0.5, 0.4), normal("c", 2.0, 0.3)]).unwrap()
}

/// Two complex nuisances of known size, one of a floated size, two noises on a measured variance.
pub(crate) fn structure() -> (Structured, Vec<NoiseGroup>) {
    let n = 2 * TIMES;
    let complex = |name: &str| -> Vec<C64> {
        let x = numbers(name, n);
        (0..TIMES).map(|k| C64::new(x[2 * k], x[2 * k + 1])).collect()
    };
    let known = complex_columns(&[complex("u1"), complex("u2")]);
    let floated = complex_columns(&[complex("u3")]);
    let odd = |i: usize| f64::from(u8::from(i.is_multiple_of(3)));
    let structured = Structured::new((0..n).map(|i| 4e-4 * (1.0 + odd(i))).collect())
        .with_noise(0, (0..n).map(|i| 1.0 + 0.1 * (i % 4) as f64).collect())
        .with_noise(1, (0..n).map(odd).collect())
        .with_nuisances(&known, &[0.3, 0.3, 10.0, 10.0])
        .with_floated_nuisances(&floated, 2);
    let groups = vec![
        NoiseGroup::floated("noise", "1"),
        NoiseGroup::inferred("more noise", "1", 0.05, 0.5),
        NoiseGroup::floated("source", "1"),
    ];
    (structured, groups)
}

pub(crate) fn values() -> Vec<f64> {
    let truth = ringing_model().predict(&[1.3, 0.4, 2.1], Order::Value).unwrap().values;
    truth.iter().zip(numbers("structured", 2 * TIMES)).map(|(t, x)| t + 0.2 * x).collect()
}

#[test]
fn exact_complex_columns_times_parts_are_parts_of_the_product() {
    let x = numbers("complex columns", 12);
    let columns: Vec<Vec<C64>> =
        (0..2).map(|j| (0..3).map(|k| C64::new(x[6 * j + 2 * k], x[6 * j + 2 * k + 1])).collect()).collect();
    let coefficients = [C64::new(0.7, -1.3), C64::new(2.1, 0.4)];
    let parts: Vec<f64> = coefficients.iter().flat_map(|c| [c.re, c.im]).collect();
    let found = complex_columns(&columns).times(&parts);
    for k in 0..3 {
        let sum: C64 = columns.iter().zip(coefficients).map(|(u, c)| u[k] * c).sum();
        assert_abs_diff_eq!(found[2 * k], sum.re, epsilon = 1e-15);
        assert_abs_diff_eq!(found[2 * k + 1], sum.im, epsilon = 1e-15);
    }
}

#[test]
fn oracle_value_and_slopes_against_the_dense_covariance() {
    let (structured, groups) = structure();
    let data = Data::new(vec![Observation::new("s", values()).with_structure(structured)], groups).unwrap();
    let (model, parameters) = (ringing_model(), unknowns());
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    // The same covariance as a dense floor, at fixed sizes.
    let z = [1.25, 0.45, 2.05, -2.5, -3.2, -0.7];
    let dense = posterior.covariance(0, &posterior.noise_sd(&z));
    let fixed = Data::new(vec![Observation::new("d", values()).with_floor(dense)], Vec::new()).unwrap();
    let plain = Posterior::new(&model, &fixed, &parameters).unwrap();
    let expected = plain.evaluate(&z[..3], Order::Second).unwrap();
    let found = posterior.evaluate(&z, Order::Second).unwrap();
    // The prior of the inferred size.
    let (u, median, sd) = (-3.2, 0.05_f64, 0.5_f64);
    let prior = 0.5 * ((u - median.ln()) / sd).powi(2) + (sd * (2.0 * PI).sqrt()).ln();
    assert_relative_eq!(found.value - prior, expected.value, max_relative = 1e-9);
    for i in 0..3 {
        assert_relative_eq!(found.gradient[i], expected.gradient[i], max_relative = 1e-7);
        for j in 0..3 {
            assert_relative_eq!(found.hessian[(i, j)], expected.hessian[(i, j)], max_relative = 1e-7);
        }
    }
}

/// The same noises once as a diagonal and columns, and once as matrices of which one acts on all data, one on
/// few, and one along two directions.
#[test]
fn oracle_noises_of_a_dense_block_act_as_columns_do() {
    let n = 2 * TIMES;
    let (structured, groups) = structure();
    let (model, parameters) = (ringing_model(), unknowns());
    let observation = Observation::new("s", values()).with_structure(structured);
    let by_columns = Data::new(vec![observation], groups.clone()).unwrap();
    let by_columns = Posterior::new(&model, &by_columns, &parameters).unwrap();
    let x = numbers("u3", n);
    let source = complex_columns(&[(0..TIMES).map(|k| C64::new(x[2 * k], x[2 * k + 1])).collect()]);
    let diagonal = |of: &dyn Fn(usize) -> f64| Matrix::diagonal(&(0..n).map(of).collect::<Vec<_>>());
    let dense = Observation::new("d", values())
        .with_floor(by_columns.covariance(0, &[0.0; 3]))
        .with_noise(0, diagonal(&|i| 1.0 + 0.1 * (i % 4) as f64))
        .with_noise(1, diagonal(&|i| f64::from(u8::from(i.is_multiple_of(3)))))
        .with_noise(2, source.product(&source.transpose()));
    let dense = Data::new(vec![dense], groups).unwrap();
    let dense = Posterior::new(&model, &dense, &parameters).unwrap();
    let z = [1.25, 0.45, 2.05, -2.5, -3.2, -0.7];
    let found = dense.evaluate(&z, Order::Second).unwrap();
    let expected = by_columns.evaluate(&z, Order::Second).unwrap();
    assert_relative_eq!(found.value, expected.value, max_relative = 1e-10);
    for i in 0..6 {
        assert_relative_eq!(found.gradient[i], expected.gradient[i], max_relative = 1e-8, epsilon = 1e-8);
        for j in 0..6 {
            let (found, expected) = (found.hessian[(i, j)], expected.hessian[(i, j)]);
            assert_relative_eq!(found, expected, max_relative = 1e-7, epsilon = 1e-7);
        }
    }
}

#[test]
fn order_sizes_have_their_derivatives() {
    let (structured, groups) = structure();
    let data = Data::new(vec![Observation::new("s", values()).with_structure(structured)], groups).unwrap();
    let (model, parameters) = (ringing_model(), unknowns());
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let z = [1.25, 0.45, 2.05, -2.5, -3.2, -0.7];
    let directions: [[f64; 6]; 5] = [
        [0.1, -0.2, 0.1, 0.5, -0.4, -0.3],
        [0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.6, 1.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, -1.0, 0.7],
        [0.2, 0.1, 0.0, 0.0, 0.0, 1.0],
    ];
    let at = posterior.evaluate(&z, Order::Second).unwrap();
    let first = posterior.evaluate(&z, Order::First).unwrap();
    for (a, b) in at.gradient.iter().zip(&first.gradient) {
        assert_relative_eq!(a, b, max_relative = 1e-9);
    }
    for direction in directions {
        let slope: f64 = at.gradient.iter().zip(&direction).map(|(g, d)| g * d).sum();
        let bend = 0.5 * at.hessian.quadratic(&direction);
        let moved = |h: f64| {
            let z: Vec<f64> = z.iter().zip(&direction).map(|(z, d)| z + h * d).collect();
            posterior.evaluate(&z, Order::Value).unwrap().value - at.value
        };
        slopes_near(&remainder_slopes(|h| (moved(h) - slope * h).abs()), 2.0, 0.1);
        // The smallest step of the third order is at rounding of J; a term that is missing would give two.
        slopes_near(&remainder_slopes(|h| (moved(h) - slope * h - bend * h * h).abs()), 3.0, 0.4);
    }
}

#[test]
fn exact_a_nuisance_is_a_parameter_integrated_out() {
    // f = x a + u b: b as a parameter with a prior, or as a column; the evidence is the same, for any width
    // of that prior.
    for width in [0.1, 1.0, 1e4] {
        let x = crate::problems::design("nuisance", 40, 3);
        let y: Vec<f64> = numbers("nuisance/y", 40);
        let prior = |i: usize| normal(&format!("a{i}"), 0.0, if i == 2 { width } else { 1.0 });
        let noise = || vec![NoiseGroup::fixed("noise", "1", 0.3)];
        let all: Vec<usize> = (0..40).collect();
        let dense =
            Data::new(vec![Observation::new("d", y.clone()).with_independent_noise(0, &all)], noise())
                .unwrap();
        let three = Parameters::new((0..3).map(prior).collect()).unwrap();
        let expected =
            assess(&Linear(x.clone()), &dense, &three, &AssessOptions::default()).unwrap().laplace.unwrap();
        let column = Matrix::from_fn(40, 1, |i, _| x[(i, 2)]);
        let structured =
            Structured::new(vec![0.0; 40]).with_noise(0, vec![1.0; 40]).with_nuisances(&column, &[width]);
        let data = Data::new(vec![Observation::new("s", y).with_structure(structured)], noise()).unwrap();
        let two = Parameters::new((0..2).map(prior).collect()).unwrap();
        let model = Linear(Matrix::from_fn(40, 2, |i, j| x[(i, j)]));
        // The data are numbers at random, which no line describes.
        let options = AssessOptions { goodness_of_fit: false, ..AssessOptions::default() };
        let found = assess(&model, &data, &two, &options).unwrap();
        assert_eq!(found.health.warnings, Vec::<String>::new());
        let laplace = found.laplace.unwrap();
        assert_abs_diff_eq!(laplace.evidence.ln_marginal, expected.evidence.ln_marginal, epsilon = 1e-8);
        for i in 0..2 {
            assert_abs_diff_eq!(laplace.mean[i], expected.mean[i], epsilon = 1e-9);
            assert_relative_eq!(laplace.covariance[(i, i)], expected.covariance[(i, i)], max_relative = 1e-7);
        }
    }
}

#[test]
fn coverage_parameters_beside_nuisances() {
    // Data drawn from the model: the stated sd must hold the truth in 68.3 and 95.4 % of 200 sets.
    let (structured, mut groups) = structure();
    let sizes = [0.05, 0.03, 0.5];
    for (group, sd) in groups.iter_mut().zip(sizes) {
        group.mode = NoiseMode::Fixed { sd };
    }
    let data = Data::new(vec![Observation::new("s", values()).with_structure(structured)], groups).unwrap();
    let (model, parameters) = (ringing_model(), unknowns());
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let (mut within, sets) = ([0, 0], 200);
    for k in 0..sets {
        let mut stream = Streams::new(9).stream(&format!("sets/{k}"));
        let xi: Vec<f64> = (0..3).map(|_| stream.sample::<f64, _>(rand_distr::StandardNormal)).collect();
        let truth = parameters.from_standard_normal(&xi);
        let drawn = simulate(&posterior, &truth, &mut stream);
        let again = Posterior::new(&model, &drawn, &parameters).unwrap();
        let fit = again.map(&MapOptions::default()).unwrap();
        let laplace = again.laplace(&fit).unwrap();
        for i in 0..3 {
            let pull = (laplace.mean[i] - truth[i]).abs() / laplace.covariance[(i, i)].sqrt();
            within[0] += usize::from(pull < 1.0);
            within[1] += usize::from(pull < 2.0);
        }
    }
    let share = within.map(|w| w as f64 / (3.0 * f64::from(sets)));
    println!("within 1 and 2 sd: {share:.3?}");
    assert!((share[0] - 0.683).abs() < 0.06 && (share[1] - 0.954).abs() < 0.03, "{share:?}");
}

/// A noise that acts through columns alone has no floor beside which it could be negligible.
#[test]
fn behaviour_a_search_beside_a_floated_nuisance_ends_in_a_fit() {
    let (structured, groups) = structure();
    let data = Data::new(vec![Observation::new("s", values()).with_structure(structured)], groups).unwrap();
    let (model, parameters) = (ringing_model(), unknowns());
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let mut unfinished = 0;
    for max_evaluations in 1..30 {
        let search = TrustRegion { max_evaluations, ..TrustRegion::default() };
        let fit = posterior.map(&MapOptions { search, start: None }).unwrap();
        assert!(fit.cost.is_finite() && fit.working.iter().all(|z| z.is_finite()), "{max_evaluations}");
        unfinished += usize::from(!fit.stop.converged());
    }
    assert!(unfinished > 0);
}

#[test]
fn message_a_bad_structure_names_its_observation() {
    let bad = |structured: Structured| {
        let data = Data::new(
            vec![Observation::new("head", vec![1.0, 2.0]).with_structure(structured)],
            vec![NoiseGroup::fixed("noise", "1", 1.0)],
        );
        data.unwrap_err().to_string()
    };
    assert!(bad(Structured::new(vec![1.0])).contains("observation 'head': its variances"));
    assert!(bad(Structured::new(vec![1.0, 0.0])).contains("value 1 has no independent variance"));
    assert!(bad(Structured::new(vec![1.0, f64::NAN])).contains("a variance is NaN"));
    assert!(bad(Structured::new(vec![1.0; 2]).with_noise(3, vec![1.0; 2])).contains("names noise group 3"));
    let short = Structured::new(vec![1.0; 2]).with_nuisances(&Matrix::identity(1), &[1.0]);
    assert!(bad(short).contains("not as long as its values"));
    let long = Structured::new(vec![1.0; 2]).with_nuisances(&Matrix::from_fn(3, 1, |_, _| 1.0), &[1.0]);
    assert!(bad(long).contains("nuisances have 3 rows"));
    let sds = Structured::new(vec![1.0; 2]).with_nuisances(&Matrix::identity(2), &[1.0, 2.0, 3.0]);
    assert!(bad(sds).contains("2 columns of nuisances have 3 standard deviations"));
    let apart = Correlated {
        size: 0,
        length: 0,
        kernel: Kernel::Matern52,
        coordinate: &[0.0, 1.0],
        part: &[0, usize::MAX],
    };
    assert!(Structured::new(vec![1.0; 2]).with_misfit(&apart).is_ok());
}

/// 15 000 complex data with 90 complex nuisances, ten parameters, one floated noise.
#[test]
#[ignore = "long: a measurement of time"]
fn behaviour_fifteen_thousand_complex_data_with_ninety_nuisances() {
    let (n, q, p) = (15_000, 90, 10);
    let x = numbers("large/u", 2 * n * q);
    let columns: Vec<Vec<C64>> = (0..q)
        .map(|j| (0..n).map(|k| C64::new(x[2 * (j * n + k)], x[2 * (j * n + k) + 1])).collect())
        .collect();
    let structured = Structured::new(vec![0.0; 2 * n])
        .with_noise(0, vec![1.0; 2 * n])
        .with_nuisances(&complex_columns(&columns), &vec![1.0; 2 * q]);
    let model = Linear(crate::problems::design("large/x", 2 * n, p));
    let parameters = Parameters::new((0..p).map(|i| normal(&format!("a{i}"), 0.0, 1.0)).collect()).unwrap();
    for mode in [NoiseMode::Fixed { sd: 0.5 }, NoiseMode::Floated] {
        let group = NoiseGroup { name: "noise".into(), unit: "1".into(), mode };
        let observation =
            Observation::new("sweep", numbers("large/y", 2 * n)).with_structure(structured.clone());
        let data = Data::new(vec![observation], vec![group]).unwrap();
        let posterior = Posterior::new(&model, &data, &parameters).unwrap();
        // The best of seven: other work on the machine is no property of the code.
        let mut best = f64::INFINITY;
        for k in 0..7 {
            let mut z = vec![0.1 + 0.01 * f64::from(k); p];
            z.resize(posterior.size(), -0.7);
            let start = Instant::now();
            let energy = posterior.evaluate(&z, Order::Second).unwrap();
            best = best.min(start.elapsed().as_secs_f64());
            assert!(energy.value.is_finite());
        }
        println!("{mode:?}: value, gradient and Hessian in {best:.3} s");
        assert!(best < 0.3, "{mode:?}: {best} s");
    }
}
