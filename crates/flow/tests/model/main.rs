//! The flow model from outside: convergence, energy, derivatives, robustness, published shapes.

#![allow(clippy::unwrap_used, reason = "an unexpected error is a failed test")]

mod assimilation;
mod calibration;
mod convergence;
mod damaged;
mod derivatives;
mod files;
mod model_error;
mod physics;
mod ramp;
mod robustness;

use rijke_flow::TubeRig;
use rijke_flow::{Closures, Pipe, TubeParameters, Unknowns};

const AMBIENT: f64 = 293.15;

fn pipe(heater: f64, refinement: u32) -> Pipe {
    Pipe::new(&TubeRig::juniper_yoko_2022(), &Closures::default(), heater, refinement).unwrap()
}

fn unknowns() -> Unknowns {
    Unknowns {
        parameters: TubeParameters::default(),
        power_factor: 1.0,
        ambient_offset: 0.0,
        heater_lag: 35.0,
        orifice_length: 0.05,
    }
}
