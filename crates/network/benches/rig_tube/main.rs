//! The rig tube with N distinct segments, wall losses and a gauze: what the performance page reports.
#![allow(clippy::unwrap_used, reason = "a bench stops at the first surprise")]
#![allow(missing_docs, reason = "the macros of criterion make undocumented items")]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use rayon::prelude::*;
use rijke_network::file::{Built, read};
use rijke_network::wall::{self, Wall};
use rijke_network::{
    At, Coefficients, Laws, Network, Newton, Places, Region, Root, Segment, Sensitivities, Slot, Workspace,
};
use rijke_numerics::{C64, Order};
use std::hint::black_box;
use std::time::Instant;

mod dense;

const WALL: Wall = Wall {
    density: 1.2041,
    sound_speed: 343.2,
    viscosity: 1.8134e-5,
    prandtl: 0.71,
    gamma: 1.4,
    diameter: 0.0474,
};

/// Laws 0, 1: wall; 2: gauze -K e^{-s tau}; 3, 4: drag of the gauze; 5: both ends. Eight parameters: eta, K,
/// tau, two of drag, modulus and angle of R, blockage.
struct Rig;

const A: [f64; 8] = [1.0, 0.05, 1.5e-3, 0.3, 0.2, 0.9975, 3.055, 0.02];

impl Coefficients for Rig {
    fn parameters(&self) -> usize {
        8
    }
    fn laws(&self) -> usize {
        6
    }
    fn fill(&self, at: &At, laws: &mut Laws) {
        let s = at.s();
        if at.space().seeds() == 1 {
            let loss = WALL.paper(s);
            laws.set_analytic(0, loss.viscous);
            laws.set_analytic(1, loss.thermal);
            let heat = -A[1] * (-s * A[2]).exp();
            laws.set_analytic(2, [A[7] + heat, -A[2] * heat, C64::ZERO]);
            laws.set_analytic(3, [A[3] + s * (1e-3 * A[4]), C64::new(1e-3 * A[4], 0.0), C64::ZERO]);
            laws.set_analytic(4, [C64::new(1e-6 * A[3], 0.0), C64::ZERO, C64::ZERO]);
            laws.set_analytic(5, [C64::from_polar(A[5], A[6]), C64::ZERO, C64::ZERO]);
            return;
        }
        let p = |i: usize| at.parameter(i, A[i]);
        let sj = at.s_jet();
        let loss = WALL.paper(s);
        for (law, [v, d, dd]) in [loss.viscous, loss.thermal].into_iter().enumerate() {
            laws.set(law, &(&p(0) * &sj.compose(v, d, dd)));
        }
        let heat = &p(1) * &(-&(&sj * &p(2))).exp();
        laws.set(2, &(&p(7) - &heat));
        laws.set(3, &(&p(3) + &(&sj * &p(4)).scale(C64::new(1e-3, 0.0))));
        laws.set(4, &p(3).scale(C64::new(1e-6, 0.0)));
        laws.set(5, &(&p(5) * &p(6).scale(C64::I).exp()));
    }
}

/// N segments whose sound speeds all differ, the gauze at a quarter, eight places.
fn rig(n: usize) -> (Network, Places) {
    let segments = (0..n).map(|i| {
        let speed = 343.2 * (1.0 + 0.1 * (i as f64 / n as f64));
        Segment::new(1.0 / n as f64, 1.765e-3, speed, 1.4 * 101_325.0 / (speed * speed))
    });
    let mut net = Network::new(segments.collect()).unwrap();
    for i in 0..n {
        net.attach(Slot::Viscous(i), 0, 1.0).unwrap();
        net.attach(Slot::Thermal(i), 1, 1.0).unwrap();
    }
    let gauze = n / 4;
    net.attach(Slot::Eu(gauze), 2, 1.0).unwrap();
    net.attach(Slot::Mu(gauze), 3, 1.0).unwrap();
    net.attach(Slot::Ep(gauze), 4, 1.0).unwrap();
    net.attach(Slot::Upstream, 5, 1.0).unwrap();
    net.attach(Slot::Downstream, 5, 1.0).unwrap();
    let at: Vec<usize> = (0..8).map(|m| n * (25 + 10 * m) / 100).collect();
    let reference = at[5];
    (net, Places { at, reference })
}

fn start(net: &Network, work: &mut Workspace) -> Root {
    net.solve(&Rig, C64::new(5.0, 1100.0), &Newton::default(), work).unwrap()
}

