//! Every mode of a network file, and what moves the least damped one: `cargo run --release -p rijke-network
//! --example modes -- FILE`.
#![allow(clippy::print_stdout, reason = "an example shows its results")]

use rijke_network::{Workspace, file::NamedNumbers};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::args().nth(1).unwrap_or_else(|| "fixtures/networks/rijke-tube.toml".to_owned());
    let numbers = NamedNumbers::of(&std::fs::read_to_string(file)?)?;
    let built = numbers.build()?;
    let modes = built.network.modes(&built.laws, &built.region, &mut Workspace::default())?.modes;
    for mode in &modes {
        println!("{:9.3} Hz, growth rate {:9.3} 1/s", mode.s.im / std::f64::consts::TAU, mode.s.re);
    }
    let Some(worst) = modes.iter().max_by(|a, b| a.s.re.total_cmp(&b.s.re)) else { return Ok(()) };
    for (name, value) in numbers.list() {
        if let Ok(slope) = numbers.derivative(worst.s, &name) {
            println!("1 % more {name}: growth rate {:+.4} 1/s", 0.01 * value * slope.re);
        }
    }
    Ok(())
}
