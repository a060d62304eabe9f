//! First and second derivatives: closed-form values, an independent chain of jets in wave amplitudes, Taylor
//! slopes.

use crate::common_laws::{RIG, c, close_with_paper_ends, given, paper_wall, rig_segment, root};
use crate::eigenvalues::{eigenvalues, reference};
use rijke_network::{At, Coefficients, Laws, Network, Places, Response, Segment, Slot, Workspace};
use rijke_numerics::check::{slopes_from, slopes_near};
use rijke_numerics::{C64, Jet, JetSpace, Order};
use serde_json::Value;

fn complex(v: &Value) -> C64 {
    c(v[0].as_f64().unwrap(), v[1].as_f64().unwrap())
}

#[track_caller]
fn close(got: C64, expected: C64, relative: f64, scale: f64) {
    let error = (got - expected).norm();
    assert!(error < relative * expected.norm().max(scale), "{got} against {expected}: {error:e}");
}

const MICS: [f64; 8] = [0.25, 0.35, 0.45, 0.55, 0.65, 0.75, 0.85, 0.95];

#[test]
fn exact_rig_tube_with_heater() {
    let case = reference("rig_tube_heater_at_0.25");
    let mut cuts = MICS.to_vec();
    cuts.push(0.25);
    let mut net = Network::cut_tube(rig_segment(), &cuts).unwrap();
    close_with_paper_ends(&mut net);
    let heater = net.place_at(0.25).unwrap();
    for (law, slot) in [Slot::Eu(heater), Slot::Mu(heater), Slot::Ep(heater)].into_iter().enumerate() {
        net.attach(slot, law, 1.0).unwrap();
    }
    let laws = given(4, 3, |at, laws| {
        let [k, tau] = [at.parameter(0, 0.05), at.parameter(1, 1.5e-3)];
        laws.set(0, &-&(&k * &(-&(&at.s_jet() * &tau)).exp()));
        laws.set(1, &at.parameter(2, 0.0));
        laws.set(2, &at.parameter(3, 0.0));
    });
    let expected = eigenvalues("rig_tube_heater_at_0.25")[0];
    let found = root(&net, &laws, expected + c(10.0, 10.0));
    close(found.s, expected, 1e-12, 0.0);
    let at: Vec<usize> = MICS.iter().map(|&x| net.place_at(x).unwrap()).collect();
    let places = Places { reference: at[5], at };
    let got = net.respond(&laws, &found, &places, Order::Second, &mut Workspace::default()).unwrap();
    let derivs = &case["derivs"];
    let first = ["ds/dK", "ds/dtau", "ds/dk_mu", "ds/dk_ep"];
    for (a, name) in first.into_iter().enumerate() {
        close(got.s.gradient()[a], complex(&derivs[name]), 1e-8, 0.0);
    }
    for (a, name) in [(0, "d2s/dK2"), (1, "d2s/dtau2"), (2, "d2s/dk_mu2")] {
        close(got.s.hessian(a, a), complex(&derivs[name]), 1e-8, 0.0);
    }
    for (m, mic) in case["mics"].as_array().unwrap().iter().enumerate() {
        let p = &got.pressures[m];
        close(p.value(), complex(&mic["P"]), 1e-8, 0.1);
        close(p.gradient()[0], complex(&mic["dP_dK"]), 1e-8, 0.1);
        close(p.hessian(0, 0), complex(&mic["d2P_dK2"]), 1e-8, 0.1);
    }
}

