//! Units of quantities: what is read, what it is in SI, and what is refused with which words.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may fail by panicking")]

use rijke_rig::{Given, Heading, Quantity, Unit};
use std::f64::consts::{PI, TAU};

#[track_caller]
fn is(text: &str, wanted: &str, value: f64) {
    let found = Quantity::parse(text).and_then(|q| q.of(wanted)).unwrap_or_else(|e| panic!("{text}: {e}"));
    assert!((found - value).abs() <= 1e-14 * value.abs(), "{text} is {found} {wanted}, not {value}");
}

/// Factors from the definitions, written out here by hand.
#[test]
fn exact_quantities_in_si() {
    is("12 mm", "m", 0.012);
    is("12mm", "m", 0.012);
    is("-3.5e-2 m", "m", -0.035);
    is("1 in", "m", 0.0254);
    is("20 degC", "K", 293.15);
    is("20 °C", "K", 293.15);
    is("(degC)".replace('(', "20 (").as_str(), "K", 293.15);
    is("68 degF", "K", 293.15);
    is("6 L/min", "m^3/s", 1e-4);
    is("6 l/min", "m3/s", 1e-4);
    is("3.6 m³/h", "m^3/s", 1e-3);
    is("50 mV/Pa", "V/Pa", 0.05);
    is("1 kg/(m^2 s)", "Pa s/m", 1.0);
    is("2 kg s^-1", "kg/s", 2.0);
    is("2 kg·s⁻¹", "kg/s", 2.0);
    is("2 kg*s-1", "kg/s", 2.0);
    is("0.025 W/(m degC)", "W/(m K)", 0.025);
    is("0.025 W/m/K", "W/(m K)", 0.025);
    is("1.2 kW", "W", 1200.0);
    is("1013.25 mbar", "Pa", 101_325.0);
    is("760 torr", "atm", 1.0);
    is("90 deg", "rad", PI / 2.0);
    is("35 us", "s", 35e-6);
    is("35 µs", "s", 35e-6);
    is("35 μs", "s", 35e-6);
    is("5 %", "1", 0.05);
    is("5", "1", 5.0);
    is("28.96 g/mol", "kg/mol", 0.028_96);
    is("7 1/s", "1/s", 7.0);
    is("20 degC", "degF", 68.0);
    for (text, wanted, value) in
        [("23.7 mm", "m", 0.0237), ("5 us", "s", 5e-6), ("49.3 mV/Pa", "V/Pa", 0.0493)]
    {
        assert_eq!(Quantity::parse(text).unwrap().of(wanted), Ok(value), "to the last bit");
    }
}

/// Cycles and radians are kept apart, and only these.
#[test]
fn exact_frequencies_and_angular_frequencies() {
    is("100 Hz", "Hz", 100.0);
    is("100 Hz", "rad/s", 100.0 * TAU);
    is("100 rad/s", "Hz", 100.0 / TAU);
    is("600 rpm", "Hz", 10.0);
    is("60 deg/s", "Hz", 1.0 / 6.0);
    is("100 kHz", "Hz", 1e5);
    is("6.2 rad/s", "1/s", 6.2);
    is("6.2 1/s", "rad/s", 6.2);
    for (have, wanted) in [("100 Hz", "1/s"), ("100 1/s", "Hz")] {
        let error = Quantity::parse(have).unwrap().of(wanted).unwrap_err().to_string();
        assert!(error.contains("write Hz or rad/s"), "{error}");
    }
}

#[test]
fn exact_a_difference_of_temperatures_has_no_offset() {
    let unit = Unit::parse("degC").unwrap();
    assert_eq!((unit.to_si(0.0), unit.difference_to_si(0.5)), (273.15, 0.5));
    let fahrenheit = Unit::parse("degF").unwrap().of("K").unwrap();
    assert!((fahrenheit.difference_to_si(9.0) - 5.0).abs() < 1e-14);
    assert_eq!((unit.factor(), unit.offset(), unit.dimension()), (1.0, 273.15, [0, 0, 0, 1, 0, 0]));
}

