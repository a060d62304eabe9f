//! What one evaluation of a law costs, as read and folded at its place: with the slope in s, as in every
//! step of a search for an eigenvalue, and with the Hessian in three parameters and s, as at its end.
#![allow(clippy::unwrap_used, reason = "a bench stops at the first surprise")]
#![allow(missing_docs, reason = "the macros of criterion make undocumented items")]

use criterion::{Criterion, criterion_group, criterion_main};
use rijke_formula::{Context, Formula, Here, Kind, Name, Scope};
use rijke_numerics::{C64, ComplexDual, Jet, JetSpace, Order};
use std::hint::black_box;

const REAL: [(&str, f64); 7] = [
    ("rho", 1.2041),
    ("c", 343.2),
    ("mu", 1.8134e-5),
    ("gamma", 1.4),
    ("Pr", 0.71),
    ("D", 0.0474),
    ("Q_h", 150.0),
];

const LAWS: [(&str, &str); 4] = [
    ("heat_release", "-k1*Q_h*exp(-s*k2)"),
    ("wall", "4/D*sqrt(s*rho*mu)"),
    ("thermal_wall", "(gamma - 1)/(rho*c)^2*4/D*sqrt(s*rho*mu)*Pr^(-2/3)"),
    ("response", "k1*(1 + s*k2)/(1 + s*k3)*s^0.5 + ln(1 + s*k2)"),
];

fn laws(criterion: &mut Criterion) {
    let mut scope = Scope::new();
    for (name, _) in REAL {
        let [name, unit, meaning] = [name, "1", "of the bench"].map(str::to_owned);
        scope.add(Name { name, unit, meaning, kind: Kind::Local }).unwrap();
    }
    let parameters = ["k1", "k2", "k3"].map(str::to_owned);
    let context = Context { scope: &scope, here: &|_| true, parameters: &parameters, definitions: &[] };
    let numbers: Vec<f64> = std::iter::once(f64::NAN).chain(REAL.map(|(_, value)| value)).collect();
    let (s, at) = (C64::new(-12.0, 1070.0), [1.3e-3, 2e-3, 1e-3]);
    let dual = ComplexDual { value: s, slope: C64::ONE };
    let short = Here { space: JetSpace::new(0, Order::Value), numbers: &numbers, analytic: &[Some(&dual)] };
    let space = JetSpace::new(4, Order::Second);
    let seed = space.seed(3, s);
    let long = Here { space, numbers: &numbers, analytic: &[Some(&seed)] };
    let jets: Vec<Jet> = (0..3).map(|k| space.seed(k, C64::new(at[k], 0.0))).collect();
    for (name, text) in LAWS {
        let formula = Formula::parse(text, &context).unwrap();
        let folded = formula.at(&numbers);
        criterion.bench_function(&format!("read/{name}"), |b| {
            b.iter(|| Formula::parse(black_box(text), &context).unwrap());
        });
        criterion.bench_function(&format!("in_s/{name}"), |b| {
            b.iter(|| formula.evaluate_in_s(black_box(&short), black_box(&at)));
        });
        criterion.bench_function(&format!("in_s_folded/{name}"), |b| {
            b.iter(|| folded.evaluate_in_s(black_box(&short), black_box(&at)));
        });
        criterion.bench_function(&format!("hessian/{name}"), |b| {
            b.iter(|| formula.evaluate(black_box(&long), black_box(&jets)));
        });
    }
}

criterion_group!(benches, laws);
criterion_main!(benches);