#[test]
fn exact_interaction_index_and_delay() {
    let case = reference("hot_cold_tube_n_tau");
    let gamma_p = 1.4 * 101_325.0;
    let speeds = [347.2189510957027, 694.4379021914054];
    let segments = speeds.map(|v| Segment::new(0.25, 1.0, v, gamma_p / v.powi(2)));
    let mut net = Network::new(segments.to_vec()).unwrap();
    net.set(Slot::Upstream, c(1.0, 0.0)).unwrap();
    net.set(Slot::Downstream, c(-1.0, 0.0)).unwrap();
    net.attach(Slot::Eu(1), 0, -3.0).unwrap();
    let laws = given(2, 1, |at, laws| {
        let [n, tau] = [at.parameter(0, 1.0), at.parameter(1, 1e-3)];
        laws.set(0, &(&n * &(-&(&at.s_jet() * &tau)).exp()));
    });
    let found = root(&net, &laws, eigenvalues("hot_cold_tube_n_tau")[0] + c(10.0, 10.0));
    let places = Places { at: vec![0], reference: 0 };
    let got = net.respond(&laws, &found, &places, Order::Second, &mut Workspace::default()).unwrap();
    for (a, first, second) in [(0, "ds/dn", "d2s/dn2"), (1, "ds/dtau", "d2s/dtau2")] {
        close(got.s.gradient()[a], complex(&case["derivs"][first]), 1e-8, 0.0);
        close(got.s.hessian(a, a), complex(&case["derivs"][second]), 1e-8, 0.0);
    }
}

/// Everything at once: nine parameters in every kind of slot, delays, wall loss, three gases, two area
/// changes.
pub(crate) const EVERYTHING: [f64; 9] = [1.1, 0.06, 1.2e-3, 0.98, 0.31, 1.0, 0.02, 1.0, 0.4];

pub(crate) fn everything(a: [f64; 9]) -> (Network, impl Coefficients) {
    let segments = vec![
        Segment::new(0.21, 1.8e-3, 343.0, 1.2),
        Segment::new(0.13, 1.8e-3, 343.0, 1.2),
        Segment::new(0.31, 1.5e-3, 420.0, 0.8),
        Segment::new(0.27, 2.1e-3, 400.0, 0.9),
    ];
    let mut net = Network::new(segments).unwrap();
    net.set(Slot::Viscous(2), c(0.2, 0.1)).unwrap();
    net.set(Slot::Mp(2), c(0.01, 0.02)).unwrap();
    for i in 0..4 {
        net.attach(Slot::Viscous(i), 0, 1.0 + 0.1 * i as f64).unwrap();
        net.attach(Slot::Thermal(i), 1, 1.0).unwrap();
    }
    net.attach(Slot::Eu(1), 2, 1.0).unwrap();
    net.attach(Slot::Mp(1), 3, 0.3).unwrap();
    net.attach(Slot::Mu(3), 4, 5.0).unwrap();
    net.attach(Slot::Ep(2), 4, 1e-5).unwrap();
    net.attach(Slot::Upstream, 5, 1.0).unwrap();
    net.attach(Slot::Downstream, 5, 1.01).unwrap();
    net.attach(Slot::Length(1), 6, 1.0).unwrap();
    net.attach(Slot::Length(2), 6, -1.0).unwrap();
    net.attach(Slot::SoundSpeed(2), 7, 30.0).unwrap();
    net.attach(Slot::Density(3), 7, 0.1).unwrap();
    net.attach(Slot::Density(0), 7, 0.05).unwrap();
    net.attach(Slot::Area(2), 8, 1e-3).unwrap();
    let laws = given(9, 9, move |at: &At, laws: &mut Laws| {
        let p = |i: usize| at.parameter(i, a[i]);
        let s = at.s_jet();
        let root = s.scale(c(RIG.density * RIG.viscosity, 0.0)).sqrt();
        laws.set(0, &(&p(0) * &root.scale(c(84.0, 0.0))));
        laws.set(1, &(&p(0) * &root.scale(c(3e-4, 0.0))));
        laws.set(2, &-&(&p(1) * &(-&(&s * &p(2))).exp()));
        laws.set(3, &(&p(1) * &s.scale(c(1e-3, 0.0))));
        laws.set(4, &(&p(4) * &s.scale(c(1e-3, 2e-4))));
        laws.set(5, &-&(&p(3) * &s.scale(c(-8e-5, 0.0)).exp()));
        laws.set(6, &p(6));
        laws.set(7, &(&p(5) * &p(7)));
        laws.set(8, &p(8).sin());
    });
    (net, laws)
}

