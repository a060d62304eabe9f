//! Exact and Monte-Carlo tests of the analysis, on linear-Gaussian problems whose answer is known.

mod forecast;

use super::moments::centred;
use super::*;
use approx::assert_abs_diff_eq;
use rijke_numerics::{Cholesky, Matrix, Streams, lu_solve};

/// A prior ensemble, a linear observation H, and full noise, with numbers of no special shape.
struct Problem {
    ensemble: Ensemble,
    operator: Matrix,
    measured: Vec<f64>,
    noise: Matrix,
}

fn problem(members: usize, variables: usize, data: usize) -> Problem {
    let mut stream = Streams::new(5).stream("problem");
    let mix = forcing::normal_matrix(variables, variables, &mut stream);
    let rows = forcing::normal_matrix(members, variables, &mut stream).product(&mix);
    let half = forcing::normal_matrix(data, data, &mut stream);
    Problem {
        ensemble: Ensemble::new(rows).unwrap(),
        operator: forcing::normal_matrix(data, variables, &mut stream),
        measured: forcing::normal_matrix(1, data, &mut stream).row(0).to_vec(),
        noise: half.product(&half.transpose()).plus(0.3, &Matrix::identity(data)),
    }
}

/// Kalman's update of a mean and covariance, written out.
fn kalman(mean: &[f64], p: &Matrix, h: &Matrix, r: &Matrix, y: &[f64]) -> (Vec<f64>, Matrix) {
    let ph = p.product(&h.transpose());
    let s = h.product(&ph).plus(1.0, r);
    let departure: Vec<f64> = h.times(mean).iter().zip(y).map(|(m, y)| y - m).collect();
    let pull = ph.times(&lu_solve(&s, &departure).unwrap());
    let inverse = Cholesky::new(&s).unwrap().inverse();
    let covariance = p.plus(-1.0, &ph.product(&inverse).product(&ph.transpose()));
    (mean.iter().zip(pull).map(|(m, d)| m + d).collect(), covariance)
}

fn analyse(problem: &Problem, scheme: Scheme) -> (Ensemble, Innovation) {
    let mut ensemble = problem.ensemble.clone();
    let predicted = ensemble.members().product(&problem.operator.transpose());
    let noise = NoiseCovariance::Full(problem.noise.clone());
    let observed = EnsembleData { predicted: &predicted, measured: &problem.measured, noise: &noise };
    let innovation = ensemble.analyse(&observed, scheme, &mut Streams::new(9).stream("analysis")).unwrap();
    (ensemble, innovation)
}

fn assert_same_moments(a: &Ensemble, mean: &[f64], covariance: &Matrix, tolerance: f64) {
    for (x, y) in a.mean().iter().zip(mean) {
        assert_abs_diff_eq!(*x, *y, epsilon = tolerance);
    }
    for (x, y) in a.covariance().as_slice().iter().zip(covariance.as_slice()) {
        assert_abs_diff_eq!(*x, *y, epsilon = tolerance);
    }
}

#[test]
fn exact_square_root_is_kalman_of_the_sample_moments() {
    // More members than data, and more data than members: both spectral forms.
    for (members, variables, data) in [(30, 6, 4), (7, 5, 12), (12, 20, 12)] {
        let p = problem(members, variables, data);
        let (mean, covariance) =
            kalman(&p.ensemble.mean(), &p.ensemble.covariance(), &p.operator, &p.noise, &p.measured);
        for scheme in [Scheme::SquareRoot, Scheme::RotatedSquareRoot] {
            let (after, innovation) = analyse(&p, scheme);
            assert_same_moments(&after, &mean, &covariance, 2e-12);
            let s = p
                .operator
                .product(&p.ensemble.covariance())
                .product(&p.operator.transpose())
                .plus(1.0, &p.noise);
            let chi = Cholesky::new(&s).unwrap().inverse().quadratic(&innovation.values);
            assert_abs_diff_eq!(innovation.chi_squared, chi, epsilon = 1e-10 * chi);
        }
        let (perturbed, _) = analyse(&p, Scheme::Stochastic);
        for (x, y) in perturbed.mean().iter().zip(&mean) {
            assert_abs_diff_eq!(*x, *y, epsilon = 2e-12);
        }
    }
}

