//! A formula at one place: folded, as a plain number, in s alone, and its share that differs between places.

use super::*;

#[test]
fn exact_folding_keeps_every_bit() {
    let numbers = heater();
    for law in LAWS.into_iter().chain([
        "k1*sqrt(s*rho*mu)*4/D",
        "(gamma - 1)/(rho*c)^2*wall_mu + wall_ep*bessel_ratio(D*1e3)",
        "heater.power^k3*exp(-s*k2*heater.length/c)",
    ]) {
        let formula = parse(law).unwrap();
        let at = |f: &Formula| jet(f, &numbers, Order::Second, &POINT);
        let folded = formula.at(&numbers);
        assert_eq!(at(&formula), at(&folded), "{law}");
        assert_eq!(folded.source(), law);
        let real = |index: &usize| scope().names()[*index].kind != Kind::Analytic;
        assert!(!names_used(&folded).iter().any(real), "{law}");
    }
    // A name without a value waits for it.
    let (mut early, formula) = (numbers.clone(), parse("k1*rho*c").unwrap());
    early[1] = f64::NAN;
    assert_eq!(names_used(&formula.at(&early)), [1]);
    assert_eq!(
        jet(&formula.at(&early), &numbers, Order::First, &POINT),
        jet(&formula, &numbers, Order::First, &POINT)
    );
}

#[test]
fn exact_real_formulas_have_real_values() {
    let real = |text: &str| parse(text).unwrap().real(&heater());
    assert_eq!(real("heater.length/4"), 0.005);
    assert_eq!(real("(-2)^2 + abs(3 + 4i) + sqrt(D*D/D^2)"), 10.0);
    for text in ["k1", "s", "2*s/s", "k1*0", "sqrt(-1)", "2i", "wall_mu", "1/0"] {
        assert!(real(text).is_nan(), "{text}");
    }
    assert!(parse("rho").unwrap().real(&[]).is_nan());
}

#[test]
fn oracle_the_slope_in_s_is_that_of_the_jets() {
    let numbers = heater();
    for law in LAWS.into_iter().chain(["wall_mu*D/(1 + k1*wall_ep)", "bessel_ratio(sqrt(s))*rho^k3"]) {
        let formula = parse(law).unwrap();
        let long = jet(&formula, &numbers, Order::First, &POINT);
        let s = POINT[3];
        let dual = |value: C64, slope: C64| ComplexDual { value, slope };
        let root = s.sqrt();
        let all = [dual(s, C64::ONE), dual(root, 0.5 / root), dual(1e-6 * root, 0.5e-6 / root)];
        let mut analytic = vec![None; numbers.len()];
        (analytic[0], analytic[10], analytic[11]) = (Some(&all[0]), Some(&all[1]), Some(&all[2]));
        let here = Here { space: JetSpace::new(0, Order::Value), numbers: &numbers, analytic: &analytic };
        let short = formula.evaluate_in_s(&here, &[POINT[0].re, POINT[1].re, POINT[2].re]);
        let near = |a: C64, b: C64| assert!((a - b).norm() <= 1e-12 * (b.norm() + 1e-12), "{law}: {a} {b}");
        near(short.value, long.value());
        near(short.slope, long.gradient()[3]);
        assert!(depends_on_s(&formula) == (long.gradient()[3] != C64::ZERO), "{law}");
    }
}

#[test]
fn exact_what_has_no_value_is_nan() {
    let space = JetSpace::new(1, Order::First);
    let here = Here { space, numbers: &[], analytic: &[] };
    for law in ["k1", "s", "rho", "R_LS", "wall_mu + 1"] {
        let formula = parse_without(law, &[], &[]).unwrap();
        assert!(formula.evaluate(&here, &[]).value().is_nan(), "{law}");
    }
}

