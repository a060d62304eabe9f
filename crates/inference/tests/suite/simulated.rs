//! Simulated data: calibration, model check, and files.

use crate::problems::{Ringing, normal, ringing, simulate};
use rand::RngExt;
use rand_distr::StandardNormal;
use rayon::prelude::*;
use rijke_inference::*;
use rijke_numerics::{Cholesky, Matrix, Order, Stream, Streams};

/// The damped oscillation with noise low enough to be near-Gaussian, and proper priors that the truth is
/// drawn from.
fn clean() -> (Ringing, Data, Parameters) {
    let model = Ringing { times: (0..12).map(|k| 0.25 * f64::from(k)).collect() };
    let values = model.predict(&[1.3, 0.4, 2.1], Order::Value).unwrap().values;
    let observations = values
        .chunks(4)
        .enumerate()
        .map(|(b, v)| Observation::new(format!("{b}"), v.to_vec()).with_independent_noise(0, &[0, 1, 2, 3]));
    let data = Data::new(observations.collect(), vec![NoiseGroup::fixed("noise", "V", 0.03)]).unwrap();
    let parameters = Parameters::new(vec![
        normal("amplitude", 1.3, 0.1),
        normal("rate", 0.4, 0.1),
        normal("frequency", 2.1, 0.1),
    ])
    .unwrap();
    (model, data, parameters)
}

/// Fits of as many sets of data, set k with the truth that `truth` makes from a stream of its own: truths
/// and Laplace's Gaussians.
fn refits<'a>(
    posterior: &Posterior<'a>,
    sets: usize,
    options: &MapOptions,
    truth: impl Fn(&mut Stream) -> Vec<f64> + Sync,
) -> Vec<(Vec<f64>, Laplace)> {
    let one = |k: usize| {
        let mut stream = Streams::new(9).stream(&format!("refits/{k}"));
        let truth = truth(&mut stream);
        let data = simulate(posterior, &truth, &mut stream);
        let again = Posterior::new(posterior.forward(), &data, posterior.parameters()).unwrap();
        let fit = again.map(options).unwrap();
        assert!(fit.stop.converged(), "set {k}: {}", fit.stop);
        (truth, again.laplace(&fit).unwrap())
    };
    (0..sets).into_par_iter().map(one).collect()
}

/// Talts et al. 2018: truths drawn from the prior are spread evenly over the quantiles of their posteriors.
#[test]
fn oracle_simulation_based_calibration() {
    let (model, data, parameters) = clean();
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let fit = posterior.map(&MapOptions::default()).unwrap();
    let (sets, slices) = (500, 20);
    let found = refits(&posterior, sets, &MapOptions::default(), |stream| {
        let xi: Vec<f64> = (0..3).map(|_| stream.sample(StandardNormal)).collect();
        parameters.from_standard_normal(&xi)
    });
    for i in 0..3 {
        let mut counts = vec![0.0; slices];
        for (truth, laplace) in &found {
            let quantile = normal_cdf((truth[i] - laplace.mean[i]) / laplace.covariance[(i, i)].sqrt());
            counts[((quantile * slices as f64) as usize).min(slices - 1)] += 1.0;
        }
        let expected = sets as f64 / slices as f64;
        let chi_squared: f64 = counts.iter().map(|c| (c - expected).powi(2) / expected).sum();
        // A probability of 1 %.
        assert!(chi_squared_sds(chi_squared, slices - 1) < 2.58, "{i}: {counts:?}");
    }
    // The gate can fail: a likelihood that claims half the true noise is seen.
    let groups = vec![NoiseGroup::fixed("noise", "V", 0.015)];
    let proud = Data::new(data.observations().to_vec(), groups).unwrap();
    let proud = Posterior::new(&model, &proud, &parameters).unwrap();
    let mut outside = 0;
    for k in 0..200 {
        let mut stream = Streams::new(9).stream(&format!("proud/{k}"));
        let noisy = simulate(&posterior, &fit.working, &mut stream);
        let claimed = Data::new(noisy.observations().to_vec(), proud.data().groups().to_vec()).unwrap();
        let again = Posterior::new(&model, &claimed, &parameters).unwrap();
        let laplace = again.laplace(&again.map(&MapOptions::default()).unwrap()).unwrap();
        outside += usize::from((laplace.parameters[2] - 2.1).abs() > 2.0 * laplace.sd()[2]);
    }
    assert!(outside > 30, "{outside} of 200 outside two claimed sd; about 60 are expected");
}

