//! The modes of a network with all first derivatives: by the adjoint, and by differences through the text of
//! its file.

#![allow(clippy::unwrap_used, reason = "a bench may fail by panicking")]

#[path = "../tests/engine/differences/mod.rs"]
mod differences;

use criterion::{Criterion, criterion_group, criterion_main};
use rijke_engine::{Assembly, Conditions, PointModel};
use rijke_inference::Forward;
use rijke_network::Workspace;
use rijke_numerics::Order;
use rijke_study::{OneTable, PointState};
use std::{hint::black_box, path::Path, sync::Arc};

fn modes_with_derivatives(c: &mut Criterion) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/ducted-flame");
    let table = OneTable::read(&folder.join("second-order.toml"), &folder.join("modes.csv"));
    let (study, observations) = table.and_then(|t| t.study()).unwrap();
    let assembly = Assembly::new(Arc::new(study.rig.clone()), Vec::new(), &Default::default()).unwrap();
    let temperature = study.rig.temperature;
    let point = |mode: &rijke_study::ObservedMode| {
        let point = study.campaign.points[mode.point].clone();
        let layout = study.rig.at(&point, temperature).unwrap();
        let base = PointState::of_the_rig(&study.rig, &layout, &point, [temperature, 0.0]).unwrap();
        let conditions = Conditions { id: point.id.clone(), point, layout, base, displaced: Vec::new() };
        let model = PointModel::new(&assembly, &conditions, &[]).unwrap();
        model.starting_from(mode.near(0.0).unwrap()).prepared()
    };
    let points: Vec<PointModel<'_>> = observations.modes.iter().map(point).collect();
    let at = |name: &str| match name {
        "end" => 0.983,
        "n" => 0.398,
        "delay" => 1.903e-3,
        "a1" => 7.856e-4,
        _ => 4.078e-7,
    };
    let values: Vec<f64> = assembly.parameters().iter().map(|p| at(&p.name)).collect();
    let slow = differences::ducted_flame();
    let same: Vec<f64> = slow.unknowns.iter().map(|(name, _)| at(name)).collect();
    let mut group = c.benchmark_group("22 modes with 5 derivatives");
    let mut work = Workspace::default();
    group.bench_function("adjoint", |b| {
        b.iter(|| {
            points.iter().for_each(|p| {
                black_box(p.respond(black_box(&values), Order::First, &mut work).unwrap());
            })
        })
    });
    group.sample_size(10);
    group.bench_function("differences through the file's text", |b| {
        b.iter(|| black_box(slow.predict(black_box(&same), Order::First).unwrap()))
    });
    group.finish();
}

criterion_group!(benches, modes_with_derivatives);
criterion_main!(benches);
