//! Growth rate and frequency of a decay, with standard deviations: `cargo run --release -p rijke-signal
//! --example ring_down -- RATE_HZ < FILE`. Standard input has a pressure in each line: silence, then the
//! decay. Without a rate a decay is made up.
#![allow(clippy::print_stdout, reason = "an example shows its results")]

use rijke_signal::{PingOptions, Trace, fit_ping};
use std::io::Read;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (rate_hz, pressures) = match std::env::args().nth(1) {
        Some(rate) => {
            let mut text = String::new();
            std::io::stdin().read_to_string(&mut text)?;
            (rate.parse()?, text.lines().map(str::parse).collect::<Result<Vec<f64>, _>>()?)
        }
        None => (1e4, (0..8000).map(made_up).collect()),
    };
    let quiet = pressures.len() / 10; // samples before the sound begins
    let trace = Trace { channels: &[pressures], rate_hz, quiet, full_scale: f64::INFINITY };
    let ping = fit_ping(&trace, &PingOptions::default())?.ping;
    let sd = |k: usize| ping.covariance[(k, k)].sqrt();
    println!("growth rate {:.3} +- {:.3} 1/s", ping.s.re, sd(0));
    println!("angular frequency {:.3} +- {:.3} rad/s", ping.s.im, sd(1));
    Ok(())
}

/// Silence for 0.1 s, then a decay at 170 Hz, in a little noise.
fn made_up(n: usize) -> f64 {
    let noise = ((n * 7919 % 10_007) as f64 / 10_007.0 - 0.5) * 1e-3;
    let t = n as f64 / 1e4 - 0.1;
    noise + if t < 0.0 { 0.0 } else { (-12.0 * t).exp() * (1068.0 * t).cos() }
}