#[test]
fn exact_units_order_and_batches_change_nothing() {
    let p = problem(20, 5, 6);
    let variances: Vec<f64> = (0..6).map(|j| 0.2 + 0.1 * j as f64).collect();
    let run = |scale: f64, order: &[usize], batches: &[std::ops::Range<usize>]| {
        let mut ensemble = p.ensemble.clone();
        for batch in batches {
            let keep = &order[batch.clone()];
            let all = ensemble.members().product(&p.operator.transpose());
            let predicted = Matrix::from_fn(ensemble.size(), keep.len(), |i, k| scale * all[(i, keep[k])]);
            let measured: Vec<f64> = keep.iter().map(|&j| scale * p.measured[j]).collect();
            let noise =
                NoiseCovariance::Independent(keep.iter().map(|&j| scale * scale * variances[j]).collect());
            let observed = EnsembleData { predicted: &predicted, measured: &measured, noise: &noise };
            let mut stream = Streams::new(0).stream("none");
            ensemble.analyse(&observed, Scheme::SquareRoot, &mut stream).unwrap();
        }
        ensemble
    };
    let plain = run(1.0, &[0, 1, 2, 3, 4, 5], std::slice::from_ref(&(0..6)));
    let (mean, covariance) = (plain.mean(), plain.covariance());
    assert_same_moments(
        &run(1e6, &[0, 1, 2, 3, 4, 5], std::slice::from_ref(&(0..6))),
        &mean,
        &covariance,
        1e-12,
    );
    assert_same_moments(
        &run(1.0, &[3, 5, 0, 2, 1, 4], std::slice::from_ref(&(0..6))),
        &mean,
        &covariance,
        1e-12,
    );
    assert_same_moments(&run(1.0, &[0, 1, 2, 3, 4, 5], &[0..2, 2..3, 3..6]), &mean, &covariance, 1e-12);
}

#[test]
fn exact_smoother_with_any_coefficients_is_the_single_update_if_linear() {
    let p = problem(25, 4, 5);
    let (mean, covariance) =
        kalman(&p.ensemble.mean(), &p.ensemble.covariance(), &p.operator, &p.noise, &p.measured);
    let smoother = Smoother {
        coefficients: vec![300.0, 60.0, 12.0, 1.0 / (1.0 - 1.0 / 300.0 - 1.0 / 60.0 - 1.0 / 12.0)],
    };
    for smoother in [Smoother::default(), smoother] {
        let model = |row: &[f64]| Ok::<_, std::convert::Infallible>(p.operator.times(row));
        let noise = NoiseCovariance::Full(p.noise.clone());
        let smoothed =
            smooth(p.ensemble.clone(), &p.measured, &noise, &smoother, &Streams::new(1), model).unwrap();
        assert_same_moments(&smoothed.ensemble, &mean, &covariance, 1e-11);
        assert_eq!(smoothed.passes.len(), 4);
    }
    let bad = Smoother { coefficients: vec![2.0, 3.0] };
    let model = |row: &[f64]| Ok::<_, std::convert::Infallible>(p.operator.times(row));
    let noise = NoiseCovariance::Full(p.noise.clone());
    let refused = smooth(p.ensemble.clone(), &p.measured, &noise, &bad, &Streams::new(1), model);
    assert!(matches!(refused, Err(EnsembleError::Coefficients { .. })));
}

