//! Names that the caller gives: points in them, definitions, and what exists elsewhere only.

use super::*;
use crate::NameError;

fn with(text: &str, definitions: &[(&str, &str)]) -> Formula {
    parse_without(text, &["R_LS"], definitions).unwrap()
}

/// The definition at fault, the offset in it, and the fault.
fn fault(text: &str, definitions: &[(&str, &str)]) -> (Option<String>, usize, FormulaProblem) {
    let error = parse_without(text, &["R_LS"], definitions).unwrap_err();
    (error.definition, error.at, *error.problem)
}

fn short(name: &str) -> Name {
    Name { name: name.to_owned(), unit: "1".to_owned(), meaning: "m".to_owned(), kind: Kind::Global }
}

#[test]
fn exact_a_scope_takes_names_and_no_others() {
    let mut scope = Scope::new();
    assert_eq!((scope.find("s"), scope.len(), scope.names()[0].kind), (Some(0), 1, Kind::Analytic));
    for (index, name) in ["x", "x.y", "x.z", "_1", "Länge", "re.i", "e1.e2"].into_iter().enumerate() {
        assert_eq!(scope.add(short(name)), Ok(index + 1), "{name}");
        assert_eq!(scope.find(name), Some(index + 1));
    }
    for name in ["", "1x", "x.", ".x", "x..y", "x.1", "x.y.z", "x y", " x", "x ", "x-y", "x(", "2"] {
        assert_eq!(scope.add(short(name)), Err(NameError::NotAName(name.to_owned())));
    }
    for name in ["i", "j", "pi", "sqrt", "bessel_ratio"] {
        assert_eq!(scope.add(short(name)), Err(NameError::Reserved(name.to_owned())));
    }
    for name in ["s", "x", "x.y"] {
        assert!(matches!(scope.add(short(name)), Err(NameError::Double { .. })), "{name}");
    }
    assert_eq!((scope.len(), scope.find("y")), (8, None));
}

#[test]
fn exact_dotted_names_are_names() {
    assert_eq!(value("heater.power/2").re, 75.0);
    assert_eq!(value("2*heater.power-heater.length").re, 299.98);
    assert_eq!(names_used(&with("heater.power*heater.power*k1", &[])), [8]);
    assert_eq!(complaint("k1.5"), (2, FormulaProblem::MissingOperator));
    assert_eq!(complaint("heater .power"), (7, FormulaProblem::Character('.')), "a space ends a name");
    assert_eq!(complaint("rho .c"), (4, FormulaProblem::Character('.')));
    assert_eq!(complaint("heater.power.x"), (12, FormulaProblem::Character('.')));
    let (at, problem) = complaint("1 + heater.lenght");
    assert!(
        matches!(&problem, FormulaProblem::UnknownName { suggestion: Some(s), .. } if s == "heater.length")
    );
    assert_eq!(at, 4);
}

#[test]
fn exact_definitions_stand_for_their_trees() {
    // Twice, chained, and with the precedence of a parenthesis.
    for (text, definitions, same) in [
        ("lag*k1 + lag", &[("lag", "exp(-s*k2)")][..], "exp(-s*k2)*k1 + exp(-s*k2)"),
        ("b*a", &[("a", "k1 + 1"), ("b", "a^2 - a")], "((k1 + 1)^2 - (k1 + 1))*(k1 + 1)"),
        ("-b^2", &[("a", "k1"), ("b", "a - s")], "-(k1 - s)^2"),
        ("loss.part*2", &[("loss.part", "wall_mu*D")], "wall_mu*D*2"),
    ] {
        let (ours, plain) = (with(text, definitions), parse(same).unwrap());
        let at = |f: &Formula| jet(f, &heater(), Order::Second, &POINT);
        assert_eq!(at(&ours), at(&plain), "{text}");
        assert_eq!(names_used(&ours), names_used(&plain));
        assert_eq!((ours.source(), ours.uses_parameter(0)), (text, plain.uses_parameter(0)));
    }
}

#[test]
fn exact_faults_of_definitions_are_told_where_they_are() {
    let text = "k1*a";
    let (of, at, problem) = fault(text, &[("a", "1 + gama")]);
    assert_eq!((of.as_deref(), at), (Some("a"), 4));
    assert!(matches!(problem, FormulaProblem::UnknownName { .. }));
    let absent =
        FormulaProblem::NotHere { name: "R_LS".to_owned(), meaning: "the R_LS of the test".to_owned() };
    assert_eq!(fault(text, &[("a", "2*R_LS")]), (Some("a".to_owned()), 2, absent));
    assert_eq!(fault(text, &[("a", "(1")]), (Some("a".to_owned()), 0, FormulaProblem::Unclosed));
    // A circle, short and long.
    let later = |name: &str| FormulaProblem::DefinedLater { name: name.to_owned() };
    assert_eq!(fault(text, &[("a", "a + 1")]), (Some("a".to_owned()), 0, later("a")));
    assert_eq!(fault(text, &[("a", "1 + b"), ("b", "a")]), (Some("a".to_owned()), 4, later("b")));
    // Not used by the formula, and used only by what is not.
    let unused =
        |name: &str| (Some(name.to_owned()), 0, FormulaProblem::UnusedDefinition { name: name.to_owned() });
    assert_eq!(fault("k1", &[("a", "1")]), unused("a"));
    assert_eq!(fault("k1", &[("a", "1"), ("b", "a")]), unused("b"));
    // A fault of the formula comes before a definition that it would have used.
    assert_eq!(fault("k1*", &[("a", "1")]), (None, 3, FormulaProblem::MissingOperand));
    // What is not analytic may not be hidden in a definition.
    let problem = FormulaProblem::NotAnalytic { function: "abs", through: "s".to_owned() };
    assert_eq!(fault("abs(a)", &[("a", "s*k1")]), (None, 0, problem));
}

