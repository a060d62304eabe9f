//! Numbers by name, and derivatives in them.

use super::*;
use crate::chain::coefficients::Coefficients;
use crate::plane::newton::Newton;
use crate::respond::answer::Places;
use crate::sense::sensitivity::Sensitivities;
use crate::slot::Slot;
use std::f64::consts::PI;

const TUBE: &str = include_str!("../../../../../fixtures/networks/rijke-tube.toml");
const CLOSED: &str = "[upstream]\ntype = 'closed'\n[downstream]\ntype = 'closed'\n[[element]]\nname = 'tube'\ntype = 'duct'\n\
                      length = 0.9\ndiameter = 0.05\ntemperature = 300";

fn root(numbers: &NamedNumbers, guess_hz: f64) -> C64 {
    let guess = C64::new(0.0, 2.0 * PI * guess_hz);
    numbers.build().unwrap().solve(guess, &Newton::default(), &mut Workspace::default()).unwrap().s
}

#[test]
fn exact_numbers_are_read_and_set_by_name() {
    let mut numbers = NamedNumbers::of(TUBE).unwrap();
    assert_eq!(numbers.build().unwrap(), Built { warnings: Vec::new(), ..read(TUBE).unwrap() });
    assert_eq!(numbers.value("heat release.gain").unwrap(), 0.06);
    assert_eq!(numbers.value("element.3.gain").unwrap(), 0.06);
    assert_eq!(numbers.value("gas.temperature").unwrap(), 293.15);
    assert_eq!(numbers.value("search.growth_rate.1").unwrap(), 150.0);
    assert!(numbers.list().contains(&("above the heater.temperature".into(), 340.0)));
    numbers.set("above the heater.temperature", 341.5).unwrap();
    assert_eq!(numbers.value("above the heater.temperature").unwrap(), 341.5);
    let unknown = numbers.set("heat release.gian", 1.0).unwrap_err().to_string();
    assert!(unknown.starts_with("no number of the file is called `heat release.gian`; known: "), "{unknown}");
    assert!(unknown.contains("heat release.gain"), "{unknown}");
}

#[test]
fn oracle_derivatives_by_name_against_closed_form_and_adjoint() {
    // A closed tube: s = i n pi c/L, c^2 = gamma R T.
    let numbers = NamedNumbers::of(CLOSED).unwrap();
    let s = root(&numbers, 170.0);
    let near = |found: C64, expected: C64| {
        let error = (found - expected).norm() / expected.norm();
        assert!(error < 1e-10, "{found} for {expected}: {error:.1e}");
    };
    near(numbers.derivative(s, "tube.length").unwrap(), -s / 0.9);
    near(numbers.derivative(s, "tube.temperature").unwrap(), s / 600.0);
    near(numbers.derivative(s, "gas.gas_constant").unwrap(), s / (2.0 * 287.05));
    // The gain of a flame: k_eu is proportional to it.
    let numbers = NamedNumbers::of(TUBE).unwrap();
    let (s, built) = (root(&numbers, 175.0), numbers.build().unwrap());
    let law = built.actors.iter().position(|a| a == "heat release").unwrap();
    let place = built.places.iter().find(|(_, name)| name == "heat release").unwrap().0;
    let (mut all, mut work) = (Sensitivities::default(), Workspace::default());
    let root = crate::plane::newton::Root { s, steps: 0, residual: 0.0 };
    let none = Places { at: Vec::new(), reference: 0 };
    built.network.sensitivities(&built.laws, &root, &none, &mut all, &mut work).unwrap();
    let by_coefficient = all.with_respect_to(&all.s, Slot::Eu(place));
    let space = rijke_numerics::JetSpace::new(1, rijke_numerics::Order::First);
    assert!(built.laws.laws() > law);
    let k = built.laws.laws[law].1.at(&space.seed(0, s), space).value();
    near(numbers.derivative(s, "heat release.gain").unwrap(), by_coefficient * k / 0.06);
}

#[test]
fn order_derivatives_by_name_against_eigenvalues_with_and_without_flow() {
    let flow = include_str!("../../../../../fixtures/networks/combustor-flow.toml");
    for (text, hz, names) in [
        (
            TUBE,
            175.0,
            vec!["heat release.delay", "heater plate.diameter", "upstream.wall_thickness", "gas.gamma"],
        ),
        (flow, 150.0, vec!["gas.temperature", "flow.mach"]),
    ] {
        let numbers = NamedNumbers::of(text).unwrap();
        let s = root(&numbers, hz);
        for name in names.iter().filter(|n| numbers.value(n).is_ok()) {
            let (value, step) = (numbers.value(name).unwrap(), 1e-4 * numbers.value(name).unwrap());
            let at = |k: f64| {
                let mut other = numbers.clone();
                other.set(name, value + k * step).unwrap();
                let work = &mut Workspace::default();
                other.build().unwrap().solve(s, &Newton::default(), work).unwrap().s
            };
            let quotient = (at(1.0) - at(-1.0)) / (2.0 * step);
            let found = numbers.derivative(s, name).unwrap();
            let error = (found - quotient).norm() / quotient.norm();
            assert!(error < 1e-6, "{name}: {found} for {quotient}: {error:.1e}");
        }
    }
}
