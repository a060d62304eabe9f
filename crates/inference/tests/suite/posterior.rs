//! Derivatives of J, priors, and what bad input does.

use crate::problems::{Ringing, normal, numbers, ringing};
use approx::assert_relative_eq;
use rijke_inference::*;
use rijke_numerics::check::{remainder_slopes, slopes_near};
use rijke_numerics::{Matrix, Order};

/// Slopes 2 after first order and 3 after second, along a random direction.
fn taylor(objective: &dyn Objective, z: &[f64], direction: &[f64]) {
    let at = objective.evaluate(z, Order::Second).unwrap();
    let slope: f64 = at.gradient.iter().zip(direction).map(|(g, d)| g * d).sum();
    let bend = 0.5 * at.hessian.quadratic(direction);
    let moved = |h: f64| {
        let z: Vec<f64> = z.iter().zip(direction).map(|(z, d)| z + h * d).collect();
        objective.evaluate(&z, Order::Value).unwrap().value - at.value
    };
    slopes_near(&remainder_slopes(|h| (moved(h) - slope * h).abs()), 2.0, 0.05);
    slopes_near(&remainder_slopes(|h| (moved(h) - slope * h - bend * h * h).abs()), 3.0, 0.05);
}

#[test]
fn order_cost_with_floor_floating_and_inferred_noise() {
    let (model, data, parameters) = ringing();
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let z = [0.1, 0.3, 2.2, -2.5, -3.0];
    taylor(&posterior, &z, &[0.5, -0.4, 0.3, 0.7, 0.6]);
    taylor(&posterior, &z, &[0.0, 0.0, 0.0, 0.7, -0.6]);
    taylor(&posterior, &z, &[0.3, 0.5, -0.8, 0.0, 0.0]);
}

#[test]
fn order_cost_with_joint_and_bounded_priors() {
    let (model, data, _) = ringing();
    let parameters = Parameters::new(vec![
        normal("a", 1.0, 0.5),
        Parameter::new("b", "b", "1", Prior::Truncated { mean: 0.3, sd: 0.4, low: 0.1, high: 3.0 }),
        Parameter::new("c", "c", "1", Prior::HalfNormal { sd: 3.0 }),
    ])
    .unwrap();
    taylor(
        &Posterior::new(&model, &data, &parameters).unwrap(),
        &[1.2, -1.0, 0.8, -2.5, -3.0],
        &[0.3, 0.5, -0.2, 0.1, 0.2],
    );
    let covariance = Matrix::from_fn(2, 2, |i, j| if i == j { 0.3 } else { 0.2 });
    let parameters = parameters.with_joint(&["c", "a"], &[0.7, 1.1], &covariance).unwrap();
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    taylor(&posterior, &[1.2, -1.0, 0.8, -2.5, -3.0], &[0.3, 0.5, -0.2, 0.1, 0.2]);
    taylor(&posterior, &[1.2, 0.0, 0.8, -2.5, -3.0], &[0.0, 1.0, 0.0, 0.0, 0.0]);
}

#[test]
fn exact_every_prior_holds_unit_mass_in_every_coordinate() {
    let cases = [
        (Prior::Normal { mean: 1.0, sd: 0.5 }, Coordinates::Natural),
        (Prior::LogNormal { median: 2.0, ln_sd: 0.7 }, Coordinates::Log),
        (Prior::LogNormal { median: 2.0, ln_sd: 0.7 }, Coordinates::Natural),
        (Prior::Uniform { low: -1.0, high: 3.0 }, Coordinates::Score),
        (Prior::Uniform { low: -1.0, high: 3.0 }, Coordinates::Natural),
        (Prior::HalfNormal { sd: 2.0 }, Coordinates::Log),
        (Prior::HalfNormal { sd: 2.0 }, Coordinates::Score),
        (Prior::LogNormal { median: 2.0, ln_sd: 0.7 }, Coordinates::Score),
        (Prior::HalfNormal { sd: 2.0 }, Coordinates::Natural),
        (Prior::Truncated { mean: 5.0, sd: 1.0, low: 0.0, high: 2.0 }, Coordinates::Score),
        (Prior::Truncated { mean: 0.5, sd: 1.0, low: 0.0, high: 2.0 }, Coordinates::Natural),
    ];
    for (prior, coordinates) in cases {
        let p = Parameter::new("q", "q", "1", prior).in_coordinates(coordinates);
        // Trapezoids over a range beyond which less than 1e-10 of the mass lies.
        let (low, high) = match coordinates {
            Coordinates::Natural => {
                let (low, high) = prior.bounds();
                (low.max(-10.0), high.min(200.0))
            }
            Coordinates::Log => (-40.0, 40.0),
            Coordinates::Score => (-8.0, 8.0),
        };
        let n = 400_000;
        let h = (high - low) / f64::from(n);
        let mass: f64 = (0..n)
            .map(|k| p.ln_density(low + (f64::from(k) + 0.5) * h).map_or(0.0, |d| d[0].exp()) * h)
            .sum();
        assert_relative_eq!(mass, 1.0, epsilon = 1e-7);
        let z = p.working(prior.quantile(0.3));
        assert_relative_eq!(p.physical(z)[0], prior.quantile(0.3), max_relative = 1e-12);
    }
}

