//! What a record costs, and what the laboratory's acoustics cost: a march through a hot tube against one
//! through a cold tube (where the integrator is exact in one step per stretch), and setting up the whole
//! campaign.
#![allow(missing_docs, reason = "the macro of the bench harness makes a function without them")]

use criterion::{Criterion, criterion_group, criterion_main};
use rijke_flow::{TubeCampaign, TubeRig};
use rijke_lab::{Truth, VirtualRig};
use rijke_rig::RecordSource;
use std::hint::black_box;

fn lab(rows: &[&str]) -> Option<VirtualRig> {
    let rows: Vec<String> = rows.iter().map(|row| (*row).to_owned()).collect();
    let (rig, campaign) = (TubeRig::juniper_yoko_2022(), TubeCampaign::juniper_yoko_2022());
    VirtualRig::new(&rig, &campaign, &Truth::standard(), &rows, Some(40), 1).ok()
}

fn records(c: &mut Criterion) {
    let Some(lab) = lab(&["C3", "H180"]) else { return };
    let hot = lab.set().points.len() - 10;
    let mut group = c.benchmark_group("record");
    group.bench_function("ping, 8 channels x 15 000", |b| b.iter(|| lab.ping_samples(black_box(3), 7)));
    group.bench_function("click, 8 channels x 6 250", |b| b.iter(|| lab.click_samples(black_box(3), 7)));
    group.bench_function("ping, hot", |b| b.iter(|| lab.ping_samples(black_box(hot), 7)));
    group.finish();
}

fn set_up(c: &mut Criterion) {
    let mut group = c.benchmark_group("set-up");
    group.sample_size(10);
    group.bench_function("row C3, 20 points", |b| b.iter(|| self::lab(&["C3"])));
    group.bench_function("row H180, 15 points", |b| b.iter(|| self::lab(&["H180"])));
    group.finish();
}

criterion_group!(benches, records, set_up);
criterion_main!(benches);
