//! The adjoint with flow, sensitivities along x, and velocities that are heard elsewhere.

use crate::common_laws::{Given, c, given};
use crate::mean_flow::{GAMMA, delayed, end, everything, inlet, modes};
use rijke_network::file::read;
use rijke_network::flow_chain::{ActionKind, FlowChain, FlowDuct, FlowState, Reference};
use rijke_network::laws::Law;
use rijke_network::{
    At, Chain, Constant, Device, Laws, NetworkError, Newton, Places, Region, Root, Slot, Station, Workspace,
};
use rijke_numerics::check::{slopes_from, slopes_near};
use rijke_numerics::{C64, Order};

const WIDE: Region = Region { sigma: [-150.0, 150.0], omega: [300.0, 4000.0] };

/// Every element, a flame that hears 0.35 m upstream through a step of area, a loop over two places.
fn talkative(velocity: f64) -> FlowChain {
    let (state, mut ducts, ends) = everything(velocity);
    ducts[2].actions[0].reference = Reference::Upstream(0.35);
    ducts[3] = ducts[3].clone().referring(ActionKind::Eu, delayed(0.3, 1e-3), Reference::Downstream(0.28));
    FlowChain::new(GAMMA, state, ducts, ends).unwrap().without_entropy_waves()
}

fn solve(chain: &FlowChain, guess: C64) -> Root {
    let newton = Newton { tolerance: 1e-14, max_step: Some(20.0), ..Newton::default() };
    crate::mean_flow::solve(chain, guess, &newton)
}

fn along(chain: &FlowChain, root: &Root, samples: usize) -> Vec<Station> {
    chain.along(&Constant, root, samples, &mut Workspace::default()).unwrap()
}

/// The same with every duct cut in two, so that place 2 i + 1 lies within what was duct i.
fn cut(chain: &FlowChain) -> FlowChain {
    let halves = |duct: &FlowDuct| {
        let behind = FlowDuct { wall: duct.wall.clone(), ..FlowDuct::new(0.6 * duct.length, duct.area) };
        [FlowDuct { length: 0.4 * duct.length, ..duct.clone() }, behind]
    };
    let ducts = chain.ducts().iter().flat_map(halves).collect();
    FlowChain::new(GAMMA, chain.states()[0], ducts, chain.ends().clone()).unwrap().without_entropy_waves()
}

/// As many laws as parameters: each is its parameter, which is 0.
fn parameters_alone(count: usize) -> Given<impl Fn(&At, &mut Laws)> {
    given(count, count, move |at: &At, laws: &mut Laws| {
        (0..count).for_each(|k| laws.set(k, &at.parameter(k, 0.0)));
    })
}

#[test]
fn oracle_adjoint_with_flow_agrees_with_jets_through_the_chain() {
    let chain = cut(&talkative(8.0));
    let root = solve(&chain, modes(&chain, &WIDE)[1]);
    let stations = along(&chain, &root, 2);
    let (mut attached, mut expected) = (chain, Vec::new());
    for place in (1..12).step_by(2) {
        let here = &stations[2 * place];
        for (k, slot) in
            [Slot::Mu(place), Slot::Mp(place), Slot::Eu(place), Slot::Ep(place)].iter().enumerate()
        {
            Chain::attach(&mut attached, *slot, expected.len(), 1.0).unwrap();
            expected.push(here.feedback[k]);
        }
    }
    let laws = parameters_alone(expected.len());
    let nowhere = Places { at: Vec::new(), reference: 0 };
    let asked: &dyn Chain = &attached;
    let jets = asked.respond(&laws, &root, &nowhere, Order::First, &mut Workspace::default()).unwrap().s;
    assert_eq!(jets.gradient().len(), 24);
    for (k, (got, jet)) in expected.iter().zip(jets.gradient()).enumerate() {
        assert!((got - jet).norm() < 1e-10 * jet.norm(), "law {k}: {got} {jet}");
    }
}

