//! A slope of temperature in a mean flow whose entropy waves a choked outlet hears, against the linearised
//! Euler equations.

use rijke_network::file::read;
use rijke_numerics::C64;

const GAMMA: f64 = 1.4;
const CONSTANT: f64 = 287.05;
const INLET: f64 = 0.03;
const PARTS: [f64; 3] = [0.3, 0.6, 0.3];
const KELVIN: [f64; 2] = [300.0, 1800.0];

fn tube(more: &str) -> String {
    let duct = |length: f64, rest: &str| {
        format!("[[element]]\ntype = 'duct'\nlength = {length}\ndiameter = 0.05\n{rest}\n")
    };
    let [cold, hot] = KELVIN;
    format!(
        "[gas]\ntemperature = {cold}\n[search]\ngrowth_rate = [-60, 200]\nfrequency_hz = [10, 700]\n[flow]\nmach = {INLET}\n\
         [upstream]\ntype = 'constant'\nmodulus = 1\nangle = 0\n[downstream]\ntype = 'choked'\n{}{}{}",
        duct(PARTS[0], &format!("temperature = {cold}")),
        duct(PARTS[1], &format!("temperature = {cold}\ntemperature_end = {hot}\n{more}")),
        duct(PARTS[2], &format!("temperature = {hot}"))
    )
}

/// Pressure, density and velocity where the gas has this temperature: mass and momentum are conserved.
fn state(kelvin: f64) -> [f64; 3] {
    let p0 = 101_325.0;
    let rho0 = p0 / (CONSTANT * KELVIN[0]);
    let u0 = INLET * (GAMMA * CONSTANT * KELVIN[0]).sqrt();
    let (mass, momentum) = (rho0 * u0, p0 + rho0 * u0 * u0);
    // p + mass U = momentum and p = rho R T, rho = mass/U.
    let u = (momentum - (momentum * momentum - 4.0 * mass * mass * CONSTANT * kelvin).sqrt()) / (2.0 * mass);
    [momentum - mass * u, mass / u, u]
}

/// Rows of the fluxes of mass, momentum and energy, and of what is stored, per p', u' and rho'.
fn matrices([p, rho, u]: [f64; 3]) -> [[[f64; 3]; 3]; 2] {
    let g = GAMMA / (GAMMA - 1.0);
    let flux =
        [[0.0, rho, u], [1.0, 2.0 * rho * u, u * u], [g * u, g * p + 1.5 * rho * u * u, 0.5 * u * u * u]];
    let stored = [[0.0, 0.0, 1.0], [0.0, rho, u], [1.0 / (GAMMA - 1.0), rho * u, 0.5 * u * u]];
    [flux, stored]
}

/// x with `a` x = `b`, by Cramer's rule.
fn solve(a: &[[f64; 3]; 3], b: [C64; 3]) -> [C64; 3] {
    let minor = |i: usize, j: usize| {
        let (r, c) = ([(i + 1) % 3, (i + 2) % 3], [(j + 1) % 3, (j + 2) % 3]);
        a[r[0]][c[0]] * a[r[1]][c[1]] - a[r[0]][c[1]] * a[r[1]][c[0]]
    };
    let determinant: f64 = (0..3).map(|j| a[0][j] * minor(0, j)).sum();
    [0, 1, 2].map(|j| (0..3).map(|i| b[i] * minor(i, j)).sum::<C64>() / determinant)
}

fn times(a: &[[f64; 3]; 3], x: [C64; 3]) -> [C64; 3] {
    a.map(|row| row.iter().zip(x).map(|(a, x)| x * *a).sum())
}

/// What is zero at a mode: M' at the outlet, for a wall upstream through which no entropy comes. Runge and
/// Kutta's steps of the fluxes along the tube.
fn outlet(s: C64) -> C64 {
    const STEPS: usize = 4000;
    let length: f64 = PARTS.iter().sum();
    let kelvin = |x: f64| KELVIN[0] + ((x - PARTS[0]) / PARTS[1]).clamp(0.0, 1.0) * (KELVIN[1] - KELVIN[0]);
    let slope = |x: f64, flux: [C64; 3]| {
        let [of_flux, stored] = matrices(state(kelvin(x)));
        times(&stored, solve(&of_flux, flux)).map(|v| -s * v)
    };
    let first = state(kelvin(0.0));
    let start = [C64::ONE, C64::ZERO, C64::ONE * first[1] / (GAMMA * first[0])];
    let mut flux = times(&matrices(first)[0], start);
    let h = length / STEPS as f64;
    for k in 0..STEPS {
        let x = k as f64 * h;
        let add = |by: f64, d: [C64; 3]| [0, 1, 2].map(|i| flux[i] + d[i] * by);
        let a = slope(x, flux);
        let b = slope(x + 0.5 * h, add(0.5 * h, a));
        let c = slope(x + 0.5 * h, add(0.5 * h, b));
        let d = slope(x + h, add(h, c));
        flux = [0, 1, 2].map(|i| flux[i] + (a[i] + (b[i] + c[i]) * 2.0 + d[i]) * (h / 6.0));
    }
    let last = state(kelvin(length));
    let [p, u, rho] = solve(&matrices(last)[0], flux);
    u / last[2] - 0.5 * (p / last[0] - rho / last[1])
}

fn modes(more: &str) -> (Vec<C64>, usize) {
    let built = read(&tube(more)).unwrap();
    let found = built.modes(&built.region).unwrap().modes.iter().map(|m| m.s).collect();
    (found, built.warnings.len())
}

#[test]
fn oracle_a_steep_slope_in_flow_has_the_modes_of_the_euler_equations() {
    // In 40 pieces there were 5 modes; that at 217.4 Hz had -3.1 for +4.9 1/s.
    let (found, warnings) = modes("");
    assert_eq!((found.len(), warnings), (7, 0));
    for s in found {
        let h = 1e-3;
        let off = outlet(s) * (2.0 * h) / (outlet(s + h) - outlet(s - h));
        assert!(off.norm() < 0.3, "{s}: {off}");
    }
}

#[test]
fn message_a_slope_in_too_few_pieces_is_said() {
    let built = read(&tube("pieces = 40")).unwrap();
    let [said] = &built.warnings[..] else { panic!("{:?}", built.warnings) };
    let said = said.to_string();
    assert!(
        said.contains("in 40 pieces the entropy waves of this slope") && said.contains("write pieces = "),
        "{said}"
    );
    let still = tube("pieces = 40").replace("mach = 0.03", "mach = 0.03\nentropy_waves = false");
    assert!(read(&still).unwrap().warnings.is_empty());
}

#[test]
fn behaviour_the_condition_of_a_long_staircase_is_that_of_a_short_one() {
    // Of 320 pieces every third stands for its neighbours; of 140 all count.
    let condition = |pieces: usize| {
        let built = read(&tube(&format!("pieces = {pieces}"))).unwrap();
        let modes = built.modes(&built.region).unwrap().modes;
        let mode = modes.iter().find(|m| (m.s.im / std::f64::consts::TAU - 217.4).abs() < 2.0).unwrap();
        built.account(mode).unwrap().condition
    };
    let [short, long] = [140, 320].map(condition);
    assert!((long / short - 1.0).abs() < 0.1 && short > 1.0, "{short} {long}");
}
