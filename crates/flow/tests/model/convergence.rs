//! Orders of convergence in space and time, and closure of the energy.

use super::{AMBIENT, pipe, unknowns};
use rijke_flow::{HeatBalance, Transient, TubeParameters};

/// Order from three successive halvings, and the error of the coarsest by Richardson's extrapolation.
fn order(values: [f64; 3]) -> (f64, f64) {
    let (first, second) = (values[0] - values[1], values[1] - values[2]);
    ((first / second).abs().log2(), first.abs() * 4.0 / 3.0)
}

#[test]
fn order_second_in_the_cell() {
    let at = |refinement: u32, heater: f64| {
        let pipe = pipe(heater, refinement);
        let steady = pipe.steady(&TubeParameters::default(), 180.0, AMBIENT).unwrap();
        let mut times = Vec::new();
        pipe.arrival_times(&steady.gas, 0.05, &mut times);
        let hottest = steady.gas.march.face.iter().copied().fold(0.0, f64::max);
        [times[7] * 1e6, pipe.heater_velocity(&steady.gas) * 1e3, hottest]
    };
    for heater in [0.25, 0.75] {
        let runs = [at(2, heater), at(4, heater), at(8, heater)];
        for k in 0..3 {
            let (order, _) = order([runs[0][k], runs[1][k], runs[2][k]]);
            assert!((1.8..2.2).contains(&order), "heater {heater}, quantity {k}: order {order} of {runs:?}");
        }
        // The default grid is within 0.2 us, 0.1 mm/s and 0.1 K of the limit.
        let coarse = at(1, heater);
        for (k, allowed) in [0.2, 0.1, 0.1].into_iter().enumerate() {
            let limit = runs[2][k] - (runs[1][k] - runs[2][k]) / 3.0;
            assert!(
                (coarse[k] - limit).abs() < allowed,
                "heater {heater}, quantity {k}: {} {limit}",
                coarse[k]
            );
        }
    }
}

#[test]
fn order_second_in_the_step() {
    // Steady at 80 W, then 180 W for 120 s.
    let pipe = pipe(0.25, 1);
    let at = |dt: f64| {
        let u = unknowns();
        let mut state = Transient::cold(&pipe, &u, AMBIENT).unwrap();
        let steady = pipe.steady(&u.parameters, 80.0, AMBIENT).unwrap();
        (state.wall, state.released, state.gas.mass_flow) = (steady.wall, 80.0, steady.gas.mass_flow);
        state.refresh(&pipe, &u, 1e-12).unwrap();
        let implicit = pipe.implicit(dt);
        for _ in 0..(120.0 / dt).round() as usize {
            state.step(&pipe, &implicit, &u, 180.0, AMBIENT, 1e-12).unwrap();
        }
        let mut times = Vec::new();
        pipe.arrival_times(&state.gas, 0.05, &mut times);
        let hottest = state.wall.iter().copied().fold(0.0, f64::max);
        [times[7] * 1e6, pipe.heater_velocity(&state.gas) * 1e3, hottest]
    };
    let runs = [at(15.0), at(7.5), at(3.75), at(1.875)];
    for k in 0..3 {
        let (order, _) = order([runs[1][k], runs[2][k], runs[3][k]]);
        assert!((1.85..2.15).contains(&order), "quantity {k}: order {order} of {runs:?}");
    }
    // A step of 15 s costs less than a tenth of the noise of 1 us.
    let (_, error) = order([runs[0][0], runs[1][0], runs[2][0]]);
    assert!(error < 0.1, "error in t_8 at 15 s: {error} us of {runs:?}");
}

#[test]
fn exact_energy_closes_at_rest_and_in_motion() {
    for heater in [0.05, 0.25, 0.85] {
        let pipe = pipe(heater, 1);
        for power in [7.0, 180.0] {
            let budget = pipe.steady(&TubeParameters::default(), power, AMBIENT).unwrap().budget;
            assert!(budget.imbalance().abs() < 1e-10 * power, "{budget:?}");
            assert!(budget.stored.abs() < 1e-10 * power, "{budget:?}");
        }
        let u = unknowns();
        let (mut state, implicit) = (Transient::cold(&pipe, &u, AMBIENT).unwrap(), pipe.implicit(15.0));
        let (mut sum, mut heater_gain, mut supplied) = (HeatBalance::default(), 0.0, 0.0);
        // Over a constant step the heater's exponential holds tau' = (dt/2)/tanh(dt/(2 tau)) times its power.
        let lag = 7.5 / (7.5_f64 / 35.0).tanh();
        for power in [7.0, 80.0, 180.0, 0.0] {
            for _ in 0..250 {
                let before = state.released;
                let e = state.step(&pipe, &implicit, &u, power, AMBIENT, 1e-8).unwrap();
                heater_gain += lag * (state.released - before);
                supplied += 15.0 * power;
                sum.gas += e.gas;
                sum.convection += e.convection;
                sum.radiation += e.radiation;
                sum.mounts += e.mounts;
                sum.stored += e.stored;
                assert!(e.imbalance().abs() < 1e-10 * (15.0 * 180.0), "{e:?}");
            }
        }
        let to = sum.gas + sum.convection + sum.radiation + sum.mounts + sum.stored + heater_gain;
        assert!((supplied - to).abs() < 1e-10 * supplied, "heater {heater}: {supplied} {to}");
    }
}
