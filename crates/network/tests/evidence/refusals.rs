//! What has no answer is an error that says where and why, never a number and never a panic.

use rijke_network::flow_chain::FlowChain;
use rijke_network::laws::{Law, LawSet};
use rijke_network::{
    Chain, Constant, Network, NetworkError, Newton, Places, Region, Root, Segment, Sensitivities, Slot,
    Source, Workspace,
};
use rijke_numerics::{C64, Order};

fn c(re: f64, im: f64) -> C64 {
    C64::new(re, im)
}

fn tube() -> Network {
    let mut tube = Network::cut_tube(Segment::new(1.5, 1.8e-3, 343.0, 1.2), &[1.0]).unwrap();
    tube.set(Slot::Upstream, c(-0.9, 0.0)).unwrap();
    tube.set(Slot::Downstream, c(-0.9, 0.0)).unwrap();
    tube
}

fn one(law: C64) -> LawSet {
    let mut laws = LawSet::default();
    laws.push("a", Law::Constant(law));
    laws
}

const REGION: Region = Region { sigma: [-100.0, 50.0], omega: [300.0, 3000.0] };
const HALF: Places = Places { at: Vec::new(), reference: 1 };

/// What every question about a chain answers.
fn asked(tube: &Network, laws: &LawSet) -> Vec<NetworkError> {
    let mut work = Workspace::default();
    let (s, root) = (c(-30.0, 700.0), Root { s: c(-30.0, 700.0), steps: 0, residual: 0.0 });
    let mut all = vec![
        tube.solve(laws, s, &Newton::default(), &mut work).unwrap_err(),
        tube.modes(laws, &REGION, &mut work).unwrap_err(),
        tube.along(laws, &root, 5, &mut work).unwrap_err(),
        Chain::budget(tube, laws, &root, &mut work).unwrap_err(),
        tube.sensitivities(laws, &root, &HALF, &mut Sensitivities::default(), &mut work).unwrap_err(),
    ];
    for order in [Order::Value, Order::First, Order::Second] {
        all.push(tube.respond(laws, &root, &HALF, order, &mut work).unwrap_err());
        all.push(tube.forced(laws, s, Source::Upstream, order, &mut work).unwrap_err());
        all.push(tube.impedance_at(laws, s, 1, order, &mut work).unwrap_err());
        all.push(tube.reflection_at(laws, s, 1, order, &mut work).unwrap_err());
        all.push(tube.transfer(laws, s, [0, 1], order, &mut work).unwrap_err());
    }
    all
}

#[test]
fn message_a_law_that_is_not_there_is_named_with_its_slot() {
    let mut tube = tube();
    tube.attach(Slot::Eu(1), 1, 1.0).unwrap();
    for error in asked(&tube, &one(c(0.1, 0.0))) {
        assert_eq!(error, NetworkError::NoLaw { slot: Slot::Eu(1), law: 1, laws: 1 });
    }
    let blown = FlowChain::of(&tube, 1.4, 1.0).unwrap();
    let (mut work, root) = (Workspace::default(), Root { s: c(0.0, 700.0), steps: 0, residual: 0.0 });
    let chain: &dyn Chain = &blown;
    let errors = [
        chain.solve(&Constant, root.s, &Newton::default(), &mut work).unwrap_err(),
        chain.modes(&Constant, &REGION, &mut work).unwrap_err(),
        chain.respond(&Constant, &root, &HALF, Order::First, &mut work).unwrap_err(),
        chain.budget(&Constant, &root, &mut work).unwrap_err(),
    ];
    for error in errors {
        assert_eq!(error, NetworkError::NoLaw { slot: Slot::Eu(1), law: 1, laws: 0 });
    }
}

#[test]
fn message_laws_that_make_a_segment_negative_are_refused() {
    for (slot, quantity, add, value) in [
        (Slot::Length(1), "length", -3.0, -2.5),
        (Slot::Area(0), "area", -1.8e-3, 0.0),
        (Slot::SoundSpeed(1), "sound speed", -400.0, -57.0),
        (Slot::Density(0), "density", -2.0, -0.8),
    ] {
        let mut tube = tube();
        tube.attach(slot, 0, 1.0).unwrap();
        for error in asked(&tube, &one(c(add, 0.0))) {
            let NetworkError::Property { index, quantity: what, value: found } = error else {
                panic!("{error:?}")
            };
            let segment = usize::from(matches!(slot, Slot::Length(1) | Slot::SoundSpeed(1)));
            assert!((index, what) == (segment, quantity) && (found - value).abs() < 1e-12, "{error}");
            // An optimiser may take a shorter step.
            assert!(error.is_recoverable());
        }
    }
    // With mean flow.
    let mut tube = tube();
    tube.attach(Slot::Length(1), 0, 1.0).unwrap();
    let blown = FlowChain::of(&tube, 1.4, 1.0).unwrap();
    let found = Chain::modes(&blown, &one(c(-3.0, 0.0)), &REGION, &mut Workspace::default());
    assert_eq!(found.unwrap_err(), NetworkError::Property { index: 1, quantity: "length", value: -2.5 });
}