#[test]
fn exact_a_truncated_prior_is_its_own_mirror() {
    // Bounds on one side of the mean, up to where a tail is lost beside 1, and on both sides of it.
    for (low, high) in [(0.5, 2.0), (3.0, 5.0), (9.0, 10.0), (30.0, 31.0), (-10.0, 490.0), (-0.3, 2.0)] {
        let right = Prior::Truncated { mean: 0.0, sd: 1.0, low, high };
        let left = Prior::Truncated { mean: 0.0, sd: 1.0, low: -high, high: -low };
        for z in [-3.0, -0.5, 0.0, 1.0, 2.5] {
            let (a, mirrored) = (right.of_score(z), left.of_score(-z));
            assert_relative_eq!(a[0], -mirrored[0], max_relative = 1e-13);
            assert_relative_eq!(a[1], mirrored[1], max_relative = 1e-9);
            assert!(low < a[0] && a[0] < high, "{a:?}");
            assert_relative_eq!(right.score(a[0]), z, epsilon = 1e-9);
        }
    }
}

/// Bounds that lie far from the mean change nothing: as far out as data may contradict a prior.
#[test]
fn exact_a_truncated_prior_with_far_bounds_is_the_normal_one() {
    let wide = Prior::Truncated { mean: 0.2, sd: 0.02, low: -0.8, high: 10.0 };
    let normal = Prior::Normal { mean: 0.2, sd: 0.02 };
    for z in [-30.0, -12.0, -8.5, -7.0, -1.0, 0.0, 3.0, 6.5, 7.9, 8.1, 8.5, 12.0, 30.0] {
        let (of, expected) = (wide.of_score(z), normal.of_score(z));
        assert_relative_eq!(of[0], expected[0], max_relative = 1e-12);
        assert_relative_eq!(of[1], expected[1], max_relative = 1e-9);
        assert_relative_eq!(wide.score(of[0]), z, epsilon = 1e-9, max_relative = 1e-12);
    }
}

#[test]
fn order_densities_of_priors_have_their_derivatives() {
    for prior in [
        Prior::Normal { mean: 1.0, sd: 2.0 },
        Prior::LogNormal { median: 2.0, ln_sd: 0.7 },
        Prior::Uniform { low: -1.0, high: 3.0 },
        Prior::HalfNormal { sd: 2.0 },
        Prior::Truncated { mean: 0.5, sd: 1.0, low: 0.0, high: 2.0 },
    ] {
        for a in [0.6, 1.7] {
            let at = prior.ln_density(a);
            for k in 0..2 {
                // Central differences of two steps, without their error of second order.
                let slope = |h: f64| (prior.ln_density(a + h)[k] - prior.ln_density(a - h)[k]) / (2.0 * h);
                let expected = (4.0 * slope(1e-3) - slope(2e-3)) / 3.0;
                assert!((at[k + 1] - expected).abs() < 1e-9, "{prior:?} at {a}: {at:?}, {expected}");
            }
        }
    }
}

