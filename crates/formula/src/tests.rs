//! Values and derivatives of formulas, and texts that are refused with the place of the fault.

mod functions;
mod names;
mod places;
mod units;

use crate::read::Function;
use crate::run::number_call;
use crate::{Context, Formula, FormulaError, FormulaProblem, Here, Kind, Name, Scope};
use approx::assert_relative_eq;
use rijke_numerics::check::{slopes_from, slopes_near};
use rijke_numerics::{C64, ComplexDual, Jet, JetSpace, Order};

const NAMES: [&str; 3] = ["k1", "k2", "k3"];

/// Names, units and values of a place in the heater; NaN for what depends on s.
const HEATER: [(&str, &str, Kind, f64); 12] = [
    ("rho", "kg/m^3", Kind::Local, 1.2041),
    ("c", "m/s", Kind::Local, 343.2),
    ("T", "K", Kind::Local, 293.15),
    ("mu", "Pa s", Kind::Local, 1.8134e-5),
    ("gamma", "1", Kind::Local, 1.4),
    ("D", "m", Kind::Global, 0.0474),
    ("Q_h", "W", Kind::Global, 0.0),
    ("heater.power", "W", Kind::Global, 150.0),
    ("heater.length", "m", Kind::Global, 0.02),
    ("wall_mu", "kg/(m^3 s)", Kind::Analytic, f64::NAN),
    ("wall_ep", "1/(Pa s)", Kind::Analytic, f64::NAN),
    ("R_LS", "1", Kind::Analytic, f64::NAN),
];

fn scope() -> Scope {
    let mut scope = Scope::new();
    for (name, unit, kind, _) in HEATER {
        let meaning = format!("the {name} of the test");
        scope.add(Name { name: name.to_owned(), unit: unit.to_owned(), meaning, kind }).unwrap();
    }
    scope
}

/// The indices of all names in a formula, each once, in rising order.
fn names_used(formula: &Formula) -> Vec<usize> {
    formula.names().collect::<std::collections::BTreeSet<_>>().into_iter().collect()
}

fn depends_on_s(formula: &Formula) -> bool {
    formula.names().any(|index| scope().names()[index].kind == Kind::Analytic)
}

/// The values of [`HEATER`] by index.
fn heater() -> Vec<f64> {
    std::iter::once(f64::NAN).chain(HEATER.map(|(.., value)| value)).collect()
}

fn parse_without(text: &str, absent: &[&str], definitions: &[(&str, &str)]) -> Result<Formula, FormulaError> {
    let scope = scope();
    let absent: Vec<_> = absent.iter().map(|name| scope.find(name).unwrap()).collect();
    let definitions: Vec<_> = definitions.iter().map(|(n, t)| ((*n).to_owned(), (*t).to_owned())).collect();
    let (here, parameters) = (|index: usize| !absent.contains(&index), NAMES.map(str::to_owned));
    let context = Context { scope: &scope, here: &here, parameters: &parameters, definitions: &definitions };
    Formula::parse(text, &context)
}

fn parse(text: &str) -> Result<Formula, FormulaError> {
    parse_without(text, &["R_LS"], &[])
}

/// Value with derivatives in the seeds k1, k2, k3, s.
fn jet(formula: &Formula, numbers: &[f64], order: Order, x: &[C64; 4]) -> Jet {
    let space = JetSpace::new(4, order);
    let seeds: Vec<Jet> = (0..4).map(|k| space.seed(k, x[k])).collect();
    let wall = [seeds[3].sqrt(), seeds[3].sqrt().scale(C64::new(1e-6, 0.0))];
    let mut analytic = vec![None; numbers.len()];
    analytic[0] = Some(&seeds[3]);
    analytic[10] = Some(&wall[0]);
    analytic[11] = Some(&wall[1]);
    formula.evaluate(&Here { space, numbers, analytic: &analytic }, &seeds[..3])
}

const POINT: [C64; 4] =
    [C64::new(0.7, 0.0), C64::new(1.3e-3, 0.0), C64::new(1.4, 0.0), C64::new(-12.0, 1070.0)];

fn value(text: &str) -> C64 {
    jet(&parse(text).unwrap(), &heater(), Order::Value, &POINT).value()
}

fn complaint(text: &str) -> (usize, FormulaProblem) {
    let error = parse(text).unwrap_err();
    (error.at, *error.problem)
}

