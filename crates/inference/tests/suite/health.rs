//! Sick posteriors are flagged, healthy ones are not.

use crate::problems::{Linear, design, normal, numbers, ringing};
use approx::assert_abs_diff_eq;
use rijke_inference::*;
use rijke_numerics::{Matrix, Order};

/// Any function of the parameters with derivatives by hand.
struct Function<F>(F);

impl<F: Fn(&[f64]) -> Prediction + Sync> Forward for Function<F> {
    fn predict(&self, a: &[f64], _: Order) -> Result<Prediction, ForwardError> {
        let prediction = (self.0)(a);
        if prediction.values.iter().all(|v| v.is_finite()) {
            Ok(prediction)
        } else {
            Err(ForwardError::recoverable("no value here"))
        }
    }
}

fn assess(model: &dyn Forward, values: Vec<f64>, sd: f64, parameters: &Parameters) -> Assessment {
    let all: Vec<usize> = (0..values.len()).collect();
    let observation = Observation::new("d", values).with_independent_noise(0, &all);
    let data = Data::new(vec![observation], vec![NoiseGroup::fixed("noise", "1", sd)]).unwrap();
    let posterior = Posterior::new(model, &data, parameters).unwrap();
    posterior.assess(&AssessOptions { random_starts: 8, ..AssessOptions::default() }).unwrap()
}

fn warned(assessment: &Assessment, word: &str) {
    let all = assessment.health.warnings.join("; ");
    assert!(all.contains(word), "expected '{word}' in '{all}'");
}

#[test]
fn exact_a_linear_model_is_trusted() {
    let parameters = Parameters::new((0..5).map(|i| normal(&format!("a{i}"), 0.0, 1.0)).collect()).unwrap();
    let a = assess(&Linear(design("health", 30, 5)), numbers("health/y", 30), 0.6, &parameters);
    assert_eq!(a.health.warnings, Vec::<String>::new());
    let (importance, laplace) = (a.health.importance.unwrap(), a.laplace.unwrap());
    // All weights are equal, so the corrected evidence is exact.
    assert_abs_diff_eq!(importance.ln_marginal, laplace.evidence.ln_marginal, epsilon = 1e-10);
    assert!(importance.standard_error < 1e-10);
}

#[test]
fn exact_a_model_that_misses_the_data_is_not_trusted() {
    let constant = Linear(Matrix::from_fn(20, 1, |_, _| 1.0));
    let parameters = Parameters::new(vec![normal("a", 0.0, 10.0)]).unwrap();
    let mut values: Vec<f64> = numbers("health/constant", 20).iter().map(|x| 1.0 + 0.03 * x).collect();
    let healthy = assess(&constant, values.clone(), 0.03, &parameters);
    assert_eq!(healthy.health.warnings, Vec::<String>::new());
    values[7] = 50.0;
    let a = assess(&constant, values.clone(), 0.03, &parameters);
    warned(&a, "the model misses the data");
    let found = a.health.chi_squared.unwrap();
    let squares: f64 = values.iter().map(|v| ((v - a.fit.parameters[0]) / 0.03).powi(2)).sum();
    assert_abs_diff_eq!(found.value / squares, 1.0, epsilon = 1e-12);
    assert_eq!(found.freedom, 19);
    assert!(found.sds > 1000.0, "{found:?}");
}

#[test]
fn oracle_chi_squared_of_a_fit_against_dense_matrices() {
    // Full covariances, a floated and an inferred noise; all data count, as both adjust themselves.
    let (model, data, parameters) = ringing();
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let a = posterior.assess(&AssessOptions::default()).unwrap();
    let linear = posterior.linearised(&a.fit, a.laplace.as_ref().unwrap()).unwrap();
    let value: f64 = linear.pulls().iter().zip(&linear.residuals).map(|(a, b)| a * b).sum();
    let found = a.health.chi_squared.unwrap();
    assert_abs_diff_eq!(found.value, value, epsilon = 1e-8 * value);
    assert_eq!(found.freedom, data.size());
}

