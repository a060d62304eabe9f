//! Closed forms that the model must reproduce in its limits.

use super::closures::Closures;
use super::draught::Draught;
use super::march::{Drive, Flow, March};
use super::parameters::{TubeParameters, Unknowns};
use super::pipe::Pipe;
use super::transient::Transient;
use crate::TubeRig;
use approx::assert_relative_eq;
use std::f64::consts::PI;

const AMBIENT: f64 = 293.15;

fn rig() -> TubeRig {
    TubeRig::juniper_yoko_2022()
}

/// No heat exchange anywhere unless a test switches it on.
fn insulated() -> (Closures, TubeParameters) {
    let closures = Closures { wire_share: 0.0, emissivity: 0.0, ..Closures::default() };
    let parameters = TubeParameters {
        outer_nusselt: 0.0,
        inner_nusselt: 0.0,
        jet_enhancement: 0.0,
        wall_share: 0.0,
        mount_resistance: 1e30,
        ..TubeParameters::default()
    };
    (closures, parameters)
}

fn unknowns(p: &TubeParameters) -> Unknowns {
    Unknowns {
        parameters: *p,
        power_factor: 1.0,
        ambient_offset: 0.0,
        heater_lag: 35.0,
        orifice_length: 0.05,
    }
}

#[test]
fn exact_gas_relaxes_exponentially_to_an_isothermal_wall() {
    // 1 - theta(x) = 1 - exp(-pi k x Nu_m(x)/(m c_p)), Hausen's mean Nusselt number.
    let nusselt = |gz: f64| 3.66 + 0.0668 * gz / (1.0 + 0.04 * gz.powf(2.0 / 3.0));
    let air = rig().gas.at(AMBIENT, rig().pressure);
    let approach = |m: f64, x: f64, k: f64| {
        let gz = 4.0 * m * air.specific_heat / (PI * k * x);
        1.0 - (-PI * k * x * nusselt(gz) / (m * air.specific_heat)).exp()
    };
    // The two numbers of the acceptance list, at L = 1 m, k(293.65 K).
    let k = rig().gas.at(293.65, rig().pressure).conductivity;
    assert_relative_eq!(approach(2e-4, 1.0, k), 0.81749, epsilon = 5e-6);
    assert_relative_eq!(approach(1e-3, 1.0, k), 0.37411, epsilon = 5e-6);
    // The march on its coarse grid, up to the heater (above it the boundary layer restarts). A wall only 1 mK
    // warmer keeps the properties constant; any grid is then exact.
    let p = TubeParameters { inner_nusselt: 1.0, jet_enhancement: 0.0, ..TubeParameters::default() };
    for refinement in [1, 4] {
        let pipe = Pipe::new(&rig(), &Closures::default(), 0.98, refinement).unwrap();
        let wall = vec![AMBIENT + 1e-3; pipe.size()];
        let heater = pipe.faces().iter().position(|&x| x == 0.98).unwrap();
        for m in [2e-4, 1e-3] {
            let mut march = March::default();
            pipe.march(&wall, Drive { released: 0.0, ambient: AMBIENT }, Flow::new(m), &p, &mut march);
            let expected = approach(m, 0.98, air.conductivity);
            assert_relative_eq!((march.face[heater] - AMBIENT) * 1e3, expected, max_relative = 2e-6);
        }
    }
}

