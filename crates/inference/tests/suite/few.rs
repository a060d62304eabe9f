//! What few data leave unknown of the noise that they choose.

use crate::problems::{Linear, normal, numbers};
use approx::assert_relative_eq;
use rand::RngExt;
use rijke_inference::*;
use rijke_numerics::{Cholesky, Matrix, Streams};

/// A constant and a slope from `n` data of one noise that floats, and a floor.
fn line(n: usize, floor: f64) -> (Linear, Data, Parameters) {
    let x = Matrix::from_fn(n, 2, |i, j| if j == 0 { 1.0 } else { i as f64 - 0.3 });
    let values = numbers("few", n);
    let all: Vec<usize> = (0..n).collect();
    let observation = Observation::new("all", values)
        .with_independent_noise(0, &all)
        .with_floor(Matrix::diagonal(&vec![floor; n]));
    let data = Data::new(vec![observation], vec![NoiseGroup::floated("noise", "V")]).unwrap();
    let parameters = Parameters::new(vec![normal("a", 0.0, 1e6), normal("b", 0.0, 1e6)]).unwrap();
    (Linear(x), data, parameters)
}

#[test]
fn exact_few_data_give_students_intervals() {
    // Half of Student's 95.45 % points (tables) with n - 2 degrees of freedom; Wallace's formula is 4 % off
    // at 2.
    for (n, half) in [(4, 4.527), (5, 3.307), (6, 2.869), (10, 2.366), (42, 2.064)] {
        let (model, data, parameters) = line(n, 1e-12);
        let posterior = Posterior::new(&model, &data, &parameters).unwrap();
        let fit = posterior.map(&MapOptions::default()).unwrap();
        let laplace = posterior.laplace(&fit).unwrap();
        let few = posterior.linearised(&fit, &laplace).unwrap().few();
        let ratio = n as f64 / (n as f64 - 2.0);
        let tolerance = if n == 4 { 0.05 } else { 0.02 };
        for factor in &few.parameters {
            assert_relative_eq!(*factor, ratio.sqrt() * 0.5 * half, max_relative = tolerance);
        }
        let [(0, [factor, spread])] = few.noises[..] else { panic!("{few:?}") };
        assert_relative_eq!(factor, ratio, max_relative = 1e-6);
        assert_relative_eq!(spread, 2.0 / (n as f64 - 2.0), max_relative = 1e-6);
    }
}

#[test]
fn exact_a_prior_of_the_noise_counts_as_data_of_it() {
    // n - 2 data tell (n - 2)/2 of ln variance, and the prior 1/(2 ln_sd)^2.
    let n = 6;
    for ln_sd in [0.1, 0.4, 2.0] {
        let (model, data, parameters) = line(n, 1e-12);
        let groups = vec![NoiseGroup::inferred("noise", "V", 0.5, ln_sd)];
        let data = Data::new(data.observations().to_vec(), groups).unwrap();
        let posterior = Posterior::new(&model, &data, &parameters).unwrap();
        let fit = posterior.map(&MapOptions::default()).unwrap();
        let few = posterior.linearised(&fit, &posterior.laplace(&fit).unwrap()).unwrap().few();
        let information = 0.5 * (n as f64 - 2.0) + 0.25 / (ln_sd * ln_sd);
        let [(0, [factor, spread])] = few.noises[..] else { panic!("{few:?}") };
        assert_relative_eq!(factor, 1.0 + 1.0 / information, max_relative = 1e-6);
        assert_relative_eq!(spread, 1.0 / information, max_relative = 1e-6);
        for parameter in &few.parameters {
            let expected = factor.sqrt() * student(2.0 * information);
            assert_relative_eq!(*parameter, expected, max_relative = 1e-6);
        }
    }
}

#[test]
fn exact_a_further_direction_with_its_noise_chosen_again() {
    // Sums of squares without and with it: n/2 ln of their ratio, and n/2 less n/2 of the ratio with the
    // noise as fitted.
    let n = 9;
    let (model, data, parameters) = line(n, 1e-14);
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let fit = posterior.map(&MapOptions::default()).unwrap();
    let direction: Vec<f64> = (0..n).map(|i| (i as f64 - 4.0).powi(2)).collect();
    let linear = posterior.linearised(&fit, &posterior.laplace(&fit).unwrap()).unwrap();
    let told = linear.told(&direction).unwrap();
    let values = numbers("few", n);
    let squares = |columns: usize| {
        let x = Matrix::from_fn(n, columns, |i, j| if j < 2 { model.0[(i, j)] } else { direction[i] });
        let best = Cholesky::new(&x.transpose().product(&x)).unwrap().solve(&x.transpose().times(&values));
        x.times(&best).iter().zip(&values).map(|(f, v)| (v - f).powi(2)).sum::<f64>()
    };
    let ratio = squares(3) / squares(2);
    assert!((0.05..0.95).contains(&ratio), "{ratio}");
    let half = 0.5 * n as f64;
    assert_relative_eq!(told.drop[0], half * (1.0 - ratio), max_relative = 1e-6);
    assert_relative_eq!(told.drop[1], -half * ratio.ln(), max_relative = 1e-6);
}

