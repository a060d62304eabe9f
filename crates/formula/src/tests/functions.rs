//! Functions with their derivatives, against contour integrals and closed forms.

use super::*;
use rijke_numerics::special::bessel_ratio;
use std::f64::consts::{FRAC_PI_2, LN_2, SQRT_2};

/// Value, slope and curvature of a formula of s.
fn in_s(text: &str, s: C64) -> [C64; 3] {
    let at = jet(&parse(text).unwrap(), &heater(), Order::Second, &[POINT[0], POINT[1], POINT[2], s]);
    [at.value(), at.gradient()[3], at.hessian(3, 3)]
}

/// The same function by another route.
type Route = fn(C64) -> C64;

fn near(text: &str, found: C64, expected: C64, relative: f64) {
    assert!((found - expected).norm() <= relative * expected.norm(), "{text}: {found}, not {expected}");
}

#[test]
fn oracle_functions_and_their_derivatives_are_contour_integrals() {
    // f^(n)(z) = n!/(2 pi i) times the integral of f(w)/(w - z)^(n + 1), by the trapezoidal rule.
    let functions: [(&str, Route); 13] = [
        ("sqrt(s)", |z| z.sqrt()),
        ("exp(s)", |z| z.exp()),
        ("ln(s)", |z| z.ln()),
        ("log(s)", |z| z.ln()),
        ("sin(s)", |z| z.sin()),
        ("cos(s)", |z| z.cos()),
        ("tan(s)", |z| z.sin() / z.cos()),
        ("sinh(s)", |z| z.sinh()),
        ("cosh(s)", |z| z.cosh()),
        ("tanh(s)", |z| z.sinh() / z.cosh()),
        ("bessel_ratio(s)", bessel_ratio),
        ("howe(s)", |z| rijke_numerics::howe(z)[0]),
        ("(s)^(-3)*(s)^0.7*(s)^(1 + 2i)", |z| z.powc(C64::new(-1.3, 2.0))),
    ];
    for z in [C64::new(1.9, 0.8), C64::new(2.2, -1.3)] {
        for (text, f) in functions {
            let (radius, points) = (0.4, 48);
            let mut moments = [C64::ZERO; 3];
            for k in 0..points {
                let turn = C64::from_polar(1.0, std::f64::consts::TAU * f64::from(k) / f64::from(points));
                let mut share = f(z + radius * turn) / f64::from(points);
                for (moment, factorial) in moments.iter_mut().zip([1.0, 1.0, 2.0]) {
                    *moment += factorial * share;
                    share /= radius * turn;
                }
            }
            for (found, expected) in in_s(text, z).into_iter().zip(moments) {
                near(text, found, expected, 1e-12);
            }
            // And the route of plain numbers.
            let number = text.replace("(s)", &format!("({} + {}i)", z.re, z.im));
            near(&number, value(&number), f(z), 1e-14);
        }
    }
}

#[test]
fn exact_tangents_far_out_have_slopes_that_fall() {
    // sech^2 z = 4 e^-2|z| beyond 20, where 1 - tanh^2 is 0.
    for (re, sign) in [(21.0, 1.0), (40.0, 1.0), (-21.0, -1.0), (-40.0, -1.0)] {
        let s = C64::new(re, 0.3);
        let slope = 4.0 * (-2.0 * sign * s).exp();
        for (found, expected) in in_s("tanh(s)", s).into_iter().zip([sign.into(), slope, -2.0 * sign * slope])
        {
            near("tanh(s)", found, expected, 1e-13);
        }
        // tan z = -i tanh(i z), with s for i z.
        let tan = in_s("tan(s)", -C64::I * s);
        for (found, expected) in tan.into_iter().zip([-C64::I * sign, slope, -2.0 * C64::I * sign * slope]) {
            near("tan(s)", found, expected, 1e-13);
        }
    }
}

#[test]
fn exact_whole_powers_have_derivatives_at_zero() {
    for (text, expected) in [
        ("s^0", [1.0, 0.0, 0.0]),
        ("s^1", [0.0, 1.0, 0.0]),
        ("s^2", [0.0, 0.0, 2.0]),
        ("s^3", [0.0, 0.0, 0.0]),
    ] {
        assert_eq!(in_s(text, C64::ZERO), expected.map(C64::from), "{text}");
    }
    assert_eq!(in_s("s^1.5", C64::ZERO)[..2], [C64::ZERO; 2]);
    // A limit only where the exponent is positive.
    assert!(in_s("0^s", C64::ZERO)[0].is_nan());
}

