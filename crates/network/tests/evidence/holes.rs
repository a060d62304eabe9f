//! Orifices, side holes, screens, ideal ends, and what a temperature slope does at flames and ends.

use crate::common_laws::c;
use rijke_network::file::{ElementProblem, FileError, read};
use rijke_network::levine_schwinger;
use rijke_network::{Places, Workspace};
use rijke_numerics::{C64, Order};
use std::f64::consts::PI;

const C: f64 = 343.2;
const RHO: f64 = 1.2041;
const DUCT: &str = "type = 'duct'\ndiameter = 0.05\nsound_speed = 343.2\ndensity = 1.2041\n";

fn modes(text: &str) -> Vec<C64> {
    let built = read(text).unwrap();
    built.modes(&built.region).unwrap().modes.iter().map(|m| m.s).collect()
}

/// A tube closed upstream, R = 0.9 e^{3i} downstream, cut at 0.4 m of 1 m by a device.
fn cut(device: &str) -> String {
    format!(
        "[search]\nfrequency_hz = [20, 900]\ngrowth_rate = [-150, 20]\n[upstream]\ntype = 'closed'\n[downstream]\n\
         type = 'constant'\nmodulus = 0.9\nangle = 3.0\n[[element]]\n{DUCT}length = 0.4\n{device}\
         [[element]]\n{DUCT}length = 0.6\n"
    )
}

/// g - R f behind a T [[1 + yz/2, -(z + y z^2/4)], [-y, 1 + yz/2]] at 0.4 m.
fn by_hand(s: C64, z: C64, y: C64) -> C64 {
    let k = s / C;
    let (p1, u1) = ((k * 0.4).cosh(), -(k * 0.4).sinh() / (RHO * C));
    let yz = y * z;
    let p = (1.0 + 0.5 * yz) * p1 - (z + 0.25 * yz * z) * u1;
    let u = (1.0 + 0.5 * yz) * u1 - y * p1;
    let (f, g) = (0.5 * (p + RHO * C * u), 0.5 * (p - RHO * C * u));
    g * (k * 0.6).exp() - C64::from_polar(0.9, 3.0) * f * (-k * 0.6).exp()
}

/// Distance of s from the nearest zero of `f`, to first order.
fn distance(f: &dyn Fn(C64) -> C64, s: C64) -> f64 {
    (f(s) * 2e-3 / (f(s + 1e-3) - f(s - 1e-3))).norm()
}

#[test]
fn oracle_orifices_have_two_corrections_less_in_narrow_tubes() {
    // Half as wide as the tube. 0.340045 is what the evanescent modes of the tube give (see the tests of
    // `fok`); one side of a hole in the open moves 8/(3 pi) radii.
    let found = modes(&cut("[[element]]\ntype = 'orifice'\ndiameter = 0.025\nthickness = 2e-3\ndrag = 5\n"));
    let effective = 2e-3 + 2.0 * 0.340_045 * 8.0 / (3.0 * PI) * 0.0125;
    assert!(found.len() >= 3);
    for s in &found {
        let f = |s: C64| by_hand(s, s * RHO * effective * 4.0 + 5.0, C64::ZERO);
        let gap = distance(&f, *s);
        assert!(gap < 1e-3 * (s - modes(&cut(""))[0]).norm().max(300.0), "{s}: {gap}");
    }
    // A hole nearly as wide as the tube moves no mode: by 10 Hz before the correction knew of the tube.
    let wide = modes(&cut("[[element]]\ntype = 'orifice'\ndiameter = 0.0495\nthickness = 1e-4\n"));
    for (s, plain) in wide.iter().zip(modes(&cut(""))) {
        assert!((s - plain).norm() < 2.0 * PI * 0.1, "{s} {plain}");
    }
    let refused =
        read(&cut("[[element]]\ntype = 'orifice'\ndiameter = 0.06\nthickness = 1e-4\n")).unwrap_err();
    assert!(
        matches!(refused, FileError::Element { problem: ElementProblem::HoleTooWide { .. }, .. }),
        "{refused}"
    );
}

