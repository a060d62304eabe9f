//! The adjoint against tangents carried forward, and the energy budget.

use crate::common_laws::{RIG, c, close_with_paper_ends, given, paper_wall, rig_segment, root};
use crate::derivatives::{EVERYTHING, everything};
use rijke_network::{
    At, Coefficients, Laws, Network, Places, Sensitivities, Slot, Workspace, levine_schwinger,
};
use rijke_numerics::{C64, Order};

/// The laws of another set, and one more real parameter whose law is that parameter.
struct Nudged<K>(K);

impl<K: Coefficients> Coefficients for Nudged<K> {
    fn parameters(&self) -> usize {
        1
    }
    fn laws(&self) -> usize {
        self.0.laws() + 1
    }
    fn fill(&self, at: &At, laws: &mut Laws) {
        // The inner laws keep their parameters constant: only s and the nudge are seeds.
        let count = self.0.laws();
        let inner = At::search(at.s());
        let mut values = Laws::default();
        values.reset(count, &inner);
        self.0.fill(&inner, &mut values);
        for law in 0..count {
            laws.set_analytic(law, [values.value(law), values.gradient(law)[0], C64::ZERO]);
        }
        laws.set(count, &at.parameter(0, 0.0));
    }
}

#[test]
fn oracle_adjoint_agrees_with_forward_tangents_for_every_slot() {
    let (net, laws) = everything(EVERYTHING);
    let laws = Nudged(laws);
    let found = root(&net, &laws, c(-40.0, 1120.0));
    let places = Places { at: vec![0, 1, 3, 4], reference: 2 };
    let (mut work, mut adjoint) = (Workspace::default(), Sensitivities::default());
    net.sensitivities(&laws, &found, &places, &mut adjoint, &mut work).unwrap();
    let mut slots = vec![Slot::Upstream, Slot::Downstream];
    for i in 0..4 {
        slots.extend([Slot::Length(i), Slot::Area(i), Slot::SoundSpeed(i), Slot::Density(i)]);
        slots.extend([Slot::Viscous(i), Slot::Thermal(i)]);
    }
    for j in 0..=4 {
        slots.extend([Slot::Mu(j), Slot::Mp(j), Slot::Eu(j), Slot::Ep(j)]);
    }
    for slot in slots {
        let mut nudged = net.clone();
        nudged.attach(slot, 9, 1.0).unwrap();
        let forward = nudged.respond(&laws, &found, &places, Order::First, &mut work).unwrap();
        let check = |got: C64, expected: C64| {
            let error = (got - expected).norm();
            let scale = expected.norm();
            assert!(error <= 1e-10 * scale + 1e-13, "{slot:?}: {got} against {expected}");
        };
        check(adjoint.with_respect_to(&adjoint.s, slot), forward.s.gradient()[0]);
        for (m, p) in forward.pressures.iter().enumerate() {
            check(adjoint.with_respect_to(&adjoint.pressures[m], slot), p.gradient()[0]);
        }
    }
}

#[test]
fn exact_condition_of_a_uniform_tube() {
    // s = (c/2L) ln(R_u R_d) + i pi c/L: lengths and speeds give |s| each, the ends c/(2L) each.
    let mut net = Network::cut_tube(rig_segment(), &[0.2, 0.6]).unwrap();
    net.set(Slot::Upstream, c(-0.9, 0.0)).unwrap();
    net.set(Slot::Downstream, c(-0.9, 0.0)).unwrap();
    let none = given(0, 0, |_, _| {});
    let found = root(&net, &none, c(0.0, 1080.0));
    let mut adjoint = Sensitivities::default();
    let places = Places { at: vec![], reference: 1 };
    net.sensitivities(&none, &found, &places, &mut adjoint, &mut Workspace::default()).unwrap();
    let by_ends = RIG.sound_speed / found.s.norm();
    let areas_and_densities: f64 = (0..3)
        .map(|i| {
            let segment = net.segments()[i];
            let by = |slot| adjoint.with_respect_to(&adjoint.s, slot);
            (by(Slot::Area(i)) * segment.area).norm() + (by(Slot::Density(i)) * segment.density).norm()
        })
        .sum::<f64>()
        / found.s.norm();
    let speeds_and_lengths = adjoint.condition(&net, found.s) - areas_and_densities - by_ends;
    // A single segment's speed and length enter with opposite signs but also reflect at its borders, so the
    // sum of moduli is at least 2.
    assert!((2.0 - 1e-12..4.0).contains(&speeds_and_lengths), "{speeds_and_lengths}");
    let all: C64 =
        (0..3).map(|i| adjoint.with_respect_to(&adjoint.s, Slot::Length(i)) * net.segments()[i].length).sum();
    assert!((all + found.s).norm() < 1e-10 * found.s.norm(), "s is inversely proportional to all lengths");
}

