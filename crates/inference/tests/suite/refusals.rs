//! What does not fit together is an error with names and numbers.

use crate::problems::{Linear, normal};
use rijke_inference::ensemble::{Ensemble, EnsembleData, EnsembleError, NoiseCovariance, Scheme, Smoother};
use rijke_inference::ensemble::{orthogonal_forcing, smooth};
use rijke_inference::*;
use rijke_numerics::{Matrix, Streams};

fn one() -> (Linear, Data, Parameters) {
    let observation = Observation::new("d", vec![1.0, 2.0]).with_independent_noise(0, &[0, 1]);
    let data = Data::new(vec![observation], vec![NoiseGroup::floated("noise", "1")]).unwrap();
    let model = Linear(Matrix::from_fn(2, 1, |_, _| 1.0));
    (model, data, Parameters::new(vec![normal("a", 0.0, 1.0)]).unwrap())
}

#[test]
fn message_starts_and_scans_of_other_parameters_are_refused() {
    let (model, data, parameters) = one();
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let wrong = |options: AssessOptions| posterior.assess(&options).unwrap_err().to_string();
    let starts = AssessOptions { starts: vec![vec![1.0, 2.0, 3.0]], ..AssessOptions::default() };
    assert!(wrong(starts).contains("3 starting values were given for 1 numbers"));
    let scans = vec![Scan { parameter: "zz".to_owned(), step: 1.0 }];
    let words = wrong(AssessOptions { scans, ..AssessOptions::default() });
    assert!(words.contains("'zz' is unknown; known: a"), "{words}");
    let error = posterior.map_from(&[0.0], &TrustRegion::default()).unwrap_err();
    assert!(matches!(error, InferenceError::StartSize { found: 1, expected: 2 }), "{error}");
    for step in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let scans = vec![Scan { parameter: "a".to_owned(), step }];
        let words = wrong(AssessOptions { scans, ..AssessOptions::default() });
        assert!(words.contains("the step of a scan is") && words.contains("above zero"), "{words}");
    }
}

#[test]
fn message_settings_that_no_search_can_follow_are_refused() {
    let (model, data, parameters) = one();
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let usual = TrustRegion::default();
    for (name, settings) in [
        ("first_radius", TrustRegion { first_radius: 0.0, ..usual }),
        ("first_radius", TrustRegion { first_radius: -1.0, ..usual }),
        ("first_radius", TrustRegion { first_radius: f64::INFINITY, ..usual }),
        ("tolerance", TrustRegion { tolerance: f64::NAN, ..usual }),
    ] {
        let words = posterior.map_from(&[0.0, 1.0], &settings).unwrap_err().to_string();
        assert!(words.contains(&format!("{name} is")), "{name}: {words}");
    }
}

#[test]
fn message_noise_of_an_element_that_is_not_there_is_refused() {
    let noise = || vec![NoiseGroup::floated("noise", "1")];
    for elements in [&[0, 1, 7][..], &[2], &[usize::MAX, 0, 1]] {
        let observation = Observation::new("d", vec![1.0, 2.0]).with_independent_noise(0, elements);
        let words = Data::new(vec![observation], noise()).unwrap_err().to_string();
        assert!(words.contains("its structure is 3 x 3, but it has 2 values"), "{words}");
    }
}

#[test]
fn message_covariances_of_the_wrong_shape_are_refused() {
    let floor = Matrix::from_fn(2, 2, |i, j| if i == j { 1.0 } else { f64::from(u8::from(i < j)) * 1e6 });
    let observation = Observation::new("point 3", vec![1.0, 2.0]).with_floor(floor);
    let words = Data::new(vec![observation], Vec::new()).unwrap_err().to_string();
    assert!(words.contains("point 3") && words.contains("floor is not symmetric: 0 at (1, 0)"), "{words}");
    let (_, _, parameters) = one();
    let joint = parameters.with_physical_joint(&["a"], &[0.0, 1.0], &Matrix::identity(2));
    let words = joint.unwrap_err().to_string();
    assert!(words.contains("1 names, 2 means and a 2 x 2 covariance"), "{words}");
}

#[test]
fn message_a_joint_prior_is_symmetric_at_any_scale() {
    // By correlations, whatever the units: 1 % is no rounding, and the last digit is.
    for scale in [1e-9, 1.0, 1e9] {
        let joint = |more: f64| {
            let two = [normal("a", 0.0, scale), normal("b", 0.0, 1e3 * scale)];
            let (aa, ab, bb) = (scale * scale, 300.0 * scale * scale, 1e6 * scale * scale);
            let covariance = Matrix::from_fn(2, 2, |i, j| match (i, j) {
                (0, 0) => aa,
                (1, 1) => bb,
                (0, _) => ab,
                _ => ab * (1.0 + more),
            });
            Parameters::new(two.to_vec()).unwrap().with_joint(&["a", "b"], &[0.0; 2], &covariance)
        };
        let words = joint(0.01).unwrap_err().to_string();
        assert!(words.contains("not symmetric (correlations differ by 3.0e-3)"), "{words}");
        assert!(joint(2e-16).is_ok());
    }
}

