//! Simulated data: calibration, model check, and files.

use crate::problems::{Ringing, normal, ringing};
use rijke_inference::*;
use rijke_numerics::{Order, Streams};

/// The damped oscillation with noise low enough to be near-Gaussian, and proper priors that the truth is drawn from.
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

#[test]
fn oracle_simulation_based_calibration() {
    let (model, data, parameters) = clean();
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let fit = posterior.map(&MapOptions::default()).unwrap();
    let found = posterior.calibrate(&fit, &MapOptions::default(), 500, Streams::new(9)).unwrap();
    assert_eq!(found.failed, 0);
    assert!(found.p_values.iter().all(|p| *p > 0.01), "{found:?}");
    // The gate can fail: a likelihood that claims half the true noise is seen.
    let groups = vec![NoiseGroup::fixed("noise", "V", 0.015)];
    let proud = Data::new(data.observations().to_vec(), groups).unwrap();
    let proud = Posterior::new(&model, &proud, &parameters).unwrap();
    let mut outside = 0;
    for k in 0..200 {
        let mut stream = Streams::new(9).stream(&format!("proud/{k}"));
        let noisy = posterior.simulate(&fit.working, &mut stream).unwrap();
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
    let found = posterior.check(&fit, &MapOptions::bfgs(), 100, Streams::new(4)).unwrap();
    assert_eq!(found.failed, 0);
    for row in &found.parameters {
        assert!(row.bias.abs() < 4.0 * row.bias_error, "{row:?}");
        // The scatter of estimates that a prior of sd 0.1 also informs is below the stated sd, by little here.
        assert!((0.75..1.15).contains(&(row.scatter / row.stated_sd)), "{row:?}");
        assert!(row.within_2_sd >= 0.9 && (0.55..0.85).contains(&row.within_1_sd), "{row:?}");
    }
}

#[test]
fn exact_records_survive_json_and_csv() {
    let (model, data, parameters) = ringing();
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let assessment = posterior.assess(&AssessOptions::default()).unwrap();
    let record = Record::new("ringing, damped", &parameters, &assessment);
    let back: Record = serde_json::from_str(&serde_json::to_string(&record).unwrap()).unwrap();
    assert_eq!(back.parameters, record.parameters);
    assert_eq!(back.evidence, record.evidence);
    let csv = evidence_csv(std::slice::from_ref(&record));
    let lines: Vec<&str> = csv.lines().collect();
    assert!(lines[1].starts_with("\"ringing, damped\",3,6,"), "{csv}");
    assert_eq!(lines[0].split(',').count(), lines[1].replace("\"ringing, damped\"", "x").split(',').count());
    assert_eq!(record.parameters_csv().lines().count(), 4);
    let laplace = assessment.laplace.unwrap();
    let draws = Draws::new(&parameters, &laplace, 2000, Streams::new(2)).unwrap();
    let amplitude = &draws.posterior["amplitude"][0];
    let mean = amplitude.iter().map(|a| a.ln()).sum::<f64>() / 2000.0;
    assert!((mean - laplace.mean[0]).abs() < 4.0 * (laplace.covariance[(0, 0)] / 2000.0).sqrt());
}
