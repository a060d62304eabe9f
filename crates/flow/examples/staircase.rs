//! Clicks of a staircase of powers, warm-up included, assimilated through the library: `cargo run --release
//! -p rijke-flow --example staircase`.
//!
//! The record is virtual: 0, 30 and 180 W for 25 min each, a click every 15 s. Your own is a `FlowRecord` of
//! the same shape: arrival times after the trigger (s), indicated ambient temperature (K) and power (W), at
//! equal intervals, from a cold start.
#![allow(clippy::print_stdout, reason = "an example shows its result")]

use rijke_flow::TubeRig;
use rijke_flow::assimilate::{Batch, Twin, TwinOptions, staircase};
use rijke_flow::{Closures, FlowError, Pipe, unknowns};
use rijke_numerics::Streams;

fn main() -> Result<(), FlowError> {
    let pipe = Pipe::new(&TubeRig::juniper_yoko_2022(), &Closures::default(), 0.25, 1)?;
    let options = TwinOptions { powers: staircase(&[0.0, 30.0, 180.0], 100), ..TwinOptions::default() };
    let twin = Twin::new(&pipe, &options, &Streams::new(1), None)?;
    let record = twin.record.checked(&pipe)?;

    let fit = Batch::new(&pipe, &record, 10)?.fit()?;
    for (k, unknown) in unknowns().iter().enumerate() {
        let [low, high] = [fit.value(k, -2.0)?, fit.value(k, 2.0)?];
        let truth = rijke_flow::assimilate::physical(unknown, twin.scores[k])?;
        println!("{:<17} {low:8.4} to {high:8.4} {}, true {truth:.4}", unknown.name, unknown.unit);
    }
    for warning in fit.health.iter().flat_map(|h| h.warnings()) {
        println!("do not trust this: {warning:?}");
    }
    let base = fit.base_state(&pipe, 180.0, 293.15)?;
    println!("at 180 W: U_h = {:.4} +- {:.4} m/s", base.heater_velocity, base.heater_velocity_sd());
    Ok(())
}
