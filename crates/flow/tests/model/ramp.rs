//! Runs over time against the settled states that they end in, and against finer steps.

use super::{AMBIENT, pipe, unknowns};
use rijke_flow::{Logged, Ramp};

/// Power from each time on.
fn ramp(log: &[(f64, f64)]) -> Ramp {
    let log = log.iter().map(|&(time, power)| Logged { time, power, point: None }).collect();
    Ramp { id: "a".into(), log }
}

#[test]
fn exact_a_long_hold_ends_in_the_settled_state() {
    for heater in [0.15, 0.25, 0.75] {
        let (pipe, known) = (pipe(heater, 1), unknowns());
        for power in [7.0, 180.0] {
            let ramp = ramp(&[(-300.0, 0.0), (0.0, 60.0), (900.0, power)]);
            let found = pipe.gas_along(&ramp, &known, AMBIENT, &[86_400.0], 15.0).unwrap();
            let settled = pipe.steady(&known.parameters, power, AMBIENT).unwrap().gas;
            let (found, exact) = (pipe.base_state(&found[0]), pipe.base_state(&settled));
            assert!(
                (found.heater_velocity / exact.heater_velocity - 1.0).abs() < 1e-8,
                "{heater} m, {power} W"
            );
            for (a, b) in found.temperature.iter().zip(&exact.temperature) {
                assert!((a - b).abs() < 1e-6, "{heater} m, {power} W: {a} {b} K");
            }
        }
    }
}

#[test]
fn order_second_in_the_step_of_a_run() {
    // Three minutes after the second of two steps of power, and thirteen: temperature above the heater and at
    // the top, and velocity.
    let (pipe, known) = (pipe(0.25, 1), unknowns());
    let ramp = ramp(&[(0.0, 30.0), (400.0, 30.0), (610.0, 180.0)]);
    let at = |step: f64| {
        let gas = pipe.gas_along(&ramp, &known, AMBIENT, &[790.0, 1400.0], step).unwrap();
        let of = |gas| {
            let base = pipe.base_state(gas);
            [base.temperature(0.4), base.temperature(0.95), 1e3 * base.heater_velocity]
        };
        gas.iter().flat_map(of).collect::<Vec<f64>>()
    };
    let runs = [at(15.0), at(7.5), at(3.75), at(1.875)];
    for k in 0..6 {
        let order = ((runs[1][k] - runs[2][k]) / (runs[2][k] - runs[3][k])).abs().log2();
        assert!((1.8..2.2).contains(&order), "quantity {k}: order {order} of {runs:?}");
        assert!((runs[0][k] - runs[3][k]).abs() < 0.1, "quantity {k} of {runs:?}");
    }
}

#[test]
fn exact_moments_do_not_move_the_run() {
    // Steps end at moments; what a step more changes is its error alone, and a row that repeats the power
    // changes nothing.
    let (pipe, known) = (pipe(0.25, 1), unknowns());
    let plain = ramp(&[(0.0, 30.0), (600.0, 80.0)]);
    let logged = ramp(&[(0.0, 30.0), (123.0, 30.0), (600.0, 80.0), (700.0, 80.0)]);
    let alone = pipe.gas_along(&plain, &known, AMBIENT, &[900.0], 7.5).unwrap();
    let same = pipe.gas_along(&logged, &known, AMBIENT, &[900.0], 7.5).unwrap();
    assert_eq!(alone[0].march.face, same[0].march.face);
    let among =
        pipe.gas_along(&plain, &known, AMBIENT, &[0.0, 71.0, 600.0, 803.0, 900.0, 900.0], 7.5).unwrap();
    let (a, b) = (pipe.base_state(&alone[0]), pipe.base_state(&among[4]));
    assert!((a.heater_velocity / b.heater_velocity - 1.0).abs() < 1e-5, "{a:?} {b:?}");
    assert_eq!(among[4].march.face, among[5].march.face);
    assert!(pipe.gas_along(&plain, &known, AMBIENT, &[-1.0], 7.5).is_err());
    assert!(pipe.gas_along(&plain, &known, AMBIENT, &[800.0, 700.0], 7.5).is_err());
}

#[test]
fn behaviour_the_gas_hardly_moves_within_a_ping_minutes_after_a_step() {
    // 0.4 s, after the paper's largest step of power: relative change of the time a pulse takes, which is
    // that of a frequency.
    let (pipe, known) = (pipe(0.25, 1), unknowns());
    let ramp = ramp(&[(0.0, 130.0), (1000.0, 180.0)]);
    let drift = |after: f64| {
        let moments = [1000.0 + after, 1000.4 + after];
        let gas = pipe.gas_along(&ramp, &known, AMBIENT, &moments, 5.0).unwrap();
        let [a, b] = [0, 1].map(|k| pipe.base_state(&gas[k]).travel_time(0.0, 1.0));
        (b / a - 1.0).abs()
    };
    let found = [10.0, 120.0, 300.0].map(drift);
    println!("{found:?}");
    assert!(found[0] < 3e-4 && found[1] < 2e-5 && found[2] < 5e-6, "{found:?}");
}
