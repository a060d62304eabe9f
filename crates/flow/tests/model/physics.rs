//! Shapes and sizes that physics and the paper's Fig. 2 ask for.

#![allow(clippy::print_stdout, reason = "the tables are recorded in docs/records/flow.md")]

use super::{AMBIENT, pipe, unknowns};
use rijke_flow::{Transient, TubeParameters};

const POWERS: [f64; 7] = [7.0, 15.0, 30.0, 50.0, 80.0, 130.0, 180.0];

/// U_h (m/s) and hottest gas (K) of an independent prototype at the defaults: rows of heater position, pairs
/// by power.
const PROTOTYPE: [(f64, [(f64, f64); 7]); 5] = [
    (
        0.15,
        [
            (0.207, 307.0),
            (0.273, 316.0),
            (0.346, 330.0),
            (0.407, 346.0),
            (0.469, 366.0),
            (0.535, 398.0),
            (0.579, 428.0),
        ],
    ),
    (
        0.25,
        [
            (0.201, 308.0),
            (0.264, 317.0),
            (0.333, 332.0),
            (0.392, 348.0),
            (0.450, 370.0),
            (0.512, 403.0),
            (0.554, 434.0),
        ],
    ),
    (
        0.45,
        [
            (0.181, 309.0),
            (0.238, 320.0),
            (0.300, 336.0),
            (0.351, 354.0),
            (0.402, 379.0),
            (0.456, 416.0),
            (0.491, 452.0),
        ],
    ),
    (
        0.65,
        [
            (0.155, 312.0),
            (0.203, 324.0),
            (0.256, 343.0),
            (0.299, 365.0),
            (0.340, 394.0),
            (0.384, 439.0),
            (0.411, 483.0),
        ],
    ),
    (
        0.85,
        [
            (0.114, 318.0),
            (0.149, 335.0),
            (0.187, 360.0),
            (0.217, 390.0),
            (0.246, 431.0),
            (0.274, 496.0),
            (0.291, 560.0),
        ],
    ),
];

#[test]
fn oracle_steady_states_of_an_independent_prototype() {
    for (heater, row) in PROTOTYPE {
        let pipe = pipe(heater, 1);
        for (power, (velocity, hottest)) in POWERS.iter().zip(row) {
            let steady = pipe.steady(&TubeParameters::default(), *power, AMBIENT).unwrap();
            let t = steady.gas.march.face.iter().copied().fold(0.0, f64::max);
            let u = pipe.heater_velocity(&steady.gas);
            assert!((u / velocity - 1.0).abs() < 0.006, "{heater} m, {power} W: {u} against {velocity}");
            assert!(
                (t - hottest).abs() < 0.01 * (hottest - AMBIENT).max(100.0),
                "{heater} m, {power} W: {t} against {hottest}"
            );
        }
    }
}

#[test]
fn paper_velocity_falls_with_position_and_rises_with_power() {
    let positions: Vec<f64> = (1..18).map(|k| 0.05 * f64::from(k)).collect();
    let mut below = [f64::INFINITY; 7];
    let mut jump_below = 0.0;
    for x in positions {
        let pipe = pipe(x, 1);
        let mut last = 0.0;
        for (k, &power) in POWERS.iter().enumerate() {
            let steady = pipe.steady(&TubeParameters::default(), power, AMBIENT).unwrap();
            let u = pipe.heater_velocity(&steady.gas);
            assert!(u > last && (u < below[k] || x < 0.16) && u > 0.05 && u < 0.65, "{x} m, {power} W: {u}");
            (last, below[k]) = (u, u);
            if k == 6 {
                let jump = steady.gas.march.face.iter().copied().fold(0.0, f64::max) - AMBIENT;
                // The mount at 0.10 m cools a heater that sits on it.
                assert!(jump > jump_below || x < 0.16, "{x}: {jump}");
                jump_below = jump;
            }
        }
    }
}

#[test]
fn paper_settling_takes_about_a_thousand_seconds() {
    println!(
        "| heater | U_h at 7 to 180 W, m/s | gas above the room, 180 W | U_h within 1 % for good, 7 to 180 W, s |"
    );
    println!("|---|---|---|---|");
    let mut longest = 0;
    for x in [0.15, 0.25, 0.45, 0.65, 0.75, 0.85] {
        let pipe = pipe(x, 1);
        let (u, implicit) = (unknowns(), pipe.implicit(15.0));
        let (mut velocities, mut times, mut jump) = (Vec::new(), Vec::new(), 0.0);
        for power in POWERS {
            let steady = pipe.steady(&u.parameters, power, AMBIENT).unwrap();
            let end = pipe.heater_velocity(&steady.gas);
            let mut state = Transient::cold(&pipe, &u, AMBIENT).unwrap();
            let mut last = 0;
            for k in 1..=400 {
                state.step(&pipe, &implicit, &u, power, AMBIENT, 1e-8).unwrap();
                if (pipe.heater_velocity(&state.gas) / end - 1.0).abs() > 0.01 {
                    last = 15 * k;
                }
            }
            assert!(last < 6000, "{x} m, {power} W");
            times.push(last + 15);
            velocities.push(format!("{end:.3}"));
            jump = steady.gas.march.face.iter().copied().fold(0.0, f64::max) - AMBIENT;
            longest = longest.max(last + 15);
        }
        println!("| {x} m | {} | {jump:.0} K | {times:?} |", velocities.join(", "));
    }
    assert!(longest < 2000, "{longest} s");
}

#[test]
fn oracle_transient_ends_at_newtons_steady_state() {
    let pipe = pipe(0.45, 1);
    let u = unknowns();
    let (mut state, implicit) = (Transient::cold(&pipe, &u, AMBIENT).unwrap(), pipe.implicit(15.0));
    let steady = pipe.steady(&u.parameters, 80.0, AMBIENT).unwrap();
    let distance = |state: &Transient<f64>| {
        (pipe.heater_velocity(&state.gas) / pipe.heater_velocity(&steady.gas) - 1.0).abs()
    };
    let mut within = None;
    for k in 0..2000 {
        state.step(&pipe, &implicit, &u, 80.0, AMBIENT, 1e-10).unwrap();
        if within.is_none() && distance(&state) < 0.01 {
            within = Some(15 * k);
        }
    }
    assert!(distance(&state) < 1e-8, "{}", distance(&state));
    // The paper's rig is steady within about 1000 s.
    assert!(within.is_some_and(|t| t < 1000), "within 1 % after {within:?} s");
}
