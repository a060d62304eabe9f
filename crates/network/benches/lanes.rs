//! Do SIMD lanes over operating points pay? One sweep of four values of s side by side against four sweeps,
//! on the same tube (50 segments, wall losses). The answer is on the performance page.
#![allow(clippy::unwrap_used, reason = "a bench stops at the first surprise")]
#![allow(missing_docs, reason = "the macros of criterion make undocumented items")]

use criterion::{Criterion, criterion_group, criterion_main};
use rijke_network::wall::Wall;
use rijke_network::{At, Coefficients, Laws, Network, Segment, Slot, Workspace};
use rijke_numerics::C64;
use std::hint::black_box;
use std::ops::{Add, Mul, Sub};

const LANES: usize = 4;
const N: usize = 50;
const WALL: Wall = Wall {
    density: 1.2041,
    sound_speed: 343.2,
    viscosity: 1.8134e-5,
    prandtl: 0.71,
    gamma: 1.4,
    diameter: 0.0474,
};

struct Losses;

impl Coefficients for Losses {
    fn parameters(&self) -> usize {
        0
    }
    fn laws(&self) -> usize {
        2
    }
    fn fill(&self, at: &At, laws: &mut Laws) {
        let loss = WALL.paper(at.s());
        laws.set_analytic(0, loss.viscous);
        laws.set_analytic(1, loss.thermal);
    }
}

fn tube() -> Network {
    let segment = |i: usize| {
        let speed = 343.2 * (1.0 + 0.1 * (i as f64 / N as f64));
        Segment::new(1.0 / N as f64, 1.765e-3, speed, 1.4 * 101_325.0 / (speed * speed))
    };
    let mut net = Network::new((0..N).map(segment).collect()).unwrap();
    for i in 0..N {
        net.attach(Slot::Viscous(i), 0, 1.0).unwrap();
        net.attach(Slot::Thermal(i), 1, 1.0).unwrap();
    }
    net.set(Slot::Upstream, C64::new(-0.99, 0.0)).unwrap();
    net.set(Slot::Downstream, C64::new(-0.99, 0.0)).unwrap();
    net
}

/// Complex numbers side by side; the compiler makes vector instructions of the loops.
#[derive(Clone, Copy)]
struct Wide {
    re: [f64; LANES],
    im: [f64; LANES],
}

impl Wide {
    fn new(f: impl Fn(usize) -> C64) -> Self {
        let all: [C64; LANES] = std::array::from_fn(f);
        Self { re: all.map(|z| z.re), im: all.map(|z| z.im) }
    }
    fn times(self, k: f64) -> Self {
        Self { re: self.re.map(|v| v * k), im: self.im.map(|v| v * k) }
    }
    fn plus(self, k: f64) -> Self {
        Self { re: self.re.map(|v| v + k), im: self.im }
    }
}

impl Add for Wide {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self {
            re: std::array::from_fn(|i| self.re[i] + o.re[i]),
            im: std::array::from_fn(|i| self.im[i] + o.im[i]),
        }
    }
}

impl Sub for Wide {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self {
            re: std::array::from_fn(|i| self.re[i] - o.re[i]),
            im: std::array::from_fn(|i| self.im[i] - o.im[i]),
        }
    }
}

impl Mul for Wide {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Self {
            re: std::array::from_fn(|i| self.re[i] * o.re[i] - self.im[i] * o.im[i]),
            im: std::array::from_fn(|i| self.re[i] * o.im[i] + self.im[i] * o.re[i]),
        }
    }
}

/// The same five-term series as the library's short segments; F and dF/ds of four s at once.
fn wide_sweep(segments: &[Segment], s: [C64; LANES]) -> [[C64; 2]; LANES] {
    const C: [f64; 5] = [1.0, 0.5, 1.0 / 24.0, 1.0 / 720.0, 1.0 / 40320.0];
    const S: [f64; 5] = [1.0, 1.0 / 6.0, 1.0 / 120.0, 1.0 / 5040.0, 1.0 / 362_880.0];
    const D: [f64; 4] = [1.0 / 6.0, 2.0 / 120.0, 3.0 / 5040.0, 4.0 / 362_880.0];
    let losses: [_; LANES] = std::array::from_fn(|l| WALL.paper(s[l]));
    let law = |k: usize| (Wide::new(|l| losses[l].viscous[k]), Wide::new(|l| losses[l].thermal[k]));
    let ((mu, ep), (dmu, dep)) = (law(0), law(1));
    let at = Wide::new(|l| s[l]);
    let r = -0.99;
    let z0 = segments[0].impedance();
    let zero = Wide::new(|_| C64::ZERO);
    let (mut p, mut u) = (zero.plus(1.0 + r), zero.plus((r - 1.0) / z0));
    let (mut dp, mut du) = (zero, zero);
    for g in segments {
        let compliance = 1.0 / (g.density * g.sound_speed * g.sound_speed);
        let (bp, bq) =
            ((at.times(g.density) + mu).times(g.length), (at.times(compliance) + ep).times(g.length));
        let (bpd, bqd) = (dmu.plus(g.density).times(g.length), dep.plus(compliance).times(g.length));
        let q = bp * bq;
        let q2 = q * q;
        let five = |k: &[f64; 5]| q.times(k[1]).plus(k[0]) + q2 * (q.times(k[3]).plus(k[2]) + q2.times(k[4]));
        let (c, sh) = (five(&C), five(&S));
        let s1 = q.times(D[1]).plus(D[0]) + q2 * q.times(D[3]).plus(D[2]);
        let dq = bpd * bq + bp * bqd;
        let ds = s1 * dq;
        let dc = (sh * dq).times(0.5);
        let (b, db) = (bp * sh, bpd * sh + bp * ds);
        let (e, de) = (bq * sh, bqd * sh + bq * ds);
        let (np, nu) = (c * p - b * u, c * u - e * p);
        let (ndp, ndu) = (c * dp - b * du + dc * p - db * u, c * du - e * dp + dc * u - de * p);
        (p, u, dp, du) = (np, nu, ndp, ndu);
    }
    let z = segments[segments.len() - 1].impedance();
    let close = |p: Wide, u: Wide| p.times(0.5 * (1.0 - r)) - u.times(0.5 * (1.0 + r) * z);
    let (f, d) = (close(p, u), close(dp, du));
    std::array::from_fn(|l| [C64::new(f.re[l], f.im[l]), C64::new(d.re[l], d.im[l])])
}

fn bench(c: &mut Criterion) {
    let (net, mut work) = (tube(), Workspace::default());
    let points: [C64; LANES] = std::array::from_fn(|k| C64::new(-5.0 + k as f64, 1100.0 + 3.0 * k as f64));
    let mut scalar =
        |points: &[C64; LANES]| points.map(|s| net.characteristic_function(&Losses, s, &mut work));
    for (one, two) in scalar(&points).iter().zip(wide_sweep(net.segments(), points)) {
        for k in 0..2 {
            assert!((one[k] - two[k]).norm() < 1e-11 * one[1].norm(), "{one:?} {two:?}");
        }
    }
    let mut group = c.benchmark_group("four_sweeps");
    group.bench_function("one_after_the_other", |b| b.iter(|| scalar(black_box(&points))));
    group.bench_function("side_by_side", |b| b.iter(|| wide_sweep(net.segments(), black_box(points))));
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
