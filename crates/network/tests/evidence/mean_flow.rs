//! Mean flow: closed forms, the limit of no flow, budgets, the condition.

use crate::common_laws::c;
use crate::eigenvalues::eigenvalues;
use rijke_network::flow_chain::{
    Action, ActionKind, FlowChain, FlowDuct, FlowEnd, FlowState, FlowWall, Reference,
};
use rijke_network::laws::{Law, LawSet, WallLaw};
use rijke_network::wall::Wall;
use rijke_network::{
    Budget, Chain, Constant, Network, NetworkError, Newton, Region, Root, Segment, Slot, Workspace,
};
use rijke_numerics::C64;
use std::f64::consts::PI;

pub(crate) const GAMMA: f64 = 1.4;
const PRESSURE: f64 = 101_325.0;
const REGION: Region = Region { sigma: [-100.0, 50.0], omega: [200.0, 5600.0] };

pub(crate) fn end(r: f64) -> FlowEnd {
    FlowEnd::Reflection(Law::Constant(c(r, 0.0)))
}

pub(crate) fn inlet(sound_speed: f64, velocity: f64) -> FlowState {
    FlowState { pressure: PRESSURE, density: GAMMA * PRESSURE / (sound_speed * sound_speed), velocity }
}

pub(crate) fn delayed(gain: f64, delay: f64) -> Law {
    Law::Transfer { gain, numerator: vec![1.0], denominator: vec![1.0], delay }
}

pub(crate) fn solve(chain: &FlowChain, guess: C64, newton: &Newton) -> Root {
    chain.solve(&Constant, guess, newton, &mut Workspace::default()).unwrap()
}

fn budget(chain: &FlowChain, s: C64) -> Budget {
    chain.budget(&Constant, &Root { s, steps: 0, residual: 0.0 }, &mut Workspace::default()).unwrap()
}

pub(crate) fn modes(chain: &FlowChain, region: &Region) -> Vec<C64> {
    chain.modes(&Constant, region, &mut Workspace::default()).unwrap().modes.iter().map(|m| m.s).collect()
}

#[test]
fn exact_uniform_tube_with_flow() {
    let reference = eigenvalues("uniform_open_open_R095_M001");
    let state = inlet(343.24614995, 3.4324615);
    for pieces in [1, 4] {
        let ducts = vec![FlowDuct::new(1.0 / f64::from(pieces), 1.0); pieces as usize];
        let chain = FlowChain::new(GAMMA, state, ducts, [end(-0.95), end(-0.95)]).unwrap();
        let found = modes(&chain, &REGION);
        assert_eq!(found.len(), reference.len());
        for (s, expected) in found.iter().zip(&reference) {
            assert!((s - expected).norm() < 1e-12 * expected.norm(), "{s} against {expected}");
            let root = solve(&chain, expected + c(3.0, -8.0), &Newton::default());
            assert!((root.s - expected).norm() < 1e-12 * expected.norm());
        }
    }
    // And to any Mach number: s = c (1 - M^2)/(2L) (ln(R_u R_d) + 2 i pi n).
    let fast =
        FlowChain::new(GAMMA, inlet(340.0, 85.0), vec![FlowDuct::new(1.0, 1.0)], [end(-0.9), end(-0.8)])
            .unwrap();
    for (k, s) in modes(&fast, &REGION).iter().enumerate() {
        let pace = 0.5 * 340.0 * (1.0 - 0.0625);
        let exact = c(pace * (0.72_f64).ln(), 2.0 * PI * pace * (k + 1) as f64);
        assert!((s - exact).norm() < 1e-12 * exact.norm(), "{s} against {exact}");
    }
}

