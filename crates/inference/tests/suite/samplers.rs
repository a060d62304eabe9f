//! Laplace's evidence against nested sampling.

use crate::problems::{Linear, design, normal, numbers, ringing};
use rijke_inference::*;
use rijke_numerics::Streams;

fn compare(posterior: &Posterior<'_>, error: f64, allowed: f64) -> (Calls, Integrated) {
    let found = posterior.assess(&AssessOptions::default()).unwrap();
    let laplace = found.laplace.as_ref().unwrap();
    let information = -laplace.evidence.ln_occam;
    let target = LikelihoodTarget::new(posterior, &found.fit).unwrap();
    let nested = Nested::with_error(error, information, target.size(), Streams::new(3));
    let sampled = nested.integrate(&target).unwrap();
    println!(
        "laplace {:.4} ({:?}), corrected {:?}\nnested {:.4} +- {:.4} ({:?} calls)",
        laplace.evidence.ln_marginal,
        found.fit.calls,
        found.health.importance,
        sampled.ln_marginal,
        sampled.standard_error,
        sampled.calls.value
    );
    assert!(sampled.finished);
    assert!(
        (laplace.evidence.ln_marginal - sampled.ln_marginal).abs() < allowed * sampled.standard_error,
        "Laplace {} against {} +- {}",
        laplace.evidence.ln_marginal,
        sampled.ln_marginal,
        sampled.standard_error
    );
    (found.fit.calls, sampled)
}

#[test]
fn oracle_nested_sampling_of_a_linear_model() {
    let (model, data, parameters) = linear(0.3);
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let (_, found) = compare(&posterior, 0.1, 3.0);
    // The draws must have the exact posterior mean and sd.
    let fit = posterior.map(&MapOptions::default()).unwrap();
    let laplace = posterior.laplace(&fit).unwrap();
    for (i, sd) in laplace.sd().into_iter().enumerate() {
        let n = found.draws.len() as f64;
        let mean = found.draws.iter().map(|z| z[i]).sum::<f64>() / n;
        let found = (found.draws.iter().map(|z| (z[i] - mean).powi(2)).sum::<f64>() / n).sqrt();
        assert!((mean - fit.parameters[i]).abs() < 0.15 * sd, "{mean} {} {sd}", fit.parameters[i]);
        assert!((found / sd - 1.0).abs() < 0.15, "{found} {sd}");
    }
}

#[test]
fn oracle_nested_sampling_of_a_curved_model() {
    let (model, data, parameters) = ringing();
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    compare(&posterior, 0.15, 3.0);
}

/// A linear model of three parameters with ten data of standard deviation `noise`.
fn linear(noise: f64) -> (Linear, Data, Parameters) {
    let parameters = Parameters::new((0..3).map(|i| normal(&format!("a{i}"), 0.0, 1.0)).collect()).unwrap();
    let observation = Observation::new("d", numbers("nested/y", 10))
        .with_independent_noise(0, &(0..10).collect::<Vec<_>>());
    let data = Data::new(vec![observation], vec![NoiseGroup::fixed("noise", "1", noise)]).unwrap();
    (Linear(design("nested", 10, 3)), data, parameters)
}

#[test]
fn exact_nested_sampling_states_its_own_error() {
    // 40 runs with few live points on a linear model: the mean misses by less than its standard error allows,
    // and the scatter is the stated error.
    let (model, data, parameters) = linear(0.1);
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let fit = posterior.map(&MapOptions::default()).unwrap();
    let exact = posterior.laplace(&fit).unwrap().evidence.ln_marginal;
    let target = LikelihoodTarget::new(&posterior, &fit).unwrap();
    let pulls: Vec<f64> = (0..40)
        .map(|seed| {
            let nested = Nested::with_error(0.35, 8.0, 3, Streams::new(seed));
            let found = nested.integrate(&target).unwrap();
            (found.ln_marginal - exact) / found.standard_error
        })
        .collect();
    let mean = pulls.iter().sum::<f64>() / 40.0;
    let scatter = (pulls.iter().map(|p| p * p).sum::<f64>() / 40.0).sqrt();
    println!("nested sampling: mean pull {mean:.3} +- 0.158, root mean square {scatter:.3}");
    assert!(mean.abs() < 0.5 && (0.7..1.35).contains(&scatter), "{mean} {scatter} {pulls:.2?}");
}

/// A target that has the value 1 where its first number is below a bound, and no answer beyond.
struct Half(f64);

impl Target for Half {
    fn size(&self) -> usize {
        2
    }
    fn ln_likelihood(&self, xi: &[f64]) -> Result<f64, InferenceError> {
        let failed = ForwardError::recoverable("no answer");
        if xi[0] < self.0 { Ok(-0.5 * xi[1] * xi[1]) } else { Err(InferenceError::from(failed)) }
    }
    fn gradient(&self, xi: &[f64]) -> Result<(f64, Vec<f64>), InferenceError> {
        Ok((self.ln_likelihood(xi)?, vec![0.0, -xi[1]]))
    }
    fn working(&self, xi: &[f64]) -> Vec<f64> {
        xi.to_vec()
    }
}

