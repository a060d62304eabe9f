//! Constants of physics against oracles that do not share them: each line that could be changed unnoticed,
//! once.

use crate::common_laws::{c, given};
use crate::mean_flow::{GAMMA, end, inlet};
use rijke_network::file::{OscilosTexts, by_the_rule_of_oscilos, read, read_oscilos};
use rijke_network::flow_chain::{ActionKind, FlowChain, FlowDuct};
use rijke_network::laws::{
    Law, Table, TableError, TableRow, choked_inlet, choked_outlet, thick_wall_correction,
};
use rijke_network::{
    At, Chain, Constant, Laws, Network, NetworkError, Region, Segment, Slot, Workspace, levine_schwinger,
};
use rijke_numerics::C64;
use std::f64::consts::PI;

#[test]
fn oracle_the_long_wave_end_correction_is_that_of_the_integrals() {
    for ka in [1e-6, 9.9e-6] {
        for angle in [0.0, 0.5, -0.5] {
            let ka = C64::from_polar(ka, angle);
            let length = |r: C64| C64::I * (-r).ln() / (2.0 * ka);
            let (got, exact) =
                (length(levine_schwinger::reflection(ka)[0]), length(levine_schwinger::integrals(ka)));
            assert!((got - exact).norm() < 1e-7, "{got} {exact}");
        }
    }
}

#[test]
fn oracle_a_very_thick_wall_has_the_end_correction_of_a_tube_in_a_baffle() {
    // 0.82159 radii (Norris & Sheng 1989, J. Sound Vib. 135, 85); one of a thin wall is 0.21 shorter.
    let (radius, sound_speed) = (0.02, 340.0);
    let correction = thick_wall_correction(radius, 1e6 * radius);
    let law = Law::Unflanged { radius, sound_speed, correction };
    let ka = 1e-3;
    let length = -(-law.analytic(c(0.0, ka * sound_speed / radius))[0]).ln().im / (2.0 * ka);
    assert!((length - 0.82159).abs() < 1e-3, "{length}");
}

#[test]
fn oracle_choked_ends_from_the_nonlinear_balances() {
    // Isentropic disturbances of a flow: p' = a, rho' = a/c^2, u' as the balance wants it.
    let (p, rho, mach): (f64, f64, f64) = (1.0e5, 1.2, 0.23);
    let speed = (GAMMA * p / rho).sqrt();
    let u = mach * speed;
    let h = 1e-4;
    let slope = |f: &dyn Fn(f64, f64, f64) -> f64, by_pressure: bool| {
        let at = |h: f64| {
            if by_pressure {
                f(p * (1.0 + h), u, rho * (1.0 + h).powf(1.0 / GAMMA))
            } else {
                f(p, u * (1.0 + h), rho)
            }
        };
        (at(h) - at(-h)) / (2.0 * h)
    };
    // Outlet: the Mach number is kept. u'/u = -x p'/p with x the ratio of the slopes.
    let number = |p: f64, u: f64, rho: f64| u / (GAMMA * p / rho).sqrt();
    let admittance = -slope(&number, true) / slope(&number, false) * u / p;
    let z = 1.0 / (admittance * rho * speed);
    assert!((choked_outlet(GAMMA, mach) - (z - 1.0) / (z + 1.0)).abs() < 1e-7);
    // Inlet: mass flow and stagnation enthalpy are kept, density is free: eliminate it.
    let mass = |_: f64, u: f64, rho: f64| (u * rho).ln();
    let enthalpy = |p: f64, u: f64, rho: f64| GAMMA / (GAMMA - 1.0) * p / rho + 0.5 * u * u;
    let by_density =
        |f: &dyn Fn(f64, f64, f64) -> f64| (f(p, u, rho * (1.0 + h)) - f(p, u, rho * (1.0 - h))) / (2.0 * h);
    let alone = |f: &dyn Fn(f64, f64, f64) -> f64| {
        let by_p = (f(p * (1.0 + h), u, rho) - f(p * (1.0 - h), u, rho)) / (2.0 * h);
        [by_p, slope(f, false), by_density(f)]
    };
    let ([m1, m2, m3], [h1, h2, h3]) = (alone(&mass), alone(&enthalpy));
    // m1 P + m2 V + m3 D = 0, h1 P + h2 V + h3 D = 0.
    let v = -(m1 * h3 - h1 * m3) / (m2 * h3 - h2 * m3);
    // Upstream f = R g: p/(rho c u) = (R + 1)/(R - 1).
    let z = 1.0 / (v * u / p * rho * speed);
    let r = (z + 1.0) / (z - 1.0);
    assert!((choked_inlet(GAMMA, mach) - r).abs() < 1e-6, "{r} {}", choked_inlet(GAMMA, mach));
}

