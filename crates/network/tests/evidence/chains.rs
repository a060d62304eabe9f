//! Both chains behind one trait: laws of a caller with mean flow, against the same built in, Taylor
//! remainders, and the chain at rest.

use crate::common_laws::{Given, c, given};
use crate::mean_flow::{GAMMA, delayed, end, inlet};
use rijke_network::flow_chain::{ActionKind, FlowChain, FlowDuct, FlowEnd};
use rijke_network::laws::{Law, LawSet};
use rijke_network::{
    At, Chain, Constant, Laws, Network, NetworkError, Newton, Places, Region, Response, Root, Segment, Slot,
    Workspace,
};
use rijke_numerics::check::{slopes_from, slopes_near};
use rijke_numerics::{C64, Jet, Order};

pub(crate) const NEWTON: Newton =
    Newton { max_steps: 60, tolerance: 1e-14, max_step: Some(20.0), radius: Some(400.0) };
const REGION: Region = Region { sigma: [-150.0, 150.0], omega: [300.0, 3000.0] };

/// A tube of three pieces: wall with a factor, a heater that lags, a screen, a leak, a step of area, ends of
/// a factor.
pub(crate) fn tube() -> Network {
    heated(1.0)
}

/// The tube with hot gas whose ratio of specific heats is so many times that of the cold gas.
fn heated(gamma: f64) -> Network {
    let hot = 1.2 * (343.2f64 / 420.0).powi(2) * gamma;
    let segments = vec![
        Segment::new(0.25, 1.8e-3, 343.2, 1.2),
        Segment::new(0.35, 1.8e-3, 420.0, hot),
        Segment::new(0.4, 1.3e-3, 420.0, hot),
    ];
    let mut net = Network::new(segments).unwrap();
    net.set(Slot::Viscous(1), c(0.3, 0.4)).unwrap();
    net.set(Slot::Mp(2), c(0.01, 0.02)).unwrap();
    net.set(Slot::Downstream, c(-0.1, 0.02)).unwrap();
    for i in 0..3 {
        net.attach(Slot::Viscous(i), 0, 1.0 + 0.1 * i as f64).unwrap();
        net.attach(Slot::Thermal(i), 1, 1.0).unwrap();
    }
    net.attach(Slot::Eu(1), 2, 1.0).unwrap();
    net.attach(Slot::Mu(1), 3, 20.0).unwrap();
    net.attach(Slot::Ep(2), 3, 1e-4).unwrap();
    net.attach(Slot::Upstream, 4, 1.0).unwrap();
    net.attach(Slot::Downstream, 4, 0.9).unwrap();
    net.attach(Slot::Length(0), 5, 1.0).unwrap();
    net.attach(Slot::Length(1), 5, -1.0).unwrap();
    net.attach(Slot::Area(2), 6, 1e-3).unwrap();
    net
}

pub(crate) const VALUES: [f64; 7] = [1.3, 0.08, 1.7e-3, 0.4, 0.96, 0.013, 0.12];

pub(crate) fn laws(a: [f64; 7]) -> Given<impl Fn(&At, &mut Laws)> {
    given(7, 7, move |at: &At, laws: &mut Laws| {
        let p = |i: usize| at.parameter(i, a[i]);
        let s = at.s_jet();
        let root = s.sqrt();
        laws.set(0, &(&p(0) * &root.scale(c(0.06, 0.0))));
        laws.set(1, &(&p(0) * &root.scale(c(2e-7, 0.0))));
        laws.set(2, &-&(&p(1) * &(-&(&s * &p(2))).exp()));
        laws.set(3, &(&p(3) * &s.scale(c(1e-3, 0.0)).shift(c(0.4, 0.0))));
        laws.set(4, &-&(&p(4) * &s.scale(c(-8e-5, 0.0)).exp()));
        laws.set(5, &p(5));
        laws.set(6, &p(6).sin());
    })
}

fn places() -> Places {
    Places { at: vec![0, 1, 3], reference: 2 }
}

fn outputs(r: &Response) -> Vec<Jet> {
    std::iter::once(r.s.clone()).chain(r.pressures.clone()).collect()
}

fn ask(chain: &dyn Chain, a: [f64; 7], guess: C64, order: Order) -> (Root, Response) {
    let (k, mut work) = (laws(a), Workspace::default());
    let root = chain.solve(&k, guess, &NEWTON, &mut work).unwrap();
    let response = chain.respond(&k, &root, &places(), order, &mut work).unwrap();
    (root, response)
}

/// Largest difference of value, gradient and Hessian of all outputs, each over `scale` of its parameters.
fn gaps(one: &Response, two: &Response, scale: [f64; 7]) -> [f64; 3] {
    let mut gaps = [0.0_f64; 3];
    for (o, (x, y)) in outputs(one).iter().zip(outputs(two)).enumerate() {
        let unit = if o == 0 { 1e-3 } else { 1.0 };
        let mut note = |k: usize, d: C64| gaps[k] = gaps[k].max(unit * d.norm());
        note(0, x.value() - y.value());
        for i in 0..7 {
            note(1, (x.gradient()[i] - y.gradient()[i]) * scale[i]);
            for j in 0..=i {
                note(2, (x.hessian(i, j) - y.hessian(i, j)) * scale[i] * scale[j]);
            }
        }
    }
    gaps
}

