//! Linear models with Gaussian priors: everything is known in closed form.

use crate::problems::{Linear, design, normal, numbers};
use approx::assert_relative_eq;
use rijke_inference::*;
use rijke_numerics::{Cholesky, Matrix, Streams};

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
        // D ~ N(0, sd^2 I + X S X'), by the Cholesky factor of an m x m matrix that the fast path never
        // forms.
        let marginal = Matrix::from_fn(m, m, |i, j| {
            let signal: f64 = (0..p).map(|k| x[(i, k)] * x[(j, k)] * prior_sd[k].powi(2)).sum();
            signal + if i == j { sd * sd } else { 0.0 }
        });
        let gain = Cholesky::new(&marginal).unwrap().solve(&y);
        for options in [MapOptions::default(), MapOptions::bfgs()] {
            let fit = posterior.map(&options).unwrap();
            assert!(fit.stop.converged(), "{p}: {:?}", fit.stop);
            let laplace = posterior.laplace(&fit).unwrap();
            // BFGS ends at 1e-12 nats, so its evidence is off by that and its mean by 1e-6 sd; Newton's by
            // rounding.
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

/// m data in blocks of `block`, with p parameters of prior sd 0.5.
fn problem(m: usize, p: usize, block: usize, mode: NoiseGroup) -> (Matrix, Vec<f64>, Data, Parameters) {
    let (x, y) = (design("blocks/x", m, p), numbers("blocks/y", m));
    let observations = (0..m / block).map(|b| {
        let values = y[b * block..(b + 1) * block].to_vec();
        Observation::new(format!("{b}"), values).with_independent_noise(0, &(0..block).collect::<Vec<_>>())
    });
    let data = Data::new(observations.collect(), vec![mode]).unwrap();
    let parameters = Parameters::new((0..p).map(|i| normal(&format!("a{i}"), 0.0, 0.5)).collect()).unwrap();
    (x, y, data, parameters)
}

fn marginal(x: &Matrix, rows: &[usize], sd: f64) -> Matrix {
    let p = x.columns();
    Matrix::from_fn(rows.len(), rows.len(), |i, j| {
        let signal: f64 = (0..p).map(|k| 0.25 * x[(rows[i], k)] * x[(rows[j], k)]).sum();
        signal + if i == j { sd * sd } else { 0.0 }
    })
}

#[test]
fn exact_leave_one_out_and_prediction() {
    let (m, block, sd) = (24, 3, 0.4);
    let (x, y, data, parameters) = problem(m, 4, block, NoiseGroup::fixed("noise", "1", sd));
    let model = Linear(x.clone());
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let fit = posterior.map(&MapOptions::default()).unwrap();
    let laplace = posterior.laplace(&fit).unwrap();
    let all: Vec<usize> = (0..m).collect();
    let linear = posterior.linearised(&fit, &laplace).unwrap();
    for b in 0..m / block {
        let places: Vec<usize> = (b * block..(b + 1) * block).collect();
        let found = linear.left_out(&places).unwrap().ln_density;
        // ln p(block | rest) = ln p(all) - ln p(rest), both in closed form.
        let rest: Vec<usize> = all.iter().copied().filter(|i| i / block != b).collect();
        let others: Vec<f64> = rest.iter().map(|&i| y[i]).collect();
        let exact = ln_gaussian(&y, &marginal(&x, &all, sd)) - ln_gaussian(&others, &marginal(&x, &rest, sd));
        assert_relative_eq!(found, exact, epsilon = 1e-10);
    }
    let new = design("blocks/new", 2, 4);
    let predicted = laplace.predict(&Linear(new.clone())).unwrap();
    let gain = Cholesky::new(&marginal(&x, &all, sd)).unwrap();
    let cross = |r: usize| -> Vec<f64> {
        (0..m).map(|i| (0..4).map(|k| 0.25 * new[(r, k)] * x[(i, k)]).sum()).collect()
    };
    for r in 0..2 {
        let mean: f64 = cross(r).iter().zip(gain.solve(&y)).map(|(c, g)| c * g).sum();
        assert_relative_eq!(predicted.mean[r], mean, epsilon = 1e-10);
        for s in 0..2 {
            let prior: f64 = (0..4).map(|k| 0.25 * new[(r, k)] * new[(s, k)]).sum();
            let learnt: f64 = cross(r).iter().zip(gain.solve(&cross(s))).map(|(c, g)| c * g).sum();
            assert_relative_eq!(predicted.covariance[(r, s)], prior - learnt, epsilon = 1e-10);
        }
    }
}

#[test]
fn exact_density_of_each_datum_given_all_others_and_the_parameters() {
    let (m, block, p) = (12, 4, 3);
    let (x, y) = (design("given/x", m, p), numbers("given/y", m));
    // Neighbours share most of their error.
    let covariance = Matrix::from_fn(block, block, |i, j| 0.2 * 0.7_f64.powi(i.abs_diff(j) as i32));
    let observations = (0..m / block).map(|b| {
        let values = y[b * block..(b + 1) * block].to_vec();
        Observation::new(format!("{b}"), values).with_floor(covariance.clone())
    });
    let data = Data::new(observations.collect(), Vec::new()).unwrap();
    let parameters = Parameters::new((0..p).map(|i| normal(&format!("a{i}"), 0.0, 0.5)).collect()).unwrap();
    let model = Linear(x.clone());
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let fit = posterior.map(&MapOptions::default()).unwrap();
    let linear = posterior.linearised(&fit, &posterior.laplace(&fit).unwrap()).unwrap();
    let moved = [0.3, -0.2, 0.05];
    let at: Vec<f64> = fit.parameters.iter().zip(moved).map(|(a, d)| a + d).collect();
    let residual: Vec<f64> = (0..m).map(|i| y[i] - (0..p).map(|k| x[(i, k)] * at[k]).sum::<f64>()).collect();
    let found = linear.ln_densities(&moved);
    assert_eq!(found.len(), m);
    for i in 0..m {
        let own: Vec<usize> = (0..block).collect();
        let others: Vec<usize> = own.iter().copied().filter(|k| *k != i % block).collect();
        let of = |within: &[usize]| -> f64 {
            let r: Vec<f64> = within.iter().map(|k| residual[i / block * block + k]).collect();
            ln_gaussian(&r, &covariance.select(within))
        };
        assert_relative_eq!(found[i], of(&own) - of(&others), epsilon = 1e-10);
    }
}

/// Other data move the parameters and the evidence of a linear model as a new fit does.
#[test]
fn exact_other_data_move_a_linear_model_as_a_new_fit() {
    let (m, sd) = (24, 0.4);
    let (x, y, data, parameters) = problem(m, 4, 3, NoiseGroup::fixed("noise", "1", sd));
    let model = Linear(x.clone());
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let fit = posterior.map(&MapOptions::default()).unwrap();
    let laplace = posterior.laplace(&fit).unwrap();
    let linear = posterior.linearised(&fit, &laplace).unwrap();
    let change: Vec<f64> = (0..m).map(|i| if i % 5 == 0 { 0.7 - 0.1 * i as f64 } else { 0.0 }).collect();
    let moved = linear.moved(&change);
    let all: Vec<usize> = (0..m).collect();
    let other: Vec<f64> = y.iter().zip(&change).map(|(y, d)| y + d).collect();
    let v = marginal(&x, &all, sd);
    assert_relative_eq!(moved.ln_evidence, ln_gaussian(&other, &v) - ln_gaussian(&y, &v), epsilon = 1e-9);
    // The posterior mean is the prior covariance, 1/4, times X' V^-1 y.
    let pull = Cholesky::new(&v).unwrap().solve(&change);
    for k in 0..4 {
        let step: f64 = (0..m).map(|i| 0.25 * x[(i, k)] * pull[i]).sum();
        assert_relative_eq!(moved.step[k], step, epsilon = 1e-9);
    }
    // The model is linear in its working coordinates.
    let step = [0.3, -0.2, 0.1, 0.05];
    for (i, more) in linear.predicts(&step).into_iter().enumerate() {
        let expected: f64 = (0..4).map(|k| x[(i, k)] * step[k]).sum();
        assert_relative_eq!(more, expected, epsilon = 1e-9);
    }
}

/// With the noise known, a further direction gains what the closed form of both evidences says.
#[test]
fn exact_a_further_direction_gains_the_difference_of_two_evidences() {
    let (m, sd) = (24, 0.4);
    let (x, y, data, parameters) = problem(m, 4, 3, NoiseGroup::fixed("noise", "1", sd));
    let model = Linear(x.clone());
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let fit = posterior.map(&MapOptions::default()).unwrap();
    let linear = posterior.linearised(&fit, &posterior.laplace(&fit).unwrap()).unwrap();
    let all: Vec<usize> = (0..m).collect();
    let without = marginal(&x, &all, sd);
    let more = design("a further direction", m, 1);
    let direction: Vec<f64> = (0..m).map(|i| more[(i, 0)] + x[(i, 1)]).collect();
    let told = linear.told(&direction).unwrap();
    assert!(told.left > 0.1 && told.left < 0.9, "{}", told.left);
    for observations in [1, 8] {
        let variance = told.prior_sd(observations).powi(2);
        let with = Matrix::from_fn(m, m, |i, j| without[(i, j)] + variance * direction[i] * direction[j]);
        let exact = ln_gaussian(&y, &with) - ln_gaussian(&y, &without);
        assert_relative_eq!(told.gain(told.drop[0], observations), exact, epsilon = 1e-10);
        assert_relative_eq!(told.drop[0], told.drop[1], epsilon = 1e-12);
    }
    // Draws of the predictive density have the covariance of scores that it says: one, for each.
    let mut stream = Streams::new(7).stream("draws");
    let squares = (0..4000).map(|_| {
        let pulls = linear.draw(&mut stream).pulls;
        (direction.iter().zip(&pulls).map(|(d, p)| d * p).sum::<f64>() * told.sd).powi(2)
    });
    let mean = squares.sum::<f64>() / 4000.0;
    assert!((mean - 1.0).abs() < 4.0 * (2.0_f64 / 4000.0).sqrt(), "{mean}");
    assert!(linear.told(&(0..m).map(|_| 0.0).collect::<Vec<_>>()).is_none());
}

/// Errors that data share beyond their covariance: directions are told as by the inverse of the whole
/// covariance, and draws have it.
#[test]
fn exact_shared_errors_beyond_the_covariance_are_allowed_for() {
    let (m, sd) = (24, 0.4);
    let (x, y, data, parameters) = problem(m, 4, 3, NoiseGroup::fixed("noise", "1", sd));
    let model = Linear(x.clone());
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let fit = posterior.map(&MapOptions::default()).unwrap();
    let alone = posterior.linearised(&fit, &posterior.laplace(&fit).unwrap()).unwrap();
    let shared = design("shared errors", m, 2);
    let columns: Vec<Vec<f64>> = (0..2).map(|k| (0..m).map(|i| shared[(i, k)]).collect()).collect();
    let linear = alone.with_shared(&columns).unwrap();
    let all: Vec<usize> = (0..m).collect();
    let whole = marginal(&x, &all, sd).plus(1.0, &shared.product(&shared.transpose()));
    let factor = Cholesky::new(&whole).unwrap();
    let (pulls, change) = (factor.solve(&y), numbers("change", m));
    for i in 0..m {
        assert_relative_eq!(linear.pulls()[i], pulls[i], epsilon = 1e-9);
    }
    // Half of a shared error, so that it has to be told from it.
    let more = numbers("a further direction", m);
    let direction: Vec<f64> = (0..m).map(|i| more[i] + 0.5 * shared[(i, 0)]).collect();
    let pulled = factor.solve(&direction);
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (told, before) = (linear.told(&direction).unwrap(), alone.told(&direction).unwrap());
    assert_relative_eq!(told.sd, product(&direction, &pulled).sqrt().recip(), epsilon = 1e-9);
    assert_relative_eq!(told.strength, product(&pulled, &y) * told.sd * told.sd, epsilon = 1e-9);
    assert!(told.sd > 1.05 * before.sd, "{} {}", told.sd, before.sd);
    let mut stream = Streams::new(7).stream("draws");
    let squares = (0..4000).map(|_| (product(&direction, &linear.draw(&mut stream).pulls) * told.sd).powi(2));
    let mean = squares.sum::<f64>() / 4000.0;
    assert!((mean - 1.0).abs() < 4.0 * (2.0_f64 / 4000.0).sqrt(), "{mean}");
    // What other data say of causes that stand in a covariance: S'P times the change, for each variance.
    let moved = linear.causes_moved(&columns, &[1.0, 0.5], &change);
    let pull = factor.solve(&change);
    assert_relative_eq!(moved[0], product(&columns[0], &pull), epsilon = 1e-9);
    assert_relative_eq!(moved[1], 0.25 * product(&columns[1], &pull), epsilon = 1e-9);
}

/// Causes that stand in the covariance of the data against the same as parameters: one joint posterior.
#[test]
fn oracle_causes_in_the_covariance_are_told_as_parameters_are() {
    let (m, sd, sds) = (24, 0.4, [1.0, 0.5]);
    let (x, y, _, parameters) = problem(m, 4, 3, NoiseGroup::fixed("noise", "1", sd));
    let shared = design("shared errors", m, 2);
    let columns: Vec<Vec<f64>> = (0..2).map(|k| (0..m).map(|i| shared[(i, k)]).collect()).collect();
    let scaled = Matrix::from_fn(m, 2, |i, k| sds[k] * shared[(i, k)]);
    let all: Vec<usize> = (0..m).collect();
    let noise = || vec![NoiseGroup::fixed("noise", "1", sd)];
    let observation = || Observation::new("all", y.clone()).with_independent_noise(0, &all);
    let floor = scaled.product(&scaled.transpose());
    let data = Data::new(vec![observation().with_floor(floor)], noise()).unwrap();
    let model = Linear(x.clone());
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let fit = posterior.map(&MapOptions::default()).unwrap();
    let laplace = posterior.laplace(&fit).unwrap();
    let causes = posterior.linearised(&fit, &laplace).unwrap().causes(&columns, &sds);
    let sigma = &laplace.physical_covariance;
    let slopes: Vec<f64> =
        parameters.list().iter().zip(&fit.working).map(|(p, z)| p.physical(*z)[1]).collect();
    let along = Matrix::from_fn(2, 4, |k, i| causes.along[(k, i)] / slopes[i]);
    let cross = along.product(sigma);
    let own = causes.given.plus(1.0, &cross.product(&along.transpose()));

    let wide = Linear(Matrix::from_fn(m, 6, |i, j| if j < 4 { x[(i, j)] } else { shared[(i, j - 4)] }));
    let explicit = (0..2).map(|k| normal(["u", "v"][k], 0.0, sds[k]));
    let explicit = Parameters::new(parameters.list().iter().cloned().chain(explicit).collect()).unwrap();
    let data = Data::new(vec![observation()], noise()).unwrap();
    let posterior = Posterior::new(&wide, &data, &explicit).unwrap();
    let fit = posterior.map(&MapOptions::default()).unwrap();
    let joint = posterior.laplace(&fit).unwrap().physical_covariance;
    for k in 0..2 {
        assert_relative_eq!(causes.mean[k], fit.parameters[4 + k], epsilon = 1e-8);
        (0..2).for_each(|l| assert_relative_eq!(own[(k, l)], joint[(4 + k, 4 + l)], epsilon = 1e-9));
        (0..4).for_each(|i| assert_relative_eq!(cross[(k, i)], joint[(4 + k, i)], epsilon = 1e-9));
    }
}

/// A noise that two others explain away, with no floor beside them: it is none, and the search ends.
#[test]
fn behaviour_a_floated_noise_that_others_explain_is_none() {
    let common = [1.0, -1.0, 2.0, -2.0, 0.6, -0.6, 1.4, -1.4];
    let own = [0.5, 0.5, -0.4, -0.4, 0.2, 0.2, -0.3, -0.3];
    let along = |a: f64, b: f64| Matrix::from_fn(2, 2, |i, j| [a, b][i] * [a, b][j]);
    let block = |k: usize| {
        Observation::new(format!("{k}"), vec![0.45 * common[k] + own[k], common[k]])
            .with_noise(0, Matrix::diagonal(&[1.0, 0.0]))
            .with_noise(1, Matrix::diagonal(&[0.0, 1.0]))
            .with_noise(2, along(0.4, 1.0))
    };
    let groups = ["first", "second", "shared"].map(|name| NoiseGroup::floated(name, "V")).to_vec();
    let data = Data::new((0..8).map(block).collect(), groups).unwrap();
    let parameters = Parameters::new(vec![normal("a", 0.0, 1.0)]).unwrap();
    let model = Linear(Matrix::from_fn(16, 1, |i, _| if i % 2 == 0 { 1.0 } else { 0.0 }));
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let fit = posterior.map(&MapOptions::default()).unwrap();
    assert!(fit.stop.converged(), "{:?} {:?}", fit.stop, fit.noise);
    let [_, second, shared] = [0, 1, 2].map(|k| fit.noise[k].sd);
    assert!(second < 1e-6 * shared, "{:?}", fit.noise);
    let rms = (common.iter().map(|c| c * c).sum::<f64>() / 8.0).sqrt();
    assert!((shared / rms - 1.0).abs() < 0.05, "{shared} {rms}");
}
