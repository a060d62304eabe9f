//! Speed of the steady state (Newton against integrating to it), of a step with and without derivatives, and
//! of the paper's filter with its members side by side against the same steps one after the other.

use criterion::{Criterion, criterion_group, criterion_main};
use rijke_flow::TubeRig;
use rijke_flow::assimilate::{FilterOptions, Twin, TwinOptions, filter, staircase};
use rijke_flow::{Closures, Dual, Number, Pipe, Single, Transient, TubeParameters, UNKNOWNS, Unknowns};
use rijke_numerics::Streams;
use std::hint::black_box;

const MIDDLE: [f64; UNKNOWNS] = [8.0, 1.0, 5.0, 0.12, 1.2, 1.0, 1.0, 0.0, 35.0, 0.05];

fn minute<N: Single>(pipe: &Pipe, values: [N; UNKNOWNS]) -> f64 {
    let unknowns = Unknowns::from_array(values);
    let implicit = pipe.implicit(15.0);
    let Ok(mut state) = Transient::cold(pipe, &unknowns, 293.15) else { return f64::NAN };
    for _ in 0..4 {
        if state.step(pipe, &implicit, &unknowns, 180.0, 293.15, 1e-6).is_err() {
            return f64::NAN;
        }
    }
    pipe.heater_velocity(&state.gas).value()
}

fn flow(c: &mut Criterion) {
    let Ok(pipe) = Pipe::new(&TubeRig::juniper_yoko_2022(), &Closures::default(), 0.25, 1) else { return };
    let p = TubeParameters::default();
    let mut group = c.benchmark_group("steady");
    group.bench_function("newton, cold start", |b| b.iter(|| pipe.steady(black_box(&p), 180.0, 293.15)));
    if let Ok(near) = pipe.steady(&p, 175.0, 293.15) {
        group.bench_function("newton, from a neighbour", |b| {
            b.iter(|| pipe.steady_near(black_box(&p), 180.0, 293.15, &near));
        });
    }
    group.bench_function("integrating for 4000 s", |b| {
        b.iter(|| {
            let unknowns = Unknowns::from_array(MIDDLE);
            let implicit = pipe.implicit(15.0);
            let mut state = Transient::cold(&pipe, &unknowns, 293.15)?;
            for _ in 0..267 {
                state.step(&pipe, &implicit, &unknowns, black_box(180.0), 293.15, 1e-6)?;
            }
            Ok::<_, rijke_flow::FlowError>(pipe.heater_velocity(&state.gas))
        });
    });
    group.finish();
    let mut group = c.benchmark_group("one minute");
    group.bench_function("values", |b| b.iter(|| minute(&pipe, black_box(MIDDLE))));
    let mut seeds = [Dual::<{ UNKNOWNS + 1 }>::constant(0.0); UNKNOWNS];
    for (i, seed) in seeds.iter_mut().enumerate() {
        *seed = Dual::variable(MIDDLE[i], i);
    }
    group.bench_function("values and ten derivatives", |b| b.iter(|| minute(&pipe, black_box(seeds))));
    group.bench_function("ten derivatives by central differences", |b| {
        b.iter(|| {
            let mut sum = 0.0;
            for k in 0..UNKNOWNS {
                for h in [-1e-4, 1e-4] {
                    let mut moved = MIDDLE;
                    moved[k] += h;
                    sum += minute(&pipe, black_box(moved));
                }
            }
            sum
        });
    });
    group.finish();
}

/// The paper's filter on 15 min at 7, 30 and 180 W: 60 clicks of 100 members side by side with their
/// analyses, against the same 100 members stepped one after the other, without any analysis.
fn filter_of_the_paper(c: &mut Criterion) {
    let Ok(pipe) = Pipe::new(&TubeRig::juniper_yoko_2022(), &Closures::default(), 0.25, 1) else { return };
    let options = TwinOptions { powers: staircase(&[7.0, 30.0, 180.0], 20), ..TwinOptions::default() };
    let Ok(twin) = Twin::new(&pipe, &options, &Streams::new(1), None) else { return };
    let record = &twin.record;
    let mut group = c.benchmark_group("60 clicks of 100 members");
    group.sample_size(20);
    group.bench_function("the paper's filter", |b| {
        b.iter(|| filter(&pipe, black_box(record), &FilterOptions::default(), &Streams::new(1)));
    });
    group.bench_function("the members one after the other", |b| {
        b.iter(|| {
            let unknowns = Unknowns::from_array(MIDDLE);
            let implicit = pipe.implicit(record.interval);
            let cold = Transient::cold(&pipe, &unknowns, record.samples[0].ambient)?;
            for _ in 0..100 {
                let mut state = cold.clone();
                for sample in &record.samples {
                    state.refresh(&pipe, &unknowns, 1e-4)?;
                    state.step(&pipe, &implicit, &unknowns, black_box(sample.power), sample.ambient, 1e-4)?;
                }
            }
            Ok::<_, rijke_flow::FlowError>(())
        });
    });
    group.finish();
}

criterion_group!(benches, flow, filter_of_the_paper);
criterion_main!(benches);