#[test]
fn behaviour_undeclared_poles_are_refused() {
    let mut net = Network::new(vec![Segment::new(1.0, 1e-3, 340.0, 1.2)]).unwrap();
    net.set(Slot::Upstream, c(-0.9, 0.0)).unwrap();
    net.attach(Slot::Downstream, 0, 1.0).unwrap();
    let region = Region { sigma: [-300.0, 200.0], omega: [200.0, 3000.0] };
    // Their zeros lie some hundred 1/s from the poles; a pair closer than 2 % of a cell passes for nothing.
    for (at, residue) in [(c(100.0, 600.0), 300.0), (c(-200.0, 2500.0), 900.0)] {
        let law = given(0, 1, move |a: &At, laws: &mut Laws| {
            let s = a.s_jet();
            laws.set(0, &s.shift(-at).recip().scale(c(residue, 0.0)).shift(c(-0.9, 0.0)));
        });
        let found = net.modes(&law, &region, &mut Workspace::default());
        assert!(matches!(found, Err(NetworkError::UndeclaredPole { .. })), "{at}: {found:?}");
    }
}

#[test]
fn behaviour_tables_with_growing_poles_are_refused() {
    for growth in [5.0, 200.0] {
        let rows: Vec<TableRow> = (1..60)
            .map(|k| {
                let frequency = 10.0 * f64::from(k);
                let s = c(0.0, 2.0 * PI * frequency);
                let pole = c(growth, 2.0 * PI * 300.0);
                let v = 200.0 / (s - pole) + 200.0 / (s - pole.conj()) + 0.5;
                TableRow { frequency, gain: v.norm(), phase: v.arg() }
            })
            .collect();
        let refused = Table::fit(&rows, 1e-6);
        assert!(
            matches!(refused, Err(TableError::Unstable { at }) if (at.re - growth).abs() < 1e-3 * growth),
            "{refused:?}"
        );
    }
}

#[test]
fn oracle_viscosity_of_hot_ducts_against_sutherland() {
    for temperature in [400.0, 700.0, 1000.0] {
        let text = format!(
            "[upstream]\ntype = 'closed'\n[downstream]\ntype = 'open'\n[[element]]\ntype = 'duct'\nlength = 1\n\
             diameter = 0.05\nwall = 'paper'\ntemperature = {temperature}\n"
        );
        let built = read(&text).unwrap();
        let viscous = built.laws.laws.iter().find(|l| l.0.contains("viscous")).unwrap();
        // The paper's wall: kappa = (4/D) sqrt(s rho mu).
        let s = c(0.0, 1000.0);
        let density = 101_325.0 / (287.05 * temperature);
        let mu = ((viscous.1.analytic(s)[0] * 0.05 / 4.0).powi(2) / (s * density)).re;
        let sutherland =
            1.716e-5 * (temperature / 273.15f64).powf(1.5) * (273.15 + 110.4) / (temperature + 110.4);
        assert!((mu / sutherland - 1.0).abs() < 0.05, "{temperature} K: {mu} {sutherland}");
    }
}

#[test]
fn exact_a_branch_takes_the_momentum_of_the_stream() {
    // Mass v of the stream's own state leaves: by the balances of mass and momentum without entropy,
    // dp = rho U v/(1 - M^2), du = -v/(1 - M^2).
    let (speed, velocity, k) = (340.0, 70.0, 1e-3);
    let state = inlet(speed, velocity);
    let ducts = vec![
        FlowDuct::new(0.4, 1.0),
        FlowDuct::new(0.6, 1.0).with(ActionKind::Branch, Law::Constant(c(k, 0.0))),
    ];
    let chain = FlowChain::new(GAMMA, state, ducts, [end(0.9), end(-0.8)]).unwrap().without_entropy_waves();
    let by_hand = |s: C64| {
        let z = state.density * speed;
        let along = |x: f64, [f, g]: [C64; 2]| {
            [f * (-s * x / (speed + velocity)).exp(), g * (s * x / (speed - velocity)).exp()]
        };
        let [f, g] = along(0.4, [c(0.9, 0.0), C64::ONE]);
        let v = k * (f + g) / (1.0 - (velocity / speed).powi(2));
        let (dp, du) = (state.density * velocity * v, -v);
        let [f, g] = along(0.6, [f + 0.5 * (dp + z * du), g + 0.5 * (dp - z * du)]);
        g + 0.8 * f
    };
    for s in [c(0.0, 700.0), c(-60.0, 2100.0)] {
        let got = chain.characteristic(s)[0];
        assert!((got - by_hand(s)).norm() < 1e-12 * got.norm(), "{got} {}", by_hand(s));
    }
}

fn oscilos(inlet: &str, outlet: &str, heat: &str) -> (FlowChain, Region) {
    let texts = OscilosTexts {
        geometry: format!("x r s t\n0 0.05 0 0\n0.8 0.05 {heat} 0\n2 0.05 0 0\n"),
        mean_flow: "P1 T1 choice M1 gamma dT\n101325 293 1 0 1 3\n".to_owned(),
        flame: Some("t a b\n1 0.4 2.5".to_owned()),
        inlet: format!("t a b c\n{inlet}\n"),
        outlet: format!("t a b c\n{outlet}\n"),
        scan_range: "f f n g g n\n10 400 50 -200 200 50\n".to_owned(),
    };
    read_oscilos(&texts).unwrap()
}

