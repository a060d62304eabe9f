//! The evidence of the prong models of Table 2 against referees, what each costs, and calibration on a Rijke model.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a long study prints what it measures")]

use rijke_candidates::Catalogue;
use rijke_inference::{
    AssessOptions, Data, LikelihoodTarget, MapOptions, Nested, NoiseGroup, NoiseMode, Observation,
    Parameters, Posterior, Referee, Target,
};
use rijke_model::{Assembly, Conditions, Noise, Observed, PointModel, Predictor, data_of};
use rijke_network::Workspace;
use rijke_numerics::{Matrix, Order, Streams};
use rijke_rig::{Campaign, Ping, Rig};

const ALL: [usize; 8] = [0, 1, 2, 3, 4, 5, 6, 7];

/// Noise of the mean of 40 pings with some model error: growth rate and frequency in 1/s and rad/s, relative pressure.
const SD: [f64; 3] = [0.1, 0.2, 1e-3];

fn catalogue() -> Catalogue {
    let read = |name: &str| {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/candidates/");
        Catalogue::read(std::path::Path::new(&format!("{folder}{name}"))).unwrap()
    };
    read("tube.toml").joined(read("prongs.toml"))
}

fn assembly(prongs: &str) -> Assembly {
    let all = catalogue();
    let chosen = ["wall.rayleigh", "ends.levine-schwinger", prongs];
    let chosen = chosen.iter().map(|id| all.get(id).unwrap().clone()).collect();
    Assembly::new(Rig::juniper_yoko_2022(), chosen).unwrap().fixed("eta", 1.05).unwrap()
}

/// Row C3 as model 6 gives it, without noise.
fn observed() -> Vec<Observed> {
    let truth = assembly("prongs.6");
    let points = Campaign::juniper_yoko_2022().points.into_iter().filter(|p| p.row == "C3");
    points
        .map(|point| {
            let conditions = Conditions::cold(&truth.rig, point, 293.15, 0.0).unwrap();
            let model = PointModel::new(&truth, &conditions, &ALL).unwrap();
            let r = model.respond(&[0.9, 1.05], Order::Value, &mut Workspace::default()).unwrap();
            let pressures = r.pressures.iter().map(|p| p.value()).collect();
            let variance: Vec<f64> = (0..16).map(|k| SD[k.min(2)].powi(2)).collect();
            let ping =
                Ping { s: r.s.value(), pressures, reference: 5, covariance: Matrix::diagonal(&variance) };
            Observed { conditions, ping }
        })
        .collect()
}

fn predictor<'a>(assembly: &'a Assembly, observed: &[Observed]) -> Predictor<'a> {
    let points = observed
        .iter()
        .map(|o| PointModel::new(assembly, &o.conditions, &ALL).unwrap().starting_from(o.ping.s))
        .collect();
    Predictor::new(points, assembly.parameters().len(), 5)
}

/// The data with noise drawn from the covariances, and the groups floating.
fn noisy(observed: &[Observed], seed: u64) -> Data {
    let exact = data_of(observed, &ALL, &Noise::MEASURED).unwrap();
    let floating = data_of(observed, &ALL, &Noise::FLOATED).unwrap();
    let truth = assembly("prongs.6");
    let model = predictor(&truth, observed);
    let parameters = Parameters::new(truth.parameters().to_vec()).unwrap();
    let posterior = Posterior::new(&model, &exact, &parameters).unwrap();
    let working = parameters.working(&[0.9, 1.05]);
    let drawn = posterior.simulate(&working, &mut Streams::new(seed).stream("model/evidence")).unwrap();
    let observations = floating.observations().iter().zip(drawn.observations());
    let observations = observations.map(|(f, d)| Observation { values: d.values.clone(), ..f.clone() });
    Data::new(observations.collect(), floating.groups().to_vec()).unwrap()
}

#[test]
#[ignore = "long: nested sampling of the prong models"]
fn oracle_laplace_against_nested_sampling_on_the_prong_models() {
    let observed = observed();
    let data = noisy(&observed, 1);
    let operating_points = observed.len();
    for (id, error) in [("prongs.5", 0.3), ("prongs.6", 0.3), ("prongs.7", 0.4)] {
        let assembly = assembly(id);
        let model = predictor(&assembly, &observed);
        let parameters = Parameters::new(assembly.parameters().to_vec()).unwrap();
        let posterior = Posterior::new(&model, &data, &parameters).unwrap();
        let clock = std::time::Instant::now();
        let fit = posterior.map(&MapOptions::bfgs()).unwrap();
        let laplace = posterior.laplace(&fit).unwrap();
        let fast = clock.elapsed().as_secs_f64();
        let clock = std::time::Instant::now();
        let found = posterior.assess(&AssessOptions::default()).unwrap();
        let checked = clock.elapsed().as_secs_f64();
        let target = LikelihoodTarget::new(&posterior, &fit).unwrap();
        let nested = Nested::with_error(error, -laplace.evidence.ln_occam, target.size(), Streams::new(1));
        let clock = std::time::Instant::now();
        let judged = nested.judge(&target).unwrap();
        let slow = clock.elapsed().as_secs_f64();
        // The statistical error falls with the square root of the calls.
        let to_a_tenth = (judged.standard_error / 0.1).powi(2);
        let calls = fit.calls.total() + 1;
        println!(
            "{id}: {} parameters, {operating_points} operating points\n  Laplace   ln ML {:.3}, {calls} model calls, {fast:.3} s; \
             BFGS matrix off by {:?}, second derivatives {:.4}\n  checked   {:?}\n            {} calls, {checked:.3} s; warnings {:?}\n  nested    ln ML {:.3} +- {:.3}, {} model calls, {slow:.1} s; \
             to 0.1 nat {:.3e} calls, {:.0} s: {:.0} times the calls, {:.0} times the seconds of Laplace",
            parameters.len(),
            laplace.evidence.ln_marginal,
            laplace.bfgs_distance,
            laplace.curvature_ratio(),
            found.health.importance,
            found.health.calls.total(),
            found.health.warnings,
            judged.ln_marginal,
            judged.standard_error,
            judged.calls.total(),
            judged.calls.total() as f64 * to_a_tenth,
            slow * to_a_tenth,
            judged.calls.total() as f64 * to_a_tenth / calls as f64,
            slow * to_a_tenth / fast,
        );
        assert!((laplace.evidence.ln_marginal - judged.ln_marginal).abs() < 3.0 * judged.standard_error);
    }
}

#[test]
#[ignore = "long: 5000 fits of row C3"]
fn oracle_simulation_based_calibration_of_a_prong_model() {
    let observed = observed();
    let assembly = assembly("prongs.6");
    let model = predictor(&assembly, &observed);
    let parameters = Parameters::new(assembly.parameters().to_vec()).unwrap();
    let exact = data_of(&observed, &ALL, &Noise::MEASURED).unwrap();
    let groups =
        exact.groups().iter().map(|g| NoiseGroup { mode: NoiseMode::Fixed { sd: 0.0 }, ..g.clone() });
    let data = Data::new(exact.observations().to_vec(), groups.collect()).unwrap();
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let fit = posterior.map(&MapOptions::default()).unwrap();
    let found = posterior.calibrate(&fit, &MapOptions::default(), 5000, Streams::new(100)).unwrap();
    println!("{found:?}");
    assert!(found.failed <= 50 && found.p_values.iter().all(|p| *p > 0.01), "{found:?}");
}
