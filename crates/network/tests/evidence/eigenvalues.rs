//! The cases of fixtures/reference/eigenvalues.json, to 1e-9 relative.

use crate::common_laws::{RIG, c, close_with_paper_ends, given, paper_wall, rig_segment, root};
use rijke_network::wall::Wall;
use rijke_network::{Constant, Network, Segment, Slot};
use rijke_numerics::C64;
use serde_json::Value;

pub(crate) fn reference(case: &str) -> Value {
    let text = include_str!("../../../../fixtures/reference/eigenvalues.json");
    let all: Value = serde_json::from_str(text).unwrap();
    all["cases"][case].clone()
}

pub(crate) fn eigenvalues(case: &str) -> Vec<C64> {
    let list = reference(case)["eigenvalues"].as_array().unwrap().clone();
    list.iter().map(|e| c(e["sigma"].as_f64().unwrap(), e["omega"].as_f64().unwrap())).collect()
}

#[track_caller]
fn close(got: C64, expected: C64, relative: f64) {
    let error = (got - expected).norm() / expected.norm();
    assert!(error < relative, "{got} against {expected}: {error:e}");
}

fn tube(sound_speed: f64, upstream: C64, downstream: C64) -> Network {
    let mut net = Network::new(vec![Segment::new(1.0, 1.0, sound_speed, 1.2)]).unwrap();
    net.set(Slot::Upstream, upstream).unwrap();
    net.set(Slot::Downstream, downstream).unwrap();
    net
}

#[test]
fn exact_uniform_tubes() {
    let paper = C64::from_polar(0.9975, 3.0550);
    for (case, r, speed) in [
        ("uniform_open_open_lossless", c(-1.0, 0.0), 343.23197767690584),
        ("uniform_open_open_R095", c(-0.95, 0.0), 343.24614995),
        ("uniform_open_open_paperLS", paper, 343.23197767690584),
    ] {
        for expected in eigenvalues(case) {
            let got = root(&tube(speed, r, r), &Constant, expected + c(20.0, -30.0));
            close(got.s, expected, 1e-12);
        }
    }
}

/// Two gases with the same gamma p on either side of a compact source k_eu = -theta F(s).
fn hot_and_cold(lengths: [f64; 2], speeds: [f64; 2], ends: [f64; 2]) -> Network {
    let gamma_p = 1.4 * 101_325.0;
    let segments = (0..2).map(|i| Segment::new(lengths[i], 1.0, speeds[i], gamma_p / speeds[i].powi(2)));
    let mut net = Network::new(segments.collect()).unwrap();
    net.set(Slot::Upstream, c(ends[0], 0.0)).unwrap();
    net.set(Slot::Downstream, c(ends[1], 0.0)).unwrap();
    net.attach(Slot::Eu(1), 0, 1.0).unwrap();
    net
}

#[test]
fn oracle_hot_and_cold_tubes() {
    let speeds = [347.2189510957027, 694.4379021914054];
    let net = hot_and_cold([0.25, 0.25], speeds, [1.0, -1.0]);
    let passive = given(0, 1, |_, _| {});
    for expected in eigenvalues("hot_cold_tube_passive") {
        close(root(&net, &passive, expected + c(15.0, 25.0)).s, expected, 1e-12);
    }
    let delay =
        given(0, 1, |at, laws| laws.set(0, &at.s_jet().scale(c(-1e-3, 0.0)).exp().scale(c(-3.0, 0.0))));
    for expected in eigenvalues("hot_cold_tube_n_tau") {
        close(root(&net, &delay, expected + c(15.0, 25.0)).s, expected, 1e-9);
    }
    let c1 = 343.20208333;
    let net = hot_and_cold([0.6, 0.4], [c1, c1 * 2f64.sqrt()], [-1.0, -1.0]);
    let cut_off = 2.0 * std::f64::consts::PI * 75.0;
    let filtered = given(0, 1, move |at, laws| {
        let s = at.s_jet();
        let filter = s.shift(c(cut_off, 0.0)).recip().scale(c(-cut_off, 0.0));
        laws.set(0, &(&filter * &s.scale(c(-3e-3, 0.0)).exp()));
    });
    for expected in eigenvalues("hot_cold_tube_filtered_n_tau") {
        close(root(&net, &filtered, expected + c(5.0, 8.0)).s, expected, 1e-9);
    }
}

/// The rig tube with the paper's wall law in N - 1 interior jumps; half jumps at the ends if asked.
pub(crate) fn lumped(n: usize, half_at_ends: bool) -> Network {
    let piece = Segment { length: 1.0 / n as f64, ..rig_segment() };
    let mut net = Network::new(vec![piece; n]).unwrap();
    close_with_paper_ends(&mut net);
    for j in 0..=n {
        let at_end = j == 0 || j == n;
        if !at_end || half_at_ends {
            let weight = piece.length * if at_end { 0.5 } else { 1.0 };
            net.attach(Slot::Mu(j), 0, weight).unwrap();
            net.attach(Slot::Ep(j), 1, weight).unwrap();
        }
    }
    net
}

