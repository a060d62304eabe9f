//! Any text as a formula: read it, check its unit, and evaluate it with derivatives where it is one.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rijke_formula::{Context, Formula, Here, Kind, Name, Scope};
use rijke_numerics::{C64, JetSpace, Order};

/// Names beside s, with units and values.
const NAMES: [(&str, &str, f64); 8] = [
    ("rho", "kg/m^3", 1.2),
    ("c", "m/s", 343.0),
    ("A", "m^2", 1.8e-3),
    ("Q_h", "W", 100.0),
    ("U_h", "m/s", 0.3),
    ("d_w", "m", 6e-4),
    ("gamma", "1", 1.4),
    ("heater.t_h", "m", 5e-3),
];

fuzz_target!(|text: &str| {
    let mut scope = Scope::new();
    for (name, unit, _) in NAMES {
        let [name, unit, meaning] = [name, unit, "a number"].map(str::to_owned);
        let _ = scope.add(Name { name, unit, meaning, kind: Kind::Global });
    }
    // Seeds have a definition before the first form feed.
    let (definition, text) = text.split_once('\u{c}').unwrap_or(("", text));
    let parameters = ["k1".to_owned(), "k2".to_owned()];
    let definitions = [("lag".to_owned(), definition.to_owned())];
    let definitions = if definition.is_empty() { &[][..] } else { &definitions[..] };
    let context = Context { scope: &scope, here: &|_| true, parameters: &parameters, definitions };
    let Ok(law) = Formula::parse(text, &context) else { return };
    let _ = law.unit_fault(&scope, &["1/W", "s"], "1");
    let space = JetSpace::new(3, Order::Second);
    let numbers: Vec<f64> = std::iter::once(f64::NAN).chain(NAMES.map(|(_, _, value)| value)).collect();
    let s = space.seed(2, C64::new(-10.0, 1000.0));
    let mut analytic = vec![None; numbers.len()];
    analytic[0] = Some(&s);
    let here = Here { space, numbers: &numbers, analytic: &analytic };
    let _ = law.evaluate(&here, &[space.seed(0, C64::ONE), space.seed(1, C64::ONE)]);
});