/// The restricted likelihood of a line, written out with dense matrices, and its second difference in ln
/// variance.
#[test]
fn oracle_what_few_data_leave_against_the_restricted_likelihood() {
    let (n, floor) = (7, 0.05);
    let (model, data, parameters) = line(n, floor);
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let fit = posterior.map(&MapOptions::default()).unwrap();
    let variance = fit.noise[0].sd.powi(2);
    assert!(variance > 0.5 * floor, "{variance}");
    let few = posterior.linearised(&fit, &posterior.laplace(&fit).unwrap()).unwrap().few();
    // Minus the expected restricted ln likelihood where the truth has this variance, at another: the data
    // enter by their mean square.
    let projected = |t: f64| {
        let information = Matrix::from_fn(2, 2, |i, j| {
            (0..n).map(|k| model.0[(k, i)] * model.0[(k, j)]).sum::<f64>() / (t + floor)
        });
        (information.clone(), Cholesky::new(&information).unwrap())
    };
    let cost = |ln: f64, truth: f64| {
        let total = ln.exp() + floor;
        let freedom = n as f64 - 2.0;
        let determinant = n as f64 * total.ln() + projected(ln.exp()).1.ln_det();
        0.5 * (determinant + freedom * (truth + floor) / total)
    };
    let (h, at) = (1e-3, variance.ln());
    // The truth is taken to be where the step goes.
    let step = few.noises[0].1[0];
    let (there, truth) = (at + step.ln(), variance * step);
    let curvature = (cost(there + h, truth) - 2.0 * cost(there, truth) + cost(there - h, truth)) / (h * h);
    assert_relative_eq!(few.noises[0].1[1], 1.0 / curvature, max_relative = 1e-4);
    // And the standard deviation of a parameter at a variance some way off, by which Satterthwaite's degrees
    // of freedom follow.
    let of = |ln: f64, k: usize| projected(ln.exp()).1.inverse()[(k, k)];
    for k in 0..2 {
        let slope = (of(at + h, k) - of(at - h, k)) / (2.0 * h);
        let (after, share) = (of(at, k) + slope * (step - 1.0), slope * step);
        let wanted = (after / of(at, k)).sqrt() * student(2.0 * after * after * curvature / (share * share));
        assert_relative_eq!(few.parameters[k], wanted, max_relative = 1e-4);
    }
}

/// The mean of `n` data of unit stated variance and a scatter of variance `scatter` beside it, whose noise
/// floats: how often ±2 sd hold the truth, and the largest factor on the sd.
fn mean_of(n: usize, scatter: f64, draws: usize) -> (f64, f64) {
    let model = Linear(Matrix::from_fn(n, 1, |_, _| 1.0));
    let parameters = Parameters::new(vec![normal("a", 0.0, 1e3)]).unwrap();
    let all: Vec<usize> = (0..n).collect();
    let mut stream = Streams::new(8).stream("few");
    let (mut inside, mut widest) = (0, 0.0_f64);
    for _ in 0..draws {
        let sd = (1.0 + scatter).sqrt();
        let values: Vec<f64> =
            (0..n).map(|_| sd * stream.sample::<f64, _>(rand_distr::StandardNormal)).collect();
        let observation =
            Observation::new("all", values).with_independent_noise(0, &all).with_floor(Matrix::identity(n));
        let data = Data::new(vec![observation], vec![NoiseGroup::floated("noise", "V")]).unwrap();
        let posterior = Posterior::new(&model, &data, &parameters).unwrap();
        let fit = posterior.map(&MapOptions::default()).unwrap();
        let laplace = posterior.laplace(&fit).unwrap();
        let factor = posterior.linearised(&fit, &laplace).unwrap().few().parameters[0];
        let sd = laplace.physical_covariance[(0, 0)].sqrt() * factor;
        inside += usize::from(fit.parameters[0].abs() < 2.0 * sd);
        widest = widest.max(factor);
    }
    (inside as f64 / draws as f64, widest)
}

/// Four data whose stated errors are true, and a noise beside them that floats: most draws find none. Where
/// one finds a little, intervals grow by what three degrees of freedom ask for, and not without bound.
#[test]
fn coverage_a_little_noise_beside_true_errors() {
    let (share, widest) = mean_of(4, 0.0, 2000);
    assert!((0.95..0.985).contains(&share), "{share}");
    // Half of Student's 95.45 % point is 1.66 for three degrees of freedom, and the step at most the root of
    // 4/3.
    assert!((1.5..2.0).contains(&widest), "{widest}");
}