#[test]
fn exact_the_chain_at_rest_is_itself_behind_the_trait() {
    let (net, k, mut work) = (tube(), laws(VALUES), Workspace::default());
    let chain: &dyn Chain = &net;
    let (root, response) = ask(chain, VALUES, c(-30.0, 1100.0), Order::Second);
    assert_eq!(root, net.solve(&k, c(-30.0, 1100.0), &NEWTON, &mut work).unwrap());
    assert_eq!(response, net.respond(&k, &root, &places(), Order::Second, &mut work).unwrap());
    let modes = chain.modes(&k, &REGION, &mut work).unwrap();
    assert!(modes.modes.len() >= 2);
    let near = modes.modes.iter().map(|m| (m.root().s - root.s).norm()).fold(f64::MAX, f64::min);
    assert!(near < 1e-9, "{near}");
    let (whole, budget) = (chain.budget(&k, &root, &mut work).unwrap(), net.budget(&k, &root, &mut work));
    assert!(whole.mismatch() < 1e-12 && whole == budget);
    assert_eq!(chain.along(&k, &root, 3, &mut work).unwrap(), net.along(&k, &root, 3, &mut work).unwrap());
    assert_eq!(chain.count(), 3);
    assert!((chain.position(2) - 0.6).abs() < 1e-15);
}

#[test]
fn order_laws_with_flow_tend_to_those_at_rest() {
    let scale = [1.0, 0.1, 1e-3, 0.3, 0.1, 0.02, 0.1];
    // In real gas the ratio of specific heats falls as it is heated.
    for net in [tube(), heated(0.98)] {
        let (still, exact) = ask(&net, VALUES, c(-30.0, 1100.0), Order::Second);
        let at = |velocity: f64| {
            let chain = FlowChain::of(&net, GAMMA, velocity).unwrap().without_entropy_waves();
            gaps(&ask(&chain, VALUES, still.s, Order::Second).1, &exact, scale)
        };
        for (k, (one, half)) in at(0.2).into_iter().zip(at(0.1)).enumerate() {
            let order = (one / half).log2();
            assert!((order - 1.0).abs() < 0.05 && half > 1e-7, "derivative {k}: order {order}, {one} {half}");
        }
    }
}

#[test]
fn order_taylor_remainders_of_laws_with_flow() {
    let direction = [0.3, 0.02, 3e-4, 0.1, 0.01, 0.01, 0.1];
    for entropy in [false, true] {
        let chain = FlowChain::of(&heated(if entropy { 0.93 } else { 1.0 }), GAMMA, 15.0).unwrap();
        let chain = if entropy { chain } else { chain.without_entropy_waves() };
        let (root, base) = ask(&chain, VALUES, c(-30.0, 1100.0), Order::Second);
        let moved = |h: f64| {
            let mut a = VALUES;
            a.iter_mut().zip(direction).for_each(|(a, d)| *a += h * d);
            outputs(&ask(&chain, a, root.s, Order::Value).1)
        };
        for (o, jet) in outputs(&base).iter().enumerate() {
            let first: C64 = (0..7).map(|i| jet.gradient()[i] * direction[i]).sum();
            let second: C64 =
                (0..49).map(|k| 0.5 * jet.hessian(k / 7, k % 7) * direction[k / 7] * direction[k % 7]).sum();
            let gap = |h: f64| moved(h)[o].value() - jet.value() - first * h;
            slopes_near(&slopes_from(0.1, |h| gap(h).norm()), 2.0, 0.05);
            slopes_near(&slopes_from(0.2, |h| (gap(h) - second * h * h).norm()), 3.0, 0.08);
        }
    }
}

