//! Formulas that are asked where they do not hold: each is said, with a remedy.

use rijke_network::file::{DrivenQuantity, read};
use rijke_network::laws::Law;
use rijke_network::{NetworkError, Region};
use rijke_numerics::C64;
use std::f64::consts::PI;

/// A tube of two ducts of half a metre with an element between them.
fn tube(head: &str, duct: &str, element: &str) -> String {
    let duct = format!("[[element]]\ntype = 'duct'\nlength = 0.5\n{duct}\n");
    format!(
        "[search]\nfrequency_hz = [20, 600]\n{head}\n[upstream]\ntype = 'closed'\n[downstream]\ntype = 'unflanged'\n{duct}{element}\n{duct}"
    )
}

#[test]
fn message_what_is_out_of_range_is_said() {
    let flow = "[flow]\nmach = 0.02\nentropy_waves = false";
    let plate = "[[element]]\ntype = 'orifice'\ndiameter = 0.03\nthickness = 0.002\n";
    for (head, duct, element, said) in [
        ("[gas]\nprandtl = 7.07", "diameter = 0.1", "", "prandtl is 7.07, and gases have 0.1 to 1.5"),
        (
            "",
            "area = 7.0",
            "",
            "element 1 (duct): area is 7 m^2, so wide that a higher mode is cut on at 67 Hz",
        ),
        (
            "",
            "diameter = 0.1\ndiameter_end = 1.0",
            "",
            "diameter_end is 1 m, so wide that a higher mode is cut on at 201 Hz",
        ),
        ("", "diameter = 0.36\ntemperature = 200", "", "a higher mode is cut on at 462 Hz"),
        (
            "",
            "diameter = 1e-3\nwall = 'kirchhoff'",
            "",
            "`wall` leaves about 14 % of the loss out there, and more below; write wall = \"zwikker-kosten\"",
        ),
        (
            "",
            "diameter = 0.1\nsound_speed = 343\ndensity = 1.205\ntemperature = 900",
            "",
            "temperature has no effect: `sound_speed` and `density` say",
        ),
        (
            "",
            "diameter = 0.1",
            "[[element]]\ntype = 'helmholtz'\nvolume = 1e-4\nneck_area = 7.854e-5\nneck_length = 0.001",
            "even a neck without a wall moves 7.85 mm of air",
        ),
        (
            "",
            "diameter = 0.1",
            "[[element]]\ntype = 'orifice'\ndiameter = 0.02\nthickness = 0.05\nbias_velocity = 3",
            "thinner than its radius",
        ),
        (
            flow,
            "diameter = 0.1",
            plate,
            "the mean flow passes at 76.3 m/s through this plate and loses nothing there",
        ),
        (
            "[flow]\nmach = 0.1\nentropy_waves = false",
            "diameter = 0.1",
            "[[element]]\ntype = 'screen'\nopen_area = 0.1",
            "the mean flow loses 58 % of its pressure here",
        ),
        (
            "[flow]\nvelocity = 0.5",
            "diameter = 0.1",
            "",
            "an entropy wave takes 600 periods of the highest frequency to cross it",
        ),
    ] {
        let warnings = read(&tube(head, duct, element)).unwrap().warnings;
        assert!(warnings.iter().any(|w| w.to_string().contains(said)), "{said}: {warnings:?}");
    }
    let quiet = tube(
        flow,
        "diameter = 0.1\nwall = 'kirchhoff'",
        &plate.replace("thickness", "drag = 500\nthickness"),
    );
    // Of the end through which the flow enters, below.
    let quiet = quiet.replace("'closed'", "'constant'\nmodulus = 0.5\nangle = 0");
    assert!(read(&quiet).unwrap().warnings.is_empty(), "{:?}", read(&quiet).unwrap().warnings);
}

/// Gas that enters at a constant rate reflects (1 - M)/(1 + M); a closed end through which it is blown
/// feeds the modes of a tube that nothing drives.
#[test]
fn exact_a_closed_end_that_is_blown_through_is_said_and_its_remedy_feeds_nothing() {
    let flow = "[flow]\nmach = 0.05\nentropy_waves = false";
    let closed = tube(flow, "diameter = 0.1", "")
        .replace("'unflanged'", "'constant'\nmodulus = 0.904761905\nangle = 0");
    let built = read(&closed).unwrap();
    let said = built.warnings[0].to_string();
    assert!(said.contains("[upstream]: gas enters here") && said.contains("modulus 0.9048"), "{said}");
    let growth = |text: &str| {
        let built = read(text).unwrap();
        built.modes(&built.region).unwrap().modes.iter().map(|m| m.s.re).collect::<Vec<_>>()
    };
    // e^{2 s L/(c (1 - M^2))} = R_u R_d.
    let c = (1.4_f64 * 287.05 * 293.15).sqrt();
    let rate = |product: f64| 0.5 * c * (1.0 - 0.05_f64.powi(2)) * product.ln();
    let remedied = closed.replacen("'closed'", "'constant'\nmodulus = 0.904761905\nangle = 0", 1);
    assert!(read(&remedied).unwrap().warnings.is_empty());
    let kept = 0.95_f64 / 1.05;
    for (text, product) in [(&closed, kept), (&remedied, kept * kept)] {
        assert!(growth(text).iter().all(|sigma| (sigma - rate(product)).abs() < 1e-4), "{:?}", growth(text));
    }
}

