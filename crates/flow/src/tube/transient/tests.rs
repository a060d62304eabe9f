//! Lanes against states that are stepped alone.

use super::{Lanes, Transient};
use crate::TubeRig;
use crate::tube::closures::Closures;
use crate::tube::parameters::{TubeParameters, Unknowns};
use crate::tube::pipe::Pipe;
use std::array::from_fn;

const L: usize = 4;

fn unknowns(k: usize) -> Unknowns {
    let share = k as f64 / L as f64;
    Unknowns {
        parameters: TubeParameters {
            heater_drag: 3.0 + 17.0 * share,
            outer_nusselt: 1.8 - share,
            mount_resistance: 1.0 + 15.0 * share,
            wall_share: 0.3 * share,
            inner_nusselt: 0.5 + 2.0 * share,
            jet_enhancement: 3.0 * share,
        },
        power_factor: 1.0 + 0.01 * share,
        ambient_offset: 0.1 * share,
        heater_lag: 35.0 + 5.0 * share,
        orifice_length: 0.05,
    }
}

#[test]
fn oracle_lanes_have_to_the_last_bit_what_they_have_alone() {
    let pipe = Pipe::new(&TubeRig::juniper_yoko_2022(), &Closures::default(), 0.25, 1).unwrap();
    let implicit = pipe.implicit(15.0);
    let apart: [Unknowns; L] = from_fn(unknowns);
    let together = Unknowns::from_array(from_fn(|j| Lanes(from_fn(|k| apart[k].values()[j]))));
    let mut states: Vec<Transient<f64>> =
        apart.iter().map(|u| Transient::cold(&pipe, u, 293.15).unwrap()).collect();
    let mut lanes = Transient::<Lanes<L>>::gather(&states).unwrap();
    let mut directions = [0; 2];
    // Rooms that differ, so that without power some lanes flow down while others flow up; then up and down
    // the staircase.
    for (step, power) in
        [0.0, 0.0, 0.0, 0.0, 0.3, 7.0, 180.0, 180.0, 30.0, 0.0, 0.0, 0.0].into_iter().enumerate()
    {
        let room: [f64; L] = from_fn(|k| 293.15 + (2.0 * step as f64 + 1.7 * k as f64).sin());
        lanes.refresh(&pipe, &together, 1e-6).unwrap();
        lanes.step_each(&pipe, &implicit, &together, power, Lanes(room), 1e-6).unwrap();
        for k in 0..L {
            states[k].refresh(&pipe, &apart[k], 1e-6).unwrap();
            states[k].step(&pipe, &implicit, &apart[k], power, room[k], 1e-6).unwrap();
            let lane = lanes.lane(k);
            assert_eq!(lane.wall, states[k].wall, "lane {k}, step {step}");
            assert_eq!(lane.gas.march.face, states[k].gas.march.face, "lane {k}, step {step}");
            assert_eq!(lane.gas.guess(), states[k].gas.guess(), "lane {k}, step {step}");
            directions[usize::from(lane.gas.mass_flow < 0.0)] += usize::from(step < 4);
        }
        assert_eq!(pipe.heater_velocity(&lanes.gas).0, from_fn(|k| pipe.heater_velocity(&states[k].gas)));
    }
    assert!(directions.iter().all(|&count| count > 2), "up, down without power: {directions:?}");
}