#[test]
fn exact_choked_ends_with_entropy_waves() {
    // Between choked nozzles: F by hand, with f = R, g = 1 and e = (gamma/(1+(gamma-1)M^2) - 1) p/c^2 at the
    // inlet.
    let (speed, velocity, length) = (340.0, 60.0, 1.3);
    let chain = FlowChain::new(
        GAMMA,
        inlet(speed, velocity),
        vec![FlowDuct::new(length, 1.0)],
        [FlowEnd::Choked, FlowEnd::Choked],
    )
    .unwrap();
    let mach = velocity / speed;
    let below = 1.0 + 0.4 * mach * mach;
    let (m, n) = (GAMMA * mach / below, 0.2 * mach);
    let r = (1.0 - m) / (1.0 + m);
    let by_hand = |s: C64, entropy: f64| {
        let f = r * (-s * length / (speed + velocity)).exp();
        let g = (s * length / (speed - velocity)).exp();
        let e =
            entropy * (GAMMA / below - 1.0) * (1.0 + r) / (speed * speed) * (-s * length / velocity).exp();
        g - (f * (1.0 - n) + 0.5 * speed * velocity * e) / (1.0 + n)
    };
    let found = modes(&chain, &REGION);
    assert!(found.len() >= 4);
    for s in found {
        assert!(by_hand(s, 1.0).norm() < 1e-11, "{s}: {}", by_hand(s, 1.0));
        assert!(by_hand(s, 0.0).norm() > 1e-4);
    }
    for s in modes(&chain.without_entropy_waves(), &REGION) {
        assert!(by_hand(s, 0.0).norm() < 1e-11, "{s}");
    }
}

const AIR: Wall = Wall {
    density: GAMMA * PRESSURE / (340.0 * 340.0),
    sound_speed: 340.0,
    viscosity: 1.8e-5,
    prandtl: 0.71,
    gamma: GAMMA,
    diameter: 0.03,
};

const RESONATOR: Law =
    Law::Helmholtz { duct_area: 1.6e-3, inertance: 120.0, resistance: 2e4, stiffness: 4e8 };

/// Of the gas behind the flame of [`everything`].
const HOT_GAMMA: f64 = 1.3;

/// Walls, steps of area both ways, a flame that refers 0.1 m upstream and burns to other
/// gas, a screen, a resonator; velocity at the inlet.
pub(crate) fn everything(velocity: f64) -> (FlowState, Vec<FlowDuct>, [FlowEnd; 2]) {
    let wall = |factor| Some(FlowWall { law: WallLaw::Kirchhoff, wall: AIR, factor });
    let ducts = vec![
        FlowDuct { wall: wall(1.0), ..FlowDuct::new(0.3, 1.0e-3) },
        FlowDuct { wall: wall(2.0), ..FlowDuct::new(0.2, 1.6e-3) },
        FlowDuct {
            ratio: 2.5,
            gamma: Some(HOT_GAMMA),
            actions: vec![Action {
                effect: ActionKind::Eu,
                law: delayed(-0.6, 2e-3),
                reference: Reference::Upstream(0.1),
            }],
            ..FlowDuct::new(0.4, 1.7e-3)
        },
        FlowDuct::new(0.2, 0.9e-3).with(ActionKind::Mu, Law::Constant(c(20.0, 5.0))),
        FlowDuct::new(0.15, 0.9e-3)
            .with(ActionKind::Branch, RESONATOR)
            .with(ActionKind::Mp, Law::Constant(c(0.02, 0.01))),
        FlowDuct::new(0.1, 0.9e-3).with(ActionKind::Ep, Law::Constant(c(1e-5, 0.0))),
    ];
    let ends = [
        FlowEnd::Reflection(Law::Constant(c(0.95, 0.0))),
        FlowEnd::Reflection(Law::Unflanged { radius: 0.017, sound_speed: 537.0, correction: 0.0 }),
    ];
    (inlet(340.0, velocity), ducts, ends)
}

fn chain(velocity: f64) -> FlowChain {
    let (state, ducts, ends) = everything(velocity);
    FlowChain::new(GAMMA, state, ducts, ends).unwrap().without_entropy_waves()
}

