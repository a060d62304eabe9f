//! The rig tube with N distinct segments, wall losses and a heater: what the performance page reports.
#![allow(clippy::unwrap_used, reason = "a bench stops at the first surprise")]
#![allow(missing_docs, reason = "the macros of criterion make undocumented items")]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use rayon::prelude::*;
use rijke_network::wall::Wall;
use rijke_network::{
    At, Coefficients, Laws, Network, Newton, Places, Region, Root, Segment, Sensitivities, Slot, Workspace,
};
use rijke_numerics::{C64, Order, complex_lu_solve};
use std::hint::black_box;

const WALL: Wall = Wall {
    density: 1.2041,
    sound_speed: 343.2,
    viscosity: 1.8134e-5,
    prandtl: 0.71,
    gamma: 1.4,
    diameter: 0.0474,
};

/// Laws 0, 1: wall; 2: heater -K e^{-s tau}; 3, 4: drag of the heater; 5: both ends. Eight parameters: eta, K, tau,
/// two of drag, modulus and angle of R, blockage.
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

/// N segments whose sound speeds all differ, the heater at a quarter, eight places.
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
    let heater = n / 4;
    net.attach(Slot::Eu(heater), 2, 1.0).unwrap();
    net.attach(Slot::Mu(heater), 3, 1.0).unwrap();
    net.attach(Slot::Ep(heater), 4, 1.0).unwrap();
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

/// The same characteristic equation as a dense 2N x 2N system in the wave amplitudes, through the LU of the
/// linear-algebra library, one factorisation per step.
fn dense_newton(net: &Network, guess: C64) -> C64 {
    let n = net.segments().len();
    let size = 2 * n;
    let matrix = |s: C64| {
        let mut a = vec![C64::ZERO; size * size];
        let loss = WALL.paper(s);
        let r = C64::from_polar(A[5], A[6]);
        let line = |i: usize| {
            let g = net.segments()[i];
            let z = s * g.density + loss.viscous[0];
            let y = s / (g.density * g.sound_speed * g.sound_speed) + loss.thermal[0];
            (z.sqrt() * y.sqrt() * g.length, z.sqrt() / y.sqrt())
        };
        // Unknowns f_i, g_i at the upstream end of segment i.
        let (_, zc) = line(0);
        let rho_c = net.segments()[0].impedance();
        let u = |sign: f64, zc: C64| sign / zc;
        // p (1 - R) = rho c u (1 + R) (-1): f + g and (f - g)/zc with R_u.
        for (column, sign) in [(0, 1.0), (1, -1.0)] {
            a[column] = (1.0 - r) + (1.0 + r) * rho_c * u(sign, zc);
        }
        for i in 0..n - 1 {
            let ((gl, zc), (_, zn)) = (line(i), line(i + 1));
            let wave = [(-gl).exp(), gl.exp()];
            let k = if i + 1 == n / 4 {
                let heat = A[7] - A[1] * (-s * A[2]).exp();
                [A[3] + s * (1e-3 * A[4]), C64::ZERO, heat, C64::new(1e-6 * A[3], 0.0)]
            } else {
                [C64::ZERO; 4]
            };
            for (w, sign) in [(0, 1.0), (1, -1.0)] {
                let (p, v) = (wave[w], u(sign, zc) * wave[w]);
                let row = (2 * i + 1) * size;
                a[row + 2 * i + w] = p - k[0] * v - k[1] * p;
                a[row + 2 * i + 2 + w] = -C64::ONE;
                let row = row + size;
                a[row + 2 * i + w] = v - k[2] * v - k[3] * p;
                a[row + 2 * i + 2 + w] = -u(sign, zn);
            }
        }
        let (gl, zc) = line(n - 1);
        let rho_c = net.segments()[n - 1].impedance();
        for (w, (sign, e)) in [(1.0, (-gl).exp()), (-1.0, gl.exp())].into_iter().enumerate() {
            a[(size - 1) * size + 2 * n - 2 + w] = ((1.0 - r) - (1.0 + r) * rho_c * u(sign, zc)) * e;
        }
        a
    };
    // The last row is moved to a bordering condition: with b the last unit vector and g = 1 fixed, the residual is a
    // scalar function of s.
    let residual = |s: C64| {
        let mut a = matrix(s);
        let last: Vec<C64> = a[(size - 1) * size..].to_vec();
        for (column, v) in a[(size - 1) * size..].iter_mut().enumerate() {
            *v = if column == 1 { C64::ONE } else { C64::ZERO };
        }
        let mut b = vec![C64::ZERO; size];
        b[size - 1] = C64::ONE;
        let x = complex_lu_solve(&a, &b).unwrap();
        last.iter().zip(&x).map(|(l, x)| l * x).sum::<C64>()
    };
    // One factorisation per step: secant, started by a step of 1e-3.
    let (mut s, mut before) = (guess, guess + 1e-3);
    let mut f_before = residual(before);
    for _ in 0..10 {
        let f = residual(s);
        let step = -f * (s - before) / (f - f_before);
        (before, f_before) = (s, f);
        s += step;
        if step.norm() < 1e-9 * s.norm() {
            break;
        }
    }
    s
}

fn bench(c: &mut Criterion) {
    let mut work = Workspace::default();
    let (net, places) = rig(50);
    let root = start(&net, &mut work);
    let dense = dense_newton(&net, root.s + WARM);
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
    group.sample_size(10);
    group.bench_function("eigenvalue_dense_lu", |b| b.iter(|| dense_newton(&net, black_box(root.s + WARM))));
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

criterion_group!(benches, bench);
criterion_main!(benches);