#[test]
fn exact_energy_budget_closes() {
    let mut work = Workspace::default();
    let (net, laws) = everything(EVERYTHING);
    let found = root(&net, &laws, c(-40.0, 1120.0));
    let budget = net.budget(&laws, &found, &mut work);
    assert!(budget.mismatch() < 1e-10, "{budget:?}");
    assert!((budget.growth - 2.0 * found.s.re).abs() < 1e-12);

    // The rig tube: everything takes energy, and radiation from both ends is alike.
    let mut net = Network::cut_tube(rig_segment(), &[0.25, 0.5]).unwrap();
    close_with_paper_ends(&mut net);
    for i in 0..3 {
        net.attach(Slot::Viscous(i), 0, 1.0).unwrap();
        net.attach(Slot::Thermal(i), 1, 1.0).unwrap();
    }
    let wall = given(0, 2, paper_wall);
    let found = root(&net, &wall, c(-5.0, 1040.0));
    let budget = net.budget(&wall, &found, &mut work);
    assert!(budget.mismatch() < 1e-10, "{budget:?}");
    assert!(budget.viscous < 0.0 && budget.thermal < 0.0);
    assert!((budget.upstream - budget.downstream).abs() < 1e-9 && budget.upstream < 0.0);
    assert!(budget.places.is_empty());
}

#[test]
fn exact_laws_share_the_power_of_a_place_by_weight_and_value() {
    let mut net = Network::cut_tube(rig_segment(), &[0.3]).unwrap();
    close_with_paper_ends(&mut net);
    net.attach(Slot::Mu(1), 0, 0.3).unwrap();
    net.attach(Slot::Mu(1), 1, 2.0).unwrap();
    net.attach(Slot::Ep(1), 2, 0.7).unwrap();
    net.attach(Slot::Eu(1), 3, 0.5).unwrap();
    net.attach(Slot::Mp(1), 4, 0.6).unwrap();
    let screens = given(0, 5, |_, laws| {
        for (law, value) in [5.0, 7.0, 1e-4, 0.1, 0.2].into_iter().enumerate() {
            laws.set_analytic(law, [c(value, 0.0), C64::ZERO, C64::ZERO]);
        }
    });
    let mut work = Workspace::default();
    let found = root(&net, &screens, c(-5.0, 1040.0));
    let budget = net.budget(&screens, &found, &mut work);
    let [at] = &budget.places[..] else { panic!("{budget:?}") };
    // From p and u in front of the place: a force takes Re(k u u*) of u there, a source Re(p2 (k u)*) of p
    // behind it, each over 2 E.
    let here = net.along(&screens, &found, 2, &mut work).unwrap()[1];
    let (p, u) = (here.pressure, here.velocity / here.impedance);
    let behind = p - 15.5 * u - 0.12 * p;
    let force = |k: f64, of: C64| k * (of * u.conj()).re;
    let source = |k: f64, of: C64| k * (behind * of.conj()).re;
    let parts = [force(1.5, u), force(14.0, u), source(7e-5, p), source(0.05, u), force(0.12, p)];
    let whole: f64 = parts.iter().sum();
    for (law, part) in parts.into_iter().enumerate() {
        let power: f64 = at.laws.iter().filter(|l| l.0 == law).map(|l| l.1).sum();
        assert!(
            (power / part * whole / at.power - 1.0).abs() < 1e-10 && power.abs() > 0.1,
            "{law}: {power} {part}"
        );
    }
}

#[test]
fn exact_radiation_of_levine_schwinger_ends() {
    // A lossless tube with two Levine-Schwinger ends loses energy by radiation alone.
    let a = 0.0237;
    let ends = given(0, 1, move |at, laws| {
        let factor = c(0.0, -a / RIG.sound_speed);
        let [r, r1, r2] = levine_schwinger::reflection(at.s() * factor);
        laws.set_analytic(0, [r, r1 * factor, r2 * factor * factor]);
    });
    let mut net = Network::new(vec![rig_segment()]).unwrap();
    net.attach(Slot::Upstream, 0, 1.0).unwrap();
    net.attach(Slot::Downstream, 0, 1.0).unwrap();
    let found = root(&net, &ends, c(-1.0, 1040.0));
    let budget = net.budget(&ends, &found, &mut Workspace::default());
    assert!(budget.mismatch() < 1e-9);
    assert!(budget.viscous == 0.0 && (budget.upstream + budget.downstream - 2.0 * found.s.re).abs() < 1e-7);
}