#[test]
fn order_wall_follows_the_fin_equation() {
    // 10 W over the heater's length, a uniform sink of 8 W/m^2K (mounts as long as the tube), insulated ends:
    // theta(x) = q0 [sinh(mf x2) - sinh(mf x1)] cosh(mf (L - x))/(mf kA mf sinh(mf L)) beyond the source.
    let (closures, p) = insulated();
    let (closures, sink) =
        (Closures { mounts: [0.5, 0.5], mount_length: 1.0, ..closures }, 8.0 * PI * 0.0508);
    let p = TubeParameters { wall_share: 1.0, mount_resistance: 2.0 / sink, ..p };
    let error = |refinement: u32| {
        let pipe = Pipe::new(&rig(), &closures, 0.25, refinement).unwrap();
        let conduction = closures.wall_conductivity * pipe.wall_area;
        let mf = (sink / conduction).sqrt();
        assert_relative_eq!(1.0 / mf, 0.05733, epsilon = 1e-5);
        let implicit = pipe.implicit(60.0);
        let mut state = Transient::cold(&pipe, &unknowns(&p), AMBIENT).unwrap();
        for _ in 0..400 {
            state.step(&pipe, &implicit, &unknowns(&p), 10.0, AMBIENT, 1e-8).unwrap();
        }
        let theta = |x: f64| {
            let source = (mf * 0.2575).sinh() - (mf * 0.2425).sinh();
            10.0 / 0.015 * source * (mf * (1.0 - x)).cosh() / (mf * conduction * mf * mf.sinh())
        };
        assert_relative_eq!(theta(0.5525), 0.35003, epsilon = 5e-6);
        let worst = |(i, f): (usize, &[f64])| {
            let x = 0.5 * (f[0] + f[1]);
            if x < 0.26 { 0.0 } else { (state.wall[i] - AMBIENT - theta(x)).abs() }
        };
        pipe.faces().windows(2).enumerate().map(worst).fold(0.0, f64::max)
    };
    let errors = [error(2), error(4), error(8)];
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((order - 2.0).abs() < 0.1, "{errors:?}");
    }
}

#[test]
fn exact_adiabatic_chimney() {
    // All power into the gas over a short heater, bare tube: one scalar equation for the mass flow.
    // The wall loses to the room, so that it has a temperature at all; it gains nothing.
    let (closures, p) = insulated();
    let p = TubeParameters { outer_nusselt: 1.0, ..p };
    let mut rig = rig();
    rig.plates.plate_thickness = 1e-5;
    rig.plates.plate_gap = 1e-5;
    rig.insert.rods = 0;
    rig.insert.wires = 0;
    let (gas, pressure, d) = (rig.gas.clone(), rig.pressure, rig.tube.inner_diameter);
    let area = rig.tube.area();
    let printed = [(7.0, 0.25, 4.858_08e-4), (180.0, 0.25, 1.208_419e-3), (180.0, 0.85, 5.931_358e-4)];
    for (power, x, expected) in printed {
        let hot = |m: f64, share: f64| {
            // m (h(T) - h(T_a)) = Q by bisection, with the heat capacity integrated by Simpson's rule.
            let rise = |t: f64| {
                let cp = |t: f64| gas.at(t, pressure).specific_heat;
                (t - AMBIENT) / 6.0 * (cp(AMBIENT) + 4.0 * cp(0.5 * (t + AMBIENT)) + cp(t))
            };
            bisect(AMBIENT, 2000.0, |t| m * rise(t) - share * power)
        };
        let excess = |m: f64, simpson: bool| {
            let middle = gas.at(hot(m, 0.5), pressure);
            let (cold, hot) = (gas.at(AMBIENT, pressure), gas.at(hot(m, 1.0), pressure));
            let (v0, v1) = (1.0 / cold.density, 1.0 / hot.density);
            // Mean specific volume in the heater: of the two sides, or over uniformly rising enthalpy.
            let within = if simpson { (v0 + 4.0 / middle.density + v1) / 6.0 } else { 0.5 * (v0 + v1) };
            let g2 = (m / area).powi(2);
            let friction =
                32.0 * m / area / (d * d) * (x * cold.viscosity * v0 + (1.0 - x) * hot.viscosity * v1);
            g2 * (v1 - v0) + 2.85 * g2 * v0 / 2.0 + 8.0 * g2 * within / 2.0 + friction
                - 9.81 * (1.0 - x) * (cold.density - hot.density)
        };
        assert_relative_eq!(bisect(1e-5, 5e-3, |m| excess(m, false)), expected, max_relative = 2e-6);
        let root = bisect(1e-5, 5e-3, |m| excess(m, true));
        // The specific heat is taken at the mean of each cell: second order in the rise per cell.
        for (refinement, tolerance) in [(1, 3e-4), (8, 2e-5)] {
            let pipe = Pipe::new(&rig, &closures, x, refinement).unwrap();
            let steady = pipe.steady(&p, power, AMBIENT).unwrap();
            assert_relative_eq!(steady.gas.mass_flow, root, max_relative = tolerance);
        }
    }
}

