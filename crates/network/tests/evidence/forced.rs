//! Forced response at s = i omega: closed forms, reciprocity, energy, derivatives, and poles that are the
//! modes.

use crate::chains::{NEWTON, VALUES, laws, tube};
use crate::common_laws::c;
use crate::mean_flow::{GAMMA, end, inlet};
use rijke_network::file::read;
use rijke_network::flow_chain::{FlowChain, FlowDuct};
use rijke_network::laws::{Law, WallLaw};
use rijke_network::{Chain, Constant, Forced, Network, NetworkError, Segment, Slot, Source, Workspace};
use rijke_numerics::check::{slopes_from, slopes_near};
use rijke_numerics::{C64, Jet, Order};

const AIR: Segment = Segment { length: 1.0, area: 2e-3, sound_speed: 340.0, density: 1.2 };
const Z: f64 = 408.0;

fn value(jet: Result<Jet, NetworkError>) -> C64 {
    jet.unwrap().value()
}

fn near(got: C64, exact: C64, tolerance: f64) {
    assert!((got - exact).norm() < tolerance * exact.norm().max(1e-300), "{got} against {exact}");
}

#[test]
fn exact_impedances_of_tubes_and_a_resonator() {
    let mut work = Workspace::default();
    for hertz in [40.0, 333.0, 1510.0] {
        let s = c(0.0, std::f64::consts::TAU * hertz);
        let k = s / 340.0;
        let t = k.tanh();
        for (end, exact) in [(1.0, Z / t), (-1.0, Z * t), (0.0, c(Z, 0.0))] {
            let mut net = Network::cut_tube(AIR, &[0.3]).unwrap();
            net.set(Slot::Downstream, c(end, 0.0)).unwrap();
            near(value(net.impedance_at(&Constant, s, 0, Order::Value, &mut work)), exact, 1e-12);
            let exact = end * (-2.0 * k).exp();
            let r = value(net.reflection_at(&Constant, s, 0, Order::Value, &mut work));
            assert!((r - exact).norm() < 1e-12, "{r} {exact}");
        }
        // A neck of 1/40 of the area and a closed volume of 0.1 m.
        let neck = Segment { length: 0.03, area: 5e-5, ..AIR };
        let mut net = Network::new(vec![neck, Segment { length: 0.1, ..AIR }]).unwrap();
        net.set(Slot::Downstream, C64::ONE).unwrap();
        let volume = Z / (0.1 * k).tanh() / 40.0;
        let t = (0.03 * k).tanh();
        let exact = Z * (volume + Z * t) / (Z + volume * t);
        near(value(net.impedance_at(&Constant, s, 0, Order::Value, &mut work)), exact, 1e-12);
    }
}

#[test]
fn exact_a_source_between_closed_ends() {
    // A velocity 1 at 0.3 m: p = -rho c cosh(k (1 - a)) cosh(k x)/sinh k upstream, symmetric beyond, up to
    // the sign of u.
    let mut net = Network::cut_tube(AIR, &[0.3, 0.8]).unwrap();
    net.set(Slot::Upstream, C64::ONE).unwrap();
    net.set(Slot::Downstream, C64::ONE).unwrap();
    let s = c(0.0, 2.0 * 340.0);
    let k = s / 340.0;
    let Forced { before, behind } =
        net.forced(&Constant, s, Source::Velocity(1), Order::Value, &mut Workspace::default()).unwrap();
    let scale = Z / k.sinh();
    near(before[0][0].value(), scale * (0.7 * k).cosh(), 1e-12);
    near(before[1][0].value(), scale * (0.7 * k).cosh() * (0.3 * k).cosh(), 1e-12);
    near(before[2][0].value(), scale * (0.3 * k).cosh() * (0.2 * k).cosh(), 1e-12);
    near(behind[1][1].value() - before[1][1].value(), C64::ONE, 1e-12);
    assert!(before[0][1].value().norm() < 1e-15 && before[3][1].value().norm() < 1e-14);
    let none = net.forced(&Constant, s, Source::Velocity(9), Order::Value, &mut Workspace::default());
    assert!(matches!(none, Err(NetworkError::Slot { .. })));
}