#[test]
fn oracle_side_holes_against_their_own_equation() {
    // Corrections by the fits of others: Lefebvre & Scavone 2012 inside, Nederveen 1998 in series.
    let (a, b, height) = (0.025, 0.0125, 0.08);
    let d: f64 = b / a;
    let inner =
        [0.822, -0.095, -1.566, 2.138, -1.640, 0.502].iter().rev().fold(0.0, |sum, k| sum * d + k) * b;
    let series = (-0.37 + 0.087 * d) * d * d * b;
    // Sagitta of the tube's wall, averaged over the hole: b delta/8 for small holes.
    let length = height + b * d / 8.0 * 1.026;
    let hole = "[[element]]\ntype = 'side-hole'\ndiameter = 0.025\nlength = 0.08\noutlet = 'unflanged'\n";
    let found = modes(&cut(hole));
    let f = |s: C64| {
        let r = levine_schwinger::integrals(s * b / (C64::I * C));
        let (outside, t) = ((1.0 + r) / (1.0 - r), (s * length / C).tanh());
        let z = RHO * C * (outside + t) / (1.0 + outside * t) + s * RHO * inner;
        by_hand(s, s * RHO * series, d * d / z)
    };
    assert!(found.len() >= 3);
    let plain = modes(&cut(""));
    for (s, without) in found.iter().zip(&plain) {
        let gap = distance(&f, *s);
        assert!(gap < 0.01 * (s - without).norm(), "{s}: {gap}, moved by {}", (s - without).norm());
    }
    // With a wall the hole loses more; a flange makes it longer.
    let lossy = modes(&cut(&format!("{hole}wall = 'zwikker-kosten'\n")));
    assert!(lossy.iter().zip(&found).any(|(x, y)| x.re < y.re - 0.01));
    let flanged = modes(&cut(&hole.replace("'unflanged'", "'flanged'")));
    assert!(flanged[0].im < found[0].im && flanged[0].im > found[0].im - 40.0);
}

#[test]
fn exact_screens_take_what_steady_flow_takes() {
    let [flow, at_rest] = ["[flow]\nvelocity = 4\nentropy_waves = false\n", ""];
    let screen = |keys: &str| cut(&format!("[[element]]\ntype = 'screen'\n{keys}"));
    let drag = |k: f64| cut(&format!("[[element]]\ntype = 'feedback'\nmu = [{k}, 0]\n"));
    let same = |one: &str, two: &str| {
        let (one, two) = (modes(one), modes(two));
        assert!(one.len() == two.len() && one.len() >= 3);
        for (a, b) in one.iter().zip(&two) {
            assert!((a - b).norm() < 1e-9 * b.norm(), "{a} {b}");
        }
    };
    // K = 1.3 (1 - 1/2) + (2 - 1)^2 = 1.65 of an open half; d(K rho U^2/2)/dU = K rho U.
    let mesh = screen("resistance = 6\nopen_area = 0.5\n");
    same(&format!("{flow}{mesh}"), &format!("{flow}{}", drag(6.0 + 1.65 * RHO * 4.0)));
    same(&format!("{flow}{}", screen("loss = 2\n")), &format!("{flow}{}", drag(2.0 * RHO * 4.0)));
    same(&format!("{at_rest}{mesh}"), &drag(6.0));
    let heavy = modes(&screen("effective_length = 0.01\n"));
    for s in heavy {
        assert!(distance(&|s| by_hand(s, s * RHO * 0.01, C64::ZERO), s) < 1e-8 * s.norm());
    }
    for (keys, says) in [
        ("open_area = 0.5\nloss = 1", "either open_area or loss"),
        ("open_area = 1.5", "open_area is 1.5, but must be above 0 and at most 1"),
        ("resistance = -1", "resistance is -1"),
    ] {
        let said = read(&screen(&format!("{keys}\n"))).unwrap_err().to_string();
        assert!(said.contains(says), "{said}");
    }
}