#[test]
fn exact_powers_of_numbers() {
    for (text, expected) in [
        ("0^0.5", C64::ZERO),
        ("0^0", C64::ONE),
        ("4^0.5", C64::new(2.0, 0.0)),
        ("0.25^0.5", C64::new(0.5, 0.0)),
        ("(3 + 4i)^0.5", C64::new(2.0, 1.0)),
        ("(-4)^0.5", C64::new(0.0, 2.0)),
        ("(2i)^(-3)", C64::new(0.0, 0.125)),
        ("4^i", C64::from_polar(1.0, 2.0 * LN_2)),
        ("2^(0.5 + i)", C64::from_polar(SQRT_2, LN_2)),
        ("i^i", C64::new((-FRAC_PI_2).exp(), 0.0)),
        ("2^(-70)", C64::new(2f64.powi(-70), 0.0)),
        ("2^65.5", C64::new(2f64.powi(65) * SQRT_2, 0.0)),
    ] {
        assert!((value(text) - expected).norm() <= 1e-15 * expected.norm(), "{text}: {}", value(text));
    }
    // What carries derivatives, as an exponent.
    near("2^s", in_s("2^s", C64::new(0.5, 1.0))[1], LN_2 * C64::from_polar(SQRT_2, LN_2), 1e-14);
}

/// Re z, Im z, conj z, |z| and arg z with the derivatives that a step of z has.
fn parts(z: C64, step: C64) -> [(&'static str, C64, C64); 5] {
    let along = z.conj() * step;
    [
        ("re", z.re.into(), step.re.into()),
        ("im", z.im.into(), step.im.into()),
        ("conj", z.conj(), step.conj()),
        ("abs", z.norm().into(), (along.re / z.norm()).into()),
        ("arg", z.arg().into(), (along.im / z.norm_sqr()).into()),
    ]
}

#[test]
fn exact_parts_and_moduli_of_what_depends_on_parameters() {
    let z = C64::new(POINT[0].re, POINT[2].re);
    let one = parts(z, C64::ONE);
    for ((name, value, slope), (_, _, across)) in one.into_iter().zip(parts(z, C64::I)) {
        let text = format!("{name}(k1 + i*k3)");
        let found = jet(&parse(&text).unwrap(), &heater(), Order::First, &POINT);
        near(&text, found.value(), value, 1e-15);
        for (found, expected) in found.gradient().iter().zip([slope, C64::ZERO, across, C64::ZERO]) {
            assert!((found - expected).norm() < 1e-15, "{text}: {found}, not {expected}");
        }
    }
    // Second derivatives of the modulus and the angle.
    let (found, cube) =
        (|text| jet(&parse(text).unwrap(), &heater(), Order::Second, &POINT), z.norm().powi(3));
    near("abs", found("abs(k1 + i*k3)").hessian(0, 0), (z.im * z.im / cube).into(), 1e-14);
    near("abs", found("abs(k1 + i*k3)").hessian(0, 2), (-z.re * z.im / cube).into(), 1e-14);
    let angle = (z.im * z.im - z.re * z.re) / z.norm_sqr().powi(2);
    near("arg", found("arg(k1 + i*k3)").hessian(0, 2), angle.into(), 1e-14);
}

#[test]
fn exact_parts_and_moduli_of_numbers_and_in_s_alone() {
    let (numbers, name) = (heater(), 6);
    assert_eq!(scope().names()[name].name, "D");
    let [value_of_d, slope_of_d] = [0.03, 0.7].map(|x| C64::new(x, 0.0));
    let factor = C64::new(-2.0, 3.0);
    let d = ComplexDual { value: value_of_d, slope: slope_of_d };
    let mut analytic = [None; 7];
    analytic[name] = Some(&d);
    let here = Here { space: JetSpace::new(0, Order::Value), numbers: &numbers, analytic: &analytic };
    for (function, expected, slope) in parts(factor * value_of_d, factor * slope_of_d) {
        let text = format!("{function}((3i - 2)*D)");
        let found = parse(&text).unwrap().evaluate_in_s(&here, &[]);
        near(&text, found.value, expected, 1e-15);
        assert!((found.slope - slope).norm() < 1e-14, "{text}: {}", found.slope);
    }
    for (function, expected, _) in parts(factor, C64::ZERO) {
        let text = format!("{function}(3i - 2)");
        near(&text, value(&text), expected, 1e-15);
    }
}