/// The mean of few data of one noise that floats: what an assessment states holds the truth as often as two
/// standard deviations should, and Laplace's standard deviation, which does not, is warned of.
#[test]
fn coverage_an_assessment_of_few_data_is_wide_enough() {
    for (n, narrow) in [(3, 0.80), (5, 0.90)] {
        let (model, all) = (Linear(Matrix::from_fn(n, 1, |_, _| 1.0)), (0..n).collect::<Vec<_>>());
        let parameters = Parameters::new(vec![normal("a", 0.0, 1.0)]).unwrap();
        let (mut inside, mut by_laplace, count) = (0_usize, 0_usize, 600_usize);
        let mut stream = Streams::new(4).stream("assessed");
        for _ in 0..count {
            let values =
                (0..n).map(|_| 1.0 + 0.1 * stream.sample::<f64, _>(rand_distr::StandardNormal)).collect();
            let observation = Observation::new("all", values).with_independent_noise(0, &all);
            let data = Data::new(vec![observation], vec![NoiseGroup::floated("noise", "V")]).unwrap();
            let options = AssessOptions { random_starts: 0, draws: 0, ..AssessOptions::default() };
            let a = assess(&model, &data, &parameters, &options).unwrap();
            let off = (a.fit.parameters[0] - 1.0).abs();
            inside += usize::from(off < 2.0 * a.sd().unwrap()[0]);
            by_laplace += usize::from(off < 2.0 * a.laplace.as_ref().unwrap().sd()[0]);
            let factor = a.few.as_ref().unwrap().parameters[0];
            let words = format!("multiply that of a by {factor:.2}");
            assert!(a.health.warnings.iter().any(|w| w.contains(&words)), "{:?}", a.health.warnings);
            assert_eq!(a.fit.noise[0].few, Some(a.few.as_ref().unwrap().noises[0].1));
        }
        let [share, by_laplace] = [inside, by_laplace].map(|k| k as f64 / count as f64);
        println!("{n} data: {share}, by Laplace {by_laplace}");
        assert!((0.925..0.98).contains(&share) && by_laplace < narrow, "{n}: {share} {by_laplace}");
    }
    // A fit alone does not know what few data leave unknown.
    let (model, data, parameters) = line(5, 1e-12);
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    assert_eq!(posterior.map(&MapOptions::default()).unwrap().noise[0].few, None);
}

/// The table of docs/theory/inference.md.
#[test]
#[ignore = "long: 4000 data sets of each of 20 kinds"]
fn coverage_noise_beside_stated_errors_over_4000_data_sets() {
    for n in [4, 6, 10, 20] {
        let shares = [0.0, 0.3, 1.0, 3.0, 30.0].map(|scatter| mean_of(n, scatter, 4000).0);
        let cells = shares.map(|share| format!("{:.1} %", 100.0 * share));
        println!("  | {n} | {} |", cells.join(" | "));
        assert!(shares.iter().all(|share| (0.925..0.98).contains(share)), "{n}: {shares:?}");
    }
}

/// Measured errors from 3e-4 to 0.2, as standard errors of two repeats have, and a noise of 0.2 that nobody
/// states: with three parameters the most precise data can be followed exactly, without any noise.
#[test]
fn oracle_a_noise_beside_unequal_errors_is_found_from_its_own_start() {
    let n = 14;
    let x = Matrix::from_fn(n, 3, |i, j| (0.4 * i as f64 - 2.6).powi(j as i32));
    let all: Vec<usize> = (0..n).collect();
    let parameters: Vec<Parameter> = ["a", "b", "c"].map(|name| normal(name, 0.0, 10.0)).into();
    let parameters = Parameters::new(parameters).unwrap();
    let mut with_noise = 0;
    for seed in 0..30 {
        let mut stream = Streams::new(seed).stream("unequal");
        let mut unit = || stream.random::<f64>();
        let sds: Vec<f64> = (0..n).map(|_| 3e-4 * (0.2 / 3e-4_f64).powf(unit())).collect();
        let mut normal = || (-2.0 * unit().ln()).sqrt() * (std::f64::consts::TAU * unit()).cos();
        let truth = x.times(&[1.0, -0.5, 0.2]);
        let values: Vec<f64> =
            truth.iter().zip(&sds).map(|(y, s)| y + 0.2 * normal() + s * normal()).collect();
        let floor = Matrix::diagonal(&sds.iter().map(|s| s * s).collect::<Vec<f64>>());
        let observation = Observation::new("all", values).with_independent_noise(0, &all).with_floor(floor);
        let data = Data::new(vec![observation], vec![NoiseGroup::floated("noise", "V")]).unwrap();
        let model = Linear(x.clone());
        let posterior = Posterior::new(&model, &data, &parameters).unwrap();
        let fit = posterior.map(&MapOptions::default()).unwrap();
        assert!(fit.stop.converged(), "{seed}: {:?}", fit.stop);
        // From the truth, with the noise held near where it is.
        let start = [1.0, -0.5, 0.2, 0.2_f64.ln()];
        let near = posterior.map_from(&start, &MapOptions::default().search).unwrap();
        assert!(fit.cost < near.cost + 1e-3, "{seed}: {} {}", fit.cost, near.cost);
        with_noise += u32::from(fit.noise[0].sd > 0.05);
    }
    assert!(with_noise >= 28, "{with_noise}");
}