#[test]
fn exact_precedence_is_that_of_matlab_and_python() {
    for (text, expected) in [
        ("1 + 2*3", 7.0),
        ("10 - 4 - 3", 3.0),
        ("16/4/2", 2.0),
        ("-2^2", -4.0),
        ("(-2)^2", 4.0),
        ("2^-1", 0.5),
        ("2*-3", -6.0),
        ("1 - -1", 2.0),
        ("+3", 3.0),
        ("2*3^2", 18.0),
        ("2**3", 8.0),
        ("-2*3", -6.0),
        ("8/2*4", 16.0),
        ("1.5e-3*1e3", 1.5),
        ("2^0.5*2^0.5", 2.0),
        ("(2^3)^2", 64.0),
        ("2^(3^2)", 512.0),
        ("abs(3 + 4i)", 5.0),
        ("re(2j*2j)", -4.0),
        ("im(i)", 1.0),
        ("arg(-1 + 0*i)/pi", 1.0),
        ("arg(-1)/pi", 1.0),
        ("im(sqrt(-4))", 2.0),
        ("im(log(-1))/pi", 1.0),
        ("im((-8)^(1/3))/sqrt(3)", 1.0),
        ("tanh(1000)", 1.0),
        ("tanh(-356)", -1.0),
        ("im(tan(1000i))", 1.0),
        ("log(exp(2))", 2.0),
    ] {
        assert_relative_eq!(value(text).re, expected, max_relative = 1e-15);
        assert!(value(text).im.abs() < 1e-15, "{text}");
    }
}

#[test]
fn exact_a_chain_of_powers_is_refused() {
    assert_eq!(complaint("2^3^2"), (3, FormulaProblem::ChainedPower));
    assert_eq!(complaint("k1^k2^k3").1, FormulaProblem::ChainedPower);
    assert_eq!(complaint("2^-1^2").1, FormulaProblem::ChainedPower);
}

#[test]
fn exact_zero_to_a_parameter_is_zero_with_its_derivatives() {
    let jet = jet(&parse("0^k3").unwrap(), &heater(), Order::Second, &POINT);
    assert_eq!(jet.value(), C64::ZERO);
    assert!(jet.gradient().iter().chain(jet.hessian_packed()).all(|d| *d == C64::ZERO));
}

#[test]
fn exact_errors_point_at_the_fault() {
    assert_eq!(complaint("k1 * $"), (5, FormulaProblem::Character('$')));
    assert_eq!(complaint("k1 *"), (4, FormulaProblem::MissingOperand));
    // A space that does not break is no blank of a formula, and is not seen.
    assert_eq!(complaint("k1\u{a0}+ 2"), (2, FormulaProblem::Character('\u{a0}')));
    let text = parse("k1\u{a0}+ 2").unwrap_err().to_string();
    assert!(text.contains("the invisible character U+00A0 has no place"), "{text}");
    assert_eq!(complaint("k1 + 1e"), (5, FormulaProblem::BrokenNumber));
    for (text, name) in [("sin k1", "sin"), ("2*exp", "exp")] {
        let (_, problem) = complaint(text);
        assert_eq!(problem, FormulaProblem::FunctionAlone { name: name.to_owned() });
    }
    assert_eq!(complaint(""), (0, FormulaProblem::MissingOperand));
    assert_eq!(complaint("2*(k1 + 3"), (2, FormulaProblem::Unclosed));
    assert_eq!(complaint("2 k1"), (2, FormulaProblem::MissingOperator));
    assert_eq!(complaint("2in"), (1, FormulaProblem::MissingOperator));
    assert_eq!(complaint("k1)"), (2, FormulaProblem::MissingOperator));
    assert_eq!(complaint("* 2"), (0, FormulaProblem::MissingOperand));
    assert!(matches!(complaint(&"(".repeat(5000)).1, FormulaProblem::TooLong | FormulaProblem::TooDeep));
    assert_eq!(complaint(&"k1+".repeat(3000)).1, FormulaProblem::TooLong);
    let (at, unknown) = complaint("k1 * sqr(s)");
    assert_eq!(at, 5);
    let FormulaProblem::UnknownName { suggestion, known, .. } = unknown else { panic!("{unknown}") };
    assert_eq!(suggestion.as_deref(), Some("sqrt"));
    assert!(known.contains("tanh"));
    let text = parse("gama - 1").unwrap_err().to_string();
    assert!(
        text.contains("did you mean `gamma`") && text.contains("k3") && text.contains("wall_mu"),
        "{text}"
    );
}

#[test]
fn exact_only_analytic_laws_of_s_are_accepted() {
    for (text, name) in [
        ("abs(s)", "s"),
        ("k1*exp(-i*im(k2*s))", "s"),
        ("conj(wall_mu)", "wall_mu"),
        ("arg(1 + 2*(rho - wall_ep))", "wall_ep"),
        ("re(sqrt(k1*s))", "s"),
    ] {
        let (_, problem) = complaint(text);
        assert!(
            matches!(&problem, FormulaProblem::NotAnalytic { through, .. } if through == name),
            "{text}: {problem}"
        );
    }
    assert!(parse("abs(k1 + i*k2)*exp(-s*k3)*conj(i)").is_ok());
    let absent =
        FormulaProblem::NotHere { name: "R_LS".to_owned(), meaning: "the R_LS of the test".to_owned() };
    assert_eq!(complaint("R_LS"), (0, absent));
    assert!(parse_without("R_LS", &[], &[]).is_ok());
    assert!(parse_without("wall_mu", &["wall_mu"], &[]).is_err());
}