#[test]
fn exact_forcing_fills_the_members_and_no_more() {
    // Four members: their mean, one column, and two draws.
    let against = Matrix::from_fn(4, 1, |i, _| (i * i) as f64);
    let mut stream = Streams::new(2).stream("forcing");
    let forcing = orthogonal_forcing(&against, &[4.0, 0.25], 1e-9, &mut stream).unwrap();
    let product = |a: usize, b: usize| (0..4).map(|i| forcing[(i, a)] * forcing[(i, b)]).sum::<f64>() / 3.0;
    let known = (0..4).map(|i| against[(i, 0)] * forcing[(i, 0)]).sum::<f64>();
    for (found, expected) in [(product(0, 0), 4.0), (product(1, 1), 0.25), (product(0, 1), 0.0), (known, 0.0)]
    {
        assert!((found - expected).abs() < 1e-13, "{found}, not {expected}");
    }
    let error = orthogonal_forcing(&against, &[1.0; 3], 1e-9, &mut stream).unwrap_err();
    assert_eq!(error, EnsembleError::TooFewMembers { have: 4, need: 5 });
}

#[test]
fn message_samplers_that_cannot_end_are_refused() {
    let (model, data, parameters) = one();
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let fit = posterior.map(&MapOptions::default()).unwrap();
    let target = LikelihoodTarget::new(&posterior, &fit).unwrap();
    let streams = Streams::new(1);
    let fine = Nested::with_error(0.5, 3.0, 1, streams);
    let wrong = [
        Nested { live: 0, ..fine },
        Nested { live: 1, ..fine },
        Nested { tolerance: f64::NAN, ..fine },
        Nested::with_error(0.0, 3.0, 1, streams),
        Nested::with_error(f64::NAN, 3.0, 1, streams),
        Nested::with_error(-1.0, 3.0, 1, streams),
    ];
    for sampler in wrong {
        let words = sampler.integrate(&target).unwrap_err().to_string();
        assert!(words.contains("live points and a tolerance of"), "{words}");
    }
    // A prior that contradicts itself is refused by its parameter, and has no quantile that panics.
    let prior = Prior::Truncated { mean: 0.0, sd: 1.0, low: 2.0, high: 1.0 };
    let median = prior.quantile(0.5);
    assert!(median.is_nan() || median <= 2.0, "{median}");
    assert!(Parameters::new(vec![Parameter::new("a", "a", "1", prior)]).is_err());
}

#[test]
fn message_numbers_that_are_none_do_not_reach_an_ensemble() {
    let mut stream = Streams::new(2).stream("ensemble");
    let mut ensemble = Ensemble::new(Matrix::from_fn(8, 2, |i, j| (3 * i + j) as f64)).unwrap();
    let predicted = Matrix::from_fn(8, 1, |i, _| i as f64);
    let noise = NoiseCovariance::Independent(vec![1.0]);
    for value in [f64::NAN, f64::INFINITY] {
        let data = EnsembleData { predicted: &predicted, measured: &[value], noise: &noise };
        let error = ensemble.analyse(&data, Scheme::SquareRoot, &mut stream).unwrap_err();
        assert_eq!(error, EnsembleError::Datum { datum: 0 });
    }
    ensemble.members_mut()[(3, 1)] = f64::NAN;
    let data = EnsembleData { predicted: &predicted, measured: &[1.0], noise: &noise };
    let error = ensemble.analyse(&data, Scheme::SquareRoot, &mut stream).unwrap_err();
    assert_eq!(error, EnsembleError::NotFinite { member: 3, variable: 1 });
    let error = orthogonal_forcing(&Matrix::zeros(9, 1), &[1.0, -1.0], 1e-9, &mut stream).unwrap_err();
    assert_eq!(error, EnsembleError::Variance { place: 1, value: -1.0 });
    let prior = Ensemble::standard_normal(40, 1, &mut stream).unwrap();
    let smoother = Smoother { coefficients: vec![f64::NAN] };
    let model = |row: &[f64]| Ok::<_, String>(vec![row[0]]);
    let found = smooth(prior, &[1.0], &noise, &smoother, &Streams::new(3), model);
    assert!(matches!(found.unwrap_err(), EnsembleError::Coefficients { .. }));
}