#[test]
fn oracle_laws_and_the_same_built_in_answer_alike() {
    // The same chain with its devices as laws of the caller, or built in: modes, stations, balance,
    // condition.
    let (screen, heater) =
        (Law::Linear { constant: c(8.0, 0.0), per_s: c(0.02, 0.0) }, delayed(-0.1, 1.5e-3));
    let wide =
        vec![FlowDuct::new(0.3, 1.8e-3), FlowDuct::new(0.4, 1.8e-3).heated(1.5), FlowDuct::new(0.5, 2e-3)];
    let ends = [end(-0.9), end(-0.9)];
    let mut free = FlowChain::new(GAMMA, inlet(340.0, 10.0), wide.clone(), [end(0.0), end(0.0)])
        .unwrap()
        .without_entropy_waves();
    let mut set = LawSet::default();
    set.push("screen", screen.clone());
    set.push("heater", heater.clone());
    set.push("end", Law::Constant(c(-0.9, 0.0)));
    for (slot, law) in [(Slot::Mu(2), 0), (Slot::Eu(1), 1), (Slot::Upstream, 2), (Slot::Downstream, 2)] {
        Chain::attach(&mut free, slot, law, 1.0).unwrap();
    }
    let mut ducts = wide;
    ducts[2] = ducts[2].clone().with(ActionKind::Mu, screen);
    ducts[1] = ducts[1].clone().with(ActionKind::Eu, heater);
    let built = FlowChain::new(GAMMA, inlet(340.0, 10.0), ducts, ends).unwrap().without_entropy_waves();
    let (free, mut work): (&dyn Chain, _) = (&free, Workspace::default());
    let (one, two) =
        (free.modes(&set, &REGION, &mut work).unwrap(), built.modes(&Constant, &REGION, &mut work).unwrap());
    assert!(one.modes.len() == two.modes.len() && one.modes.len() >= 2);
    for (x, y) in one.modes.iter().zip(&two.modes) {
        assert!((x.s - y.s).norm() < 1e-11 * y.s.norm());
        let root = y.root();
        let (got, expected) = (
            free.budget(&set, &root, &mut work).unwrap(),
            built.budget(&Constant, &root, &mut work).unwrap(),
        );
        assert!(got.mismatch() < 1e-9 && (got.upstream - expected.upstream).abs() < 1e-9);
        assert_eq!(got.places.iter().map(|p| p.place).collect::<Vec<_>>(), [1, 2]);
        for (power, built) in got.places.iter().zip(&expected.places) {
            assert!((power.power - built.power).abs() < 1e-9 * built.power.abs() && built.laws.is_empty());
            assert_eq!(power.laws.len(), 1);
        }
        // A screen alone takes all the power of its place but that of the step of area, which is convected:
        // of order M.
        let screen = &got.places[1];
        assert!((screen.laws[0].1 / screen.power - 1.0).abs() < 0.1 && screen.power < 0.0, "{screen:?}");
        let (here, there) = (
            free.along(&set, &root, 4, &mut work).unwrap(),
            built.along(&Constant, &root, 4, &mut work).unwrap(),
        );
        for (a, b) in here.iter().zip(&there) {
            assert!((a.area - b.area).norm() < 1e-9 * b.area.norm().max(1.0));
            assert!((a.branch - b.branch).norm() < 1e-9 * b.branch.norm().max(1.0));
        }
        let ratio = free.condition(&set, &root, &mut work).unwrap()
            / built.condition(&Constant, &root, &mut work).unwrap();
        assert!((ratio - 1.0).abs() < 1e-9, "{ratio}");
    }
}

#[test]
fn message_what_a_chain_with_flow_refuses() {
    let net = Network::cut_tube(Segment::new(1.0, 1e-3, 340.0, 1.2), &[0.5]).unwrap();
    let mut chain = FlowChain::of(&net, GAMMA, 3.0).unwrap();
    let refused = chain.attach(Slot::Density(0), 0, 1.0).unwrap_err().to_string();
    assert!(refused.contains("Density(0) follows from the inlet"), "{refused}");
    // A law of the gas that the chain at rest has is not taken for a law of something else.
    for slot in [Slot::Density(1), Slot::SoundSpeed(1)] {
        let mut rest = net.clone();
        rest.attach(slot, 0, 1.0).unwrap();
        assert_eq!(FlowChain::of(&rest, GAMMA, 3.0).err(), Some(NetworkError::SlotOfRest { slot }));
    }
    assert_eq!(chain.attach(Slot::Mu(0), 0, 1.0), Err(NetworkError::ActionAtInlet));
    for slot in [Slot::Length(2), Slot::Ep(2)] {
        assert_eq!(chain.attach(slot, 0, 1.0), Err(NetworkError::NoDuct { index: 2, ducts: 2 }));
    }
    let mut choked = chain.clone().with_ends([FlowEnd::Choked, FlowEnd::Choked]);
    let refused = choked.attach(Slot::Downstream, 0, 1.0).unwrap_err().to_string();
    assert!(refused.starts_with("end 1 is choked"), "{refused}");
    // A law of s that moves the mean flow, and a flow that a law makes too fast.
    chain.attach(Slot::Area(1), 0, 1e-3).unwrap();
    let mut work = Workspace::default();
    let ask = |law: &dyn rijke_network::Coefficients, work: &mut Workspace| {
        Chain::solve(&chain, law, c(0.0, 1000.0), &NEWTON, work).unwrap_err()
    };
    let refused = ask(&given(0, 1, |at: &At, laws: &mut Laws| laws.set(0, &at.s_jet())), &mut work);
    assert_eq!(refused, NetworkError::MeanFlowOfS { law: "law 0".to_owned() });
    let fast = given(1, 1, |at: &At, laws: &mut Laws| laws.set(0, &at.parameter(0, -0.98)));
    let refused = ask(&fast, &mut work);
    assert!(
        matches!(refused, NetworkError::TooFast { index: 1, .. }) && refused.is_recoverable(),
        "{refused}"
    );
    assert!(FlowChain::of(&net, GAMMA, 3.0).is_ok_and(|c| Chain::count(&c) == 2));
    let plain = FlowChain::of(&net, GAMMA, 3.0).unwrap().with_ends([end(-0.9), end(-0.9)]);
    assert!(Chain::solve(&plain, &Constant, c(0.0, 1000.0), &Newton::default(), &mut work).is_ok());
}
