//! Value, slope and curvature of any function in one pass: `cargo run --release -p rijke-numerics --example
//! derivatives`.
#![allow(clippy::print_stdout, reason = "an example shows its results")]

use rijke_numerics::{C64, JetSpace, Order};

fn main() {
    // Resonances of a bottle, omega = c sqrt(S/(V l)), in the area S of its neck, its volume V and the length
    // l of its neck.
    let space = JetSpace::new(3, Order::Second);
    let [area, volume, length] =
        [(0, 3e-4), (1, 7.5e-4), (2, 0.06)].map(|(k, x)| space.seed(k, C64::new(x, 0.0)));
    let omega = (&area * &(&volume * &length).recip()).sqrt().scale(C64::new(343.2, 0.0));
    println!("frequency {:.2} Hz", omega.value().re / std::f64::consts::TAU);
    for (k, name) in ["area of the neck", "volume", "length of the neck"].into_iter().enumerate() {
        let per_cent = omega.gradient()[k].re * [3e-4, 7.5e-4, 0.06][k] / omega.value().re;
        println!("1 % more {name}: {per_cent:+.3} % (second derivative {:.3e})", omega.hessian(k, k).re);
    }
}