#[test]
fn behaviour_no_answer_is_nan() {
    let (mut tube, mut work) = (tube(), Workspace::default());
    let laws = one(c(0.1, 0.0));
    tube.attach(Slot::Eu(1), 0, 1.0).unwrap();
    for s in [c(f64::NAN, 700.0), c(1e6, 1e3), c(0.0, 1e300)] {
        for order in [Order::Value, Order::First] {
            let found = [
                tube.impedance_at(&laws, s, 1, order, &mut work).map(|z| z.value()),
                tube.reflection_at(&laws, s, 1, order, &mut work).map(|z| z.value()),
                tube.transfer(&laws, s, [0, 2], order, &mut work).map(|t| t.matrix[0][0].value()),
            ];
            for answer in found {
                assert!(answer.as_ref().map_or(true, |z| z.is_finite()), "{s} {answer:?}");
            }
            assert!(tube.impedance_at(&laws, s, 0, order, &mut work).is_err(), "{s}");
        }
    }
    let far = tube.impedance_at(&laws, c(1e6, 1e3), 0, Order::Value, &mut work).unwrap_err();
    assert!(matches!(far, NetworkError::Overflow { .. }), "{far}");
    for sigma in [[-1e5, 0.0], [0.0, 1e6]] {
        let region = Region { sigma, omega: [300.0, 3000.0] };
        let error = tube.modes(&laws, &region, &mut work).unwrap_err();
        let words = error.to_string();
        assert!(words.contains("stay within 7.775e4 1/s"), "{words}");
    }
    let newton = Newton { tolerance: f64::INFINITY, ..Newton::default() };
    let error = tube.solve(&laws, c(0.0, 700.0), &newton, &mut work).unwrap_err();
    assert!(matches!(error, NetworkError::Tolerance { .. }), "{error}");
    let found = tube.along(&laws, &Root { s: c(0.0, 700.0), steps: 0, residual: 0.0 }, usize::MAX, &mut work);
    assert!(matches!(found.unwrap_err(), NetworkError::Samples { segments: 2, .. }));
    for slot in [Slot::Mu(1 << 63), Slot::Length(usize::MAX), Slot::Length(usize::MAX / 2)] {
        assert!(matches!(tube.set(slot, c(7.0, 0.0)).unwrap_err(), NetworkError::Slot { .. }), "{slot:?}");
    }
}

#[test]
fn exact_an_energy_budget_closes_at_an_eigenvalue_alone() {
    let (rest, mut work) = (tube(), Workspace::default());
    let blown = FlowChain::of(&rest, 1.4, 8.0).unwrap();
    for chain in [&rest as &dyn Chain, &blown] {
        let root = chain.solve(&Constant, c(-30.0, 720.0), &Newton::default(), &mut work).unwrap();
        let mut mismatch = |s: C64| {
            let root = Root { s, ..root };
            chain.budget(&Constant, &root, &mut work).unwrap().mismatch()
        };
        assert!(mismatch(root.s) < 1e-12);
        // It grows in proportion to the distance, and is large far off.
        let [near, nearer] = [1e-2, 1e-3].map(|step| mismatch(root.s + c(step, 0.0)));
        assert!((near / nearer - 10.0).abs() < 0.1 && near > 1e-5, "{near} {nearer}");
        assert!(mismatch(c(-500.0, 1700.0)) > 0.1, "{}", mismatch(c(-500.0, 1700.0)));
    }
}

#[test]
fn message_lengths_stretches_and_samples_that_are_none() {
    let whole = Segment::new(-1.0, 1.8e-3, 343.0, 1.2);
    let error = Network::cut_tube(whole, &[]).unwrap_err().to_string();
    assert!(error.contains("length") && error.contains("-1"), "{error}");
    let tube = tube();
    let (laws, mut work) = (LawSet::default(), Workspace::default());
    let back = tube.transfer(&laws, c(-30.0, 700.0), [1, 0], Order::Value, &mut work).unwrap_err();
    assert!(back.to_string().contains("give the place upstream first"), "{back}");
    let blown = FlowChain::of(&tube, 1.4, 1.0).unwrap();
    let guess = tube.solve(&laws, c(-24.0, 718.0), &Newton::default(), &mut work).unwrap().s;
    let root = blown.solve(&laws, guess, &Newton::default(), &mut work).unwrap();
    let most = blown.along(&laws, &root, usize::MAX, &mut work).unwrap_err();
    assert!(matches!(most, NetworkError::Samples { samples: usize::MAX, .. }), "{most}");
}