/// The guess of a warm start: the root of a neighbouring operating point, some rad/s away.
const WARM: C64 = C64::new(0.3, -1.0);

fn bench(c: &mut Criterion) {
    let mut work = Workspace::default();
    let (net, places) = rig(50);
    let root = start(&net, &mut work);
    let dense = dense::newton(&net, root.s + WARM);
    assert!((dense - root.s).norm() < 1e-8 * root.s.norm(), "{dense} against {}", root.s);
    let newton = Newton::default();

    let mut group = c.benchmark_group("rig50");
    group.bench_function("eigenvalue", |b| {
        b.iter(|| net.solve(&Rig, black_box(root.s + WARM), &newton, &mut work).unwrap());
    });
    let mut all = Sensitivities::default();
    group.bench_function("eigenvalue_and_all_first_derivatives", |b| {
        b.iter(|| {
            let root = net.solve(&Rig, black_box(root.s + WARM), &newton, &mut work).unwrap();
            net.sensitivities(&Rig, &root, &places, &mut all, &mut work).unwrap();
        });
    });
    for (name, order) in [("gradient_p8", Order::First), ("hessian_p8", Order::Second)] {
        group.bench_function(name, |b| {
            b.iter(|| net.respond(&Rig, black_box(&root), &places, order, &mut work).unwrap());
        });
    }
    let region = Region { sigma: [-150.0, 150.0], omega: [200.0, 4000.0 * std::f64::consts::PI] };
    group.bench_function("all_modes_below_2_khz", |b| {
        b.iter(|| net.modes(&Rig, black_box(&region), &mut work).unwrap());
    });
    let forced = C64::new(0.0, root.s.im);
    group.bench_function("impedance", |b| {
        b.iter(|| net.impedance_at(&Rig, black_box(forced), 0, Order::Value, &mut work).unwrap());
    });
    let turns = (0..64).map(|k| C64::new(0.0, 300.0 + 300.0 * f64::from(k)));
    for (name, wall) in [("lossless", "none"), ("kirchhoff", "kirchhoff"), ("bessel", "zwikker-kosten")] {
        let bores = fifty_bores(wall);
        let mut frequency = turns.clone().cycle();
        group.bench_function(BenchmarkId::new("impedance_of_fifty_bores", name), |b| {
            b.iter(|| {
                let s = frequency.next().unwrap();
                bores.network.impedance_at(&bores.laws, s, 0, Order::Value, &mut work).unwrap()
            });
        });
    }
    // What no program without lanes can undercut: a hundred ratios of Bessel functions and fifty
    // exponentials.
    let mut frequency = turns.cycle();
    group.bench_function("ratios_and_exponentials_of_fifty_bores", |b| {
        b.iter(|| {
            let s = frequency.next().unwrap();
            let root = s.sqrt();
            let one = |k: i32| {
                let z = root * (0.5 * (0.014 + 1e-4 * f64::from(k)) / 1.5e-5_f64.sqrt());
                let decay = (s * (0.02 / 343.0) + 1e-3).exp();
                wall::bessel_ratio(z) + wall::bessel_ratio(z * 0.84) + decay
            };
            (0..50).map(one).sum::<C64>()
        });
    });
    group.sample_size(10);
    group.bench_function("eigenvalue_dense_lu", |b| b.iter(|| dense::newton(&net, black_box(root.s + WARM))));
    group.finish();

    let mut group = c.benchmark_group("linear_in_n");
    for n in [50, 500, 5000] {
        let (net, _) = rig(n);
        let root = start(&net, &mut work);
        group.throughput(Throughput::Elements(n as u64));
        group.bench_function(BenchmarkId::from_parameter(n), |b| {
            b.iter(|| net.solve(&Rig, black_box(root.s + WARM), &newton, &mut work).unwrap());
        });
    }
    group.finish();

    let mut group = c.benchmark_group("batch_of_175");
    let points: Vec<C64> = (0..175).map(|k| root.s + WARM * (f64::from(k) / 175.0)).collect();
    let one = |guess: &C64, work: &mut Workspace| {
        let root = net.solve(&Rig, *guess, &newton, work).unwrap();
        net.respond(&Rig, &root, &places, Order::Second, work).unwrap()
    };
    group.bench_function("one_thread", |b| {
        b.iter(|| points.iter().map(|guess| one(guess, &mut work)).collect::<Vec<_>>());
    });
    group.bench_function("all_threads", |b| {
        b.iter(|| {
            points.par_iter().map_init(Workspace::default, |work, guess| one(guess, work)).collect::<Vec<_>>()
        });
    });
    group.finish();
}

