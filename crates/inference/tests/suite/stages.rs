//! Priors that contradict the data, and evidence over several stages.

use crate::problems::{Linear, design, normal, numbers};
use approx::{assert_abs_diff_eq, assert_relative_eq};
use rijke_inference::*;
use rijke_numerics::Matrix;

fn data(values: Vec<f64>, sd: f64) -> Data {
    let all: Vec<usize> = (0..values.len()).collect();
    let observation = Observation::new("d", values).with_independent_noise(0, &all);
    Data::new(vec![observation], vec![NoiseGroup::fixed("noise", "1", sd)]).unwrap()
}

/// What the parameters of a stage are in the next one: its posterior stands in the place of their priors.
fn handed_on(parameters: &Parameters, found: &Assessment) -> Parameters {
    let names: Vec<&str> = parameters.list().iter().map(|p| p.name.as_str()).collect();
    let laplace = found.laplace.as_ref().unwrap();
    let declared = Parameters::new(parameters.list().to_vec()).unwrap();
    declared.with_physical_joint(&names, &laplace.parameters, &laplace.physical_covariance).unwrap()
}

fn ln_marginal(found: &Assessment) -> f64 {
    found.evidence.as_ref().unwrap().ln_marginal
}

#[test]
fn oracle_three_stages_against_one_fit_of_all_data() {
    // Stage 1 tells of a, b; stage 2 of a and c; stage 3 of b and c. One fit has the data of all three.
    let mut x = design("stages", 30, 3);
    for i in 0..30 {
        let absent = [2, 1, 0][i / 10];
        x[(i, absent)] = 0.0;
    }
    let y: Vec<f64> = numbers("stages/y", 30).iter().map(|v| 0.5 + v).collect();
    let list = vec![normal("a", 0.3, 0.5), normal("b", 0.0, 2.0), normal("c", -1.0, 1.0)];
    let declared = Parameters::new(list).unwrap();
    let (mut parameters, mut sum, mut last) = (declared.clone(), 0.0, None);
    for rows in [0..10, 10..20, 20..30] {
        let model = Linear(Matrix::from_fn(10, 3, |i, j| x[(rows.start + i, j)]));
        let data = data(y[rows].to_vec(), 0.4);
        let found = assess(&model, &data, &parameters, &AssessOptions::default()).unwrap();
        sum += ln_marginal(&found);
        parameters = handed_on(&parameters, &found);
        last = Some(found);
    }
    let (last, whole) =
        (last.unwrap(), assess(&Linear(x), &data(y, 0.4), &declared, &AssessOptions::default()).unwrap());
    assert_relative_eq!(sum, ln_marginal(&whole), max_relative = 1e-12);
    let (found, expected) = (last.laplace.unwrap(), whole.laplace.unwrap());
    for i in 0..3 {
        assert_abs_diff_eq!(found.mean[i], expected.mean[i], epsilon = 1e-10);
        for j in 0..3 {
            assert_abs_diff_eq!(found.covariance[(i, j)], expected.covariance[(i, j)], epsilon = 1e-12);
        }
    }
    let (one, all) = (last.health.conflict.declared, whole.health.conflict.declared);
    assert_relative_eq!(one.chi_squared, all.chi_squared, max_relative = 1e-9);
}

#[test]
fn behaviour_a_penalty_of_an_early_stage_stays_in_the_number() {
    // eta is 1 +- 0.5 by its prior, and 3.76 by data: of old, the second stage started from 3.76 as if it had
    // always been known.
    let one = Linear(Matrix::from_fn(20, 1, |_, _| 1.0));
    let run = |truth: f64| {
        let parameters = Parameters::new(vec![normal("eta", 1.0, 0.5)]).unwrap();
        let data = data(vec![truth; 20], 0.01);
        let first = assess(&one, &data, &parameters, &AssessOptions::default()).unwrap();
        let parameters = handed_on(&parameters, &first);
        let second = assess(&one, &data, &parameters, &AssessOptions::default()).unwrap();
        (ln_marginal(&first) + ln_marginal(&second), second)
    };
    let ((good_sum, good), (bad_sum, bad)) = (run(1.0), run(3.76));
    // The second stage alone does not see it; the sum does: (2.76/0.5)^2/2 = 15.24 nats.
    assert_abs_diff_eq!(ln_marginal(&good), ln_marginal(&bad), epsilon = 1e-3);
    assert_abs_diff_eq!(good_sum - bad_sum, 15.235, epsilon = 0.02);
    let expected = 2.76 / 0.5;
    let offset = &bad.health.conflict.offsets[0];
    assert_abs_diff_eq!(offset.sds, expected, epsilon = 1e-3);
    assert!(offset.carried_sds.unwrap().abs() < 0.05);
    let warnings = bad.health.conflict.warnings();
    assert!(
        matches!(&warnings[0], ConflictWarning::Parameter { parameter, carried: false, .. } if parameter == "eta"),
        "{warnings:?}"
    );
    let words = bad.health.warnings.join("; ");
    assert!(words.contains("eta = 3.7600 lies +5.5 sd from its prior"), "{words}");
    assert!(warnings.len() == 2 && good.health.conflict.warnings().is_empty());
}

