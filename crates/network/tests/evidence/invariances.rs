//! Changes of description that must change nothing, to 1e-12.

use crate::common_laws::{c, given, paper_wall, rig_segment, root};
use crate::eigenvalues::lossy_line;
use rijke_network::{Constant, Network, NetworkError, Newton, Places, Segment, Slot, Workspace};
use rijke_numerics::{C64, Order};

#[track_caller]
fn same(a: C64, b: C64) {
    assert!((a - b).norm() < 1e-12 * b.norm(), "{a} against {b}");
}

#[test]
fn exact_splitting_a_segment_changes_nothing() {
    let wall = given(0, 2, paper_wall);
    let guess = c(-5.0, 1040.0);
    let whole = root(&lossy_line(1), &wall, guess).s;
    for n in [2, 3, 50] {
        same(root(&lossy_line(n), &wall, guess).s, whole);
    }
}

#[test]
fn exact_mirror_of_a_tube_without_feedback() {
    let segments = [
        Segment::new(0.3, 1e-3, 343.0, 1.2),
        Segment::new(0.5, 2e-3, 400.0, 0.88),
        Segment::new(0.2, 5e-4, 500.0, 0.56),
    ];
    let ends = [c(-0.9, 0.1), c(0.4, -0.7)];
    let chain = |order: [usize; 3], ends: [C64; 2]| {
        let mut net = Network::new(order.map(|i| segments[i]).to_vec()).unwrap();
        net.set(Slot::Upstream, ends[0]).unwrap();
        net.set(Slot::Downstream, ends[1]).unwrap();
        net
    };
    let there = root(&chain([0, 1, 2], ends), &Constant, c(-60.0, 900.0)).s;
    let back = root(&chain([2, 1, 0], [ends[1], ends[0]]), &Constant, there + c(3.0, 3.0)).s;
    same(back, there);
}

#[test]
fn exact_order_of_attaching_changes_nothing() {
    let laws = given(0, 2, |at, laws| {
        laws.set(0, &at.s_jet().scale(c(-1e-3, 0.0)).exp().scale(c(-0.1, 0.0)));
        laws.set_analytic(1, [c(3.0, 1.0), C64::ZERO, C64::ZERO]);
    });
    let build = |swap: bool| {
        let mut net = Network::cut_tube(rig_segment(), &[0.25]).unwrap();
        net.set(Slot::Upstream, c(-0.99, 0.0)).unwrap();
        net.set(Slot::Downstream, c(-0.99, 0.0)).unwrap();
        let mut steps = [(Slot::Eu(1), 0), (Slot::Mu(1), 1)];
        if swap {
            steps.reverse();
        }
        for (slot, law) in steps {
            net.attach(slot, law, 1.0).unwrap();
        }
        root(&net, &laws, c(0.0, 1080.0)).s
    };
    assert_eq!(build(false), build(true));
}

#[test]
fn exact_small_independent_jumps_at_one_place_permute() {
    // An area change as a property of the segments is the feedback k_eu = 1 - A1/A2.
    let lengths = [0.4, 0.6];
    let areas = [1e-3, 1.7e-3];
    let net = |areas: [f64; 2]| {
        let segments = (0..2).map(|i| Segment::new(lengths[i], areas[i], 343.0, 1.2)).collect();
        let mut net = Network::new(segments).unwrap();
        net.set(Slot::Upstream, c(-0.98, 0.0)).unwrap();
        net.set(Slot::Downstream, c(-0.98, 0.0)).unwrap();
        net
    };
    let with_area = root(&net(areas), &Constant, c(-5.0, 1080.0)).s;
    let mut fed = net([1.0, 1.0]);
    fed.set(Slot::Eu(1), c(1.0 - areas[0] / areas[1], 0.0)).unwrap();
    same(root(&fed, &Constant, with_area + c(4.0, -4.0)).s, with_area);
}

