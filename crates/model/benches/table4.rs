//! Ranking the nine models of Table 4 on the 105 hot operating points: best fit, floating noise, Laplace, evidence and
//! every check of it.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    missing_docs,
    reason = "a bench; its macros make undocumented functions"
)]

use criterion::{Criterion, criterion_group, criterion_main};
use rijke_candidates::Catalogue;
use rijke_flow::{Closures, Pipe};
use rijke_inference::{AssessOptions, Data, MapOptions, Parameters, Posterior};
use rijke_model::{Assembly, Conditions, Noise, Observed, PointModel, Predictor, Workspace, data_of};
use rijke_numerics::{Matrix, Order, Streams};
use rijke_rig::{Campaign, Ping, Rig};

const ALL: [usize; 8] = [0, 1, 2, 3, 4, 5, 6, 7];

/// Noise of growth rate (1/s), frequency (rad/s) and relative pressure: measurement and error of the base state.
const SD: [f64; 3] = [0.3, 0.5, 2e-3];

/// What the earlier stages leave known: name, mean, sd.
const KNOWN: [(&str, f64, f64); 13] = [
    ("eta", 1.02, 0.01),
    ("k_r", 1.0, 1e-3),
    ("k_i", 0.0, 2e-3),
    ("alpha", 0.9, 0.02),
    ("beta", 1.05, 0.02),
    ("kappa", 1.0, 0.01),
    ("drag", 0.07, 0.005),
    ("heat_r", 0.01, 0.005),
    ("heat_i", 0.0, 0.005),
    ("tc_mu_r", 0.002, 1e-3),
    ("tc_mu_i", 0.003, 1e-3),
    ("tc_ep_r", 0.002, 1e-3),
    ("tc_ep_i", 0.003, 1e-3),
];

fn assembly(model: usize) -> Assembly {
    let read = |name: &str| {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/candidates/");
        Catalogue::read(std::path::Path::new(&format!("{folder}{name}"))).unwrap()
    };
    let all = read("tube.toml").joined(read("prongs.toml")).joined(read("heater.toml"));
    let all = all.joined(read("heat-release.toml"));
    let heat = format!("heat-release.{model}");
    let ids = ["wall.rayleigh", "ends.calibrated", "prongs.6", "heater.3", "thermocouples.paper", &heat];
    Assembly::new(Rig::juniper_yoko_2022(), ids.iter().map(|id| all.get(id).unwrap().clone()).collect())
        .unwrap()
}

fn parameters(assembly: &Assembly) -> Parameters {
    let (names, mean): (Vec<&str>, Vec<f64>) = KNOWN.iter().map(|(n, m, _)| (*n, *m)).unzip();
    let covariance = Matrix::diagonal(&KNOWN.map(|(_, _, sd)| sd * sd));
    Parameters::new(assembly.parameters().to_vec()).unwrap().with_joint(&names, &mean, &covariance).unwrap()
}

/// The hot points as model 7 gives them with a weak drift of the drag, and noise.
fn observed() -> Vec<Observed> {
    let truth = assembly(7);
    let values: Vec<f64> = KNOWN.iter().map(|k| k.1).chain([8e-4, 5e-4, 1e-4, -5e-5]).collect();
    let points = Campaign::juniper_yoko_2022().points.into_iter().filter(|p| p.power > 0.0);
    let mut stream = Streams::new(1).stream("model/table4");
    points
        .map(|point| {
            let pipe = Pipe::new(&truth.rig, &Closures::default(), point.position.unwrap(), 1).unwrap();
            let steady = pipe.steady(&rijke_flow::Parameters::default(), point.power, 293.15).unwrap();
            let conditions = Conditions { point, base: steady.base_state(&pipe), ambient: 293.15 };
            let model = PointModel::new(&truth, &conditions, &ALL).unwrap();
            let r = model.respond(&values, Order::Value, &mut Workspace::default()).unwrap();
            let pressures = r.pressures.iter().map(|p| p.value()).collect();
            let variance: Vec<f64> = (0..16).map(|k| SD[k.min(2)].powi(2)).collect();
            let mut ping =
                Ping { s: r.s.value(), pressures, reference: 5, covariance: Matrix::diagonal(&variance) };
            noise(&mut ping, &mut stream);
            Observed { conditions, ping }
        })
        .collect()
}

fn noise(ping: &mut Ping, stream: &mut rijke_numerics::Stream) {
    use rand::RngExt;
    let mut normal = |sd: f64| {
        let x: f64 = stream.sample(rand_distr::StandardNormal);
        sd * x
    };
    ping.s += rijke_numerics::C64::new(normal(SD[0]), normal(SD[1]));
    for m in (0..8).filter(|m| *m != ping.reference) {
        ping.pressures[m] += rijke_numerics::C64::new(normal(SD[2]), normal(SD[2]));
    }
}

fn table4(c: &mut Criterion) {
    let observed = observed();
    assert_eq!(observed.len(), 105);
    let assemblies: Vec<Assembly> = (1..=9).map(assembly).collect();
    let data: Data = data_of(&observed, &ALL, &Noise::FLOATED).unwrap();
    let with = |assembly: &Assembly, use_it: &mut dyn FnMut(&Posterior<'_>)| {
        let points = observed
            .iter()
            .map(|o| PointModel::new(assembly, &o.conditions, &ALL).unwrap().starting_from(o.ping.s))
            .collect();
        let predictor = Predictor::new(points, assembly.parameters().len());
        let parameters = parameters(assembly);
        use_it(&Posterior::new(&predictor, &data, &parameters).unwrap());
    };
    for (k, assembly) in assemblies.iter().enumerate() {
        with(assembly, &mut |posterior| {
            let found = posterior.assess(&AssessOptions::default()).unwrap();
            let laplace = found.laplace.unwrap();
            println!(
                "model {}: {} parameters, ln ML {:.3}, importance {:?}, calls {:?}, {:?}",
                k + 1,
                laplace.parameters.len(),
                laplace.evidence.ln_marginal,
                found.health.importance.map(|i| (i.ln_marginal, i.standard_error, i.k_hat)),
                found.health.calls,
                found.health.warnings,
            );
        });
    }
    let mut group = c.benchmark_group("nine models of Table 4 on 105 operating points");
    group.sample_size(10);
    group.bench_function("best fit by BFGS, Laplace, evidence", |b| {
        b.iter(|| {
            for assembly in &assemblies {
                with(assembly, &mut |p| {
                    p.laplace(&p.map(&MapOptions::bfgs()).unwrap()).unwrap();
                });
            }
        });
    });
    group.bench_function("with every check", |b| {
        b.iter(|| {
            for assembly in &assemblies {
                with(assembly, &mut |p| {
                    p.assess(&AssessOptions::default()).unwrap();
                });
            }
        });
    });
    group.finish();

    // What one call of the model costs, by the derivatives asked for.
    let mut group = c.benchmark_group("model 7 of Table 4 on 105 operating points");
    with(&assemblies[6], &mut |posterior| {
        let centre = posterior.parameters().physical(&posterior.parameters().centre());
        for (name, order) in [("values", Order::Value), ("first", Order::First), ("second", Order::Second)] {
            group.bench_function(name, |b| b.iter(|| posterior.forward().predict(&centre, order).unwrap()));
        }
    });
    group.finish();
}

criterion_group!(benches, table4);
criterion_main!(benches);