#[test]
fn exact_all_four_pairs_of_ideal_ends() {
    for (text, shift) in [
        (include_str!("../../../../fixtures/networks/open-open.toml"), 0.0),
        (include_str!("../../../../fixtures/networks/open-closed.toml"), 0.5),
        (include_str!("../../../../fixtures/networks/closed-open.toml"), 0.5),
        (include_str!("../../../../fixtures/networks/closed-closed.toml"), 0.0),
    ] {
        for flow in ["", "[flow]\nvelocity = 0.1\nentropy_waves = false\n"] {
            let built = read(&format!("{flow}{text}").replace("name = \"Tube", "# \"Tube")).unwrap();
            let mut work = Workspace::default();
            let (chain, laws) = built.chain();
            let found = chain.modes(laws, &built.region, &mut work).unwrap();
            assert!(found.counted >= 2);
            for (k, mode) in found.modes.iter().enumerate() {
                let n = k as f64 + if shift > 0.0 { shift } else { 1.0 };
                let speed = if flow.is_empty() { C } else { (1.4 * 101_325.0f64 / RHO).sqrt() };
                assert!((mode.s - c(0.0, PI * n * speed)).norm() < 1e-3, "{}", mode.s);
                let root = mode.root();
                // Nothing is asked of the reference when no pressure is asked for, though it is a node at an
                // open end.
                let condition = chain.condition(laws, &root, &mut work).unwrap();
                assert!((1.5..6.0).contains(&condition), "{condition}");
                let none = Places { at: Vec::new(), reference: 0 };
                let s = chain.respond(laws, &root, &none, Order::First, &mut work).unwrap().s;
                assert_eq!(s.value(), root.s);
                assert!(chain.along(laws, &root, 3, &mut work).is_ok());
            }
        }
    }
}

#[test]
fn order_temperature_slopes_are_of_fourth_order_at_rest_and_of_second_in_a_flow() {
    let ends = [
        ["type = 'unflanged'", "type = 'flanged'"],
        ["type = 'constant'\nmodulus = 0.7\nangle = 2.5", "type = 'impedance'\nnumerator = [0.4, 1e-4]"],
    ];
    let text = |[up, down]: [&str; 2], pieces: usize, flow: &str| {
        format!(
            "{flow}[search]\nfrequency_hz = [60, 700]\ngrowth_rate = [-400, 200]\n[upstream]\n{up}\n[downstream]\n{down}\n\
             [[element]]\ntype = 'duct'\nlength = 0.45\ndiameter = 0.05\ntemperature = 300\ntemperature_end = 420\n\
             pieces = {pieces}\n\
             [[element]]\ntype = 'flame'\nn = 0.6\ndelay = 2e-3\n\
             [[element]]\ntype = 'duct'\nlength = 0.55\ndiameter = 0.05\ndiameter_end = 0.06\ntemperature = 1100\n\
             temperature_end = 700\npieces = {pieces}\n"
        )
    };
    for flow in ["", "[flow]\nvelocity = 0.5\nentropy_waves = false\n"] {
        for pair in ends {
            let coarsest = if flow.is_empty() { 5 } else { 20 };
            let found = [1, 2, 4, 8].map(|k| modes(&text(pair, k * coarsest, flow)));
            assert!(found.iter().all(|f| f.len() == found[0].len()) && found[0].len() >= 2);
            for k in 0..found[0].len() {
                let steps: Vec<f64> = found.windows(2).map(|w| (w[1][k] - w[0][k]).norm()).collect();
                // 0.2 1/s at 40 pieces when ends took the gas of the middle of the last piece.
                let left = if flow.is_empty() { 2e-4 } else { 0.02 };
                assert!(k > 0 || steps[1] + steps[2] < left, "{flow} {k}: {steps:?}");
                for pair in steps.windows(2) {
                    let order = (pair[0] / pair[1]).log2();
                    // Entropy waves that are lost in every piece are lost sooner in short ones: of first
                    // order in the Mach number times the length of the pieces.
                    let orders = if flow.is_empty() { 3.6..4.5 } else { 1.6..2.3 };
                    assert!(orders.contains(&order), "{flow} {k}: order {order} of {steps:?}");
                }
            }
        }
    }
}