/// Laws with a positive real part where they meet a branch cut, written alike for both readers.
const LAWS: [&str; 8] = [
    "-k1*exp(-s*k2)",
    "k1*sqrt(s)*s^k3",
    "(k1 + i*k3)/(1 + s*k2)",
    "ln(s*k2)*sin(k1) - cos(s*k2)^2",
    "tanh(s*k2) + sinh(k2*s)/cosh(k1)",
    "k1^k3 - 2^k1 + (k1*s)^-2*1000000",
    "-s^2*k1 + s^3*k2^2/(k3 - 2*s)",
    "tan(k1*k3)*s^0.5 + exp(k2*s)^2",
];

#[test]
fn oracle_values_and_derivatives_agree_with_symbolic_differentiation() {
    let (around, variables) = (heater(), ["k1", "k2", "k3", "s"]);
    for law in LAWS {
        let ours = jet(&parse(law).unwrap(), &around, Order::Second, &POINT);
        let theirs =
            |text: &str| formulac::Builder::<f64, 4>::new(text, variables).compile().unwrap().eval(&POINT);
        let near = |a: C64, b: C64| assert!((a - b).norm() <= 1e-11 * (b.norm() + 1e-12), "{law}: {a} {b}");
        near(ours.value(), theirs(law));
        for (a, x) in variables.iter().enumerate() {
            near(ours.gradient()[a], theirs(&format!("diff({law}, {x})")));
            for (b, y) in variables.iter().enumerate().take(a + 1) {
                near(ours.hessian(a, b), theirs(&format!("diff(diff({law}, {x}), {y})")));
            }
        }
    }
}

#[test]
fn order_taylor_remainders_fall_as_h2_and_h3() {
    let around = heater();
    let direction = [C64::new(0.4, 0.0), C64::new(5e-4, 0.0), C64::new(-0.3, 0.0), C64::new(30.0, -40.0)];
    for law in LAWS {
        let formula = parse(law).unwrap();
        let at = jet(&formula, &around, Order::Second, &POINT);
        let (mut first, mut second) = (C64::ZERO, C64::ZERO);
        for a in 0..4 {
            first += at.gradient()[a] * direction[a];
            for b in 0..4 {
                second += 0.5 * at.hessian(a, b) * direction[a] * direction[b];
            }
        }
        let change = |h: f64| {
            let moved = std::array::from_fn(|k| POINT[k] + h * direction[k]);
            jet(&formula, &around, Order::Value, &moved).value() - at.value()
        };
        slopes_near(&slopes_from(0.05, |h| (change(h) - first * h).norm()), 2.0, 0.05);
        slopes_near(&slopes_from(0.2, |h| (change(h) - first * h - second * h * h).norm()), 3.0, 0.15);
    }
}

proptest::proptest! {
    #[test]
    fn exact_no_text_makes_the_reader_panic(text in "\\PC{0,40}") {
        let _ = parse(&text);
    }

    #[test]
    fn exact_no_string_of_words_makes_the_reader_or_the_evaluation_panic(
        words in proptest::collection::vec(0_usize..16, 0..14)
    ) {
        let all = ["k1", "s", "(", ")", "+", "-", "*", "/", "^", "2", "0", "sqrt(", "abs(", "i", "1e3", "**"];
        let text: String = words.iter().map(|&w| all[w]).collect::<Vec<_>>().join(" ");
        if let Ok(formula) = parse(&text) {
            let _ = jet(&formula, &heater(), Order::Second, &POINT);
        }
    }
}

#[test]
fn exact_tangents_keep_their_digits_near_poles_and_far_out() {
    for small in [1e-3_f64, 1e-5, 1e-7] {
        // The distance from the pole as it is rounded, to its own last digits.
        let x = std::f64::consts::FRAC_PI_2 - small;
        let gap = (std::f64::consts::FRAC_PI_2 - x) + 6.123_233_995_736_766e-17;
        let tan = number_call(Function::Tan, C64::new(x, 0.0));
        assert_relative_eq!(tan.re, 1.0 / gap.tan(), max_relative = 1e-14);
        let tanh = number_call(Function::Tanh, C64::new(0.0, x));
        assert_relative_eq!(tanh.im, 1.0 / gap.tan(), max_relative = 1e-14);
    }
    for re in [19.9, 20.1, -19.9, -20.1, 400.0] {
        let tanh = number_call(Function::Tanh, C64::new(re, 0.3));
        assert!((tanh - re.signum()).norm() < 1e-15, "{tanh}");
    }
}

#[test]
fn oracle_square_roots_are_those_by_way_of_the_argument() {
    for k in 0..64 {
        let z = C64::from_polar(10f64.powi(k - 32), 0.1 + 0.37 * f64::from(k));
        let (fast, slow) = (number_call(Function::Sqrt, z), z.sqrt());
        assert!((fast - slow).norm() <= 4e-16 * slow.norm(), "{z}: {fast} {slow}");
    }
    for z in [C64::new(-4.0, 0.0), C64::new(0.0, 0.0), C64::new(0.0, -2.0), C64::new(1e-200, 1e-200)] {
        let (fast, slow) = (number_call(Function::Sqrt, z), z.sqrt());
        assert!(
            (fast - slow).norm() <= 4e-16 * slow.norm()
                && fast.im.is_sign_negative() == slow.im.is_sign_negative(),
            "{z}"
        );
    }
}