#[test]
fn order_stochastic_error_falls_with_the_root_of_the_members() {
    // One variable, prior N(0, 1), datum 1 with variance 0.5: posterior N(2/3, 1/3).
    let error = |members: usize| {
        let runs = 40;
        let squares: f64 = (0..runs)
            .map(|seed| {
                let mut stream = Streams::new(seed).stream("mc");
                let mut ensemble = Ensemble::standard_normal(members, 1, &mut stream).unwrap();
                let predicted = ensemble.members().clone();
                let noise = NoiseCovariance::Independent(vec![0.5]);
                let observed = EnsembleData { predicted: &predicted, measured: &[1.0], noise: &noise };
                ensemble.analyse(&observed, Scheme::Stochastic, &mut stream).unwrap();
                (ensemble.mean()[0] - 2.0 / 3.0).powi(2) + (ensemble.covariance()[(0, 0)] - 1.0 / 3.0).powi(2)
            })
            .sum();
        (squares / runs as f64).sqrt()
    };
    let errors = [error(100), error(1000), error(10_000)];
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log10();
        assert!((order - 0.5).abs() < 0.15, "errors {errors:?}");
    }
}

#[test]
fn exact_orthogonal_forcing_has_the_stated_moments() {
    let mut stream = Streams::new(2).stream("forcing");
    let (_, mut against) = centred(&forcing::normal_matrix(20, 6, &mut stream));
    for i in 0..20 {
        against[(i, 5)] = against[(i, 0)] - against[(i, 1)]; // dependent: must not count
    }
    let draws = orthogonal_forcing(&against, &[0.25, 4.0], 1e-10, &mut stream).unwrap();
    let ensemble = Ensemble::new(draws.clone()).unwrap();
    assert_same_moments(&ensemble, &[0.0, 0.0], &Matrix::diagonal(&[0.25, 4.0]), 1e-13);
    assert!(against.transpose().product(&draws).as_slice().iter().all(|v| v.abs() < 1e-12));
    let few = Matrix::from_fn(4, 3, |i, j| f64::from(u8::from(i == j)));
    let refused = orthogonal_forcing(&few, &[1.0], 1e-10, &mut stream);
    assert_eq!(refused, Err(EnsembleError::TooFewMembers { have: 4, need: 5 }));
}

#[test]
fn exact_static_parameters_with_a_forced_nuisance_stay_calibrated() {
    // flow.md 6.3: 6 static parameters, one AR(1) nuisance state, 2000 analyses, 100 members. The exact
    // answer is the Kalman filter's; with orthogonal forcing the square root matches its sd, with plain
    // forcing it collapses.
    let (steps, members, parameters) = (1000, 100, 6);
    let (decay, variance) = (0.99_f64, 1.0_f64);
    let run = |seed: u64, orthogonal: bool| {
        let streams = Streams::new(seed);
        let mut stream = streams.stream("toy");
        let truth = forcing::normal_matrix(1, parameters + 1, &mut stream).row(0).to_vec();
        let mut nuisance = truth[parameters];
        let mut ensemble = Ensemble::standard_normal(members, parameters + 1, &mut stream).unwrap();
        let drive = variance * (1.0 - decay * decay);
        let (mut p, mut mean) = (Matrix::identity(parameters + 1), vec![0.0; parameters + 1]);
        for _ in 0..steps {
            let fresh = forcing::normal_matrix(1, 1, &mut stream)[(0, 0)];
            nuisance = decay * nuisance + drive.sqrt() * fresh;
            let against = ensemble.anomalies();
            let noise = if orthogonal {
                orthogonal_forcing(&against, &[drive], 1e-8, &mut stream).unwrap()
            } else {
                let raw = forcing::normal_matrix(members, 1, &mut stream);
                Matrix::from_fn(members, 1, |i, _| drive.sqrt() * raw[(i, 0)])
            };
            for i in 0..members {
                let v = &mut ensemble.members_mut()[(i, parameters)];
                *v = decay * *v + noise[(i, 0)];
            }
            for i in 0..=parameters {
                p[(i, parameters)] *= decay;
                p[(parameters, i)] *= decay;
            }
            p[(parameters, parameters)] += drive;
            mean[parameters] *= decay;
            let h = forcing::normal_matrix(2, parameters + 1, &mut stream);
            let mut state = truth.clone();
            state[parameters] = nuisance;
            let errors = forcing::normal_matrix(1, 2, &mut stream);
            let measured: Vec<f64> =
                h.times(&state).iter().enumerate().map(|(j, y)| y + errors[(0, j)]).collect();
            let predicted = ensemble.members().product(&h.transpose());
            let noise = NoiseCovariance::Independent(vec![1.0; 2]);
            let observed = EnsembleData { predicted: &predicted, measured: &measured, noise: &noise };
            ensemble.analyse(&observed, Scheme::SquareRoot, &mut stream).unwrap();
            (mean, p) = kalman(&mean, &p, &h, &Matrix::identity(2), &measured);
        }
        let spread = ensemble.spread();
        let ratio: f64 =
            (0..parameters).map(|k| spread[k] / p[(k, k)].sqrt()).sum::<f64>() / parameters as f64;
        let inside =
            (0..parameters).filter(|&k| (ensemble.mean()[k] - truth[k]).abs() < 2.0 * spread[k]).count();
        (ratio, inside as f64 / parameters as f64)
    };
    let average = |orthogonal: bool| {
        let seeds = 10;
        let (ratio, inside) = (0..seeds)
            .map(|s| run(s, orthogonal))
            .fold((0.0, 0.0), |(a, b), (r, i)| (a + r / seeds as f64, b + i / seeds as f64));
        (ratio, inside)
    };
    let (ratio, inside) = average(true);
    assert!(
        (0.95..1.05).contains(&ratio) && inside > 0.90,
        "orthogonal: sd ratio {ratio}, coverage {inside}"
    );
    let (plain_ratio, plain_inside) = average(false);
    assert!(plain_ratio < 0.85 && plain_inside < inside, "plain: {plain_ratio}, {plain_inside}");
}

