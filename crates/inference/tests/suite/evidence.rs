//! Evidence against values known from closed forms and quadrature: `fixtures/reference/evidence.toml`.

use crate::problems::{Linear, normal, numbers};
use approx::{assert_abs_diff_eq, assert_relative_eq};
use rijke_inference::*;
use rijke_numerics::{Cholesky, Matrix, Order, Streams};
use std::f64::consts::PI;

fn case(name: &str) -> toml::Table {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/reference/evidence.toml");
    let file: toml::Table = std::fs::read_to_string(path).unwrap().parse().unwrap();
    let cases = file["case"].as_array().unwrap().clone();
    cases.iter().find(|c| c["name"].as_str() == Some(name)).unwrap().as_table().unwrap().clone()
}

fn list(case: &toml::Table, key: &str) -> Vec<f64> {
    match &case[key] {
        toml::Value::Array(a) => a.iter().map(number).collect(),
        single => vec![number(single)],
    }
}

fn number(value: &toml::Value) -> f64 {
    value.as_float().or_else(|| value.as_integer().map(|i| i as f64)).unwrap()
}

/// The corrected evidence must lie within four of its own standard errors wherever k-hat is good.
fn corrected_is_close(objective: &dyn Objective, proposal: &Gaussian, exact: f64, what: &str) {
    let corrected = importance(objective, proposal, 4000, Streams::new(5)).unwrap();
    let miss = (corrected.ln_marginal - exact).abs();
    assert!(
        !corrected.good() || miss <= 4.0 * corrected.standard_error + 1e-9,
        "{what}: {corrected:?} against {exact}"
    );
}

#[test]
fn oracle_correlated_gaussian_in_a_box() {
    let reference = case("gauss3d_box");
    let covariance = Matrix::from_fn(3, 3, |i, j| if i == j { 1.0 } else { 0.95 });
    let data =
        Data::new(vec![Observation::new("x", vec![-1.0, 0.0, 1.0]).with_floor(covariance)], vec![]).unwrap();
    let parameter = |name: &str| {
        let prior = Prior::Uniform { low: -10.0, high: 10.0 };
        Parameter::new(name, name, "1", prior).in_coordinates(Coordinates::Natural)
    };
    let parameters = Parameters::new(vec![parameter("x"), parameter("y"), parameter("z")]).unwrap();
    let model = Linear(Matrix::identity(3));
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let fit = posterior.map(&MapOptions::default()).unwrap();
    let evidence = posterior.laplace(&fit).unwrap().evidence;
    assert_abs_diff_eq!(evidence.ln_marginal, list(&reference, "laplace")[0], epsilon = 1e-8);
    let gaussian = Gaussian::at(&posterior, &fit.working).unwrap();
    corrected_is_close(&posterior, &gaussian, list(&reference, "lnz")[0], "gauss3d_box");
}

/// Residuals 1 - x and 10 (y - x^2) of Rosenbrock's valley.
struct Rosenbrock;

impl Forward for Rosenbrock {
    fn predict(&self, a: &[f64], _: Order) -> Result<Prediction, ForwardError> {
        let (x, y) = (a[0], a[1]);
        let rows = [[-1.0, 0.0], [-20.0 * x, 10.0]];
        Ok(Prediction {
            values: vec![1.0 - x, 10.0 * (y - x * x)],
            jacobian: Matrix::from_fn(2, 2, |i, j| rows[i][j]),
            curvature: vec![0.0, 0.0, 0.0, -20.0, 0.0, 0.0],
        })
    }
}

#[test]
fn oracle_rosenbrock_valley() {
    let reference = case("rosenbrock2d");
    let data =
        Data::new(vec![Observation::new("r", vec![0.0; 2]).with_floor(Matrix::identity(2))], vec![]).unwrap();
    let parameter = |name: &str| {
        let prior = Prior::Uniform { low: -10.0, high: 10.0 };
        Parameter::new(name, name, "1", prior).in_coordinates(Coordinates::Natural)
    };
    let parameters = Parameters::new(vec![parameter("x"), parameter("y")]).unwrap();
    let posterior = Posterior::new(&Rosenbrock, &data, &parameters).unwrap();
    let fit = posterior.map(&MapOptions::default().from(&[-1.2, 1.0])).unwrap();
    // The reference leaves the two factors 1/sqrt(2 pi) of the noise out of its likelihood.
    let shift = (2.0 * PI).ln();
    let evidence = posterior.laplace(&fit).unwrap().evidence;
    assert_abs_diff_eq!(evidence.ln_marginal + shift, list(&reference, "laplace")[0], epsilon = 1e-8);
    let gaussian = Gaussian::at(&posterior, &fit.working).unwrap();
    corrected_is_close(&posterior, &gaussian, list(&reference, "lnz")[0] - shift, "rosenbrock2d");
}

/// J = t - n ln t, or the same in z = ln t with the Jacobian.
struct Factorial {
    n: f64,
    logarithmic: bool,
}