#[test]
fn order_slow_flow_tends_to_no_flow() {
    // As the velocity falls, the chain tends to the network without flow, first order in M: every element,
    // every slot.
    let hot = 340.0 * f64::sqrt(2.5 * HOT_GAMMA / GAMMA);
    let speeds = [340.0, 340.0, hot, hot, hot, hot];
    let (_, ducts, _) = everything(1.0);
    let segments = ducts.iter().zip(speeds).map(|(d, c)| {
        let gamma = if c == hot { HOT_GAMMA } else { GAMMA };
        Segment::new(d.length, d.area, c, gamma * PRESSURE / (c * c))
    });
    let mut still = Network::new(segments.collect()).unwrap();
    let mut laws = LawSet::default();
    for (i, duct) in ducts.iter().enumerate() {
        if let Some(wall) = &duct.wall {
            let (viscous, thermal) = (Law::Viscous(wall.law, wall.wall), Law::Thermal(wall.law, wall.wall));
            still.attach(Slot::Viscous(i), laws.push("wall", viscous), wall.factor).unwrap();
            still.attach(Slot::Thermal(i), laws.push("wall", thermal), wall.factor).unwrap();
        }
    }
    let attached = [
        (Slot::Mu(3), Law::Constant(c(20.0, 5.0))),
        (Slot::Ep(4), RESONATOR),
        (Slot::Mp(4), Law::Constant(c(0.02, 0.01))),
        (Slot::Ep(5), Law::Constant(c(1e-5, 0.0))),
        (Slot::Upstream, Law::Constant(c(0.95, 0.0))),
        (Slot::Downstream, Law::Unflanged { radius: 0.017, sound_speed: 537.0, correction: 0.0 }),
    ];
    for (slot, law) in attached {
        still.attach(slot, laws.push("device", law), 1.0).unwrap();
    }
    // The flame's reference: 0.1 m before it in the second duct, losses included.
    let law = laws.push("flame", delayed(0.6, 2e-3));
    let own = still.attach_heard(laws.laws.len(), &[2], &[]).unwrap().of_compact[0];
    laws.heard.sources.push(still.remote_source(2, 0.1, false, law, &own).unwrap());
    let region = Region { sigma: [-200.0, 200.0], omega: [300.0, 4000.0] };
    let exact = still.modes(&laws, &region, &mut Workspace::default()).unwrap();
    let gap = |velocity: f64| -> Vec<f64> {
        let found = modes(&chain(velocity), &region);
        assert_eq!(found.len(), exact.modes.len());
        found.iter().zip(&exact.modes).map(|(s, m)| (s - m.s).norm()).collect()
    };
    let (one, half) = (gap(0.2), gap(0.1));
    assert!(one.len() >= 4);
    for (a, b) in one.iter().zip(&half) {
        let order = (a / b).log2();
        assert!((order - 1.0).abs() < 0.03 && *b > 1e-3, "order {order} from {a} and {b}");
    }
}

#[test]
fn exact_mean_states_conserve() {
    let ducts =
        vec![FlowDuct::new(0.3, 1.0e-3), FlowDuct::new(0.2, 1.9e-3), FlowDuct::new(0.4, 1.2e-3).heated(3.0)];
    let chain = FlowChain::new(GAMMA, inlet(340.0, 30.0), ducts.clone(), [end(1.0), end(-1.0)]).unwrap();
    let mass: Vec<f64> =
        chain.states().iter().zip(&ducts).map(|(s, d)| s.density * s.velocity * d.area).collect();
    assert!(mass.iter().all(|m| (m / mass[0] - 1.0).abs() < 1e-13), "{mass:?}");
    let temperature = |s: &FlowState| s.pressure / s.density;
    let [first, second, third] = [0, 1, 2].map(|i| chain.states()[i]);
    let enthalpy = |s: &FlowState| 3.5 * temperature(s) + 0.5 * s.velocity * s.velocity;
    assert!((enthalpy(&second) / enthalpy(&first) - 1.0).abs() < 1e-13);
    assert!(third.pressure < second.pressure && temperature(&third) > 2.9 * temperature(&second));
    let fast = FlowChain::new(GAMMA, inlet(340.0, 110.0), ducts.clone(), [end(1.0), end(-1.0)]);
    assert!(matches!(fast, Err(NetworkError::TooFast { index: 0, .. })));
    let early = vec![ducts[2].clone(), ducts[0].clone()];
    let early = FlowChain::new(GAMMA, inlet(340.0, 1.0), early, [end(1.0), end(-1.0)]);
    assert_eq!(early.unwrap_err(), NetworkError::ActionAtInlet);
}