#[test]
fn exact_reciprocity_and_energy() {
    let mut work = Workspace::default();
    // Pressure at j per volume flow at i is that at i per volume flow at j: areas, losses, a side hole, a
    // resonator.
    let text = "[upstream]\ntype = 'constant'\nmodulus = 0.7\nangle = 1\n[downstream]\ntype = 'unflanged'\n\
                [[element]]\ntype = 'duct'\nlength = 0.3\ndiameter = 0.05\nwall = 'kirchhoff'\n\
                [[element]]\ntype = 'side-hole'\ndiameter = 0.012\nlength = 0.004\nwall = 'kirchhoff'\n\
                [[element]]\ntype = 'duct'\nlength = 0.4\ndiameter = 0.05\nwall = 'kirchhoff'\n\
                [[element]]\ntype = 'duct'\nlength = 0.2\ndiameter = 0.08\ntemperature = 500\n\
                [[element]]\ntype = 'helmholtz'\nvolume = 5e-4\nneck_area = 4e-4\nneck_length = 0.03\n\
                [[element]]\ntype = 'duct'\nlength = 0.2\ndiameter = 0.08\ntemperature = 500\n";
    let built = read(text).unwrap();
    let areas: Vec<f64> = built.network.segments().iter().map(|s| s.area).collect();
    for hertz in [70.0, 455.0, 1300.0] {
        let s = c(0.0, std::f64::consts::TAU * hertz);
        let mut at = |j: usize| {
            built.network.forced(&built.laws, s, Source::Velocity(j), Order::Value, &mut work).unwrap()
        };
        let (one, two) = (at(1), at(2));
        near(one.behind[2][0].value() / areas[1], two.behind[1][0].value() / areas[2], 1e-11);
        let hole =
            built.network.transfer(&built.laws, s, [1, 1], Order::Value, &mut Workspace::default()).unwrap();
        let [[a, b], [c, d]] = hole.matrix.each_ref().map(|row| row.each_ref().map(Jet::value));
        near(a * d - b * c, C64::ONE, 1e-12);
        near(a, d, 1e-12);
    }
    // What a lossless change of area and gas reflects and lets pass carries all the energy.
    let hot = Segment { area: 5e-3, sound_speed: 500.0, density: 0.5, ..AIR };
    let net = Network::new(vec![AIR, hot]).unwrap();
    let s = c(0.0, 800.0);
    let whole = net.transfer(&Constant, s, [0, 2], Order::Value, &mut work).unwrap();
    let [[r, back], [t, r2]] = whole.scattering().map(|row| row.map(|j| j.value().norm_sqr()));
    let weight = (5e-3 / 250.0) / (2e-3 / 408.0);
    assert!((r + t * weight - 1.0).abs() < 1e-12 && (r2 + back / weight - 1.0).abs() < 1e-12, "{r} {t}");
    // R of a step: (Z2 - Z1)/(Z2 + Z1) with Z = rho c/A.
    let (z1, z2): (f64, f64) = (408.0 / 2e-3, 250.0 / 5e-3);
    assert!((r - ((z2 - z1) / (z2 + z1)).powi(2)).abs() < 1e-12);
}

#[test]
fn exact_poles_of_the_response_are_the_modes() {
    let (net, k, mut work) = (tube(), laws(VALUES), Workspace::default());
    let root = net.solve(&k, c(-30.0, 1100.0), &NEWTON, &mut work).unwrap().s;
    for source in [Source::Velocity(1), Source::Pressure(2), Source::Upstream, Source::Downstream] {
        let mut pressure = |d: f64| {
            let s = root + C64::from_polar(d, 0.7);
            net.forced(&k, s, source, Order::Value, &mut work).unwrap().before[3][0].value() * d
        };
        let (near_one, nearer) = (pressure(1e-3), pressure(1e-5));
        assert!((near_one / nearer - 1.0).norm() < 1e-4, "{source:?}: {near_one} {nearer}");
    }
    // And the impedance seen upstream meets the upstream end there: f = R_u g.
    let r = value(net.reflection_at(&k, root, 0, Order::Value, &mut work));
    let up = -VALUES[4] * (-8e-5 * root).exp();
    near(r * up, C64::ONE, 1e-9);
}

#[test]
fn order_taylor_remainders_of_forced_response() {
    let net = tube();
    let s = c(0.0, 900.0);
    let direction = [0.3, 0.02, 3e-4, 0.1, 0.01, 0.01, 0.1, 0.0];
    let turn = c(2.0, 30.0);
    let outputs = |h: f64, order: Order| -> Vec<Jet> {
        let (mut a, mut work) = (VALUES, Workspace::default());
        a.iter_mut().zip(direction).for_each(|(a, d)| *a += h * d);
        let (k, s) = (laws(a), s + turn * h);
        let forced = net.forced(&k, s, Source::Velocity(1), order, &mut work).unwrap();
        let transfer = net.transfer(&k, s, [0, 3], order, &mut work).unwrap();
        let [[r, _], [t, _]] = transfer.scattering();
        let seen = net.reflection_at(&k, s, 1, order, &mut work).unwrap();
        vec![forced.before[2][0].clone(), forced.behind[1][1].clone(), r, t, seen]
    };
    let base = outputs(0.0, Order::Second);
    let along = |i: usize| if i == 7 { turn } else { c(direction[i], 0.0) };
    for (o, jet) in base.iter().enumerate() {
        let first: C64 = (0..8).map(|i| jet.gradient()[i] * along(i)).sum();
        let second: C64 =
            (0..64).map(|k| 0.5 * jet.hessian(k / 8, k % 8) * along(k / 8) * along(k % 8)).sum();
        let gap = |h: f64| outputs(h, Order::First)[o].value() - jet.value() - first * h;
        slopes_near(&slopes_from(0.05, |h| gap(h).norm()), 2.0, 0.06);
        slopes_near(&slopes_from(0.1, |h| (gap(h) - second * h * h).norm()), 3.0, 0.08);
    }
}