#[test]
fn exact_definitions_have_names_of_their_own() {
    for (name, meaning) in [("k1", "a parameter"), ("rho", "the rho of the test")] {
        let double = NameError::Double { name: name.to_owned(), meaning: meaning.to_owned() };
        let expected = (Some(name.to_owned()), 0, FormulaProblem::DefinitionName(double));
        assert_eq!(fault(name, &[(name, "1")]), expected);
    }
    let double = NameError::Double { name: "a".to_owned(), meaning: "another definition".to_owned() };
    assert_eq!(fault("a", &[("a", "1"), ("a", "2")]).2, FormulaProblem::DefinitionName(double));
    assert_eq!(
        fault("a", &[("pi", "3")]).2,
        FormulaProblem::DefinitionName(NameError::Reserved("pi".to_owned()))
    );
    assert_eq!(
        fault("a", &[("a b", "3")]).2,
        FormulaProblem::DefinitionName(NameError::NotAName("a b".to_owned()))
    );
}

#[test]
fn exact_definitions_that_grow_without_end_are_refused() {
    let names: Vec<String> = (0..40).map(|k| format!("a{k}")).collect();
    let texts: Vec<String> =
        (0..40).map(|k| if k == 0 { "k1".to_owned() } else { format!("a{0}*a{0}", k - 1) }).collect();
    let all: Vec<(&str, &str)> =
        names.iter().map(String::as_str).zip(texts.iter().map(String::as_str)).collect();
    let (of, at, problem) = fault("a39", &all);
    // Definition n has w(n) = 3 + 2 w(n - 1) words, w(0) = 1: 4 2^n - 3, and the first above 2000 is the
    // tenth.
    assert_eq!((of.as_deref(), at, problem), (Some("a9"), 3, FormulaProblem::TooLong));
    assert!(parse_without("a8", &[], &all[..9]).is_ok());
}

#[test]
fn exact_messages_name_the_definition_and_count_characters() {
    let text =
        |formula: &str, all: &[(&str, &str)]| parse_without(formula, &[], all).unwrap_err().to_string();
    assert_eq!(
        text("a", &[("a", "2 *")]),
        "in the definition of `a`, `2 *`, at character 4: a number, a name or an opening parenthesis is missing here"
    );
    assert_eq!(
        text("Länge 2", &[("Länge", "1")]),
        "in the formula `Länge 2`, at character 7: an operator (+ - * / ^) is missing here"
    );
    assert_eq!(
        text("1", &[("a", "2")]),
        "in the definition of `a`, `2`, at character 1: `a` is defined but never used; use it or remove it"
    );
}

#[test]
fn exact_a_real_name_may_carry_derivatives_in_a_parameter() {
    // A diameter that is a parameter: its jet counts before its number.
    let (scope, diameter) = (scope(), 6);
    assert_eq!(scope.names()[diameter].name, "D");
    let context = Context { scope: &scope, here: &|_| true, parameters: &[], definitions: &[] };
    let law = Formula::parse("D^2*s*rho", &context).unwrap();
    let space = JetSpace::new(2, Order::Second);
    let (d, s) = (space.seed(0, C64::new(0.03, 0.0)), space.seed(1, C64::new(-3.0, 200.0)));
    let mut analytic = [None; 7];
    (analytic[0], analytic[diameter]) = (Some(&s), Some(&d));
    let numbers = heater();
    let got = law.evaluate(&Here { space, numbers: &numbers, analytic: &analytic }, &[]);
    let factor = s.value() * numbers[1];
    for (found, expected) in [
        (got.value(), factor * 9e-4),
        (got.gradient()[0], factor * 0.06),
        (got.hessian(0, 0), factor * 2.0),
        (got.hessian(0, 1), C64::new(0.06 * numbers[1], 0.0)),
    ] {
        assert!((found - expected).norm() < 1e-12 * expected.norm(), "{found} {expected}");
    }
}

#[test]
fn exact_a_program_in_words_has_operands_before_operations() {
    let formula = parse("k1*(rho + 2i)^2/exp(-s*k2)").unwrap();
    let words = formula.postfix(|parameter| format!("p{parameter}"));
    assert_eq!(words, "p0 n1 0e0,2e0 + 2e0 ^ * n0 neg p1 * exp /");
    // Arithmetic of known numbers is done.
    let known = formula.at(&heater()).postfix(|_| "x".into());
    assert!(known.starts_with("x -2.55") && known.ends_with(" * n0 neg x * exp /"), "{known}");
}
