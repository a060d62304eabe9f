//! No input inside the prior breaks the model; input outside is refused with numbers.

use super::{AMBIENT, pipe, unknowns};
use rijke_flow::{FlowError, Transient, TubeParameters, Unknowns};

fn corner(index: usize) -> TubeParameters {
    let pick = |k: usize, low: f64, high: f64| if index >> k & 1 == 1 { high } else { low };
    TubeParameters {
        heater_drag: pick(0, 3.0, 20.0),
        outer_nusselt: pick(1, 0.6, 1.8),
        mount_resistance: pick(2, 1.0, 20.0),
        wall_share: pick(3, 0.0, 0.30),
        inner_nusselt: pick(4, 0.5, 2.5),
        jet_enhancement: pick(5, 0.0, 3.0),
    }
}

#[test]
fn exact_every_corner_of_the_prior_survives_steps_of_power_and_kicks() {
    for heater in [0.05, 0.85] {
        let pipe = pipe(heater, 1);
        let implicit = pipe.implicit(15.0);
        for index in 0..64 {
            let u = Unknowns { parameters: corner(index), ..unknowns() };
            let mut state = Transient::cold(&pipe, &u, AMBIENT).unwrap();
            for power in [0.0, 7.0, 180.0, 30.0, 0.0] {
                for k in 0..12 {
                    // A deterministic kick of up to 6 K per cell, as an analysis might give.
                    if k == 6 {
                        for (i, w) in state.wall.iter_mut().enumerate() {
                            *w += 6.0 * ((37 * i + 11 * index) as f64).sin();
                        }
                        state.refresh(&pipe, &u, 1e-8).unwrap();
                    }
                    let energy = state.step(&pipe, &implicit, &u, power, AMBIENT, 1e-8).unwrap();
                    let finite = state.wall.iter().chain(&state.gas.march.face).all(|t| t.is_finite());
                    assert!(finite && energy.imbalance().abs() < 1e-7, "{heater} {index} {power} {energy:?}");
                }
            }
            if index % 8 == 0 {
                pipe.steady(&corner(index), 180.0, AMBIENT).unwrap();
                pipe.steady(&corner(index), 0.5, AMBIENT).unwrap();
            }
        }
    }
}

#[test]
fn exact_bad_conditions_are_refused() {
    let pipe = pipe(0.25, 1);
    let p = TubeParameters::default();
    assert!(matches!(pipe.steady(&p, -1.0, AMBIENT), Err(FlowError::Power { .. })));
    assert!(matches!(pipe.steady(&p, f64::NAN, AMBIENT), Err(FlowError::Power { .. })));
    for kelvin in [-5.0, 0.0, 20.0, 180.0, 2000.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            pipe.steady(&p, 10.0, kelvin),
            Err(FlowError::Range { low: 210.0, high: 1800.0, .. })
        ));
        assert!(matches!(Transient::cold(&pipe, &unknowns(), kelvin), Err(FlowError::Range { .. })));
    }
    assert!(pipe.steady(&p, 10.0, 210.0).is_ok());
}
