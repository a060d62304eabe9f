//! Flames whose heat is released along a duct.

use rijke_network::file::read;
use rijke_numerics::C64;
use rijke_numerics::check::{slopes_from, slopes_near};

const C: f64 = 343.2;
const RHO: f64 = 1.2041;

/// A tube of one gas, and this flame at 0.3 of 1 m.
fn tube(flame: &str) -> String {
    format!(
        "[search]\nfrequency_hz = [20, 700]\ngrowth_rate = [-150, 150]\n[upstream]\ntype = 'closed'\n[downstream]\n\
         type = 'constant'\nmodulus = 0.9\nangle = 3.0\n[[element]]\ntype = 'flame'\nat = 0.3\ngain = 0.6\n\
         delay = 1e-3\n{flame}\n[[element]]\ntype = 'duct'\nlength = 1.0\ndiameter = 0.05\nsound_speed = {C}\n\
         density = {RHO}\n"
    )
}

fn modes(text: &str) -> Vec<C64> {
    let built = read(text).unwrap();
    let region = built.region;
    built.modes(&region).unwrap().modes.iter().map(|m| m.s).collect()
}

/// g - R f at the outlet by Runge and Kutta through heat of this density (over 0.3 to 0.5 m, integral 1) and
/// delay, in answer to the velocity at 0.2 m.
fn by_integration(s: C64, density: &dyn Fn(f64) -> f64, delay: &dyn Fn(f64) -> f64) -> C64 {
    let wave = |x: f64| [(s * x / C).cosh(), -(s * x / C).sinh() / (RHO * C)];
    let heard = wave(0.2)[1];
    let slope = |x: f64, [p, u]: [C64; 2]| {
        let released = 0.6 * density(x) * (-s * delay(x)).exp() * heard;
        [-s * RHO * u, released - s * p / (RHO * C * C)]
    };
    let (mut state, n) = (wave(0.3), 4000);
    let h = 0.2 / f64::from(n);
    let step = |a: [C64; 2], b: [C64; 2], f: f64| [a[0] + f * b[0], a[1] + f * b[1]];
    for k in 0..n {
        let x = 0.3 + h * f64::from(k);
        let k1 = slope(x, state);
        let k2 = slope(x + 0.5 * h, step(state, k1, 0.5 * h));
        let k3 = slope(x + 0.5 * h, step(state, k2, 0.5 * h));
        let k4 = slope(x + h, step(state, k3, h));
        for (part, f) in [(k1, 1.0), (k2, 2.0), (k3, 2.0), (k4, 1.0)] {
            state = step(state, part, f * h / 6.0);
        }
    }
    let [p, u] = state;
    let (f, g) = (0.5 * (p + RHO * C * u), 0.5 * (p - RHO * C * u));
    g * (s * 0.5 / C).exp() - C64::from_polar(0.9, 3.0) * f * (-s * 0.5 / C).exp()
}

/// The zero near `s`.
fn root(f: &dyn Fn(C64) -> C64, mut s: C64) -> C64 {
    for _ in 0..8 {
        s -= f(s) * 2e-2 / (f(s + 1e-2) - f(s - 1e-2));
    }
    s
}

#[test]
fn oracle_spread_flames_against_integration() {
    let late = |x: f64| 1e-3 + (x - 0.3) / 0.2 * 3e-3;
    let even = |_: f64| 5.0;
    let tent = |x: f64| 50.0 * (0.1 - (x - 0.4).abs()) * 2.0;
    for (density, given) in [(&even as &dyn Fn(f64) -> f64, ""), (&tent, "density = [0, 1, 0]")] {
        let text = |pieces: usize| {
            tube(&format!("length = 0.2\ndelay_end = 4e-3\nreference = 0.1\npieces = {pieces}\n{given}"))
        };
        let exact: Vec<C64> =
            modes(&text(40)).iter().map(|s| root(&|s| by_integration(s, density, &late), *s)).collect();
        assert!(exact.len() >= 3);
        let gaps = |pieces: usize| -> Vec<f64> {
            modes(&text(pieces)).iter().zip(&exact).map(|(a, b)| (a - b).norm()).collect()
        };
        for (coarse, fine) in gaps(20).iter().zip(&gaps(40)) {
            let order = (coarse / fine).log2();
            assert!((order - 2.0).abs() < 0.1 && *fine < 0.5, "order {order} from {coarse}");
        }
    }
}

#[test]
fn order_short_flames_tend_to_the_compact_one() {
    let compact = modes(&tube("reference = 0.1"));
    for (k, exact) in compact.iter().enumerate() {
        // All of it moves by half the length.
        let gap = |length: f64| {
            (modes(&tube(&format!("reference = 0.1\nlength = {length}\npieces = 10")))[k] - exact).norm()
        };
        slopes_near(&slopes_from(2e-3, gap), 1.0, 0.05);
    }
    let here = (modes(&tube(""))[0] - modes(&tube("length = 1e-6"))[0]).norm();
    assert!(here < 1e-2, "{here}");
}