#[test]
fn message_equal_resonators_at_one_place_and_sizes_that_are_none_are_said() {
    let resonator = "[[element]]\ntype = 'helmholtz'\nvolume = 1e-3\nneck_area = 3e-4\nneck_length = 0.04\n";
    let two = tube("", "diameter = 0.1", &format!("{resonator}{resonator}"));
    let other = two.replacen("volume = 1e-3", "volume = 1.0000001e-3", 1);
    let [twins, apart] = [&two, &other].map(|text| read(text).unwrap());
    let said = twins.warnings[0].to_string();
    assert!(twins.warnings.len() == 1 && said.contains("the two also ring against each other"), "{said}");
    assert!(apart.warnings.is_empty());
    // The mode that is said not to be counted.
    let count = |built: &rijke_network::file::Built| built.modes(&built.region).unwrap().modes.len();
    assert_eq!(count(&apart), count(&twins) + 1);
    for (head, element, said) in [
        ("[gas]\ngas_constant = 8.314", "", "the heaviest gas has 23"),
        ("[gas]\ngamma = 14", "", "no gas has more than 5/3"),
        ("", "[[element]]\ntype = 'screen'", "it does nothing"),
        ("", &resonator.replace("1e-3", "0.5"), "the cavity is not small beside the wavelength"),
        ("", &resonator.replace("0.04", "0.9"), "the neck is not small beside the wavelength"),
        ("", "[[element]]\ntype = 'quarter-wave'\nlength = 0.2\narea = 0.5", "its area is 0.500 m^2"),
    ] {
        let warnings = read(&tube(head, "diameter = 0.1", element)).unwrap().warnings;
        assert!(warnings.iter().any(|w| w.to_string().contains(said)), "{said}: {warnings:?}");
    }
    let wide = |diameter: f64| read(&tube("", &format!("diameter = {diameter}"), "")).unwrap().warnings;
    for diameter in [3.0, 5.0] {
        assert!(
            wide(diameter).iter().any(|w| w.to_string().contains("cut on")),
            "{diameter}: {:?}",
            wide(diameter)
        );
    }
}

/// Where gas is drawn in from rest, R = -(1 - M)/(1 + M). A uniform tube that is open at both ends then loses
/// by sigma = c (1 - M^2) ln((1 - M)/(1 + M))/(2 L).
#[test]
fn exact_a_mouth_that_draws_gas_in_is_said_and_its_remedy_keeps_total_pressure() {
    let flow = "[flow]\nmach = 0.05\nentropy_waves = false";
    let open =
        tube(flow, "diameter = 0.1", "").replace("'closed'", "'open'").replace("'unflanged'", "'open'");
    let built = read(&open).unwrap();
    let said = built.warnings[0].to_string();
    assert!(said.contains("[upstream]: gas is drawn in here") && said.contains("modulus 0.9048"), "{said}");
    assert!(built.warnings.len() == 1);
    let remedied =
        open.replacen("type = 'open'", "type = 'constant'\nmodulus = 0.904761905\nangle = 3.14159265", 1);
    let remedied = read(&remedied).unwrap();
    assert!(remedied.warnings.is_empty(), "{:?}", remedied.warnings);
    // p' + rho U u' = 0 upstream and p' = 0 downstream: e^{2 s L/(c (1 - M^2))} = (1 - M)/(1 + M).
    let c = (1.4_f64 * 287.05 * 293.15).sqrt();
    let expected = 0.5 * c * (1.0 - 0.05_f64.powi(2)) * (0.95_f64 / 1.05).ln();
    for mode in remedied.modes(&remedied.region).unwrap().modes {
        assert!((mode.s.re - expected).abs() < 1e-5, "{} {expected}", mode.s);
    }
}

#[test]
fn message_what_a_flow_does_not_tell_is_refused() {
    let flow = tube("[flow]\nmach = 0.1", "diameter = 0.1", "[[element]]\nname = 'mark'\ntype = 'feedback'");
    let built = read(&flow).unwrap();
    // Before, every place had the impedance of the upstream end.
    for place in ["mark", "downstream", "0.5"] {
        let error = built.driven(&DrivenQuantity::Port(place.into()), &[100.0]).unwrap_err();
        assert_eq!(error.to_string(), "with [flow] what the chain shows is known at its upstream end alone");
    }
    assert!(built.driven(&DrivenQuantity::Port("upstream".into()), &[100.0]).is_ok());
    // Before: "a law has a pole or is undefined there".
    let slow = read(&tube("[flow]\nvelocity = 0.5", "diameter = 0.1", "")).unwrap();
    let error = slow.modes(&slow.region).unwrap_err();
    assert!(matches!(error, NetworkError::EntropyWaves { .. }), "{error}");
    assert!(error.to_string().contains("entropy_waves = false"), "{error}");
}