fn speed(t: f64) -> f64 {
    (1.4 * 8.3145 / 28.965_12 * 1000.0 * t).sqrt()
}

#[track_caller]
fn check(case: (FlowChain, Region), by_hand: &dyn Fn(C64) -> C64, tolerance: f64) {
    let found = case.0.modes(&Constant, &case.1, &mut Workspace::default()).unwrap();
    assert!(found.modes.len() >= 3);
    for m in found.modes {
        let gap = (by_hand(m.s) * 2e-3 / (by_hand(m.s + 1e-3) - by_hand(m.s - 1e-3))).norm();
        assert!(gap < tolerance, "{}: {gap}", m.s);
    }
}

fn uniform(s: C64, upstream: C64, downstream: C64) -> C64 {
    1.0 - upstream * downstream * (-4.0 * s / speed(293.0)).exp()
}

#[test]
fn oracle_oscilos_delays_of_ends_are_in_milliseconds() {
    // BC_subfc.m: R = a exp(-s tau), tau in ms.
    check(oscilos("2 - - -", "4 0.8 3.5 -", "0"), &|s| uniform(s, C64::ONE, 0.8 * (-3.5e-3 * s).exp()), 1e-2);
}

#[test]
fn oracle_oscilos_phases_lag() {
    // BC_subfc.m: R = a exp(-i Phi), Phi in rad, in degrees if the third parameter is not 0.
    let lag = C64::from_polar(0.8, -1.1);
    check(oscilos("2 - - -", "5 0.8 1.1 0", "0"), &|s| uniform(s, C64::ONE, lag), 1e-2);
    let degrees = C64::from_polar(0.7, -40f64.to_radians());
    check(oscilos("5 0.7 40 1", "2 - - -", "0"), &|s| uniform(s, degrees, C64::ONE), 1e-2);
}

#[test]
fn oracle_oscilos_ends_11_are_unflanged_and_12_flanged() {
    // To first order they are longer by 0.6127 and 8/(3 pi) radii.
    for (kind, correction) in [(11, 0.6127), (12, 8.0 / (3.0 * PI))] {
        let case = oscilos("2 - - -", &format!("{kind} - - -"), "0");
        let first = case.0.modes(&Constant, &case.1, &mut Workspace::default()).unwrap().modes[0].s.im;
        let longer = 0.5 * PI * speed(293.0) / first - 2.0;
        assert!((longer / 0.05 - correction).abs() < 0.01, "{kind}: {longer}");
    }
}

#[test]
fn oracle_oscilos_own_rule_takes_open_ends_at_the_frequency_alone() {
    // BC_subfc.m, polyLevineSchwingerBC, with its s imaginary or not: R is that of Im s.
    let case = oscilos("5 0.3 0 0", "11 - - -", "0");
    let end = |omega: f64| {
        let ka = omega * 0.05 / speed(293.0);
        let modulus = (1.0 + 0.2 * ka - 0.084 * ka * ka) / (1.0 + 0.2 * ka + (0.5 - 0.084) * ka * ka);
        let length = (0.6133 + 0.027 * ka * ka) / (1.0 + 0.19 * ka * ka);
        -modulus * C64::new(0.0, -2.0 * ka * length).exp()
    };
    for mode in case.0.modes(&Constant, &case.1, &mut Workspace::default()).unwrap().modes {
        let s = by_the_rule_of_oscilos(&case.0, mode.s).unwrap().unwrap();
        let off = uniform(s, C64::new(0.3, 0.0), end(s.im)).norm();
        assert!(off < 1e-3, "{s}: {off}");
        // Strongly damped modes differ from those of the exact end, and not by much.
        let apart = (s - mode.s).norm();
        assert!(apart > 0.05 && apart < 5.0, "{} {s}", mode.s);
    }
    let closed = oscilos("2 - - -", "1 - - -", "0");
    assert_eq!(by_the_rule_of_oscilos(&closed.0, c(0.0, 800.0)).unwrap(), None);
}

/// Closed ends, three times as hot behind 0.8 m, a flame Q'/Q of u'/U there.
fn heated(s: C64, flame: C64) -> C64 {
    // p is kept; rho c falls by the root of the ratio; the flame adds 2 (Q'/Q) u.
    let (a, b) = (s * 0.8 / speed(293.0), s * 1.2 / speed(879.0));
    -a.sinh() * (1.0 + 2.0 * flame) * b.cosh() - a.cosh() * b.sinh() * 3.0f64.sqrt()
}

#[test]
fn oracle_oscilos_section_10_is_steady_heat() {
    check(oscilos("2 - - -", "2 - - -", "10"), &|s| heated(s, C64::ZERO), 5e-2);
}

#[test]
fn oracle_oscilos_section_11_is_a_flame_that_lags_milliseconds() {
    check(oscilos("2 - - -", "2 - - -", "11"), &|s| heated(s, 0.4 * (-2.5e-3 * s).exp()), 5e-2);
}