#[test]
fn exact_two_signs_are_two_modes() {
    // d = a^2 knows a up to its sign.
    let square = Function(|a: &[f64]| Prediction {
        values: vec![a[0] * a[0]],
        jacobian: Matrix::from_fn(1, 1, |_, _| 2.0 * a[0]),
        curvature: vec![2.0],
    });
    let parameters = Parameters::new(vec![normal("a", 0.1, 2.0)]).unwrap();
    warned(&assess(&square, vec![4.0], 0.1, &parameters), "further maxim");
}

#[test]
fn exact_an_aliased_delay_is_flagged() {
    // The phase of a delay repeats with the period of the wave.
    let wave = Function(|a: &[f64]| {
        let (s, c) = (6.0 * a[0]).sin_cos();
        Prediction {
            values: vec![c, s],
            jacobian: Matrix::from_fn(2, 1, |i, _| if i == 0 { -6.0 * s } else { 6.0 * c }),
            curvature: vec![-36.0 * c, -36.0 * s],
        }
    });
    let prior = Prior::Uniform { low: 0.0, high: 5.0 };
    let parameters = Parameters::new(vec![Parameter::new("tau", "tau", "s", prior)]).unwrap();
    warned(&assess(&wave, vec![0.6, 0.8], 0.05, &parameters), "further maxim");
}

#[test]
fn exact_a_spike_on_a_broad_posterior_is_flagged() {
    // A narrow well at the centre of a broad one: -ln L = -ln(exp(-x^2/2) + 30 exp(-(x/0.01)^2/2)) has its
    // maximum in a spike that holds 23 % of the mass; as residuals, f = sqrt(2 (C - ln(...))).
    let spike = Function(|a: &[f64]| {
        let value = |x: f64| {
            let density = (-0.5 * x * x).exp() + 30.0 * (-0.5 * (x / 0.01).powi(2)).exp();
            (2.0 * (4.0 - density.ln())).sqrt()
        };
        let h = 1e-4;
        let (low, mid, high) = (value(a[0] - h), value(a[0]), value(a[0] + h));
        Prediction {
            values: vec![mid],
            jacobian: Matrix::from_fn(1, 1, |_, _| (high - low) / (2.0 * h)),
            curvature: vec![(high - 2.0 * mid + low) / (h * h)],
        }
    });
    let parameters = Parameters::new(vec![normal("x", 0.0, 3.0)]).unwrap();
    let found = assess(&spike, vec![0.0], 1.0, &parameters);
    assert!(!found.health.warnings.is_empty(), "{:?}", found.health);
}

#[test]
fn exact_a_bound_and_a_direction_without_data_are_named() {
    let sum = Linear(Matrix::from_fn(1, 2, |_, _| 1.0));
    let wide = |name: &str| normal(name, 0.0, 1.0);
    let parameters = Parameters::new(vec![wide("alpha"), wide("beta")]).unwrap();
    let found = assess(&sum, vec![0.3], 0.01, &parameters);
    assert_eq!(found.health.unidentified.len(), 1);
    let words = &found.health.unidentified[0].0;
    assert!(words.contains("alpha") && words.contains("beta"), "{words}");
    assert!(found.health.warnings.is_empty(), "{:?}", found.health.warnings);

    let prior = Prior::Uniform { low: 0.0, high: 1.0 };
    let bounded = Parameter::new("k", "k", "1", prior).in_coordinates(Coordinates::Natural);
    let parameters = Parameters::new(vec![bounded]).unwrap();
    let one = Linear(Matrix::identity(1));
    warned(&assess(&one, vec![1.1], 0.05, &parameters), "did not converge");
    warned(&assess(&one, vec![0.999], 0.05, &parameters), "at a bound: k");

    // In its own coordinates the maximum keeps away from the bound. Whether the data ask for more is said by
    // how far, in standard deviations.
    let uniform = Parameters::new(vec![Parameter::new("k", "k", "1", prior)]).unwrap();
    for beyond in [1.0, 1.05, 1.2, -0.05] {
        let found = assess(&one, vec![beyond], 0.05, &uniform);
        assert!(found.health.warnings.iter().any(|w| w.starts_with("at a bound: k")), "{beyond}");
    }
    for (within, sd) in [(0.5, 0.05), (0.85, 0.05), (0.5, 5.0)] {
        assert!(assess(&one, vec![within], sd, &uniform).health.at_bound.is_empty(), "{within}");
    }
}

