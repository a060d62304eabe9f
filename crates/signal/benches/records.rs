//! Cost of one ping and one click at the sizes of the paper's rig, beside the cost of one pass over the same
//! samples.
#![allow(missing_docs, reason = "criterion's macros make public functions")]
#![allow(clippy::unwrap_used, reason = "a bench may stop")]

use criterion::{Criterion, criterion_group, criterion_main};
use rand_distr::{Distribution, StandardNormal};
use rijke_numerics::{C64, Streams};
use rijke_signal::{ClickOptions, PingOptions, Trace, fit_click, fit_ping};
use std::f64::consts::{PI, TAU};
use std::hint::black_box;

/// Eight channels of 15 000 samples: noise, forcing, decay of two modes.
fn ping() -> Vec<Vec<f64>> {
    let mut stream = Streams::new(1).stream("bench/ping");
    (0..8)
        .map(|m| {
            let x = 0.25 + 0.1 * f64::from(m);
            (0..15_000)
                .map(|n| {
                    let noise: f64 = StandardNormal.sample(&mut stream);
                    let t = (f64::from(n) - 4000.0) / 1e4;
                    let mode = |k: f64, s: C64| {
                        let s = if t < 0.0 { C64::new(0.0, 1097.0) } else { s };
                        (PI * k * x).sin() * (s * t).exp().re
                    };
                    let signal =
                        mode(1.0, C64::new(-10.0, 1090.0)) + 0.2 * mode(2.0, C64::new(-18.0, 2185.0));
                    noise + if n < 2000 { 0.0 } else { 100.0 * signal }
                })
                .collect()
        })
        .collect()
}

/// Eight channels of 6250 samples: one Ricker wavelet that passes by.
fn click() -> Vec<Vec<f64>> {
    let mut stream = Streams::new(1).stream("bench/click");
    (0..8)
        .map(|m| {
            let arrival = 1e-3 + (0.25 + 0.1 * f64::from(m)) / 343.0;
            (0..6250)
                .map(|n| {
                    let noise: f64 = StandardNormal.sample(&mut stream);
                    let a = (PI * 1500.0 * ((f64::from(n) - 1250.0) / 62_500.0 - arrival)).powi(2);
                    noise + 100.0 * (1.0 - 2.0 * a) * (-a).exp()
                })
                .collect()
        })
        .collect()
}

/// The least that any method must do: read every sample once, with one multiplication.
fn one_pass(channels: &[Vec<f64>]) -> f64 {
    channels.iter().flatten().enumerate().map(|(n, y)| y * ((n & 7) as f64 - TAU)).sum()
}

fn benches(c: &mut Criterion) {
    let (ping, click) = (ping(), click());
    let pings = Trace { channels: &ping, rate_hz: 1e4, quiet: 2000, full_scale: f64::INFINITY };
    let clicks = Trace { channels: &click, rate_hz: 62_500.0, quiet: 1250, full_scale: f64::INFINITY };
    let options = PingOptions { reference: 5, ..PingOptions::default() };
    c.bench_function("ping, one pass", |b| b.iter(|| one_pass(black_box(&ping))));
    c.bench_function("ping, fit", |b| b.iter(|| fit_ping(black_box(&pings), &options).unwrap()));
    c.bench_function("click, one pass", |b| b.iter(|| one_pass(black_box(&click))));
    c.bench_function("click, fit", |b| {
        b.iter(|| fit_click(black_box(&clicks), &ClickOptions::default()).unwrap());
    });
}

criterion_group! { name = records; config = Criterion::default().sample_size(20); targets = benches }
criterion_main!(records);