#[test]
fn exact_truncated_and_half_normal_quantiles_invert_the_mass() {
    let prior = Prior::Truncated { mean: 5.0, sd: 1.0, low: 0.0, high: 2.0 };
    let n = 100_000;
    let end = prior.quantile(0.25);
    let h = end / f64::from(n);
    let mass: f64 = (0..n).map(|k| prior.ln_density((f64::from(k) + 0.5) * h)[0].exp() * h).sum();
    assert_relative_eq!(mass, 0.25, epsilon = 1e-8);
    let half = Prior::HalfNormal { sd: 2.0 };
    assert_relative_eq!(half.quantile(0.5), 2.0 * 0.674_489_750_196_081_7, max_relative = 1e-12);
    assert!(Prior::Flat.quantile(0.5) == 0.0 && Prior::Flat.quantile(0.3).is_nan());
}

#[test]
fn oracle_bfgs_and_newton_find_the_same_maximum() {
    let (model, data, parameters) = ringing();
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let newton = posterior.map(&MapOptions::default()).unwrap();
    let bfgs = posterior.map(&MapOptions::bfgs()).unwrap();
    assert!(newton.stop.converged(), "{:?}", newton.stop);
    assert!(bfgs.stop.converged(), "{:?}", bfgs.stop);
    let laplace = posterior.laplace(&newton).unwrap();
    assert!(laplace.decrement < 1e-18, "{}", laplace.decrement);
    assert_eq!(laplace.bfgs_distance, None);
    let distance = posterior.laplace(&bfgs).unwrap().bfgs_distance.unwrap();
    assert!(distance < 1.0, "BFGS matrix against A: {distance}");
    println!("BFGS matrix against A: {distance:.3}, second derivatives: {:.3}", laplace.curvature_ratio());
    for (a, b) in newton.working.iter().zip(&bfgs.working) {
        assert_relative_eq!(a, b, epsilon = 1e-5);
    }
    assert!(newton.calls.total() < 30 && bfgs.calls.total() < 80, "{:?} {:?}", newton.calls, bfgs.calls);
}

#[test]
fn exact_bad_input_is_refused() {
    let noise = || vec![NoiseGroup::fixed("noise", "V", 0.1)];
    let bad = |o: Observation| Data::new(vec![o], noise()).unwrap_err().to_string();
    let nan = Observation::new("E-7", vec![1.0, f64::NAN]).with_independent_noise(0, &[0, 1]);
    assert_eq!(bad(nan), "observation 'E-7': value 1 is NaN");
    let naked = Observation::new("E-7", vec![1.0, 2.0]).with_independent_noise(0, &[0]);
    assert!(bad(naked).contains("is a variance zero?"));
    let small = Observation::new("E-7", vec![1.0, 2.0]).with_floor(Matrix::identity(3));
    assert!(bad(small).contains("3 x 3"));
    let silent =
        Observation::new("E-7", vec![1.0; 24]).with_independent_noise(0, &(0..24).collect::<Vec<_>>());
    let data = Data::new(vec![silent], vec![NoiseGroup::fixed("noise", "V", 0.0)]).unwrap();
    let model = Ringing { times: numbers("t", 12) };
    let (_, _, parameters) = ringing();
    let error = Posterior::new(&model, &data, &parameters).err().unwrap();
    assert!(matches!(error, InferenceError::SingularCovariance { .. }), "{error}");

    let parameter =
        |prior| Parameters::new(vec![Parameter::new("k", "k", "1", prior)]).unwrap_err().to_string();
    assert!(parameter(Prior::Uniform { low: 2.0, high: 1.0 }).contains("lower bound 2 is not below"));
    assert!(parameter(Prior::Normal { mean: 0.0, sd: 0.0 }).contains("sd = 0"));
    assert!(parameter(Prior::Normal { mean: f64::NAN, sd: 1.0 }).contains("not finite"));
    assert!(parameter(Prior::Truncated { mean: 1e6, sd: 1.0, low: 0.0, high: 1.0 }).contains("prior mass"));
    let twice = Parameters::new(vec![normal("k", 0.0, 1.0), normal("k", 0.0, 1.0)]).unwrap_err();
    assert!(twice.to_string().contains("given twice"));
    let singular = Parameters::new(vec![normal("a", 0.0, 1.0), normal("b", 0.0, 1.0)])
        .unwrap()
        .with_joint(&["a", "b"], &[0.0, 0.0], &Matrix::from_fn(2, 2, |_, _| 1.0))
        .unwrap_err();
    assert!(matches!(singular, InferenceError::BadJoint { .. }));
}