#[test]
fn exact_energy_budget_with_flow_closes() {
    for chain in [chain(15.0), chain(0.5)] {
        for s in modes(&chain, &Region { sigma: [-200.0, 200.0], omega: [300.0, 4000.0] }) {
            let budget = budget(&chain, s);
            assert!(budget.mismatch() < 1e-8, "at {s}: {budget:?}");
            assert!(budget.viscous < 0.0 && budget.thermal < 0.0 && budget.places.len() == 4);
        }
    }
    // A sudden expansion alone: the flow takes energy from the waves (Bechert 1980), without flow none.
    let ducts = vec![FlowDuct::new(0.5, 1.0e-3), FlowDuct::new(0.7, 2.0e-3)];
    let taken = |velocity: f64| {
        let chain =
            FlowChain::new(GAMMA, inlet(340.0, velocity), ducts.clone(), [end(0.99), end(-0.99)]).unwrap();
        let chain = chain.without_entropy_waves();
        let s = modes(&chain, &REGION)[0];
        budget(&chain, s).mean_flow
    };
    assert!(taken(20.0) < -1.0 && taken(1e-3).abs() < 1e-3 * taken(20.0).abs());
}

#[test]
fn oracle_condition_with_flow_by_small_changes() {
    // Every number of the chain by a fraction h: what s moves by, over h and |s|.
    let scaled = |law: &Law, h: f64| Law::Scaled(Box::new(law.clone()), c(1.0 + h, 0.0));
    let newton = Newton { tolerance: 1e-14, max_step: Some(20.0), ..Newton::default() };
    let base = chain(8.0);
    let guess = modes(&base, &Region { sigma: [-150.0, 150.0], omega: [300.0, 4000.0] })[1];
    let root = solve(&base, guess, &newton);
    type Change<'a> = Box<dyn Fn(f64, &mut FlowState, &mut [FlowDuct], &mut [FlowEnd; 2]) + 'a>;
    let mut changes: Vec<Change<'_>> = vec![
        Box::new(|h, state, _, _| state.velocity *= 1.0 + h),
        Box::new(|h, state, _, _| state.density *= 1.0 + h),
    ];
    for end in 0..2 {
        changes.push(Box::new(move |h, _, _, ends| {
            if let FlowEnd::Reflection(law) = &mut ends[end] {
                *law = scaled(law, h);
            }
        }));
    }
    for (i, duct) in base.ducts().iter().enumerate() {
        changes.push(Box::new(move |h, _, ducts, _| ducts[i].length *= 1.0 + h));
        changes.push(Box::new(move |h, _, ducts, _| ducts[i].area *= 1.0 + h));
        if duct.wall.is_some() {
            changes.push(Box::new(move |h, _, ducts, _| {
                ducts[i].wall.iter_mut().for_each(|wall| wall.factor *= 1.0 + h);
            }));
        }
        if !duct.actions.is_empty() {
            changes.push(Box::new(move |h, _, ducts, _| {
                ducts[i].actions.iter_mut().for_each(|action| action.law = scaled(&action.law, h));
            }));
        }
    }
    assert_eq!(changes.len(), 22);
    let moved = |change: &Change<'_>, h: f64| {
        let (mut state, mut ducts, mut ends) = everything(8.0);
        change(h, &mut state, &mut ducts, &mut ends);
        let chain = FlowChain::new(GAMMA, state, ducts, ends).unwrap().without_entropy_waves();
        solve(&chain, root.s, &newton).s
    };
    let h = 1e-6;
    let sum: f64 = changes.iter().map(|f| (moved(f, h) - moved(f, -h)).norm() / (2.0 * h)).sum();
    let (got, expected) =
        (base.condition(&Constant, &root, &mut Workspace::default()).unwrap(), sum / root.s.norm());
    assert!((got / expected - 1.0).abs() < 1e-6, "{got} {expected}");
}