#[test]
fn oracle_model_check_finds_no_bias_and_honest_sds() {
    let (model, data, parameters) = clean();
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let fit = posterior.map(&MapOptions::default()).unwrap();
    let sets = 100;
    let found = refits(&posterior, sets, &MapOptions::bfgs(), |_| fit.working.clone());
    let mean = |values: &[f64]| values.iter().sum::<f64>() / sets as f64;
    for i in 0..3 {
        let misses: Vec<f64> = found.iter().map(|(_, l)| l.parameters[i] - fit.parameters[i]).collect();
        let sds: Vec<f64> = found.iter().map(|(_, l)| l.sd()[i]).collect();
        let bias = mean(&misses);
        let scatter = mean(&misses.iter().map(|m| (m - bias).powi(2)).collect::<Vec<_>>()).sqrt();
        assert!(bias.abs() < 4.0 * scatter / (sets as f64).sqrt(), "{i}: {bias} {scatter}");
        // The scatter of estimates that a prior of sd 0.1 also informs is below the stated sd, by little
        // here.
        assert!((0.75..1.15).contains(&(scatter / mean(&sds))), "{i}: {scatter} {}", mean(&sds));
        let within = |n: f64| misses.iter().zip(&sds).filter(|(m, sd)| m.abs() <= n * **sd).count();
        assert!(within(2.0) >= 90 && (55..85).contains(&within(1.0)), "{i}: {} {}", within(1.0), within(2.0));
    }
}

#[test]
fn oracle_leave_one_out_against_refits() {
    let (model, data, parameters) = clean();
    let mut stream = Streams::new(5).stream("left out");
    let noisy = Posterior::new(&model, &data, &parameters).unwrap();
    let truth = parameters.working(&[1.3, 0.4, 2.1]);
    let data = simulate(&noisy, &truth, &mut stream);
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let fit = posterior.map(&MapOptions::default()).unwrap();
    let laplace = posterior.laplace(&fit).unwrap();
    let linear = posterior.linearised(&fit, &laplace).unwrap();
    for b in 0..data.observations().len() {
        let places: Vec<usize> = (4 * b..4 * b + 4).collect();
        let found = linear.left_out(&places).unwrap().ln_density;
        // ln p(block | rest) = ln p(all) - ln p(rest), by a fit of the rest.
        let others = data.observations().iter().enumerate().filter(|(k, _)| *k != b).map(|(_, o)| o.clone());
        let rest = Data::new(others.collect(), data.groups().to_vec()).unwrap();
        let times = model.times.iter().enumerate().filter(|(k, _)| k / 2 != b).map(|(_, t)| *t).collect();
        let model = Ringing { times };
        let posterior = Posterior::new(&model, &rest, &parameters).unwrap();
        let without = posterior.laplace(&posterior.map(&MapOptions::default()).unwrap()).unwrap();
        let exact = laplace.evidence.ln_marginal - without.evidence.ln_marginal;
        assert!((found - exact).abs() < 0.05, "{b}: {found} {exact}");
    }
}

/// With floated noise, which each refit chooses from what it has.
#[test]
fn oracle_leave_one_out_with_floated_noise_against_refits() {
    let (model, data, parameters) = clean();
    let floated = Data::new(data.observations().to_vec(), vec![NoiseGroup::floated("noise", "V")]).unwrap();
    let noisy = Posterior::new(&model, &data, &parameters).unwrap();
    let truth = parameters.working(&[1.3, 0.4, 2.1]);
    let mut stream = Streams::new(6).stream("left out");
    let values = simulate(&noisy, &truth, &mut stream);
    let data = Data::new(values.observations().to_vec(), floated.groups().to_vec()).unwrap();
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let fit = posterior.map(&MapOptions::default()).unwrap();
    let linear = posterior.linearised(&fit, &posterior.laplace(&fit).unwrap()).unwrap();
    for (b, own) in data.observations().iter().enumerate() {
        let found = linear.left_out(&(4 * b..4 * b + 4).collect::<Vec<_>>()).unwrap();
        let others = data.observations().iter().enumerate().filter(|(k, _)| *k != b).map(|(_, o)| o.clone());
        let rest = Data::new(others.collect(), data.groups().to_vec()).unwrap();
        let times = |keep: bool| {
            model.times.iter().enumerate().filter(|(k, _)| (k / 2 == b) == keep).map(|(_, t)| *t).collect()
        };
        let model = Ringing { times: times(false) };
        let posterior = Posterior::new(&model, &rest, &parameters).unwrap();
        let fit = posterior.map(&MapOptions::default()).unwrap();
        let predicted = posterior.laplace(&fit).unwrap().predict(&Ringing { times: times(true) }).unwrap();
        let noise = Matrix::diagonal(&[fit.noise[0].sd.powi(2); 4]);
        let factor = Cholesky::new(&predicted.covariance.plus(1.0, &noise)).unwrap();
        let residuals: Vec<f64> = own.values.iter().zip(&predicted.mean).map(|(y, f)| y - f).collect();
        let square: f64 = factor.whiten(&residuals).iter().map(|w| w * w).sum();
        let exact = -0.5 * (square + factor.ln_det()) - 2.0 * std::f64::consts::TAU.ln();
        assert!((found.ln_density - exact).abs() < 0.05, "{b}: {} {exact}", found.ln_density);
    }
}

