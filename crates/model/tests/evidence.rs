//! The evidence of the prong models of Table 2 against referees, what each costs, and calibration on a Rijke model.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a long study prints what it measures")]

use rijke_candidates::Catalogue;
use rijke_inference::{
    AssessOptions, Data, Judged, LikelihoodTarget, MapOptions, NoiseGroup, NoiseMode, Observation,
    Parameters, Posterior, RefereeKind, Target,
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
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/candidates/");
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
    Predictor::new(points, assembly.parameters().len())
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

/// The headline: what Laplace's method, NUTS and nested sampling cost to the same error of ln ML, 0.1 nat, in one run.
#[test]
#[ignore = "long: referees of the prong models to 0.1 nat"]
fn oracle_laplace_against_referees_on_the_prong_models() {
    let observed = observed();
    let data = noisy(&observed, 1);
    for id in ["prongs.5", "prongs.6", "prongs.7", "prongs.4"] {
        let assembly = assembly(id);
        let model = predictor(&assembly, &observed);
        let parameters = Parameters::new(assembly.parameters().to_vec()).unwrap();
        let posterior = Posterior::new(&model, &data, &parameters).unwrap();
        let timed = |what: &mut dyn FnMut()| {
            let clock = std::time::Instant::now();
            what();
            clock.elapsed().as_secs_f64()
        };
        // The first call pays for threads.
        let fit = posterior.map(&MapOptions::bfgs()).unwrap();
        let laplace = posterior.laplace(&fit).unwrap();
        let fast = timed(&mut || {
            posterior.laplace(&posterior.map(&MapOptions::bfgs()).unwrap()).unwrap();
        });
        let mut found = None;
        let checked = timed(&mut || found = Some(posterior.assess(&AssessOptions::default()).unwrap()));
        let (found, calls, ln) = (found.unwrap(), fit.calls.total() + 1, laplace.evidence.ln_marginal);
        println!(
            "{id}: {} parameters, {} operating points\n  Laplace: ln ML {ln:.3}, {calls} calls, {fast:.4} s; \
             BFGS matrix off by {:.3}, second derivatives {:.1e} of the Hessian\n  with checks: {:?}, {} calls, {checked:.3} s, {:?}",
            parameters.len(),
            observed.len(),
            laplace.bfgs_distance.unwrap(),
            laplace.curvature_ratio(),
            found.health.importance,
            found.health.calls.total(),
            found.health.warnings,
        );
        let target = LikelihoodTarget::new(&posterior, &fit).unwrap();
        let nuts = cfg!(feature = "nuts").then_some(RefereeKind::Nuts);
        for kind in nuts.into_iter().chain([RefereeKind::Nested]) {
            let size = target.size();
            let referee = kind.build(0.1, laplace.evidence.ln_occam, size, Streams::new(1)).unwrap();
            let mut judged = Judged::default();
            let slow = timed(&mut || judged = referee.judge(&target).unwrap());
            println!(
                "  {}: ln ML {:.3} +- {:.3}, {:?}, {slow:.2} s: {:.0} times the calls, {:.0} times the seconds of Laplace",
                referee.name(),
                judged.ln_marginal,
                judged.standard_error,
                judged.calls,
                judged.calls.total() as f64 / calls as f64,
                slow / fast,
            );
            assert!(judged.finished && (ln - judged.ln_marginal).abs() < 3.5 * judged.standard_error);
        }
    }
}

/// The paper's remark that MAP and MML parameters are almost identical, and the maximum by another route: fixed noise.
#[test]
fn oracle_marginal_likelihood_of_a_prong_model() {
    let observed = observed();
    let data = noisy(&observed, 1);
    for id in ["prongs.6", "prongs.7"] {
        let assembly = assembly(id);
        let model = predictor(&assembly, &observed);
        let parameters = Parameters::new(assembly.parameters().to_vec()).unwrap();
        let posterior = Posterior::new(&model, &data, &parameters).unwrap();
        let fit = posterior.map(&MapOptions::default()).unwrap();
        let sds = posterior.laplace(&fit).unwrap().sd();
        let found = posterior.maximise_marginal(&fit).unwrap();
        assert!(found.stop.converged(), "{:?}", found.stop);
        let shifts: Vec<f64> =
            (0..sds.len()).map(|i| (found.fit.parameters[i] - fit.parameters[i]) / sds[i]).collect();
        let ratios: Vec<f64> = found.fit.noise.iter().zip(&fit.noise).map(|(m, f)| m.sd / f.sd).collect();
        println!("{id}: MML - MAP in posterior sd {shifts:.4?}, noise MML/MAP {ratios:.4?}");
        assert!(shifts.iter().all(|s| s.abs() < 0.05), "{shifts:?}");
        // Without free noise there is no gradient of the marginal likelihood to be wrong.
        let with = |sds: &[f64]| {
            let groups = data.groups().iter().zip(sds);
            let groups = groups.map(|(g, &sd)| NoiseGroup { mode: NoiseMode::Fixed { sd }, ..g.clone() });
            let data = Data::new(data.observations().to_vec(), groups.collect()).unwrap();
            let posterior = Posterior::new(&model, &data, &parameters).unwrap();
            let fit = posterior.map(&MapOptions::default()).unwrap();
            posterior.laplace(&fit).unwrap().evidence.ln_marginal
        };
        let best: Vec<f64> = found.fit.noise.iter().map(|n| n.sd).collect();
        let middle = with(&best);
        assert!((middle - found.ln_marginal).abs() < 1e-8, "{middle} {}", found.ln_marginal);
        for g in 0..best.len() {
            let h = 1e-3_f64;
            let at = |h: f64| {
                let mut sds = best.clone();
                sds[g] *= h.exp();
                with(&sds)
            };
            let (up, down) = (at(h), at(-h));
            let (slope, bend) = ((up - down) / (2.0 * h), (up - 2.0 * middle + down) / (h * h));
            assert!(bend < 0.0 && (slope / bend).abs() < 1e-4, "{id} noise {g}: {slope} {bend}");
        }
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
