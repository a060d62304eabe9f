//! Cost of a ping and a click of the virtual laboratory: making the record, and fitting it with the mains, six modes,
//! dispersion and reflection in it.
#![allow(missing_docs, reason = "criterion's macros make public functions")]
#![allow(clippy::unwrap_used, reason = "a bench may stop")]

use criterion::{Criterion, criterion_group, criterion_main};
use rijke_lab::{Truth, VirtualRig};
use rijke_rig::{Campaign, RecordSource, Rig};
use rijke_signal::{ProcessOptions, Trace, click_options, fit_click, fit_ping};
use std::hint::black_box;

fn benches(c: &mut Criterion) {
    let (rig, campaign) = (Rig::juniper_yoko_2022(), Campaign::juniper_yoko_2022());
    for id in ["C3-35", "H180-40"] {
        let mut campaign = campaign.clone();
        campaign.points.retain(|p| p.id == id);
        let lab = VirtualRig::new(&rig, &campaign, &Truth::standard(), &[], Some(40), 1).unwrap();
        let mut options = ProcessOptions::default();
        options.ping.reference = rig.microphones.reference;
        let (day, point) = (lab.set().points[0].day, &lab.set().points[0].point);
        let known = click_options(lab.set(), day, Some(point), &options.click);
        let (ping, click) = (lab.ping(0, 7).unwrap(), lab.click(0, 7).unwrap());
        let mut group = c.benchmark_group(id);
        group.sample_size(30);
        group.bench_function("ping, record", |b| b.iter(|| lab.ping(0, black_box(7)).unwrap()));
        group.bench_function("ping, fit", |b| {
            b.iter(|| fit_ping(&Trace::from(black_box(&ping)), &options.ping).unwrap());
        });
        group.bench_function("click, record", |b| b.iter(|| lab.click(0, black_box(7)).unwrap()));
        group.bench_function("click, fit", |b| {
            b.iter(|| fit_click(&Trace::from(black_box(&click)), &known).unwrap());
        });
        group.finish();
    }
}

criterion_group!(signal, benches);
criterion_main!(signal);