impl Objective for Factorial {
    fn size(&self) -> usize {
        1
    }

    fn evaluate(&self, z: &[f64], _: Order) -> Result<Energy, InferenceError> {
        let (n, x) = (self.n, z[0]);
        let [value, slope, curvature] = if self.logarithmic {
            [x.exp() - (n + 1.0) * x, x.exp() - n - 1.0, x.exp()]
        } else if x > 0.0 {
            [x - n * x.ln(), 1.0 - n / x, n / (x * x)]
        } else {
            return Err(InferenceError::NotFinite { value: f64::INFINITY, at: self.named_point(z) });
        };
        let hessian = Matrix::diagonal(&[curvature]);
        Ok(Energy { value, gradient: vec![slope], hessian, gauss_newton: None })
    }
}

#[test]
fn oracle_stirling_in_two_coordinates() {
    let reference = case("gamma_stirling");
    for (k, n) in list(&reference, "n").into_iter().enumerate() {
        let exact = list(&reference, "lnz")[k];
        for logarithmic in [false, true] {
            let objective = Factorial { n, logarithmic };
            let start = if logarithmic { 0.0 } else { 1.0 };
            let minimum = minimise(&objective, &[start], &TrustRegion::default()).unwrap();
            assert!(minimum.stop.converged());
            let gaussian = Gaussian::at(&objective, &minimum.z).unwrap();
            let expected = if logarithmic {
                exact + list(&reference, "laplace_err_in_ln_t")[k]
            } else {
                list(&reference, "laplace_in_t")[k]
            };
            assert_abs_diff_eq!(gaussian.ln_integral, expected, epsilon = 1e-8);
            corrected_is_close(&objective, &gaussian, exact, &format!("{n}! ({logarithmic})"));
        }
    }
}

#[test]
fn oracle_underdetermined_ridge() {
    let reference = case("ridge_underdetermined");
    let model = Linear(Matrix::from_fn(1, 2, |_, _| 1.0));
    let observation = Observation::new("d", vec![1.5]).with_floor(Matrix::diagonal(&[0.01]));
    let data = Data::new(vec![observation], vec![]).unwrap();
    for (k, sd) in list(&reference, "S").into_iter().enumerate() {
        let parameters = Parameters::new(vec![normal("a", 0.0, sd), normal("b", 0.0, sd)]).unwrap();
        let posterior = Posterior::new(&model, &data, &parameters).unwrap();
        let laplace = posterior.laplace(&posterior.map(&MapOptions::default()).unwrap()).unwrap();
        assert_abs_diff_eq!(laplace.evidence.ln_marginal, list(&reference, "lnz")[k], epsilon = 1e-10);
        assert_abs_diff_eq!(laplace.parameters[0], list(&reference, "posterior_mean")[k], epsilon = 1e-10);
        let covariance = &laplace.physical_covariance;
        assert_abs_diff_eq!(covariance[(0, 0)], list(&reference, "posterior_var")[k], epsilon = 1e-9);
        assert_abs_diff_eq!(covariance[(1, 0)], list(&reference, "posterior_cov")[k], epsilon = 1e-9);
    }
}

#[test]
fn oracle_polynomial_ladder() {
    let reference = case("poly_ladder");
    let t: Vec<f64> = (0..21).map(|j| -1.0 + 0.1 * f64::from(j)).collect();
    let y: Vec<f64> = t
        .iter()
        .enumerate()
        .map(|(j, t)| 1.0 + 2.0 * t - 3.0 * t * t + 0.1 * (7.0 * j as f64 + 1.0).sin())
        .collect();
    let observation = Observation::new("y", y).with_independent_noise(0, &(0..21).collect::<Vec<_>>());
    let data = Data::new(vec![observation], vec![NoiseGroup::fixed("noise", "1", 0.1)]).unwrap();
    let mut entries = Vec::new();
    for (k, degree) in list(&reference, "degree").into_iter().enumerate() {
        let p = degree as usize + 1;
        let model = Linear(Matrix::from_fn(21, p, |j, i| t[j].powi(i as i32)));
        let parameters =
            Parameters::new((0..p).map(|i| normal(&format!("a{i}"), 0.0, 2.0)).collect()).unwrap();
        let posterior = Posterior::new(&model, &data, &parameters).unwrap();
        let evidence = posterior.laplace(&posterior.map(&MapOptions::default()).unwrap()).unwrap().evidence;
        assert_abs_diff_eq!(evidence.ln_marginal, list(&reference, "lnz")[k], epsilon = 1e-8);
        assert_abs_diff_eq!(
            evidence.ln_best_fit,
            list(&reference, "ln_best_fit_likelihood")[k],
            epsilon = 1e-8
        );
        assert_abs_diff_eq!(evidence.ln_occam, list(&reference, "ln_occam_factor")[k], epsilon = 1e-8);
        entries.push(Entry {
            name: format!("degree {degree}"),
            parameters: p,
            ln_prior_weight: 0.0,
            outcome: Ok(evidence),
            warnings: Vec::new(),
        });
    }
    assert_eq!(rank(entries).models[0].entry.name, "degree 2");
}