#[test]
fn order_taylor_remainders_of_feedback_that_is_not_there_yet() {
    let weak = [
        (1, ActionKind::Mu, 40.0, Slot::Mu(1)),
        (3, ActionKind::Ep, 2e-4, Slot::Ep(3)),
        (4, ActionKind::Mp, 0.02, Slot::Mp(4)),
        (2, ActionKind::Eu, 0.1, Slot::Eu(2)),
    ];
    let shifts =
        [(0.01, Slot::Length(2)), (0.01, Slot::Length(3)), (3e-5, Slot::Area(1)), (0.02, Slot::Upstream)];
    let base_chain = talkative(8.0);
    let guess = modes(&base_chain, &WIDE)[1];
    let moved = |h: f64| {
        let mut ducts = base_chain.ducts().to_vec();
        for &(place, effect, size, _) in &weak {
            ducts[place] = ducts[place].clone().with(effect, Law::Constant(c(h * size, 0.0)));
        }
        ducts[2].length += h * shifts[0].0;
        ducts[3].length += h * shifts[1].0;
        ducts[1].area += h * shifts[2].0;
        let (state, _, [_, downstream]) = everything(8.0);
        let ends = [end(0.95 + h * shifts[3].0), downstream];
        FlowChain::new(GAMMA, state, ducts, ends).unwrap().without_entropy_waves()
    };
    let places = Places { at: vec![1, 4], reference: 2 };
    let mut work = Workspace::default();
    let mut attached = base_chain.clone();
    let slots = weak.iter().map(|w| (w.2, w.3)).chain(shifts);
    for (law, (size, slot)) in slots.enumerate() {
        Chain::attach(&mut attached, slot, law, size).unwrap();
    }
    let root = solve(&base_chain, guess);
    let base =
        Chain::respond(&attached, &parameters_alone(8), &root, &places, Order::Second, &mut work).unwrap();
    let value = |h: f64, o: usize| {
        let (chain, mut work) = (moved(h), Workspace::default());
        let root = solve(&chain, guess);
        let r = Chain::respond(&chain, &Constant, &root, &places, Order::Value, &mut work).unwrap();
        if o == 0 { r.s.value() } else { r.pressures[o - 1].value() }
    };
    for (o, jet) in std::iter::once(&base.s).chain(&base.pressures).enumerate() {
        let first: C64 = jet.gradient().iter().sum();
        let second: C64 = (0..64).map(|k| 0.5 * jet.hessian(k / 8, k % 8)).sum();
        let gap = |h: f64| value(h, o) - jet.value() - first * h;
        slopes_near(&slopes_from(0.2, |h| gap(h).norm()), 2.0, 0.06);
        slopes_near(&slopes_from(0.4, |h| (gap(h) - second * h * h).norm()), 3.0, 0.08);
    }
}

/// A chain whose second duct is cut at a point, with a piece in between.
fn with_piece(
    entropy: bool,
    at: f64,
    piece: f64,
    change: &dyn Fn(&mut FlowDuct, &mut FlowDuct),
) -> FlowChain {
    let flame = FlowDuct::new(0.5, 1.4e-3).heated(1.8).referring(
        ActionKind::Flame,
        delayed(0.8, 1.5e-3),
        Reference::Upstream(0.45),
    );
    let mut middle = FlowDuct::new(piece, 1.6e-3);
    let mut behind = FlowDuct::new(0.3 - at - 0.5 * piece, 1.6e-3);
    change(&mut middle, &mut behind);
    let before = FlowDuct::new(at - 0.5 * piece, 1.6e-3);
    let ducts = vec![FlowDuct::new(0.4, 1e-3), before, middle, behind, flame];
    let (_, _, ends) = everything(1.0);
    let ends = [ends[0].clone(), rijke_network::flow_chain::FlowEnd::Choked];
    let chain = FlowChain::new(GAMMA, inlet(340.0, 40.0), ducts, ends).unwrap();
    if entropy { chain } else { chain.without_entropy_waves() }
}