#[test]
fn oracle_fifty_bores_by_the_product_of_their_matrices() {
    // Short and long segments, thick and thin boundary layers, whole blocks and a rest: one after the other,
    // with I1/I0 by its continued fraction (DLMF 10.33.1).
    let bessel = |z: C64| (1..=600).rev().fold(C64::ZERO, |below, k| z * z / (f64::from(2 * k) + below)) / z;
    for count in [1, 7, 16, 50] {
        let mut text = "[upstream]\ntype = 'closed'\n[downstream]\ntype = 'closed'\n".to_owned();
        for k in 0..count {
            let (diameter, length) = (1e-3 * (1.0 + f64::from(k % 9)), 0.004 * f64::from(1 + k % 5));
            text += &format!(
                "[[element]]\ntype = 'duct'\nlength = {length}\ndiameter = {diameter}\nwall = 'zwikker-kosten'\n"
            );
        }
        let built = read(&text).unwrap();
        let (network, laws, mut work) = (&built.network, &built.laws, Workspace::default());
        for s in [c(0.0, 60.0), c(0.0, 900.0), c(-40.0, 3000.0), c(0.0, 2.5e4)] {
            // u/p, from the closed end.
            let mut admittance = C64::ZERO;
            for (i, segment) in network.segments().iter().enumerate().rev() {
                let Law::Viscous(WallLaw::ZwikkerKosten, wall) = laws.laws[2 * i].1 else {
                    panic!("law {} is of no viscous wall", 2 * i);
                };
                let z = 0.5 * wall.diameter * (s * wall.density / wall.viscosity).sqrt();
                let mean = |z: C64| 2.0 * bessel(z) / z;
                let stiff = segment.density * segment.sound_speed * segment.sound_speed;
                let series = s * segment.density / (1.0 - mean(z));
                let shunt = s / stiff * (1.0 + (wall.gamma - 1.0) * mean(z * wall.prandtl.sqrt()));
                let (t, y) =
                    ((segment.length * (series * shunt).sqrt()).tanh(), shunt.sqrt() / series.sqrt());
                let next = network.segments().get(i + 1).map_or(0.0, |next| next.area / segment.area);
                let load = admittance * next;
                admittance = y * (load + y * t) / (y + load * t);
            }
            let got = value(network.impedance_at(laws, s, 0, Order::Value, &mut work));
            near(got, admittance.inv(), 1e-11);
        }
    }
}

#[test]
fn exact_values_alone_are_those_of_the_jets() {
    // Areas, every law of losses, a side hole, a resonator, an open end: what the values pass without
    // derivatives.
    let text = "[upstream]\ntype = 'closed'\n[downstream]\ntype = 'unflanged'\n\
                [[element]]\ntype = 'duct'\nlength = 0.3\ndiameter = 0.05\nwall = 'zwikker-kosten'\n\
                [[element]]\ntype = 'side-hole'\ndiameter = 0.012\nlength = 0.004\nwall = 'kirchhoff'\n\
                [[element]]\ntype = 'duct'\nlength = 0.4\ndiameter = 0.03\nwall = 'kirchhoff'\n\
                [[element]]\ntype = 'helmholtz'\nvolume = 5e-4\nneck_area = 4e-4\nneck_length = 0.03\n\
                [[element]]\ntype = 'duct'\nlength = 0.2\ndiameter = 0.08\ntemperature = 500\nwall = 'paper'\n";
    let built = read(text).unwrap();
    let (network, laws, mut work) = (&built.network, &built.laws, Workspace::default());
    let n = network.segments().len();
    for hertz in [30.0, 410.0, 1900.0] {
        let s = c(0.0, std::f64::consts::TAU * hertz);
        for place in 0..=n {
            let mut both = |order| {
                let seen = [
                    network.impedance_at(laws, s, place, order, &mut work).unwrap().value(),
                    network.reflection_at(laws, s, place, order, &mut work).unwrap().value(),
                ];
                let through = network.transfer(laws, s, [place, n], order, &mut work).unwrap();
                let sources =
                    [Source::Velocity(place), Source::Pressure(place), Source::Upstream, Source::Downstream];
                // All pressures of a response, and all velocities, against the largest of them.
                let made = sources.map(|source| network.forced(laws, s, source, order, &mut work).unwrap());
                let made = made.iter().flat_map(|made| {
                    let sides = made.before.iter().chain(&made.behind);
                    [0, 1].map(|part| sides.clone().map(|state| state[part].value()).collect::<Vec<_>>())
                });
                let parts = through.matrix.iter().flatten().chain(&through.impedances);
                let alone = seen.into_iter().chain(parts.map(Jet::value)).map(|value| vec![value]);
                alone.chain(made).collect::<Vec<_>>()
            };
            for (alone, jets) in both(Order::Value).into_iter().zip(both(Order::First)) {
                let largest = jets.iter().map(|z| z.norm()).fold(0.0, f64::max);
                for (alone, jet) in alone.into_iter().zip(jets) {
                    // A pressure at a closed end moves nothing but for rounding of 1/(rho c), 2e-3.
                    assert!(
                        (alone - jet).norm() < 1e-12 * largest + 1e-15,
                        "{hertz} {place}: {alone} against {jet}"
                    );
                }
            }
        }
    }
    let none = network.impedance_at(laws, C64::ONE, n + 1, Order::Value, &mut work);
    assert!(matches!(none, Err(NetworkError::Slot { .. })));
}

