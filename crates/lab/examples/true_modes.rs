//! What is true in the virtual laboratory: growth rate and frequency of every operating point, one line per
//! row of the campaign, one column per position. Run with `cargo run --release -p rijke-lab --example
//! true_modes`.
#![allow(clippy::print_stdout, reason = "an example shows something")]

use rijke_flow::{TubeCampaign, TubeRig};
use rijke_lab::{LabError, Truth, VirtualRig};
use rijke_rig::RecordSource;

fn main() -> Result<(), LabError> {
    // One day for all, so that rows can be compared.
    let mut truth = Truth::standard();
    truth.ambient.day_sd_k = 0.0;
    let (rig, campaign) = (TubeRig::juniper_yoko_2022(), TubeCampaign::juniper_yoko_2022());
    let lab = VirtualRig::new(&rig, &campaign, &truth, &[], Some(1), 1)?;
    for (k, entry) in lab.set().points.iter().enumerate() {
        let (s, _) = lab.true_mode(k);
        let velocity = lab.true_base_state(k).heater_velocity;
        println!("{:8} {:9.3} 1/s {:10.3} rad/s  U_h {velocity:.3} m/s", entry.point.id, s.re, s.im);
    }
    Ok(())
}