/// Rayleigh's piston by its power series is good to |ka| = 8.
#[test]
fn behaviour_a_baffle_beyond_its_series_is_no_number() {
    let wide = tube("", "diameter = 2.985", "").replace("'unflanged'", "'flanged'");
    let r = |hz: f64| read(&wide).unwrap().driven(&DrivenQuantity::Port("downstream".into()), &[hz]);
    assert!(r(250.0).unwrap()[1].1[0].norm() < 1.0);
    assert!(r(700.0).unwrap_err().to_string().contains("not finite"));
}

/// The poles of Rayleigh's piston, where its impedance is -rho c, are counted with the modes beside them;
/// before, the search asked for them in words that no user can follow.
#[test]
fn exact_poles_of_a_baffle_are_declared() {
    let (a, c) = (0.15, 343.0);
    let law = Law::Flanged { radius: a, sound_speed: c };
    let region = Region { sigma: [-5000.0, 0.0], omega: [2.0 * PI * 1200.0, 2.0 * PI * 1700.0] };
    let poles = law.poles_in(&region).unwrap();
    // |k a| = 3.9529 + 1.7551 i by a search of its own in the power series.
    let expected = C64::new(0.0, 1.0) * C64::new(3.9529, 1.7551) * c / a;
    assert!(poles.len() == 1 && (poles[0].0 - expected).norm() < 2e-4 * expected.norm(), "{poles:?}");
    let duct = "[search]\nfrequency_hz = [1200, 1700]\ngrowth_rate = [-5000, 0]\n[upstream]\ntype = 'open'\n[downstream]\ntype = 'flanged'\n\
                [[element]]\ntype = 'duct'\nlength = 1.0\ndiameter = 0.3\n";
    let built = read(duct).unwrap();
    assert!(built.modes(&built.region).unwrap().modes.len() > 1);
}

/// A rigid end reflects all, and has no finite impedance.
#[test]
fn exact_a_rigid_end_has_a_port() {
    let built = read("[upstream]\ntype = 'unflanged'\n[downstream]\ntype = 'closed'\n[[element]]\ntype = 'duct'\nlength = 1.0\ndiameter = 0.05\n").unwrap();
    let port = built.driven(&DrivenQuantity::Port("downstream".into()), &[100.0]).unwrap();
    assert_eq!([port[0].1[0], port[1].1[0]], [C64::new(f64::INFINITY, 0.0), C64::ONE]);
}

#[test]
fn message_elements_and_ends_at_odds_with_themselves_are_said() {
    let hole =
        |at: f64| format!("[[element]]\ntype = 'side-hole'\nat = {at}\ndiameter = 0.02\nlength = 0.003\n");
    let holes = |apart: f64| hole(0.2) + &hole(0.2 + apart);
    let flame = |more: &str| format!("[[element]]\ntype = 'flame'\ngain = 0.1\ndelay = 1e-3\n{more}");
    let end = |keys: &str| tube("", "diameter = 0.1", "").replace("'unflanged'", keys);
    let with = |element: &str| tube("", "diameter = 0.1", element);
    for (text, said) in [
        (
            with(&holes(0.015)),
            Some("it is 0.0150 m from element 2 (side-hole), less than the sum of their radii"),
        ),
        (with(&holes(0.025)), None),
        (with(&flame("numerator = [1, 2e-3]")), Some("it grows without end with the frequency")),
        (with(&flame("numerator = [1, 2e-3]\ncutoff_hz = 200")), None),
        (with(&flame("numerator = [1, 2e-3]\ndenominator = [1, 1e-3, 1e-7]")), None),
        (
            end("'rational'\nnumerator = [0.1, 1e-5]\ndenominator = [1]"),
            Some("its numerator is of degree 1 in s"),
        ),
        (end("'impedance'"), Some("write `anechoic`")),
        (end("'impedance'\nnumerator = [0.1, 1e-4]"), None),
        (end("'unflanged'\nwall_thickness = 3"), Some("wall_thickness is 3.00 m, 60.0 radii of the mouth")),
        (end("'unflanged'\ncalibration = [1, 3]"), Some("if these are degrees, write 0.0524")),
        (end("'unflanged'\ncalibration = [0.99, 0.05]\nwall_thickness = 0.01"), None),
        (
            with("[[element]]\ntype = 'screen'\nopen_area = 0.4\nresistance = 20"),
            Some("open_area has no effect"),
        ),
    ] {
        let warnings = read(&text).unwrap().warnings;
        match said {
            Some(said) => {
                assert!(warnings.iter().any(|w| w.to_string().contains(said)), "{said}: {warnings:?}")
            }
            None => assert!(warnings.is_empty(), "{text}: {warnings:?}"),
        }
    }
}