#[test]
fn exact_headings() {
    let read = |text: &str| Heading::parse(text).unwrap();
    for text in ["x [mm]", "x(mm)", "x / mm", " x[mm] "] {
        let heading = read(text);
        assert_eq!((heading.name.as_str(), heading.of("m").unwrap().to_si(12.0)), ("x", 0.012), "{text}");
    }
    for text in ["x/mm", "x, mm", "x,mm", "x/(mm)"] {
        let heading = read(text);
        assert_eq!((heading.name.as_str(), heading.of("m").unwrap().to_si(12.0)), ("x", 0.012), "{text}");
    }
    assert_eq!(
        (read("u/m/s").unit, read("U/V (Volts)").name),
        (Some(Unit::parse("m/s").unwrap()), "U/V".into())
    );
    // Neither is followed by a unit.
    for text in ["p1/p2", "left, right", "/V"] {
        assert_eq!((read(text).name.as_str(), read(text).unit), (text, None), "{text}");
    }
    assert_eq!(read("T (degC)").of("K").unwrap().to_si(20.0), 293.15);
    assert_eq!(read("gain [W/(m K)]").name, "gain");
    assert_eq!(read("k (W/(m K))").unit, Some(Unit::parse("W/(m K)").unwrap()));
    assert_eq!(read("n [-]").unit.unwrap().to_si(3.0), 3.0);
    assert_eq!((read("x_h").unit, read("p[1]").name, read("p[1]").unit), (None, "p[1]".into(), None));
    assert_eq!(read("n [1]").unit, Some(Unit::one()));
    assert_eq!(read("power").of("W").unwrap().to_si(3.0), 3.0);
}

#[test]
fn exact_a_key_is_a_number_or_a_text_with_a_unit() {
    #[derive(serde::Deserialize, serde::Serialize)]
    struct File {
        length: Given,
        radius: Given,
    }
    let file: File = toml::from_str("length = 1\nradius = \"23.7 mm\"").unwrap();
    assert_eq!((file.length.of("m"), file.radius.of("m")), (Ok(1.0), Ok(0.0237)));
    let again: File = toml::from_str(&toml::to_string(&file).unwrap()).unwrap();
    assert_eq!(again.radius, file.radius);
    let error = toml::from_str::<File>("length = [1]\nradius = 1").err().unwrap().to_string();
    assert!(error.contains("a number in SI units, or a text with a unit such as \"12 mm\""), "{error}");
}

#[test]
fn message_of_units_that_cannot_be_read() {
    let quantity = |text: &str| Quantity::parse(text).unwrap_err().to_string();
    let heading = |text: &str| Heading::parse(text).unwrap_err().to_string();
    for (said, part) in [
        (
            quantity("12 furlong"),
            "`furlong` in `furlong` is not a unit; known: 1, %, ppm, m nm um mm cm km, in, ft",
        ),
        (quantity("12 m/fortnight"), "`fortnight` in `m/fortnight` is not a unit"),
        (quantity("3 dB"), "`dB` in `dB` is not a unit"),
        (heading("flow [NL/min]"), "Normal and standard litres are a mass"),
        (
            Heading::parse("flow [g/s]").unwrap().of("m^3/s").unwrap_err().to_string(),
            "a volume flow is the mass flow over the density of the gas",
        ),
        (quantity("12,5 mm"), "`12,5 mm` is not a number with a unit"),
        (quantity("1 000 mm"), "with a decimal point"),
        (quantity("mm"), "is not a number with a unit"),
        (quantity("nan m"), "is not a number with a unit"),
        (quantity("1e999 m"), "is not a number with a unit"),
        (quantity(""), "is not a number with a unit"),
        (quantity("1 W/m K"), "has several factors behind a slash; write it as in m/s, W/(m K)"),
        (quantity("1 W/(m K"), "has brackets that do not match"),
        (quantity("1 W/((m) K)"), "has brackets that do not match"),
        (quantity("1 m/"), "has nothing beside a slash"),
        (quantity("1 m^0.5"), "has an exponent that is not a whole number"),
        (quantity("1 m^99"), "has an exponent beyond 1 to 9"),
        (quantity("1 m^0"), "has an exponent beyond 1 to 9"),
        (quantity("20 1 degC"), "is not a number with a unit"),
        (quantity("20 degC m/m"), "is a temperature in a product"),
        (quantity(&format!("1 {}", "m ".repeat(40))), "is longer than 64 bytes"),
        (heading("x [mm"), "has a bracket that does not close"),
        (heading("x mm]"), "closes a bracket that is not open"),
        (heading("[mm]"), "names no quantity"),
        (heading("T (top)"), "`top` in `top` is not a unit"),
        (
            Heading::parse("x [mm]").unwrap().of("s").unwrap_err().to_string(),
            "`mm` is not a unit of this quantity, which is in s",
        ),
        (
            Quantity::parse("3").unwrap().of("m").unwrap_err().to_string(),
            "which is in m; a pure number was given",
        ),
    ] {
        assert!(said.contains(part), "no `{part}` in: {said}");
    }
}