#[test]
fn oracle_small_changes_anywhere_with_flow_do_what_stations_say() {
    for entropy in [false, true] {
        let whole = with_piece(entropy, 0.15, 1e-9, &|_, _| ());
        let ducts = [whole.ducts()[0].clone(), FlowDuct::new(0.3, 1.6e-3), whole.ducts()[4].clone()];
        let (_, _, ends) = everything(1.0);
        let ends = [ends[0].clone(), rijke_network::flow_chain::FlowEnd::Choked];
        let plain = FlowChain::new(GAMMA, inlet(340.0, 40.0), ducts.to_vec(), ends).unwrap();
        let plain = if entropy { plain } else { plain.without_entropy_waves() };
        let region = Region { sigma: [-150.0, 50.0], omega: [1000.0, 3000.0] };
        let root = solve(&plain, modes(&plain, &region)[1]);
        // On both sides of the point (0.25 m into the first duct = 0.45 m before the flame) that the flame
        // hears.
        for (at, station) in [(0.12, 13 + 4), (0.21, 13 + 7), (0.27, 13 + 9)] {
            let here = along(&plain, &root, 11)[station - 2];
            assert!((here.x - 0.4 - at).abs() < 1e-12 && here.segment == 1, "{}", here.x);
            let slope = |f: &dyn Fn(f64) -> FlowChain, h: f64| {
                // Central differences of h and 2h: the error is of the fourth order.
                let at = |h: f64| solve(&f(h), root.s).s;
                (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h)
            };
            let z = here.impedance;
            for (device, effect, unit) in [
                (Device::Drag, ActionKind::Mu, z),
                (Device::Heat, ActionKind::Eu, -1.0),
                (Device::Leak, ActionKind::Branch, 1.0 / z),
            ] {
                let put = |h: f64| {
                    with_piece(entropy, at, 1e-9, &|middle, _| {
                        *middle = middle.clone().with(effect, Law::Constant(c(unit * h, 0.0)));
                    })
                };
                let (got, expected) = (slope(&put, 1e-4), here.device(device));
                assert!((got - expected).norm() < 1e-6 * expected.norm(), "{device:?} {got} {expected}");
            }
            let piece = 1e-3;
            let area =
                slope(&|h| with_piece(entropy, at, piece, &|middle, _| middle.area *= 1.0 + h), 1e-4) / piece;
            assert!((area - here.area).norm() < 1e-3 * here.area.norm(), "area {area} {}", here.area);
            let warm = |h: f64| {
                with_piece(entropy, at, piece, &|middle, behind| {
                    middle.ratio = 1.0 + h;
                    behind.ratio = 1.0 / (1.0 + h);
                })
            };
            let (got, expected) = (slope(&warm, 1e-4) / piece, here.temperature);
            assert!((got - expected).norm() < 1e-3 * expected.norm(), "temperature {got} {expected}");
        }
    }
}

/// A tube with a flame, the gas at rest or not.
fn file(reference: &str, flow: &str) -> String {
    format!(
        "{flow}[search]\nfrequency_hz = [50, 700]\ngrowth_rate = [-200, 200]\n[upstream]\ntype = 'constant'\n\
         modulus = 0.9\nangle = 0.3\n[downstream]\ntype = 'constant'\nmodulus = 0.8\nangle = 3.0\n\
         [[element]]\ntype = 'duct'\nlength = 0.3\ndiameter = 0.05\nwall = 'kirchhoff'\n\
         [[element]]\ntype = 'duct'\nlength = 0.2\ndiameter = 0.04\npieces = 2\n\
         [[element]]\ntype = 'flame'\nn = 0.8\ndelay = 2e-3\n{reference}\n\
         [[element]]\ntype = 'duct'\nlength = 0.2\ndiameter = 0.05\ntemperature = 900\n\
         [[element]]\ntype = 'duct'\nlength = 0.5\ndiameter = 0.06\ntemperature = 900\n"
    )
}

#[test]
fn order_references_and_sensitivities_tend_to_those_without_flow() {
    let near = "reference = 0.05";
    let far = "reference = 0.35";
    let behind = "reference = 0.3\nreference_side = 'downstream'";
    // A device just where the flame hears may stand on either side: no comparison there.
    for (reference, at) in [(near, 0.45), (far, 0.15), (behind, 0.8)] {
        let still = read(&file(reference, "")).unwrap();
        let mut work = Workspace::default();
        let exact = still.network.modes(&still.laws, &still.region, &mut work).unwrap().modes;
        assert!(exact.len() >= 3);
        let mut gaps = |velocity: f64| {
            let flow = format!("[flow]\nvelocity = {velocity}\nentropy_waves = false\n");
            let chain = read(&file(reference, &flow)).unwrap().flow.unwrap();
            let found = modes(&chain, &still.region);
            assert_eq!(found.len(), exact.len(), "{reference}");
            let mut gaps = Vec::new();
            for (m, e) in found.iter().zip(&exact) {
                gaps.push((m - e.s).norm());
                let root = |s| Root { s, steps: 0, residual: 0.0 };
                let with = along(&chain, &root(*m), 7);
                let without = still.network.along(&still.laws, &root(e.s), 7, &mut work).unwrap();
                let norm = |f: &dyn Fn(usize) -> [C64; 2]| {
                    let compared = (0..with.len()).filter(|&k| (with[k].x - at).abs() > 1e-6);
                    compared.map(f).map(|[a, b]| (a - b).norm()).fold(0.0, f64::max)
                };
                gaps.push(norm(&|k| [with[k].area, without[k].area]));
                gaps.push(norm(&|k| [with[k].temperature, without[k].temperature]));
                for device in [Device::Drag, Device::Heat, Device::Leak] {
                    gaps.push(norm(&|k| [with[k].device(device), without[k].device(device)]));
                }
            }
            gaps
        };
        for (k, (one, half)) in gaps(0.2).iter().zip(&gaps(0.1)).enumerate() {
            let order = (one / half).log2();
            assert!(
                (order - 1.0).abs() < 0.05 && *half > 1e-4,
                "{reference} {k}: order {order}, {one} {half}"
            );
        }
    }
}