/// The slow oracle: the chain in wave amplitudes (f, g) with jets, transfer matrices from exponentials of
/// sqrt(Z) sqrt(Y) l. Shares no code with the network but the jets. Returns (F, p at places), last seed s.
fn oracle(a: [f64; 9], s: C64, order: Order) -> (Jet, Vec<Jet>) {
    let space = JetSpace::new(10, order);
    let p = |i: usize| space.seed(i, c(a[i], 0.0));
    let s = space.seed(9, s);
    let k = |v: f64| space.real(v);
    let wall = s.scale(c(RIG.density * RIG.viscosity, 0.0)).sqrt();
    let (eta, shift, seven) = (p(0), p(6), &p(5) * &p(7));
    let lengths = [k(0.21), &k(0.13) + &shift, &k(0.31) - &shift, k(0.27)];
    let speeds = [k(343.0), k(343.0), &k(420.0) + &seven.scale(c(30.0, 0.0)), k(400.0)];
    let rhos = [&k(1.2) + &seven.scale(c(0.05, 0.0)), k(1.2), k(0.8), &k(0.9) + &seven.scale(c(0.1, 0.0))];
    let areas = [k(1.8e-3), k(1.8e-3), &k(1.5e-3) + &p(8).sin().scale(c(1e-3, 0.0)), k(2.1e-3)];
    let zero = k(0.0);
    let drag = &p(4) * &s.scale(c(1e-3, 2e-4));
    let heat = -&(&p(1) * &(-&(&s * &p(2))).exp());
    let feedback = [
        [zero.clone(), zero.clone(), zero.clone(), zero.clone()],
        [zero.clone(), (&p(1) * &s.scale(c(1e-3, 0.0))).scale(c(0.3, 0.0)), heat, zero.clone()],
        [zero.clone(), space.constant(c(0.01, 0.02)), zero.clone(), drag.scale(c(1e-5, 0.0))],
        [drag.scale(c(5.0, 0.0)), zero.clone(), zero.clone(), zero.clone()],
    ];
    let r = -&(&p(3) * &s.scale(c(-8e-5, 0.0)).exp());
    let z0 = &rhos[0] * &speeds[0];
    let (mut pressure, mut velocity) = (r.shift(C64::ONE), &r.shift(-C64::ONE) / &z0);
    let mut pressures = Vec::new();
    for i in 0..4 {
        pressures.push(pressure.clone());
        if i > 0 {
            let [mu, mp, eu, ep] = &feedback[i];
            let ratio = &areas[i - 1] / &areas[i];
            let next_p = &(&pressure - &(mu * &velocity)) - &(mp * &pressure);
            velocity = &(&(&ratio * &velocity) - &(eu * &velocity)) - &(ep * &pressure);
            pressure = next_p;
        }
        let mut viscous = (&eta * &wall.scale(c(84.0, 0.0))).scale(c(1.0 + 0.1 * i as f64, 0.0));
        if i == 2 {
            viscous = viscous.shift(c(0.2, 0.1));
        }
        let thermal = &eta * &wall.scale(c(3e-4, 0.0));
        let z = &(&s * &rhos[i]) + &viscous;
        let y = &(&s / &(&rhos[i] * &(&speeds[i] * &speeds[i]))) + &thermal;
        let (gamma, zc) = (&z.sqrt() * &y.sqrt(), &z.sqrt() / &y.sqrt());
        let half = c(0.5, 0.0);
        let zu = &zc * &velocity;
        let f = &(&pressure + &zu).scale(half) * &(-&(&gamma * &lengths[i])).exp();
        let g = &(&pressure - &zu).scale(half) * &(&gamma * &lengths[i]).exp();
        pressure = &f + &g;
        velocity = &(&f - &g) / &zc;
    }
    pressures.push(pressure.clone());
    let zu = &(&rhos[3] * &speeds[3]) * &velocity;
    let r = r.scale(c(1.01, 0.0));
    let f = &(&pressure - &zu) - &(&r * &(&pressure + &zu));
    (f, pressures)
}

fn respond(a: [f64; 9], order: Order) -> (C64, Response) {
    let (net, laws) = everything(a);
    let found = root(&net, &laws, c(-40.0, 1120.0));
    let places = Places { at: vec![0, 1, 2, 3, 4], reference: 2 };
    let got = net.respond(&laws, &found, &places, order, &mut Workspace::default()).unwrap();
    (found.s, got)
}