#[test]
fn exact_units_of_pressure_change_nothing() {
    // Density times 1000 with losses scaled alike is a change of the unit of pressure.
    let scaled = |factor: f64| {
        let mut net =
            Network::cut_tube(Segment { density: 1.2 * factor, ..rig_segment() }, &[0.3, 0.7]).unwrap();
        net.set(Slot::Upstream, c(-0.99, 0.02)).unwrap();
        net.set(Slot::Downstream, c(-0.99, 0.01)).unwrap();
        net.set(Slot::Viscous(1), c(2.0 * factor, factor)).unwrap();
        net.set(Slot::Mu(1), c(0.5 * factor, 0.1 * factor)).unwrap();
        net.set(Slot::Ep(2), c(1e-5 / factor, 0.0)).unwrap();
        root(&net, &Constant, c(-5.0, 1080.0)).s
    };
    same(scaled(1e3), scaled(1.0));
}

#[test]
fn exact_conjugate_roots() {
    // Laws that are real for real s: the conjugate of a root is a root.
    let laws = given(0, 3, |at, laws| {
        paper_wall(at, laws);
        laws.set(2, &at.s_jet().scale(c(-2e-3, 0.0)).exp().scale(c(-0.2, 0.0)));
    });
    let mut net = lossy_line(4);
    net.set(Slot::Upstream, c(-0.98, 0.0)).unwrap();
    net.set(Slot::Downstream, c(-0.98, 0.0)).unwrap();
    net.attach(Slot::Eu(1), 2, 1.0).unwrap();
    let above = root(&net, &laws, c(0.0, 1060.0)).s;
    same(root(&net, &laws, c(0.0, -1060.0)).s, above.conj());
}

#[test]
fn exact_mistakes_are_named() {
    assert_eq!(Network::new(vec![]).unwrap_err(), NetworkError::Empty);
    let wrong = Network::new(vec![rig_segment(), Segment { density: -1.0, ..rig_segment() }]).unwrap_err();
    assert_eq!(wrong.to_string(), "segment 1: the density is -1, but must be positive and finite");
    let mut net = Network::new(vec![rig_segment()]).unwrap();
    assert!(matches!(net.set(Slot::Mu(2), C64::ONE), Err(NetworkError::Slot { segments: 1, .. })));
    assert!(matches!(net.attach(Slot::Viscous(1), 0, 1.0), Err(NetworkError::Slot { .. })));
    assert!(matches!(net.place_at(0.4), Err(NetworkError::NoPlace { .. })));
    assert!(matches!(Network::cut_tube(rig_segment(), &[1.2]), Err(NetworkError::Outside { .. })));
    // Ends that do not reflect have no mode; a far guess with a small radius is another branch.
    let newton = Newton::default();
    let mut work = Workspace::default();
    let lost = net.solve(&Constant, c(0.0, 1000.0), &newton, &mut work);
    assert!(lost.is_err_and(|e| e.is_recoverable()));
    net.set(Slot::Upstream, c(-1.0, 0.0)).unwrap();
    net.set(Slot::Downstream, c(-1.0, 0.0)).unwrap();
    let narrow = Newton { radius: Some(1.0), ..newton };
    let lost = net.solve(&Constant, c(0.0, 1000.0), &narrow, &mut work).unwrap_err();
    assert!(matches!(lost, NetworkError::LostBranch { .. }));
    let few = Newton { max_steps: 1, ..newton };
    let slow = net.solve(&Constant, c(0.0, 1000.0), &few, &mut work).unwrap_err();
    assert!(matches!(slow, NetworkError::NotConverged { steps: 1, .. }));
    // The middle of an open tube's second mode is silent.
    let mut net = Network::cut_tube(rig_segment(), &[0.25, 0.5]).unwrap();
    net.set(Slot::Upstream, c(-1.0, 0.0)).unwrap();
    net.set(Slot::Downstream, c(-1.0, 0.0)).unwrap();
    let second = root(&net, &Constant, c(0.0, 2100.0));
    let places = |reference| Places { at: vec![1, 2], reference };
    let silent = net.respond(&Constant, &second, &places(2), Order::First, &mut work);
    assert_eq!(silent.unwrap_err(), NetworkError::SilentReference { place: 2 });
    let absent = net.respond(&Constant, &second, &places(7), Order::First, &mut work);
    assert!(matches!(absent, Err(NetworkError::Slot { segments: 3, .. })));
}