#[test]
fn exact_diagnostics_of_white_and_correlated_innovations() {
    let mut stream = Streams::new(8).stream("white");
    let noise = forcing::normal_matrix(4000, 1, &mut stream);
    let (mut white, mut red, mut state) = (Diagnostics::default(), Diagnostics::default(), 0.0);
    for i in 0..4000 {
        state = 0.5 * state + 0.75_f64.sqrt() * noise[(i, 0)];
        for (diagnostics, v) in [(&mut white, noise[(i, 0)]), (&mut red, state)] {
            let innovation = Innovation { values: vec![v], expected: vec![1.0], chi_squared: v * v };
            diagnostics.record(&innovation);
        }
    }
    assert!((white.chi_squared_per_datum() - 1.0).abs() < 4.0 * (2.0_f64 / 4000.0).sqrt());
    assert!(white.whiteness()[0].abs() < 4.0 / 4000_f64.sqrt());
    assert!((red.whiteness()[0] - 0.5).abs() < 0.06);
    assert_abs_diff_eq!(effective_rank(&Matrix::identity(5)).unwrap(), 5.0, epsilon = 1e-12);
    assert_abs_diff_eq!(effective_rank(&Matrix::from_fn(3, 3, |_, _| 2.0)).unwrap(), 1.0, epsilon = 1e-12);
}

#[test]
fn exact_bad_input_is_refused_with_numbers() {
    let mut ensemble = problem(6, 2, 1).ensemble;
    let predicted = Matrix::from_fn(6, 1, |i, _| i as f64);
    let mut run = |measured: &[f64], noise: NoiseCovariance| {
        let observed = EnsembleData { predicted: &predicted, measured, noise: &noise };
        ensemble.analyse(&observed, Scheme::SquareRoot, &mut Streams::new(1).stream("x"))
    };
    let shape = run(&[1.0, 2.0], NoiseCovariance::Independent(vec![1.0; 2]));
    assert!(matches!(shape, Err(EnsembleError::Shape { expected: 2, got: 1, .. })));
    assert!(matches!(run(&[1.0], NoiseCovariance::Independent(vec![0.0])), Err(EnsembleError::Dense(_))));
    let nan = Matrix::from_fn(3, 2, |i, j| if (i, j) == (1, 1) { f64::NAN } else { 0.0 });
    assert_eq!(Ensemble::new(nan), Err(EnsembleError::NotFinite { member: 1, variable: 1 }));
}