/// Fifty cylinders of different radii, each with losses of its own.
fn fifty_bores(wall: &str) -> Built {
    let mut text = "[upstream]\ntype = 'closed'\n[downstream]\ntype = 'closed'\n".to_owned();
    for k in 0..50 {
        let diameter = 0.014 + 1e-4 * f64::from(k);
        text +=
            &format!("[[element]]\ntype = 'duct'\nlength = 0.02\ndiameter = {diameter}\nwall = '{wall}'\n");
    }
    read(&text).unwrap()
}

/// The least time of a run in many short bursts, s: what the machine takes when nothing else disturbs a
/// burst.
fn least(mut run: impl FnMut()) -> f64 {
    let mut burst = 1;
    loop {
        let start = Instant::now();
        (0..burst).for_each(|_| run());
        if start.elapsed().as_secs_f64() > 2e-4 {
            break;
        }
        burst *= 2;
    }
    let mut best = f64::INFINITY;
    let start = Instant::now();
    while start.elapsed().as_secs_f64() < 1.5 {
        let one = Instant::now();
        (0..burst).for_each(|_| run());
        best = best.min(one.elapsed().as_secs_f64() / f64::from(burst));
    }
    best
}

/// Least times side by side, and their ratios: robust against other work on the machine.
#[allow(clippy::print_stdout, reason = "a bench reports")]
fn compare(_: &mut Criterion) {
    let mut work = Workspace::default();
    let (net, places) = rig(50);
    let root = start(&net, &mut work);
    let newton = Newton::default();
    let one = least(|| drop(black_box(net.solve(&Rig, black_box(root.s + WARM), &newton, &mut work))));
    let mut all = Sensitivities::default();
    let derivatives = least(|| {
        let root = net.solve(&Rig, black_box(root.s + WARM), &newton, &mut work).unwrap();
        net.sensitivities(&Rig, &root, &places, &mut all, &mut work).unwrap();
    });
    let hessian = least(|| drop(net.respond(&Rig, black_box(&root), &places, Order::Second, &mut work)));
    let region = Region { sigma: [-150.0, 150.0], omega: [200.0, 4000.0 * std::f64::consts::PI] };
    let modes = least(|| drop(black_box(net.modes(&Rig, &region, &mut work))));
    let dense = least(|| {
        black_box(dense::newton(&net, black_box(root.s + WARM)));
    });
    println!(
        "least times: eigenvalue {:.2} us, and first derivatives {:.2} us",
        1e6 * one,
        1e6 * derivatives
    );
    println!(
        "least times: Hessian p = 8 {:.1} us, all modes below 2 kHz {:.2} ms",
        1e6 * hessian,
        1e3 * modes
    );
    println!("least times: dense Newton {:.0} us, {:.0} times the sweep's", 1e6 * dense, dense / one);
    let points: Vec<C64> = (0..175).map(|k| root.s + WARM * (f64::from(k) / 175.0)).collect();
    let point = |guess: &C64, work: &mut Workspace| {
        let root = net.solve(&Rig, *guess, &newton, work).unwrap();
        net.respond(&Rig, &root, &places, Order::Second, work).unwrap()
    };
    let alone = least(|| drop(black_box(points.iter().map(|s| point(s, &mut work)).collect::<Vec<_>>())));
    let shared = least(|| {
        let all = points.par_iter().map_init(Workspace::default, |work, s| point(s, work));
        drop(black_box(all.collect::<Vec<_>>()));
    });
    println!(
        "least times: 175 points with Hessians {:.2} ms, {:.2} ms on {} threads",
        1e3 * alone,
        1e3 * shared,
        rayon::current_num_threads()
    );
    for n in [500, 5000] {
        let (net, _) = rig(n);
        let root = start(&net, &mut work);
        let long = least(|| drop(black_box(net.solve(&Rig, black_box(root.s + WARM), &newton, &mut work))));
        println!("least times: N = {n} {:.1} us, {:.1} times N = 50", 1e6 * long, long / one);
    }
}

criterion_group!(benches, bench, compare);
criterion_main!(benches);