/// The prior of a noise may lie far below the measured errors, where J hardly depends on it, and the data
/// ask for one above them: the larger maximum is found, whatever the median.
#[test]
fn oracle_an_inferred_noise_whose_median_lies_far_below_against_quadrature() {
    let (n, floor) = (12, 0.01);
    let y = numbers("below", n);
    let x = Matrix::from_fn(n, 1, |_, _| 1.0);
    for (median, ln_sd) in [(1e-4, 2.0), (1e-3, 2.0), (1e-2, 1.5), (1.0, 1.0)] {
        let observation = Observation::new("all", y.clone())
            .with_independent_noise(0, &(0..n).collect::<Vec<_>>())
            .with_floor(Matrix::diagonal(&vec![floor; n]));
        let data =
            Data::new(vec![observation], vec![NoiseGroup::inferred("noise", "V", median, ln_sd)]).unwrap();
        let parameters = Parameters::new(vec![normal("a", 0.0, 0.5)]).unwrap();
        let model = Linear(x.clone());
        let posterior = Posterior::new(&model, &data, &parameters).unwrap();
        let fit = posterior.map(&MapOptions::default()).unwrap();
        assert!(fit.stop.converged() && fit.noise[0].sd > 0.3, "{median}: {:?}", fit.noise);
        let found = posterior.laplace(&fit).unwrap().evidence.ln_marginal;
        // The integral over ln sd, by the trapezoidal rule; over a in closed form.
        let (low, step) = ((1e-8_f64).ln(), 0.01);
        let ln = |k: usize| {
            let t = low + step * k as f64;
            let variance = (2.0 * t).exp() + floor;
            let all = Matrix::from_fn(n, n, |i, j| 0.25 + if i == j { variance } else { 0.0 });
            let factor = Cholesky::new(&all).unwrap();
            let square: f64 = factor.whiten(&y).iter().map(|w| w * w).sum();
            let tau = std::f64::consts::TAU;
            let prior = -0.5 * ((t - median.ln()) / ln_sd).powi(2) - ln_sd.ln() - 0.5 * tau.ln();
            prior - 0.5 * (square + factor.ln_det() + n as f64 * tau.ln())
        };
        let all: Vec<f64> = (0..2200).map(ln).collect();
        let most = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let exact = most + (step * all.iter().map(|v| (v - most).exp()).sum::<f64>()).ln();
        assert!((found - exact).abs() < 0.1, "{median}: {found} for {exact}");
    }
}

/// (a b, a + b^2, a^2/2).
struct Bent;

impl Forward for Bent {
    fn predict(&self, x: &[f64], _: Order) -> Result<Prediction, ForwardError> {
        let (a, b) = (x[0], x[1]);
        Ok(Prediction {
            values: vec![a * b, a + b * b, 0.5 * a * a],
            jacobian: Matrix::from_fn(3, 2, |i, j| [[b, a], [1.0, 2.0 * b], [a, 0.0]][i][j]),
            curvature: vec![0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 1.0, 0.0, 0.0],
        })
    }
}

#[test]
fn exact_the_size_of_second_derivatives_is_an_eigenvalue() {
    let observation = Observation::new("bent", vec![1.5, 0.2, 1.1]).with_independent_noise(0, &[0, 1, 2]);
    let data = Data::new(vec![observation], vec![NoiseGroup::fixed("noise", "1", 0.3)]).unwrap();
    let parameters = Parameters::new(vec![normal("a", 1.0, 1.0), normal("b", 1.0, 0.5)]).unwrap();
    let posterior = Posterior::new(&Bent, &data, &parameters).unwrap();
    // The larger root in modulus of det(K - x G) = 0.
    let root = |k: &Matrix, g: &Matrix| {
        let det = |m: &Matrix| m[(0, 0)] * m[(1, 1)] - m[(0, 1)] * m[(1, 0)];
        let mixed = k[(0, 0)] * g[(1, 1)] + k[(1, 1)] * g[(0, 0)] - 2.0 * k[(0, 1)] * g[(0, 1)];
        let (half, product) = (0.5 * mixed / det(g), det(k) / det(g));
        half.abs() + (half * half - product).sqrt()
    };
    let newton = posterior.laplace(&posterior.map(&MapOptions::default()).unwrap()).unwrap();
    let expected = root(&newton.curvature, &newton.gauss_newton.plus(1.0, &newton.prior));
    assert!(expected > 0.05, "{expected}");
    assert_relative_eq!(newton.curvature_ratio(), expected, max_relative = 1e-10);
    let fit = posterior.map(&MapOptions::bfgs()).unwrap();
    let bfgs = posterior.laplace(&fit).unwrap();
    let expected = root(&fit.search_hessian.plus(-1.0, &bfgs.hessian), &bfgs.hessian);
    assert_relative_eq!(bfgs.bfgs_distance.unwrap(), expected, max_relative = 1e-8);
}