#[test]
fn exact_floated_noise_rests_on_a_floor_that_explains_the_data() {
    // Six data of one mean, with unit floor. Scatter below it: no further noise. Above it: the rest floats.
    for (scatter, expected) in [(0.5, 0.0), (3.0, 8.0)] {
        let observations = (0..6).map(|i| {
            let value = if i % 2 == 0 { scatter } else { -scatter };
            Observation::new(format!("{i}"), vec![value])
                .with_floor(Matrix::identity(1))
                .with_independent_noise(0, &[0])
        });
        let data = Data::new(observations.collect(), vec![NoiseGroup::floated("excess", "1")]).unwrap();
        let parameters = Parameters::new(vec![normal("mean", 0.0, 10.0)]).unwrap();
        let model = crate::problems::Linear(Matrix::from_fn(6, 1, |_, _| 1.0));
        let posterior = Posterior::new(&model, &data, &parameters).unwrap();
        for options in [MapOptions::default(), MapOptions::bfgs()] {
            let fit = posterior.map(&options).unwrap();
            assert!(fit.stop.converged() && fit.calls.total() < 40, "{:?} {:?}", fit.stop, fit.calls);
            // The mean is zero by symmetry, so the total variance is the mean square: scatter^2.
            assert_relative_eq!(fit.noise[0].sd.powi(2), expected, epsilon = 1e-5);
            assert!(posterior.laplace(&fit).is_ok());
        }
    }
}

/// What is measured is the parameter.
struct Itself;

impl Forward for Itself {
    fn predict(&self, a: &[f64], _: Order) -> Result<Prediction, ForwardError> {
        Ok(Prediction { values: a.to_vec(), jacobian: Matrix::identity(1), curvature: vec![0.0] })
    }
}

/// One number is measured as `at` with the error `sd`, under a prior with bounds: evidence and width against
/// integrals over the physical value.
#[test]
fn oracle_priors_with_bounds_where_the_data_say_little_and_beside_a_bound() {
    let half = Prior::HalfNormal { sd: 1.0 };
    let uniform = Prior::Uniform { low: 0.0, high: 1.0 };
    let cut = Prior::Truncated { mean: 0.7, sd: 0.5, low: 0.0, high: 1.0 };
    for (prior, at, sd) in [half, uniform, cut].into_iter().flat_map(|prior| {
        [(0.0, 30.0), (0.0, 3.0), (0.0, 0.3), (0.0, 0.03), (-0.3, 0.1), (0.2, 0.1), (0.5, 0.05)]
            .map(|(at, sd)| (prior, at, sd))
    }) {
        let observation = Observation::new("one", vec![at]).with_independent_noise(0, &[0]);
        let data = Data::new(vec![observation], vec![NoiseGroup::fixed("noise", "1", sd)]).unwrap();
        let parameters = Parameters::new(vec![Parameter::new("a", "a", "1", prior)]).unwrap();
        let posterior = Posterior::new(&Itself, &data, &parameters).unwrap();
        let fit = posterior.map(&MapOptions::default()).unwrap();
        let laplace = posterior.laplace(&fit).unwrap();
        let n = 200_000;
        let h = prior.bounds().1.min(8.0) / f64::from(n);
        let mut sums = [0.0; 3];
        for k in 0..n {
            let a = (f64::from(k) + 0.5) * h;
            let density = (prior.ln_density(a)[0] - 0.5 * ((a - at) / sd).powi(2)).exp() * h;
            sums = [sums[0] + density, sums[1] + a * density, sums[2] + a * a * density];
        }
        let (evidence, mean) = (sums[0] / (sd * std::f64::consts::TAU.sqrt()), sums[1] / sums[0]);
        let exact = (sums[2] / sums[0] - mean * mean).sqrt();
        let (nats, ratio) = (laplace.evidence.ln_marginal - evidence.ln(), laplace.sd()[0] / exact);
        println!("{prior:?} {at} +- {sd}: {nats:.3} nats, sd {:.4} for {exact:.4}", laplace.sd()[0]);
        assert!(nats.abs() < 0.11 && (ratio - 1.0).abs() < 0.17, "{prior:?} {at} +- {sd}: {nats} {ratio}");
        if sd > 20.0 {
            assert!(nats.abs() < 1e-3 && (ratio - 1.0).abs() < 2e-3, "nothing is learnt: {nats} {ratio}");
        }
    }
}