#[test]
fn order_spread_flames_in_slow_flow_tend_to_those_at_rest() {
    // At rest one step of pressure and velocity stands for all; with flow every piece acts where it is, and
    // the velocity passes those before it. The area grows and the gas is heated along the flame.
    for (reference, heat) in [(0.0, "n = 0.6"), (0.12, "n = 0.6"), (0.12, "gain = 0.5\ncutoff_hz = 300")] {
        let text = format!(
            "[search]\nfrequency_hz = [20, 700]\ngrowth_rate = [-150, 250]\n[upstream]\ntype = 'closed'\n[downstream]\n\
             type = 'constant'\nmodulus = 0.9\nangle = 3.0\n[[element]]\ntype = 'duct'\nlength = 0.3\ndiameter = 0.05\n\
             wall = 'kirchhoff'\n[[element]]\ntype = 'flame'\n{heat}\ndelay = 1e-3\ndelay_end = 2e-3\nlength = 0.2\n\
             pieces = 8\nreference = {reference}\n[[element]]\ntype = 'duct'\nlength = 0.2\ndiameter = 0.05\n\
             diameter_end = 0.06\ntemperature_end = 900\npieces = 400\n[[element]]\ntype = 'duct'\nlength = 0.4\n\
             diameter = 0.06\ntemperature = 900\n"
        );
        let rest = modes(&text);
        let gap = |mach: f64| {
            let flow = modes(&format!("{text}[flow]\nmach = {mach}\nentropy_waves = false\n"));
            assert_eq!(flow.len(), rest.len());
            flow.iter().zip(&rest).map(|(a, b)| (a - b).norm()).collect::<Vec<_>>()
        };
        for (one, half) in gap(2e-4).iter().zip(&gap(1e-4)) {
            let order = (one / half).log2();
            assert!((order - 1.0).abs() < 0.05, "{heat} {reference}: order {order} from {one}");
        }
    }
}

/// Two to forty coefficients answer to one velocity with one transfer function: its poles are poles of F
/// once. Before, the modes of such files were not certified.
#[test]
fn exact_a_resonance_of_a_spread_flame_is_one_pole() {
    let resonance = "numerator = [1.58e6]\ndenominator = [1.58e6, 100, 1]";
    for flow in ["", "[flow]\nmach = 0.01\nentropy_waves = false\n"] {
        for reference in [0.0, 0.1] {
            let of = |length: &str| {
                modes(&format!("{}{flow}", tube(&format!("{resonance}\nreference = {reference}\n{length}"))))
            };
            let (compact, spread) = (of(""), of("length = 1e-3\npieces = 4"));
            assert!(compact.len() >= 5 && spread.len() == compact.len(), "{flow} {reference}");
            for (a, b) in compact.iter().zip(&spread) {
                assert!((a - b).norm() < 6.0, "{flow} {reference}: {a} {b}");
            }
        }
    }
    // So are those of a pair of coefficients of one place.
    let pair = "eu = { gain = -0.5, delay = 1e-3, numerator = [1.58e6], denominator = [1.58e6, 100, 1] }\n\
                mu = { gain = 20, numerator = [1.58e6], denominator = [1.58e6, 100, 1] }";
    let text =
        tube("").replace("type = 'flame'", "type = 'feedback'").replace("gain = 0.6\ndelay = 1e-3\n", pair);
    assert!(modes(&text).len() >= 5);
}

#[test]
fn behaviour_spread_flames_that_cannot_be_are_refused() {
    let orifice = "length = 0.2\n[[element]]\ntype = 'orifice'\ndiameter = 0.03\nthickness = 0.002\nat = 0.4";
    for (keys, said) in [
        ("delay_end = 2e-3", "give delay_end and length together"),
        ("density = [1, 2]", "give density and length together"),
        ("length = 0", "length is 0, but must be positive and finite"),
        ("length = 0.8", "it lies at 1.1 m, but the tube reaches from 0 to 1 m"),
        ("length = 0.2\ndensity = [1, -1]", "density is -1, but must be zero or more, and finite"),
        ("length = 0.2\ndensity = []", "the sum of density is 0, but must be positive and finite"),
        ("length = 0.2\npieces = 0", "pieces is 0, but must be from 1 to 1000"),
        (
            "length = 0.2\nreference_side = 'downstream'",
            "a flame with `length` answers to a velocity upstream: leave `reference_side` out",
        ),
        (orifice, "element 2 (orifice) lies inside the flame, which ends at 0.5 m: only ducts may"),
    ] {
        let found = read(&tube(keys)).unwrap_err().to_string();
        assert_eq!(found, format!("line 10: element 1 (flame): {said}"));
    }
}