/// The rig tube with the paper's wall law in the propagation, in n equal segments.
pub(crate) fn lossy_line(n: usize) -> Network {
    let piece = Segment { length: 1.0 / n as f64, ..rig_segment() };
    let mut net = Network::new(vec![piece; n]).unwrap();
    close_with_paper_ends(&mut net);
    for i in 0..n {
        net.attach(Slot::Viscous(i), 0, 1.0).unwrap();
        net.attach(Slot::Thermal(i), 1, 1.0).unwrap();
    }
    net
}

#[test]
fn oracle_rig_tube_with_wall_loss() {
    let wall = given(0, 2, paper_wall);
    let guess = c(-5.0, 1040.0);
    for n in [1, 7] {
        let expected = eigenvalues("rig_tube_wall_loss_continuum")[0];
        close(root(&lossy_line(n), &wall, guess).s, expected, 1e-9);
    }
    for (n, half, case) in [
        (40, false, "rig_tube_wall_loss_N40_interior_jumps"),
        (80, false, "rig_tube_wall_loss_N80_interior_jumps"),
        (160, false, "rig_tube_wall_loss_N160_interior_jumps"),
        (40, true, "rig_tube_wall_loss_N40_half_end_jumps"),
    ] {
        close(root(&lumped(n, half), &wall, guess).s, eigenvalues(case)[0], 1e-9);
    }
}

#[test]
fn order_lumped_scheme_is_first_order() {
    let wall = given(0, 2, paper_wall);
    let exact = root(&lossy_line(1), &wall, c(-5.0, 1040.0)).s;
    let error = |n: usize| (root(&lumped(n, false), &wall, c(-5.0, 1040.0)).s - exact).norm();
    for n in [80, 160, 320] {
        let order = (error(n) / error(2 * n)).log2();
        assert!((order - 1.0).abs() < 0.01, "order {order} at N = {n}");
    }
    let low = 1.0 - root(&lumped(40, false), &wall, c(-5.0, 1040.0)).s.re / exact.re;
    assert!((low - 0.0288).abs() < 1e-4, "the decay rate at N = 40 is {low} low");
}

#[test]
fn exact_wall_laws_tend_to_each_other() {
    let s = c(-6.0, 1043.0);
    // Zwikker-Kosten against Kirchhoff: the difference is of the next order in boundary layer over radius, so
    // it falls by ten when the diameter grows tenfold.
    let gap = |diameter: f64| {
        let wall = Wall { diameter, ..RIG };
        let (thick, thin) = (wall.zwikker_kosten(s), wall.kirchhoff(s));
        let relative = |a: [C64; 3], b: [C64; 3]| (a[0] - b[0]).norm() / b[0].norm();
        [relative(thick.viscous, thin.viscous), relative(thick.thermal, thin.thermal)]
    };
    for k in 0..2 {
        let ratio = gap(0.3)[k] / gap(3.0)[k];
        assert!((ratio - 10.0).abs() < 0.2, "ratio {ratio}");
    }
    // Narrow tube: Poiseuille's 32 mu/D^2, and isothermal sound, Y = s gamma/(rho c^2).
    let narrow = Wall { diameter: 1e-5, ..RIG }.zwikker_kosten(s);
    let poiseuille = 32.0 * RIG.viscosity / 1e-10;
    // Next order: s rho/3.
    close(narrow.viscous[0], poiseuille + s * RIG.density / 3.0, 1e-6);
    let adiabatic = s / (RIG.density * RIG.sound_speed.powi(2));
    // Next order: 1 - (D/2)^2 s rho Pr/(8 mu).
    let delay = 25e-12 * s * RIG.density * RIG.prandtl / (8.0 * RIG.viscosity);
    close(narrow.thermal[0], 0.4 * adiabatic * (1.0 - delay), 1e-6);
}

#[test]
fn order_wall_laws_differentiate_in_s() {
    use rijke_numerics::check::{slopes_from, slopes_near};
    let s = c(-6.0, 1043.0);
    for law in [Wall::paper, Wall::kirchhoff, Wall::zwikker_kosten] {
        let parts: [fn(&Wall, C64) -> [C64; 3]; 2] = match law(&RIG, s) {
            _ if law(&RIG, s) == RIG.paper(s) => [|w, s| w.paper(s).viscous, |w, s| w.paper(s).thermal],
            _ if law(&RIG, s) == RIG.kirchhoff(s) => {
                [|w, s| w.kirchhoff(s).viscous, |w, s| w.kirchhoff(s).thermal]
            }
            _ => [|w, s| w.zwikker_kosten(s).viscous, |w, s| w.zwikker_kosten(s).thermal],
        };
        for part in parts {
            let [v, d, dd] = part(&RIG, s);
            let step = c(60.0, 200.0);
            let first = |h: f64| (part(&RIG, s + step * h)[0] - v - d * step * h).norm();
            let second = |h: f64| {
                let x = step * h;
                (part(&RIG, s + x)[0] - v - d * x - 0.5 * dd * x * x).norm()
            };
            slopes_near(&slopes_from(0.2, first), 2.0, 0.05);
            slopes_near(&slopes_from(0.5, second), 3.0, 0.05);
        }
    }
}