/// The evidence is Phi(bound) / sqrt(2), wherever the model has an answer.
#[test]
fn exact_nested_sampling_counts_the_prior_at_which_the_model_fails() {
    for (bound, share) in [(0.0, 0.5), (-1.281_551_565_5, 0.1)] {
        let exact = f64::ln(share) - 0.5 * std::f64::consts::LN_2;
        let pulls: Vec<f64> = (0..40)
            .map(|seed| {
                let nested = Nested::with_error(0.2, 1.0, 2, Streams::new(seed));
                let found = nested.integrate(&Half(bound)).unwrap();
                (found.ln_marginal - exact) / found.standard_error
            })
            .collect();
        let mean = pulls.iter().sum::<f64>() / 40.0;
        let scatter = (pulls.iter().map(|p| p * p).sum::<f64>() / 40.0).sqrt();
        assert!(mean.abs() < 0.5 && (0.6..1.4).contains(&scatter), "{share}: {mean} {scatter} {pulls:.2?}");
    }
    let nested = Nested::with_error(0.2, 1.0, 2, Streams::new(1));
    let never = nested.integrate(&Half(f64::NEG_INFINITY)).unwrap_err().to_string();
    assert!(never.contains("no answer at 10000 of 10000"), "{never}");
}

/// Slopes of the target against central differences, with every kind of prior and an inferred noise.
#[test]
fn oracle_gradient_of_the_target() {
    let (model, data, parameters) = ringing();
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let fit = posterior.map(&MapOptions::default()).unwrap();
    let target = LikelihoodTarget::new(&posterior, &fit).unwrap();
    let xi = vec![0.3, -0.5, 0.2, 0.4];
    let (value, gradient) = target.gradient(&xi).unwrap();
    assert_eq!(value, target.ln_likelihood(&xi).unwrap());
    for i in 0..4 {
        let at = |h: f64| {
            let mut moved = xi.clone();
            moved[i] += h;
            target.ln_likelihood(&moved).unwrap()
        };
        let slope = (8.0 * (at(1e-3) - at(-1e-3)) - (at(2e-3) - at(-2e-3))) / 12e-3;
        assert!((gradient[i] - slope).abs() < 1e-7 * (1.0 + slope.abs()), "{i}: {} {slope}", gradient[i]);
    }
    let tied = parameters.with_joint(
        &["frequency", "amplitude"],
        &[2.0, 0.1],
        &rijke_numerics::Matrix::from_fn(2, 2, |i, j| if i == j { 0.2 } else { 0.1 }),
    );
    let tied = tied.unwrap();
    let posterior = Posterior::new(&model, &data, &tied).unwrap();
    let target = LikelihoodTarget::new(&posterior, &fit).unwrap();
    let direction = [0.2, -0.3, 0.5, 0.1];
    let along = |h: f64| {
        let moved: Vec<f64> = xi.iter().zip(direction).map(|(x, d)| x + h * d).collect();
        target.ln_likelihood(&moved).unwrap()
    };
    let slope = (8.0 * (along(1e-3) - along(-1e-3)) - (along(2e-3) - along(-2e-3))) / 12e-3;
    let found: f64 = target.gradient(&xi).unwrap().1.iter().zip(direction).map(|(g, d)| g * d).sum();
    assert!((found - slope).abs() < 1e-7 * (1.0 + slope.abs()), "{found} {slope}");
}

#[cfg(feature = "nuts")]
#[test]
fn oracle_nuts_states_its_own_error() {
    let (model, data, parameters) = linear(0.1);
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let fit = posterior.map(&MapOptions::default()).unwrap();
    let laplace = posterior.laplace(&fit).unwrap();
    let target = LikelihoodTarget::new(&posterior, &fit).unwrap();
    let pulls: Vec<f64> = (0..20)
        .map(|seed| {
            let found = Nuts::with_error(0.1, Streams::new(seed)).integrate(&target).unwrap();
            assert!(found.finished && found.standard_error <= 0.1);
            (found.ln_marginal - laplace.evidence.ln_marginal) / found.standard_error
        })
        .collect();
    let scatter = (pulls.iter().map(|p| p * p).sum::<f64>() / 20.0).sqrt();
    println!("NUTS and bridge sampling: root mean square pull {scatter:.2}: {pulls:.2?}");
    // Half of the draws fit the bridge, whose own scatter the stated error leaves out.
    assert!((0.5..1.8).contains(&scatter), "{scatter} {pulls:.2?}");
}

#[cfg(feature = "nuts")]
#[test]
fn oracle_nuts_on_a_curved_model() {
    let (model, data, parameters) = ringing();
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let found = posterior.assess(&AssessOptions { draws: 4000, ..AssessOptions::default() }).unwrap();
    let exact = found.health.importance.unwrap();
    let target = LikelihoodTarget::new(&posterior, &found.fit).unwrap();
    let found = Nuts::with_error(0.05, Streams::new(3)).integrate(&target).unwrap();
    let error = found.standard_error.hypot(exact.standard_error);
    println!(
        "NUTS {} +- {}, {:?}; importance {exact:?}",
        found.ln_marginal, found.standard_error, found.calls
    );
    assert!((found.ln_marginal - exact.ln_marginal).abs() < 4.0 * error);
}