#[test]
fn oracle_places_differ_by_the_scale_that_the_form_shows() {
    // Two places with other gas: the values must differ by g, where g is given, at any s and parameters.
    let (cold, mut hot) = (heater(), heater());
    for (index, factor) in [(1, 0.6), (2, 1.3), (3, 1.7), (4, 1.5), (5, 0.98)] {
        hot[index] *= factor;
    }
    let mut analytic = vec![None; cold.len()];
    analytic[0] = Some(1.0);
    let g = |text: &str, numbers: &[f64]| parse(text).unwrap().scale(numbers, &analytic);
    for law in [
        "k1*sqrt(s*rho*mu)*4/D",
        "(gamma - 1)/(rho*c)^2*k1*s^k3",
        "k2*exp(-s*k1)*D",
        "-k1*rho^2*c",
        "heater.power*3",
        "rho*(s*c + k1*c)",
        "abs(k1*c)*(2 + s)",
        "(rho + c)*s",
        "(c - rho)*s",
        "rho*c/mu*s",
        "(c + 2)*(3 + rho)*s",
        "(c - 2)*(3 - rho)*s",
        "c/(k1*rho)*s",
        "s*c/(k1*rho)",
        "s/3/c",
        "2/(s*c)",
        "2/c*s*(c/2)^3",
        "rho*(1 + 2i)*s",
        "rho/(1 + 2i)*s",
        "(1 + 2i)/rho*s",
        "c*k1 - s*c",
        "(s - 2)*rho*(2 - s)",
        "(k1*rho)^2",
        "(s*c)^0.5*s^k1*2^k1",
        "sqrt(rho)*sqrt(s*c)*exp(s*k2)",
        "conj(k1*c)*re(k1*c)*im((1 + i)*k1*c)",
        "abs(-c*k1) + c*k1",
        "(c/2 + rho)*s",
        "(2/c + 1/rho)*s",
        "(2*c + c^2*rho)*s",
        "(c*rho + c/rho)*s",
        "exp(2)*c*s",
        "(2^k1 + s^k1 + s)*c",
        "sin(2 + k1)*cos(k1 - 2)*c",
    ] {
        let values = [&cold, &hot].map(|numbers| {
            jet(&parse(law).unwrap(), numbers, Order::Value, &POINT).value() / g(law, numbers).unwrap()
        });
        assert!((values[0] - values[1]).norm() <= 1e-14 * values[0].norm(), "{law}: {values:?}");
    }
    for law in [
        "exp(-s*D/c)",
        "k1*rho + c",
        "s + rho",
        "rho^k1",
        "wall_mu",
        "s*c + 2",
        "s*c - s*rho",
        "(s*c)^k1",
        "2^(s*c)",
        "sin(s*c)",
        "sqrt(-c*s)",
        "(-c*s)^0.5",
        "(-c)^0.5*s",
        "sqrt(-c)*s",
        "(s*c)^i",
    ] {
        assert_eq!(g(law, &cold), None, "{law}");
    }
    // The same texts with what differs declared the same everywhere have the scale 1.
    assert_eq!(g("exp(-s*D)", &cold), Some(1.0));
    // The share of what depends on s is the caller's.
    analytic[10] = Some(2.5);
    let wall = parse("k1*wall_mu*rho").unwrap();
    assert_eq!(wall.scale(&cold, &analytic), Some(2.5 * 1.2041));
    assert_eq!(wall.scale(&[], &analytic), None);
}

#[test]
fn exact_what_a_formula_uses_is_told() {
    let formula = parse("c*k2 + rho*c + wall_mu").unwrap();
    assert_eq!(names_used(&formula), [1, 2, 10]);
    assert!(formula.uses(2) && !formula.uses(3) && depends_on_s(&formula));
    assert!(formula.uses_parameter(1) && !formula.uses_parameter(0));
    assert!(!depends_on_s(&parse("rho*k1").unwrap()));
}

#[test]
fn exact_divisors_are_what_may_vanish() {
    let at = |f: &Formula| jet(f, &heater(), Order::First, &POINT).value();
    let values = |text: &str| parse(text).unwrap().divisors().iter().map(at).collect::<Vec<_>>();
    let s = at(&parse("s").unwrap());
    let near = |found: &[C64], expected: &[C64]| {
        assert!(found.len() == expected.len(), "{found:?} {expected:?}");
        for (f, e) in found.iter().zip(expected) {
            assert!((f - e).norm() < 1e-12 * e.norm(), "{found:?} {expected:?}");
        }
    };
    // Inner ones first; what does not depend on s cannot vanish.
    near(&values("rho/(k1 + 1/(s + 2)) + s/D"), &[s + 2.0, at(&parse("k1 + 1/(s + 2)").unwrap())]);
    near(
        &values("(s*rho + k1)^(-2)*tanh(s*1e-3) - s^2"),
        &[at(&parse("s*rho + k1").unwrap()), (s * 1e-3).cosh()],
    );
    near(&values("s*rho - k1*exp(-s*k2)"), &[]);
    near(&values("s/(rho + k1) + s/(2*k1)^2"), &[]);
    // Only negative powers divide, in whatever way their sign stands.
    near(&values("s^0.5 + s^2 + s^(-1) + s^-0.5"), &[s, s]);
    let power = parse("s^(1 - gamma) + s^gamma").unwrap().at(&heater());
    near(&power.divisors().iter().map(at).collect::<Vec<_>>(), &[s]);
}

#[test]
fn exact_what_varies_as_fast_as_a_delay_is_not_algebraic() {
    let algebraic = |text: &str| parse(text).unwrap().is_algebraic();
    assert!(algebraic("s*rho + k1*s^2 - sqrt(s*k2)/(s + 1)^k1"));
    for other in ["exp(-s*k1)", "1 + tanh(s*k2)", "2^s", "s^(1 + s)"] {
        assert!(!algebraic(other), "{other}");
    }
}

#[test]
fn exact_a_formula_of_s_alone_has_the_same_value() {
    let formula = parse("k1*rho*s/(D + exp(-s*k2)*k1^2) - k2").unwrap();
    let (numbers, values) = (heater(), [0.37, 2.5e-3]);
    let s = ComplexDual { value: C64::new(-20.0, 900.0), slope: C64::ONE };
    let mut analytic = [None; 8];
    analytic[scope().find("s").unwrap()] = Some(&s);
    let here = Here { space: JetSpace::new(1, Order::First), numbers: &numbers, analytic: &analytic };
    let (whole, alone) =
        (formula.evaluate_in_s(&here, &values), formula.of_s(&numbers, &values).evaluate_in_s(&here, &[]));
    assert_eq!((whole.value, whole.slope), (alone.value, alone.slope));
    assert!(!formula.of_s(&numbers, &values).uses_parameter(0), "parameters are numbers");
    assert!(formula.of_s(&numbers, &values[..1]).uses_parameter(1), "one without a value stays");
}