/// Two waves of p = f e^{-sx/(c + v)} + g e^{sx/(c - v)}, of which one is sent into the duct at an end.
#[test]
fn exact_waves_sent_into_a_duct_with_flow() {
    let (speed, velocity, length, ends) = (340.0, 51.0, 0.8, [0.6, -0.7]);
    let ducts = vec![FlowDuct::new(0.3, 2e-3), FlowDuct::new(length - 0.3, 2e-3)];
    let chain = FlowChain::new(GAMMA, inlet(speed, velocity), ducts, ends.map(end)).unwrap();
    let impedance = inlet(speed, velocity).density * speed;
    let (down, up) = (speed + velocity, speed - velocity);
    for s in [c(0.0, 900.0), c(-20.0, 3300.0)] {
        let round = (-s * length * (1.0 / down + 1.0 / up)).exp();
        for source in [Source::Upstream, Source::Downstream] {
            // What each end sends: what it reflects, and the wave that enters there. g is that of x = 0.
            let gain = (C64::ONE - ends[0] * ends[1] * round).inv();
            let [f, g] = match source {
                Source::Upstream => [gain, gain * ends[1] * round],
                _ => [gain * ends[0] * (-s * length / up).exp(), gain * (-s * length / up).exp()],
            };
            let Forced { before, behind } = chain.forced(s, source).unwrap();
            for (k, x) in [(1, 0.3), (2, length)] {
                let (f, g) = (f * (-s * x / down).exp(), g * (s * x / up).exp());
                near(before[k][0].value(), f + g, 1e-12);
                near(before[k][1].value(), (f - g) / impedance, 1e-12);
            }
            near(behind[0][0].value(), f + g, 1e-12);
        }
    }
}

/// The eighth mode of a duct of constant reflections, whose phase turns by a little more than 24 on the way
/// upstream: what leaves at the ends and what a little friction takes is what the energy loses. Friction
/// kappa per metre slows the decay of a wave by kappa/(2 rho).
#[test]
fn exact_energy_of_many_waves_with_flow() {
    let (speed, density, length, ends, friction) = (340.0, 1.2, 1.0, [0.9, -0.9], 1e-3);
    // s L (1/(c + v) + 1/(c - v)) = ln |R R'| + (2 n + 1) i pi.
    let turns = c((0.9f64 * 0.9).ln(), 15.0 * std::f64::consts::PI);
    let velocity = speed * (2.0 * 24.001 / turns.norm() - 1.0);
    let s = turns * (speed * speed - velocity * velocity) / (2.0 * speed * length);
    assert!((s.norm() * length / (speed - velocity) - 24.001).abs() < 1e-9, "{velocity}");
    let mut rest = Network::new(vec![Segment::new(length, 2e-3, speed, density)]).unwrap();
    rest.set(Slot::Viscous(0), c(friction, 0.0)).unwrap();
    rest.set(Slot::Upstream, c(ends[0], 0.0)).unwrap();
    rest.set(Slot::Downstream, c(ends[1], 0.0)).unwrap();
    let chain = FlowChain::of(&rest, GAMMA, velocity).unwrap();
    let mut work = Workspace::default();
    let root = Chain::solve(&chain, &Constant, s + c(1.0, 2.0), &NEWTON, &mut work).unwrap();
    assert!((root.s - s).norm() < friction, "{} {s}", root.s);
    let budget = chain.budget(&Constant, &root, &mut work).unwrap();
    assert!(budget.mismatch() < 1e-9, "{budget:?}");
    assert!((budget.viscous * density / friction + 1.0).abs() < 0.01, "{budget:?}");
}