#[test]
fn oracle_doubled_priors_against_a_new_fit() {
    let (model, data, parameters) = ringing();
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let found = posterior.assess(&AssessOptions::default()).unwrap();
    let base = found.laplace.unwrap().evidence.ln_marginal;
    for (i, (_, change)) in found.health.doubled_prior.iter().enumerate() {
        let wide = parameters.widened(i, 2.0);
        let posterior = Posterior::new(&model, &data, &wide).unwrap();
        let again = posterior.laplace(&posterior.map(&MapOptions::default()).unwrap()).unwrap();
        // The likelihood is not quadratic and the noise moves, so the short cut is good to a few hundredths
        // of a nat.
        assert_abs_diff_eq!(change.unwrap(), again.evidence.ln_marginal - base, epsilon = 0.03);
    }
}

#[test]
fn exact_failures_are_rows_or_errors_never_numbers() {
    let nowhere = Function(|_: &[f64]| Prediction { values: vec![f64::NAN], ..Prediction::default() });
    let parameters = Parameters::new(vec![normal("a", 0.0, 1.0)]).unwrap();
    let observation = || Observation::new("d", vec![1.0]).with_independent_noise(0, &[0]);
    let data = Data::new(vec![observation()], vec![NoiseGroup::fixed("noise", "1", 0.1)]).unwrap();
    let posterior = Posterior::new(&nowhere, &data, &parameters).unwrap();
    let error = posterior.assess(&AssessOptions::default()).unwrap_err();
    assert!(error.to_string().contains("starting point a = 0:"), "{error}");
    assert!(error.to_string().contains("cannot be evaluated at the starting point"), "{error}");

    // One datum, one parameter, floating noise: the noise collapses and says so.
    let data = Data::new(vec![observation()], vec![NoiseGroup::floated("noise", "1")]).unwrap();
    let one = Linear(Matrix::identity(1));
    let posterior = Posterior::new(&one, &data, &parameters).unwrap();
    let found = posterior.assess(&AssessOptions::default()).unwrap();
    warned(&found, "the noise of 'noise' (1 data) can hardly be estimated");
    // As many data as parameters, all of which they tell.
    let parameters = Parameters::new(["a", "b"].map(|n| normal(n, 0.0, 10.0)).to_vec()).unwrap();
    let pair = Observation::new("d", vec![1.0, -2.0]).with_independent_noise(0, &[0, 1]);
    let data = Data::new(vec![pair], vec![NoiseGroup::floated("noise", "1")]).unwrap();
    let two = Linear(Matrix::identity(2));
    let posterior = Posterior::new(&two, &data, &parameters).unwrap();
    let found = posterior.assess(&AssessOptions::default()).unwrap();
    warned(&found, "the noise of 'noise' (2 data) can hardly be estimated");

    let flat = Parameters::new(vec![Parameter::new("a", "a", "1", Prior::Flat)]).unwrap();
    let data = Data::new(vec![observation()], vec![NoiseGroup::fixed("noise", "1", 0.1)]).unwrap();
    let posterior = Posterior::new(&one, &data, &flat).unwrap();
    let found = posterior.assess(&AssessOptions::default()).unwrap();
    assert!(found.laplace.unwrap_err().contains("improper prior"));
}