#[test]
fn exact_tension_of_a_linear_model_is_that_of_its_evidence() {
    // For one parameter seen once: T = (d - m)^2/(s^2 + sd^2), whatever share of the prior the datum takes
    // away.
    for (sd, datum) in [(0.1, 3.0), (1.0, 3.0), (3.0, 9.0)] {
        let parameters = Parameters::new(vec![normal("a", 0.5, 1.0)]).unwrap();
        let one = Linear(Matrix::identity(1));
        let found = assess(&one, &data(vec![datum], sd), &parameters, &AssessOptions::default()).unwrap();
        let expected = (datum - 0.5) / (1.0 + sd * sd).sqrt();
        assert_relative_eq!(found.health.conflict.declared.sds, expected, max_relative = 1e-9);
        let mean = 0.5 + (datum - 0.5) / (1.0 + sd * sd);
        assert_relative_eq!(found.health.conflict.offsets[0].sds, mean - 0.5, max_relative = 1e-9);
    }
}

#[test]
fn exact_directions_that_the_data_do_not_tell_are_no_surprise() {
    // One datum of two parameters: T = (d - x'm)^2/(x'x + sd^2), of one degree of freedom.
    let (row, means, sd, datum) = ([0.8, -0.3], [0.5, 4.0], 0.2, 3.0);
    let parameters = Parameters::new(vec![normal("a", means[0], 1.0), normal("b", means[1], 1.0)]).unwrap();
    let one = Linear(Matrix::from_fn(1, 2, |_, j| row[j]));
    let found = assess(&one, &data(vec![datum], sd), &parameters, &AssessOptions::default()).unwrap();
    let expected = (datum - row[0] * means[0] - row[1] * means[1]) / (0.73_f64 + sd * sd).sqrt();
    assert_relative_eq!(found.health.conflict.declared.sds, expected, max_relative = 1e-9);
    assert_eq!(found.health.conflict.declared.freedom, 1);
}

#[test]
fn exact_a_conflict_begins_at_four_standard_deviations() {
    // A datum that leaves nothing of the prior, 3.99 and 4.01 prior standard deviations from its centre.
    for (distance, warnings) in [(3.99, 0), (-3.99, 0), (4.01, 2), (-4.01, 2)] {
        let parameters = Parameters::new(vec![normal("a", 0.5, 2.0)]).unwrap();
        let one = Linear(Matrix::identity(1));
        let data = data(vec![0.5 + 2.0 * distance], 1e-4);
        let found = assess(&one, &data, &parameters, &AssessOptions::default()).unwrap();
        assert_eq!(found.health.conflict.warnings().len(), warnings, "{distance}");
    }
}

#[test]
fn coverage_tension_of_draws_from_the_prior() {
    // Truths from the prior: the tension must exceed two standard deviations in 4.55 % of cases.
    use rand::RngExt;
    let mut stream = rijke_numerics::Streams::new(5).stream("tension");
    let mut normal_number = || stream.sample::<f64, _>(rand_distr::StandardNormal);
    let x = design("tension", 6, 4);
    let parameters = Parameters::new((0..4).map(|i| normal(&format!("a{i}"), 0.0, 1.0)).collect()).unwrap();
    let (mut beyond, cases) = (0, 1000);
    for _ in 0..cases {
        let truth: Vec<f64> = (0..4).map(|_| normal_number()).collect();
        let y: Vec<f64> = x.times(&truth).iter().map(|v| v + 0.3 * normal_number()).collect();
        let (model, data) = (Linear(x.clone()), data(y, 0.3));
        let posterior = Posterior::new(&model, &data, &parameters).unwrap();
        let fit = posterior.map(&MapOptions::default()).unwrap();
        let conflict = posterior.conflict(&fit, &posterior.laplace(&fit).unwrap()).unwrap();
        beyond += usize::from(conflict.declared.sds > 2.0);
    }
    // Binomial: 45.5 +- 6.6.
    assert!((26..66).contains(&beyond), "{beyond} of {cases}");
}

#[test]
fn exact_bounded_priors_count_by_their_tails() {
    let one = Linear(Matrix::identity(1));
    let sds = |prior: Prior, datum: f64| {
        let parameters = Parameters::new(vec![Parameter::new("k", "k", "1", prior)]).unwrap();
        let data = data(vec![datum], 1e-4);
        let posterior = Posterior::new(&one, &data, &parameters).unwrap();
        let fit = posterior.map(&MapOptions::default()).unwrap();
        posterior.conflict(&fit, &posterior.laplace(&fit).unwrap()).unwrap().offsets[0].sds
    };
    assert_abs_diff_eq!(sds(Prior::Uniform { low: 0.0, high: 1.0 }, 0.975), 1.96, epsilon = 0.01);
    assert_abs_diff_eq!(sds(Prior::HalfNormal { sd: 0.1 }, 0.6), 6.0, epsilon = 0.01);
    assert_abs_diff_eq!(sds(Prior::LogNormal { median: 1.0, ln_sd: 0.1 }, 0.5), -6.93, epsilon = 0.01);
    let far = Prior::Truncated { mean: 0.0, sd: 0.1, low: -1.0, high: 1.0 };
    assert_abs_diff_eq!(sds(far, -0.7), -7.0, epsilon = 0.02);
}
