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

/// Columns of `all` as a model of those parameters alone.
fn columns(all: &Matrix, rows: std::ops::Range<usize>, keep: &[usize]) -> Linear {
    Linear(Matrix::from_fn(rows.len(), keep.len(), |i, j| all[(rows.start + i, keep[j])]))
}

#[test]
fn oracle_three_stages_against_one_fit_of_all_data() {
    // Stage 1 knows a, b; stage 2 knows a and c, but not b; stage 3 knows b and c. One fit knows all three.
    let mut x = design("stages", 30, 3);
    for i in 0..30 {
        let absent = [2, 1, 0][i / 10];
        x[(i, absent)] = 0.0;
    }
    let y: Vec<f64> = numbers("stages/y", 30).iter().map(|v| 0.5 + v).collect();
    let list = [normal("a", 0.3, 0.5), normal("b", 0.0, 2.0), normal("c", -1.0, 1.0)];
    let mut chain = EvidenceChain::default();
    for (k, keep) in [vec![0, 1], vec![0, 2], vec![2, 1]].into_iter().enumerate() {
        let rows = 10 * k..10 * k + 10;
        let model = columns(&x, rows.clone(), &keep);
        let parameters = chain.parameters(keep.iter().map(|&i| list[i].clone()).collect()).unwrap();
        let found =
            assess(&model, &data(y[rows].to_vec(), 0.4), &parameters, &AssessOptions::default()).unwrap();
        chain = chain.then(&format!("stage {k}"), &parameters, &found).unwrap();
    }
    let parameters = Parameters::new(list.to_vec()).unwrap();
    let whole = assess(&Linear(x), &data(y, 0.4), &parameters, &AssessOptions::default()).unwrap();
    let laplace = whole.laplace.unwrap();
    assert_relative_eq!(chain.ln_marginal(), laplace.evidence.ln_marginal, max_relative = 1e-12);
    let (mean, covariance) = chain.known();
    for i in 0..3 {
        assert_abs_diff_eq!(mean[i], laplace.mean[i], epsilon = 1e-10);
        for j in 0..3 {
            assert_abs_diff_eq!(covariance[(i, j)], laplace.covariance[(i, j)], epsilon = 1e-12);
        }
    }
    let (one, all) = (chain.conflict().unwrap(), whole.conflict);
    assert_relative_eq!(one.declared.chi_squared, all.declared.chi_squared, max_relative = 1e-9);
    assert_eq!(chain.stages().len(), 3);
}

#[test]
fn behaviour_a_penalty_of_an_early_stage_stays_in_the_number() {
    // eta is 1 +- 0.5 by its prior, and 3.76 by data: of old, the second stage started from 3.76 as if it had
    // always been known.
    let one = Linear(Matrix::from_fn(20, 1, |_, _| 1.0));
    let eta = normal("eta", 1.0, 0.5);
    let run = |truth: f64| {
        let chain = EvidenceChain::default();
        let parameters = chain.parameters(vec![eta.clone()]).unwrap();
        let first =
            assess(&one, &data(vec![truth; 20], 0.01), &parameters, &AssessOptions::default()).unwrap();
        let chain = chain.then("first", &parameters, &first).unwrap();
        let parameters = chain.parameters(vec![eta.clone()]).unwrap();
        let second =
            assess(&one, &data(vec![truth; 20], 0.01), &parameters, &AssessOptions::default()).unwrap();
        (chain.then("second", &parameters, &second).unwrap(), second)
    };
    let ((good, _), (bad, second)) = (run(1.0), run(3.76));
    let stage = |c: &EvidenceChain| c.stages()[1].evidence.ln_marginal;
    // The second stage alone does not see it; the sum does: (2.76/0.5)^2/2 = 15.24 nats.
    assert_abs_diff_eq!(stage(&good), stage(&bad), epsilon = 1e-3);
    assert_abs_diff_eq!(good.ln_marginal() - bad.ln_marginal(), 15.235, epsilon = 0.02);
    let expected = 2.76 / 0.5;
    let offset = &second.conflict.offsets[0];
    assert_abs_diff_eq!(offset.sds, expected, epsilon = 1e-3);
    assert!(offset.carried_sds.unwrap().abs() < 0.05);
    let warnings = second.conflict.warnings();
    assert!(
        matches!(&warnings[0], ConflictWarning::Parameter { parameter, carried: false, .. } if parameter == "eta"),
        "{warnings:?}"
    );
    let words = second.health.warnings.join("; ");
    assert!(words.contains("eta = 3.7600e0 lies +5.5 sd from its prior"), "{words}");
    assert!(bad.conflict().unwrap().warnings().len() == 2 && good.conflict().unwrap().warnings().is_empty());
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
        assert_relative_eq!(found.conflict.declared.sds, expected, max_relative = 1e-9);
        let mean = 0.5 + (datum - 0.5) / (1.0 + sd * sd);
        assert_relative_eq!(found.conflict.offsets[0].sds, mean - 0.5, max_relative = 1e-9);
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