#[test]
fn exact_a_loop_with_flow_against_its_own_equation() {
    // k_eu v on both sides of the same gas: u rises by -k v/(1 - M^2), p by rho U times k v/(1 - M^2).
    let (speed, velocity) = (340.0, 50.0);
    let (before, behind, distance) = (0.4, 0.7, 0.5);
    let state: FlowState = inlet(speed, velocity);
    let law = delayed(0.9, 3e-3);
    let ducts = |reference| {
        let flame = FlowDuct::new(0.2, 1.0).referring(ActionKind::Eu, law.clone(), reference);
        vec![FlowDuct::new(before, 1.0), flame, FlowDuct::new(behind - 0.2, 1.0)]
    };
    let chain =
        FlowChain::new(GAMMA, state, ducts(Reference::Downstream(distance)), [end(0.9), end(-0.8)]).unwrap();
    let z = state.density * speed;
    let by_hand = |s: C64| {
        let along = |x: f64, [f, g]: [C64; 2]| {
            [f * (-s * x / (speed + velocity)).exp(), g * (s * x / (speed - velocity)).exp()]
        };
        let [f, g] = along(before, [c(0.9, 0.0), C64::ONE]);
        let mach = velocity / speed;
        let du = -law.analytic(s)[0] / (1.0 - mach * mach);
        let dp = -state.density * velocity * du;
        let added = [0.5 * (dp + z * du), 0.5 * (dp - z * du)];
        let heard = |waves: [C64; 2]| {
            let [f, g] = along(distance, waves);
            (f - g) / z
        };
        let open = 1.0 - heard(added);
        let v = heard([f, g]) / open;
        let [f, g] = along(behind, [f + added[0] * v, g + added[1] * v]);
        (g + 0.8 * f) * open
    };
    let region = Region { sigma: [-200.0, 300.0], omega: [100.0, 4000.0] };
    let found = chain.modes(&Constant, &region, &mut Workspace::default()).unwrap();
    assert_eq!(found.poles, 0);
    assert!(found.modes.len() >= 4);
    for m in &found.modes {
        let slope = (by_hand(m.s + 1e-3) - by_hand(m.s - 1e-3)) / 2e-3;
        assert!((by_hand(m.s) / slope).norm() < 1e-9, "{}", m.s);
    }
    let s = c(12.0, 777.0);
    let [f, slope] = chain.characteristic(s);
    assert!((f - by_hand(s)).norm() < 1e-12 * f.norm(), "{f} {}", by_hand(s));
    let h = 1e-3;
    let difference = (chain.characteristic(s + h)[0] - chain.characteristic(s - h)[0]) / (2.0 * h);
    assert!((slope - difference).norm() < 1e-7 * slope.norm());
    // What lies beyond the chain, and loops through others, are refused.
    let far = FlowChain::new(GAMMA, state, ducts(Reference::Downstream(2.0)), [end(0.9), end(-0.8)]);
    assert!(matches!(far, Err(NetworkError::Outside { .. })));
    let mut crossed = ducts(Reference::Downstream(distance));
    crossed[2] = crossed[2].clone().referring(ActionKind::Mu, law.clone(), Reference::Upstream(0.1));
    let crossed = FlowChain::new(GAMMA, state, crossed, [end(0.9), end(-0.8)]);
    assert_eq!(crossed.unwrap_err(), NetworkError::ReferenceCrossed { place: 1, other: 2 });
}