#[test]
fn exact_a_noise_has_the_parameters_of_its_own_data_against_it() {
    // Three data of another noise tell three of the four parameters, which leaves this noise its own.
    let parameters = Parameters::new(["a", "b", "c", "d"].map(|n| normal(n, 0.0, 10.0)).to_vec()).unwrap();
    let all = [1.0, 1.3, 0.8, 2.0, 3.0, 4.0];
    let rows = |i: usize, j: usize| f64::from(u8::from(if i < 3 { j == 0 } else { j == i - 2 }));
    let observation = Observation::new("d", all.to_vec())
        .with_independent_noise(0, &[0, 1, 2])
        .with_independent_noise(1, &[3, 4, 5]);
    let groups = vec![NoiseGroup::floated("noise", "1"), NoiseGroup::fixed("others", "1", 0.1)];
    let data = Data::new(vec![observation], groups).unwrap();
    let four = Linear(Matrix::from_fn(6, 4, rows));
    let posterior = Posterior::new(&four, &data, &parameters).unwrap();
    let found = posterior.assess(&AssessOptions::default()).unwrap();
    assert!(found.health.warnings.iter().all(|w| !w.contains("hardly be estimated")), "{:?}", found.health);
}

/// All points of a circle fit alike: there is no maximum that a Gaussian is like.
struct Circle;

impl Forward for Circle {
    fn predict(&self, a: &[f64], _: Order) -> Result<Prediction, ForwardError> {
        let jacobian = Matrix::from_fn(1, 2, |_, k| 2.0 * a[k]);
        Ok(Prediction { values: vec![a[0] * a[0] + a[1] * a[1]], jacobian, curvature: vec![2.0, 0.0, 2.0] })
    }
}

#[test]
fn behaviour_a_posterior_that_is_no_sum_of_gaussians_has_no_evidence() {
    let observation = Observation::new("one", vec![1.0]).with_independent_noise(0, &[0]);
    let data = Data::new(vec![observation], vec![NoiseGroup::fixed("noise", "1", 0.1)]).unwrap();
    let prior = Prior::Normal { mean: 0.0, sd: 2.0 };
    let parameters = ["a", "b"].map(|name| Parameter::new(name, name, "1", prior));
    let parameters = Parameters::new(parameters.into()).unwrap();
    let posterior = Posterior::new(&Circle, &data, &parameters).unwrap();
    let refused = posterior.assess(&AssessOptions::default()).unwrap().evidence.unwrap_err();
    assert!(
        refused.contains("no sum of Gaussians") || refused.contains("not positive definite"),
        "{refused}"
    );
}

/// A model with first derivatives alone, in coordinates that bend: their curvature is known. The width
/// beside a bound is that of the same model with second derivatives.
#[test]
fn exact_coordinates_bend_without_second_derivatives_too() {
    struct Line(Order);
    impl Forward for Line {
        fn predict(&self, a: &[f64], order: Order) -> Result<Prediction, ForwardError> {
            let curvature = if order.min(self.0) == Order::Second { vec![0.0] } else { Vec::new() };
            Ok(Prediction { values: a.to_vec(), jacobian: Matrix::identity(1), curvature })
        }
        fn highest_order(&self) -> Order {
            self.0
        }
    }
    let observation = Observation::new("one", vec![0.02]).with_independent_noise(0, &[0]);
    let data = Data::new(vec![observation], vec![NoiseGroup::fixed("noise", "1", 0.1)]).unwrap();
    for prior in [Prior::HalfNormal { sd: 1.0 }, Prior::LogNormal { median: 0.05, ln_sd: 1.5 }] {
        let parameters = Parameters::new(vec![Parameter::new("a", "a", "1", prior)]).unwrap();
        let [first, second] = [Order::First, Order::Second].map(|order| {
            let model = Line(order);
            let posterior = Posterior::new(&model, &data, &parameters).unwrap();
            let fit = posterior.map(&MapOptions::default()).unwrap();
            posterior.laplace(&fit).unwrap()
        });
        assert!((first.parameters[0] / second.parameters[0] - 1.0).abs() < 1e-6);
        assert!((first.sd()[0] / second.sd()[0] - 1.0).abs() < 1e-6, "{:?} {:?}", first.sd(), second.sd());
        assert!((first.evidence.ln_marginal - second.evidence.ln_marginal).abs() < 1e-9);
    }
}