#[test]
fn oracle_jets_through_the_whole_chain() {
    let (s, got) = respond(EVERYTHING, Order::Second);
    let (f, pressures) = oracle(EVERYTHING, s, Order::Second);
    assert!((f.value() / f.gradient()[9]).norm() < 1e-11 * s.norm());
    let fs = f.gradient()[9];
    let sa: Vec<C64> = (0..9).map(|i| -f.gradient()[i] / fs).collect();
    let sab = |i: usize, j: usize| {
        let cross = f.hessian(i, 9) * sa[j] + f.hessian(j, 9) * sa[i] + f.hessian(9, 9) * sa[i] * sa[j];
        -(f.hessian(i, j) + cross) / fs
    };
    for i in 0..9 {
        close(got.s.gradient()[i], sa[i], 1e-10, 1e-3);
        for j in 0..9 {
            close(got.s.hessian(i, j), sab(i, j), 1e-10, s.norm());
        }
    }
    for (m, p) in pressures.iter().enumerate() {
        let relative = p / &pressures[2];
        let q = &got.pressures[m];
        close(q.value(), relative.value(), 1e-11, 1.0);
        let ys = relative.gradient()[9];
        for i in 0..9 {
            close(q.gradient()[i], relative.gradient()[i] + ys * sa[i], 1e-10, 1.0);
            for j in 0..9 {
                let along =
                    relative.hessian(i, j) + relative.hessian(i, 9) * sa[j] + relative.hessian(j, 9) * sa[i];
                let whole = along + relative.hessian(9, 9) * sa[i] * sa[j] + ys * sab(i, j);
                // The scale of the second derivatives with respect to the delay (1e-3 s) is 1e6.
                close(q.hessian(i, j), whole, 1e-10, 1e3);
            }
        }
    }
}

#[test]
fn order_taylor_remainders_of_s_and_pressures() {
    let (_, at) = respond(EVERYTHING, Order::Second);
    let direction = [0.3, 0.02, 3e-4, 0.01, 0.1, 0.2, 0.01, 0.1, 0.2];
    let outputs =
        |r: &Response| -> Vec<Jet> { std::iter::once(r.s.clone()).chain(r.pressures.clone()).collect() };
    let base = outputs(&at);
    let moved = |h: f64| {
        let mut a = EVERYTHING;
        for (a, d) in a.iter_mut().zip(direction) {
            *a += h * d;
        }
        outputs(&respond(a, Order::First).1)
    };
    for (o, jet) in base.iter().enumerate() {
        if o == 3 {
            continue; // the reference itself
        }
        let first: C64 = (0..9).map(|i| jet.gradient()[i] * direction[i]).sum();
        let second: C64 =
            (0..81).map(|k| 0.5 * jet.hessian(k / 9, k % 9) * direction[k / 9] * direction[k % 9]).sum();
        let gap = |h: f64| moved(h)[o].value() - jet.value() - first * h;
        slopes_near(&slopes_from(4e-2, |h| gap(h).norm()), 2.0, 0.05);
        slopes_near(&slopes_from(0.1, |h| (gap(h) - second * h * h).norm()), 3.0, 0.05);
    }
}

#[test]
fn exact_orders_agree_and_parameters_without_effect_have_no_derivative() {
    let (_, second) = respond(EVERYTHING, Order::Second);
    let (_, first) = respond(EVERYTHING, Order::First);
    let (_, value) = respond(EVERYTHING, Order::Value);
    assert!(value.s.gradient().is_empty() && first.s.hessian_packed().is_empty());
    assert_eq!(first.s.gradient(), second.s.gradient());
    let mut net = Network::new(vec![rig_segment()]).unwrap();
    close_with_paper_ends(&mut net);
    net.attach(Slot::Viscous(0), 0, 1.0).unwrap();
    net.attach(Slot::Thermal(0), 1, 1.0).unwrap();
    let idle = given(2, 2, paper_wall);
    let found = root(&net, &idle, c(-5.0, 1040.0));
    let places = Places { at: vec![1], reference: 0 };
    let got = net.respond(&idle, &found, &places, Order::Second, &mut Workspace::default()).unwrap();
    assert!(got.s.gradient().iter().chain(got.s.hessian_packed()).all(|g| *g == C64::ZERO));
}
