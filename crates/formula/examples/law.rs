//! A law as text, checked and differentiated: `cargo run --release -p rijke-formula --example law --
//! "gain*exp(-s*d/U)"`.
#![allow(clippy::print_stdout, reason = "an example shows its results")]

use rijke_formula::{Context, Formula, Here, Kind, Name, Scope};
use rijke_numerics::{C64, JetSpace, Order};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let text = std::env::args().nth(1).unwrap_or_else(|| "gain*exp(-s*d/U)".to_owned());
    let mut scope = Scope::new(); // `s` is name 0
    for (name, unit, meaning) in [("d", "m", "diameter of the wire"), ("U", "m/s", "velocity of the gas")] {
        scope.add(Name {
            name: name.into(),
            unit: unit.into(),
            meaning: meaning.into(),
            kind: Kind::Global,
        })?;
    }
    let parameters = ["gain".to_owned()];
    let context = Context { scope: &scope, here: &|_| true, parameters: &parameters, definitions: &[] };
    let law = Formula::parse(&text, &context)?;
    if let Some(fault) = law.unit_fault(&scope, &["1"], "1") {
        println!("the units do not agree: {fault}");
    }
    let space = JetSpace::new(2, Order::First);
    for hertz in [50.0, 100.0, 200.0] {
        let s = space.seed(1, C64::new(0.0, std::f64::consts::TAU * hertz));
        let here = Here { space, numbers: &[f64::NAN, 0.0006, 0.5], analytic: &[Some(&s), None, None] };
        let value = law.evaluate(&here, &[space.seed(0, C64::new(0.2, 0.0))]);
        println!(
            "{hertz} Hz: {:.4}, d/dgain {:.4}, d/ds {:.3e}",
            value.value(),
            value.gradient()[0],
            value.gradient()[1]
        );
    }
    Ok(())
}
