//! Units of formulas.

use super::*;

fn unit_fault(unit: &str, wanted: &str, law: &str, definitions: &[(&str, &str)]) -> Option<String> {
    let formula = parse_without(law, &[], definitions).unwrap();
    formula.unit_fault(&scope(), &[unit, unit, unit], wanted)
}

#[test]
fn exact_units_that_do_not_agree_are_told() {
    let fault = |unit: &str, wanted: &str, law: &str| unit_fault(unit, wanted, law, &[]);
    assert_eq!(fault("1/W", "1", "-k1*Q_h"), None);
    assert_eq!(fault("1", "1", "-k1*Q_h").unwrap(), "its unit is kg m^2 s^-3, where 1 is wanted");
    assert_eq!(fault("s", "1", "exp(-s*k1)"), None);
    assert_eq!(fault("1", "1", "exp(-s*k1)").unwrap(), "exp is applied to something of unit s^-1");
    let drag = "kg/(m^2 s)";
    assert_eq!(
        fault("1", drag, "k1*(rho + c)").unwrap(),
        "something of unit m s^-1 is added to something of unit kg m^-3"
    );
    assert_eq!(fault("1", drag, "k1").unwrap(), "its unit is 1, where kg m^-2 s^-1 is wanted");
    assert_eq!(fault("1", drag, "k1*wall_mu*D"), None);
    assert!(fault("1", "kg/(m^3 s)", "k1*wall_mu*D").is_some());
    assert_eq!(fault("1/W^k", "1", "k1*Q_h^2"), None, "not to be told");
    assert_eq!(fault("m", "1", "Q_h^k1").unwrap(), "an exponent has the unit m");
    assert_eq!(fault("K", "1", "(T - 273.15)/k1"), None, "numbers have any unit");
    assert_eq!(fault("1", "m", "0"), None);
    assert_eq!(fault("1", "m", "2*3").unwrap(), "it is a number, where m is wanted");
    assert_eq!(
        fault("1", "furlong", "k1*D + c").unwrap(),
        "something of unit m s^-1 is added to something of unit m"
    );
    assert_eq!(fault("1", "furlong", "k1*D"), None, "not to be told");
}

#[test]
fn regress_exponents_are_computed_and_angles_have_no_unit() {
    // Before, the power 1/2 was taken for 1, the power 3 - 1 for 1, and arg was refused.
    let fault = |wanted: &str, law: &str| unit_fault("m", wanted, law, &[]);
    assert_eq!(fault("m", "(D*heater.length)^(1/2)"), None);
    assert_eq!(fault("m^2", "D^(3 - 1)"), None);
    assert_eq!(fault("m", "(D^4)^(1/sqrt(16))"), None);
    assert_eq!(fault("1", "arg(k1 + i*k2)"), None);
    assert_eq!(fault("1", "bessel_ratio(D)").unwrap(), "bessel_ratio is applied to something of unit m");
}

#[test]
fn exact_units_are_followed_through_definitions() {
    let lag = [("tau", "k1*D/c"), ("lag", "exp(-s*tau)")];
    assert_eq!(unit_fault("1", "1", "lag*lag", &lag), None);
    assert_eq!(unit_fault("m", "1", "lag*lag", &lag).unwrap(), "exp is applied to something of unit m");
    assert_eq!(unit_fault("1", "m", "area/D", &[("area", "k1*D^2")]), None);
    assert!(unit_fault("1", "m", "area", &[("area", "k1*D^2")]).is_some());
}

#[test]
fn exact_units_are_understood_or_not() {
    for (_, unit, ..) in HEATER {
        assert!(crate::is_unit(unit), "{unit}");
    }
    assert!(crate::is_unit(&scope().names()[0].unit) && crate::is_unit("W/(m K)"));
    assert!(!crate::is_unit("1/W^k_3") && !crate::is_unit("furlong") && !crate::is_unit("m^"));
}

#[test]
fn exact_units_are_those_of_the_si() {
    let differs = |unit: &str, wanted: &str| unit_fault(unit, wanted, "k1", &[]);
    for (unit, same) in [
        ("rad", "1"),
        ("Hz", "1/s"),
        ("N", "kg m/s^2"),
        ("Pa", "N/m^2"),
        ("J", "N m"),
        ("W", "J/s"),
        ("W", "kg m^2/s^3"),
        ("m^-1.5", "1/m^1.5"),
    ] {
        assert_eq!(differs(unit, same), None, "{unit}");
    }
    let base = ["1", "kg", "m", "s", "K"];
    for unit in base {
        for other in base.into_iter().filter(|other| *other != unit) {
            let expected = format!("its unit is {unit}, where {other} is wanted");
            assert_eq!(differs(unit, other), Some(expected));
        }
    }
}

#[test]
fn exact_every_operation_has_its_unit() {
    for (wanted, law) in [
        ("1/m", "D^-1"),
        ("1/m^0.5", "D^(-0.5)"),
        ("m^0.5", "sqrt(D)"),
        ("m", "-D + 2"),
        ("m", "3 - D"),
        ("m", "re(D) + im(i*D) - abs(D)*conj(2)"),
        ("K m", "T*D"),
        ("K/m", "T/D"),
        ("1/m", "2/D"),
        ("1", "(D/heater.length)^k1"),
        ("1", "2^(D/heater.length)*gamma^k1"),
    ] {
        assert_eq!(unit_fault("1", wanted, law, &[]), None, "{law}");
        assert!(unit_fault("1", "kg", law, &[]).is_some(), "{law}");
    }
    let fault = |law: &str| unit_fault("1", "1", law, &[]).unwrap();
    assert_eq!(fault("D - T"), "something of unit K is taken from something of unit m");
    assert_eq!(fault("2^D"), "an exponent has the unit m");
    assert_eq!(fault("sin(D)"), "sin is applied to something of unit m");
    assert_eq!(unit_fault("1", "m", "2 - 2", &[]), None, "zero has any unit");
}