#[test]
fn exact_draws_have_the_layout_that_arviz_reads() {
    let (model, data, parameters) = ringing();
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let laplace = posterior.laplace(&posterior.map(&MapOptions::default()).unwrap()).unwrap();
    let draws = Draws::new(&parameters, &laplace, &vec![1.0; parameters.len()], 40, Streams::new(2)).unwrap();
    // from_json wants group -> variable -> chains -> draws, and attributes as group_attrs.
    let json: serde_json::Value = serde_json::to_value(&draws).unwrap();
    let groups: Vec<&String> = json.as_object().unwrap().keys().collect();
    assert_eq!(groups, ["posterior", "posterior_attrs"]);
    let variables = json["posterior"].as_object().unwrap();
    assert_eq!(variables.len(), 3);
    for values in variables.values() {
        let chains = values.as_array().unwrap();
        assert_eq!(chains.len(), 1);
        assert_eq!(chains[0].as_array().unwrap().len(), 40);
        assert!(chains[0].as_array().unwrap().iter().all(serde_json::Value::is_f64));
    }
    assert!(json["posterior_attrs"].as_object().unwrap().values().all(serde_json::Value::is_string));
}

#[test]
fn exact_records_survive_json() {
    let (model, data, parameters) = ringing();
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let assessment = posterior.assess(&AssessOptions::default()).unwrap();
    let record = InferenceRecord::new("ringing", &parameters, &assessment, &vec![1.0; parameters.len()]);
    let back: InferenceRecord = serde_json::from_str(&serde_json::to_string(&record).unwrap()).unwrap();
    assert_eq!(back.parameters, record.parameters);
    assert_eq!(back.evidence, record.evidence);
    let laplace = assessment.laplace.unwrap();
    let draws =
        Draws::new(&parameters, &laplace, &vec![1.0; parameters.len()], 2000, Streams::new(2)).unwrap();
    let amplitude = &draws.posterior["amplitude"][0];
    let mean = amplitude.iter().map(|a| a.ln()).sum::<f64>() / 2000.0;
    assert!((mean - laplace.mean[0]).abs() < 4.0 * (laplace.covariance[(0, 0)] / 2000.0).sqrt());
}

/// Few numbers whose noise floats: what a record states holds the truth as often as two standard deviations
/// should.
#[test]
fn coverage_of_records_of_few_data() {
    for n in [4, 8] {
        let (mut inside, count) = (0, 400);
        for seed in 0..count {
            let mut stream = Streams::new(seed).stream("few");
            let values = (0..n).map(|_| -> f64 { stream.sample(StandardNormal) }).collect();
            let which: Vec<usize> = (0..n).collect();
            let observation = Observation::new("few", values).with_independent_noise(0, &which);
            let data = Data::new(vec![observation], vec![NoiseGroup::floated("noise", "1")]).unwrap();
            let prior = Prior::Normal { mean: 0.0, sd: 100.0 };
            let parameters = Parameters::new(vec![Parameter::new("mean", "m", "1", prior)]).unwrap();
            let model = Mean(n);
            let posterior = Posterior::new(&model, &data, &parameters).unwrap();
            let assessment = posterior.assess(&AssessOptions::default()).unwrap();
            let few =
                posterior.linearised(&assessment.fit, assessment.laplace.as_ref().unwrap()).unwrap().few();
            let record = InferenceRecord::new("few", &parameters, &assessment, &few.parameters);
            let [value, sd] = [record.parameters[0].value, record.parameters[0].sd.unwrap()];
            inside += usize::from(value.abs() < 2.0 * sd);
            assert!((record.covariance[0][0].sqrt() / sd - 1.0).abs() < 1e-9);
        }
        let share = inside as f64 / count as f64;
        println!("{n} numbers: {share}");
        assert!((0.925..0.98).contains(&share), "{n}: {share}");
    }
}

/// Every number is the parameter.
struct Mean(usize);

impl Forward for Mean {
    fn predict(&self, a: &[f64], _: Order) -> Result<Prediction, ForwardError> {
        let jacobian = Matrix::from_fn(self.0, 1, |_, _| 1.0);
        Ok(Prediction { values: vec![a[0]; self.0], jacobian, curvature: vec![0.0; self.0] })
    }
}