fn bisect(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if f(middle) < 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[test]
fn exact_wall_cools_to_the_room_at_the_lumped_rate() {
    // d ln(theta)/dt = -pi D_o (h_o + 4 eps sigma T^3)/C_w at theta = 0.5 K; printed in the acceptance list:
    // -5.39e-4 1/s.
    let (closures, p) = insulated();
    let closures = Closures { emissivity: 0.30, ..closures };
    let p = TubeParameters { outer_nusselt: 1.0, ..p };
    let pipe = Pipe::new(&rig(), &closures, 0.25, 1).unwrap();
    let wall = vec![AMBIENT + 0.5; pipe.size()];
    let (mut gas, mut heat) = (Draught::empty(), Vec::new());
    let drive = Drive { released: 0.0, ambient: AMBIENT };
    pipe.draught(&wall, drive, &p, 1e-9, &mut gas).unwrap();
    pipe.wall_heat(&wall, drive, &p, &gas, &mut heat);
    let rate = heat.iter().sum::<f64>() / (pipe.wall_capacity() * pipe.length) / 0.5;
    let h = pipe.outside.coefficient(&pipe.air, AMBIENT + 0.5, AMBIENT);
    let t: f64 = AMBIENT + 0.25;
    let lumped = -PI * 0.0508 * (h + 4.0 * 0.30 * 5.670_374_419e-8 * t.powi(3)) / 1036.0;
    assert_relative_eq!(rate, lumped, max_relative = 1e-3);
    assert_relative_eq!(rate, -5.39e-4, max_relative = 2e-3);
}

#[test]
fn exact_conduction_through_the_mounts() {
    // 10 W at mid-height leave through two equal mounts: 5 W each, a straight profile between heater and
    // mount, and a mean temperature of 5 W R_m at the mount.
    let (closures, p) = insulated();
    let p = TubeParameters { wall_share: 1.0, mount_resistance: 3.0, ..p };
    let pipe = Pipe::new(&rig(), &closures, 0.5, 1).unwrap();
    let implicit = pipe.implicit(100.0);
    let mut state = Transient::cold(&pipe, &unknowns(&p), AMBIENT).unwrap();
    for _ in 0..6_000 {
        state.step(&pipe, &implicit, &unknowns(&p), 10.0, AMBIENT, 1e-8).unwrap();
    }
    let at_mounts: f64 =
        pipe.cells.iter().zip(&state.wall).map(|(c, w)| c.mount * (w - AMBIENT)).sum::<f64>() / 2.0;
    assert_relative_eq!(at_mounts, 5.0 * 3.0, max_relative = 1e-6);
    let centre = |i: usize| 0.5 * (pipe.faces[i] + pipe.faces[i + 1]);
    // The split between the sides is 5 W each up to the grid; their sum is exact.
    let slope = |from: f64, to: f64| {
        let cells: Vec<usize> = (0..pipe.size()).filter(|&i| centre(i) > from && centre(i) < to).collect();
        let (a, b) = (cells[0], cells[cells.len() - 1]);
        (state.wall[b] - state.wall[a]) / (centre(b) - centre(a))
    };
    let (below, above) = (slope(0.12, 0.48), slope(0.52, 0.88));
    assert_relative_eq!(below - above, 10.0 / (16.0 * pipe.wall_area), max_relative = 1e-6);
    assert_relative_eq!(below, -above, max_relative = 1e-2);
}

#[test]
fn exact_without_heating_nothing_moves() {
    let closures = Closures { pulse_frequency: f64::INFINITY, ..Closures::default() };
    let pipe = Pipe::new(&rig(), &closures, 0.25, 1).unwrap();
    let p = TubeParameters::default();
    let steady = pipe.steady(&p, 0.0, AMBIENT).unwrap();
    assert_eq!(steady.gas.mass_flow, 0.0);
    assert!(steady.gas.march.face.iter().chain(&steady.wall).all(|&t| t == AMBIENT));
    let mut state = Transient::cold(&pipe, &unknowns(&p), AMBIENT).unwrap();
    state.step(&pipe, &pipe.implicit(15.0), &unknowns(&p), 0.0, AMBIENT, 1e-8).unwrap();
    assert!(state.wall.iter().all(|&t| (t - AMBIENT).abs() < 1e-12));
    let mut times = Vec::new();
    pipe.arrival_times(&steady.gas, 0.0, &mut times);
    let c = rig().gas.at(AMBIENT, rig().pressure).sound_speed;
    for (t, x) in times.iter().zip(pipe.microphones()) {
        assert_relative_eq!(*t, x / c, max_relative = 1e-12);
    }
    assert_relative_eq!(times[7], 2.767_067e-3, max_relative = 2e-7);
}

#[test]
fn exact_walls_and_orifices_delay_a_click() {
    // Kirchhoff's retardation of a pulse of 1 kHz in a tube of radius a = 23.7 mm, sqrt(nu/(2 omega))/a (1 +
    // (gamma - 1)/sqrt(Pr)), of air at 20 C by handbooks; orifices as long as L delay by L/(2c) beyond them.
    let (viscosity, ratio, prandtl): (f64, f64, f64) = (1.506e-5, 1.4, 0.71);
    let layer = (viscosity / (4000.0 * PI)).sqrt() / 0.0237 * (1.0 + (ratio - 1.0) / prandtl.sqrt());
    let speed = rig().gas.at(AMBIENT, rig().pressure).sound_speed;
    let pipe = Pipe::new(&rig(), &Closures::default(), 0.25, 1).unwrap();
    let gas = pipe.steady(&TubeParameters::default(), 0.0, AMBIENT).unwrap().gas;
    let [mut plain, mut late] = [Vec::new(), Vec::new()];
    pipe.arrival_times(&gas, 0.0, &mut plain);
    pipe.arrival_times(&gas, 0.08, &mut late);
    for (x, (t, late)) in pipe.microphones().zip(plain.into_iter().zip(late)) {
        assert_relative_eq!(t * speed / x - 1.0, layer, max_relative = 0.02);
        let beyond = if x > 0.25 { 0.08 / (2.0 * speed) } else { 0.0 };
        assert_relative_eq!(late - t, beyond, epsilon = 1e-7);
    }
}

#[test]
fn exact_cold_walls_turn_the_flow_round() {
    let pipe = Pipe::new(&rig(), &Closures::default(), 0.25, 1).unwrap();
    let mut gas = Draught::empty();
    let drive = Drive { released: 0.0, ambient: AMBIENT };
    for (offset, sign) in [(-3.0, -1.0), (3.0, 1.0)] {
        let wall = vec![AMBIENT + offset; pipe.size()];
        pipe.draught(&wall, drive, &TubeParameters::default(), 1e-9, &mut gas).unwrap();
        assert!(gas.mass_flow * sign > 1e-5, "{}", gas.mass_flow);
        let balance = pipe.balance(&gas.march, Flow::new(gas.mass_flow), AMBIENT, &TubeParameters::default());
        assert!((balance.buoyancy / balance.losses).ln().abs() < 1e-6);
    }
}
