//! Network files: what they build, what they refuse, and that nothing makes the reader panic.

use crate::common_laws::c;
use crate::eigenvalues::eigenvalues;
use rijke_network::file::{ElementProblem, FileError, Warning, read};
use rijke_network::laws::{Law, LawSet};
use rijke_network::{At, Coefficients, Laws, NetworkError, Workspace, levine_schwinger};
use rijke_numerics::C64;
use rijke_numerics::check::slopes_from;
use std::f64::consts::PI;

const ENDS: &str = "[upstream]\ntype = \"open\"\n[downstream]\ntype = \"open\"\n";

fn modes(text: &str) -> Vec<C64> {
    let built = read(text).unwrap();
    let found = built.network.modes(&built.laws, &built.region, &mut Workspace::default()).unwrap();
    found.modes.iter().map(|m| m.s).collect()
}

#[track_caller]
fn close(got: C64, expected: C64, relative: f64) {
    assert!((got - expected).norm() < relative * expected.norm(), "{got} against {expected}");
}

#[test]
fn oracle_files_give_the_reference_eigenvalues() {
    let text = "
        [gas]
        gas_constant = 287.05
        pressure = 101325.0
        [search]
        growth_rate = [-500, 100]
        frequency_hz = [50, 800]
        [upstream]
        type = 'closed'
        [downstream]
        type = 'open'
        [[element]]
        type = 'duct'
        length = 0.25
        diameter = 0.1
        temperature = 300
        [[element]]
        type = 'flame'
        n = 1.0
        delay = 1e-3
        [[element]]
        type = 'duct'
        length = 0.25
        diameter = 0.1
        temperature = 1200
    ";
    let expected = eigenvalues("hot_cold_tube_n_tau")[0];
    assert!(modes(text).iter().any(|s| (s - expected).norm() < 1e-9 * expected.norm()));
    let text = "
        [gas]
        temperature = 293.0953791026949
        viscosity = 1.8134e-5
        [search]
        frequency_hz = [100, 200]
        growth_rate = [-50, 50]
        [upstream]
        type = 'constant'
        modulus = 0.9975
        angle = 3.0550
        [downstream]
        type = 'constant'
        modulus = 0.9975
        angle = 3.0550
        [[element]]
        type = 'duct'
        length = 1.0
        diameter = 0.0474
        sound_speed = 343.2
        density = 1.2041
        wall = 'paper'
    ";
    close(modes(text)[0], eigenvalues("rig_tube_wall_loss_continuum")[0], 1e-9);
    let lumped = text.replace("wall = 'paper'", "wall = 'paper'\nscheme = 'lumped'\npieces = 40");
    close(modes(&lumped)[0], eigenvalues("rig_tube_wall_loss_N40_interior_jumps")[0], 1e-9);
}

#[test]
fn exact_examples_are_certified_and_their_budgets_close() {
    for text in [
        include_str!("../../../../fixtures/networks/rig-tube.toml"),
        include_str!("../../../../fixtures/networks/rijke-tube.toml"),
        include_str!("../../../../fixtures/networks/combustor.toml"),
    ] {
        let built = read(text).unwrap();
        let mut work = Workspace::default();
        let found = built.network.modes(&built.laws, &built.region, &mut work).unwrap();
        assert!(found.counted >= 4);
        for mode in &found.modes {
            let root = rijke_network::Root { s: mode.s, steps: 0, residual: 0.0 };
            let budget = built.network.budget(&built.laws, &root, &mut work);
            assert!(budget.mismatch() < 1e-8, "{budget:?}");
            assert!(!built.passive || mode.s.re < 0.0);
        }
    }
}

#[test]
fn exact_resonators_against_their_own_equation() {
    // A closed-closed tube with a Helmholtz resonator at the far end is p = cos(kx) with
    // -i tan(kL) A/(rho c) + s/(m s^2 + k) = 0.
    let text = "
        [search]
        growth_rate = [-20, 20]
        frequency_hz = [20, 1000]
        [upstream]
        type = 'closed'
        [downstream]
        type = 'closed'
        [[element]]
        type = 'duct'
        length = 0.8
        area = 2e-3
        sound_speed = 340.0
        density = 1.22
        [[element]]
        type = 'helmholtz'
        volume = 1e-3
        neck_area = 3e-4
        neck_length = 0.04
    ";
    let found = modes(text);
    assert!(found.len() >= 5);
    for s in found {
        let (rho, speed) = (1.22, 340.0);
        let line = (s * (0.8 / speed)).tanh() * (2e-3 / (rho * speed));
        let resonator = s / (s * s * (rho * 0.04 / 3e-4) + rho * speed * speed / 1e-3);
        assert!((line + resonator).norm() < 1e-12 * line.norm(), "at {s}");
    }
    // A quarter-wave tube at the far end of a duct of the same width just lengthens it.
    let text = text.replace(
        "type = 'helmholtz'\n        volume = 1e-3\n        neck_area = 3e-4\n        neck_length = 0.04",
        "type = 'quarter-wave'\n        area = 2e-3\n        length = 0.3",
    );
    for (k, s) in modes(&text).iter().enumerate() {
        close(*s, c(0.0, PI * (k + 1) as f64 * 340.0 / 1.1), 1e-12);
    }
}

#[test]
fn exact_velocity_reference_at_a_distance() {
    // A reference at the closed inlet sees no velocity: the flame does nothing there.
    let with = |reference: f64| {
        modes(&format!(
            "[search]\nfrequency_hz = [20, 900]\ngrowth_rate = [-100, 100]\n[upstream]\ntype = 'closed'\n\
             [downstream]\ntype = 'constant'\nmodulus = 0.9\nangle = 3.1\n\
             [[element]]\ntype = 'duct'\nlength = 0.4\ndiameter = 0.1\n\
             [[element]]\ntype = 'flame'\ngain = 0.5\ndelay = 2e-3\nreference = {reference}\n\
             [[element]]\ntype = 'duct'\nlength = 0.6\ndiameter = 0.1\n"
        ))
    };
    let silent = with(0.4);
    let passive = modes(
        "[search]\nfrequency_hz = [20, 900]\ngrowth_rate = [-100, 100]\n[upstream]\ntype = 'closed'\n\
         [downstream]\ntype = 'constant'\nmodulus = 0.9\nangle = 3.1\n\
         [[element]]\ntype = 'duct'\nlength = 1.0\ndiameter = 0.1\n",
    );
    assert_eq!(silent.len(), passive.len());
    for (a, b) in silent.iter().zip(&passive) {
        close(*a, *b, 1e-12);
    }
    assert!((with(0.1)[0] - passive[0]).norm() > 1.0);
}

#[test]
fn exact_ends() {
    let value = |law: Law, s: C64| {
        let set = LawSet { laws: vec![("end".to_owned(), law)], ..LawSet::default() };
        let mut laws = Laws::default();
        let at = At::search(s);
        laws.reset(1, &at);
        set.fill(&at, &mut laws);
        laws.value(0)
    };
    // Impedance 1 absorbs everything; impedance -> infinity is closed.
    let impedance = |z: f64| {
        let z = Law::Transfer { gain: z, numerator: vec![1.0], denominator: vec![1.0], delay: 0.0 };
        value(Law::Impedance(Box::new(z)), c(0.0, 1000.0))
    };
    assert!(impedance(1.0).norm() < 1e-15 && (impedance(1e12) - 1.0).norm() < 1e-11);
    // The baffled piston tends to the end correction 8/(3 pi) and to the radiation of a baffled source, |R| =
    // 1 - (ka)^2 (twice that of a free end); the baffled value of J1 and the Struve function at 2ka = 2 from
    // tables.
    let (radius, speed) = (0.02, 340.0);
    let at_ka = |ka: f64| value(Law::Flanged { radius, sound_speed: speed }, c(0.0, ka * speed / radius));
    let small = at_ka(1e-3);
    assert!(((PI - small.arg()) / 2e-3 - 8.0 / (3.0 * PI)).abs() < 1e-6);
    assert!(((1.0 - small.norm()) / 1e-6 - 1.0).abs() < 1e-5);
    let z = (1.0 + at_ka(1.0)) / (1.0 - at_ka(1.0));
    // 1 - J1(2) = 0.423275192, H1(2) = 0.646763748 (Abramowitz & Stegun, tables 9.1 and 12.1).
    assert!((z - c(0.423_275_192, 0.646_763_728)).norm() < 2e-8, "{z}");
    // A thin wall is Levine and Schwinger's; a thick one tends to the flanged correction 0.8216.
    let law = Law::Unflanged { radius, sound_speed: speed, correction: 0.0 };
    let exact = levine_schwinger::reflection(c(0.3, 0.0))[0];
    close(value(law, c(0.0, 0.3 * speed / radius)), exact, 1e-14);
    assert!(rijke_network::laws::thick_wall_correction(1.0, 0.0).abs() < 1e-12);
    assert!((rijke_network::laws::thick_wall_correction(1.0, 1e9) - (0.8216 - 0.6133)).abs() < 1e-8);
}

#[test]
fn order_laws_differentiate_in_s() {
    let transfer = Law::Transfer {
        gain: -0.3,
        numerator: vec![1.0, 2e-4],
        denominator: vec![1.0, 1e-3, 4e-7],
        delay: 2e-3,
    };
    let all = [
        Law::Linear { constant: c(1.0, 2.0), per_s: c(0.1, 0.0) },
        Law::Helmholtz { duct_area: 1e-3, inertance: 160.0, resistance: 1e4, stiffness: 1.4e8 },
        Law::QuarterWave { area_ratio: 0.5, length: 0.1, sound_speed: 340.0, impedance: 400.0 },
        Law::Unflanged { radius: 0.02, sound_speed: 340.0, correction: 0.1 },
        Law::Scaled(Box::new(Law::Flanged { radius: 0.02, sound_speed: 340.0 }), c(0.9, 0.1)),
        Law::Impedance(Box::new(transfer.clone())),
        transfer,
    ];
    let laws = all.iter().map(|l| (String::new(), l.clone())).collect();
    let set = LawSet { laws, ..LawSet::default() };
    let values = |s: C64| {
        let at = At::full(s, 0, rijke_numerics::Order::Second);
        let mut laws = Laws::default();
        laws.reset(set.laws(), &at);
        set.fill(&at, &mut laws);
        laws
    };
    let (s, step) = (c(-30.0, 900.0), c(120.0, 200.0));
    let base = values(s);
    for law in 0..set.laws() {
        let [v, d, dd] = [base.value(law), base.gradient(law)[0], base.hessian(law)[0]];
        if dd == C64::ZERO {
            continue; // linear: exact
        }
        // Remainders that have reached rounding say nothing; zero leaves them out.
        let seen = |r: C64| if r.norm() > 1e-11 * v.norm() { r.norm() } else { 0.0 };
        let first = |h: f64| seen(values(s + step * h).value(law) - v - d * step * h);
        let second =
            |h: f64| seen(values(s + step * h).value(law) - v - d * step * h - 0.5 * dd * (step * h).powi(2));
        for (slopes, order) in [(slopes_from(0.03, first), 2.0), (slopes_from(0.06, second), 3.0)] {
            let last = slopes[slopes.len() - 1];
            assert!((last - order).abs() < 0.06, "law {law}: {slopes:.4?}");
        }
    }
}

#[test]
fn exact_mistakes_in_files_are_named() {
    let duct = "[[element]]\nname = \"tube\"\ntype = \"duct\"\nlength = 1.0\ndiameter = 0.05\n";
    let said = |text: &str| read(text).unwrap_err().to_string();
    assert_eq!(read(ENDS).unwrap_err(), FileError::NoDuct);
    let negative = format!("{ENDS}{}", duct.replace("1.0", "-1.0"));
    assert_eq!(
        said(&negative),
        "line 5: element 1 `tube` (duct): length is -1, but must be positive and finite"
    );
    let cold = format!("{ENDS}{duct}temperature = -3\n");
    assert!(said(&cold).contains("temperature is -3"));
    let unknown = said(&format!("{ENDS}{duct}[[element]]\ntype = \"horn\"\n"));
    assert!(
        unknown.starts_with("line 10: element 2 (horn): `horn` is not known; known here: duct"),
        "{unknown}"
    );
    let key = said(&format!("{ENDS}{duct}lenght = 2\n"));
    assert!(
        key.contains("element 1 `tube`") && key.contains("lenght") && key.contains("temperature"),
        "{key}"
    );
    let far = format!(
        "{ENDS}{duct}[[element]]\ntype = \"flame\"\ngain = 1\nreference = 2.0\n{}",
        duct.replace("tube", "other")
    );
    assert!(matches!(
        read(&far),
        Err(FileError::Element {
            line: 10,
            problem: ElementProblem::ReferenceOutside { length: 1.0, .. },
            ..
        })
    ));
    let choked = format!("[upstream]\ntype = \"open\"\n[downstream]\ntype = \"choked\"\nmach = 0.4\n{duct}");
    assert!(matches!(read(&choked), Err(FileError::Element { problem: ElementProblem::TooFast { .. }, .. })));
    let both = said(&format!("{ENDS}{duct}area = 0.1\n"));
    assert!(both.ends_with("give either diameter or area"), "{both}");
    assert!(said("[upstream\n").contains("line 1"));
    // Doubtful, not wrong: pressure that does not fit, |R| above one.
    let odd = format!(
        "[upstream]\ntype = \"constant\"\nmodulus = 1.2\nangle = 3.0\n[downstream]\ntype = \"open\"\n{duct}\
         sound_speed = 343.0\ndensity = 1.1\n"
    );
    let built = read(&odd).unwrap();
    assert!(matches!(built.warnings[0], Warning::Pressure { line: 7, .. }));
    assert!(
        matches!(built.warnings[1], Warning::Reflection { modulus, .. } if (modulus - 1.2).abs() < 1e-12)
    );
    assert!(!built.passive);
    // A law with an undeclared essential singularity cannot be built from a file; an empty region is refused.
    let empty = format!("[search]\nfrequency_hz = [5, 1]\n{ENDS}{duct}");
    assert!(matches!(read(&empty), Err(FileError::Search { line: 1, key: "frequency_hz" })));
    let none = NetworkError::Empty;
    assert!(!none.is_recoverable());
}

/// What is possible and does nothing, or is most often in another unit, is said; what cannot be is refused.
#[test]
fn message_keys_without_effect_and_impossible_devices() {
    let tube = |gas: &str, duct: &str, device: &str| {
        format!(
            "[gas]\ntemperature = 293.15\n{gas}\n{ENDS}[[element]]\nname = \"a\"\ntype = \"duct\"\nlength = 0.5\ndiameter = 0.07\n{duct}\n\
             [[element]]\nname = \"device\"\n{device}\n[[element]]\nname = \"b\"\ntype = \"duct\"\nlength = 0.8\ndiameter = 0.08\n"
        )
    };
    const FLAME: &str = "type = \"flame\"\ngain = 0.5\ndelay = 1e-3";
    assert!(read(&tube("", "", FLAME)).unwrap().warnings.is_empty());
    for (gas, duct, device, says) in [
        ("", "", "type = \"flame\"\nn = 0.3\ndelay = 1e-3", "n has no effect"),
        ("", "", "type = \"screen\"\nloss = 2", "loss has no effect"),
        ("", "wall_factor = 2", FLAME, "wall_factor has no effect"),
        ("", "scheme = \"lumped\"", FLAME, "scheme has no effect"),
        ("pressure = 101.325", "", FLAME, "if these are kPa, write 101325"),
        ("pressure = 4e3", "", FLAME, "less than in any rig"),
        ("pressure = 1e9", "", FLAME, "rigs have at most 100000000"),
        ("", "temperature = 150", FLAME, "if these are degrees Celsius, write 423.15"),
        ("pressure = 1.013", "", FLAME, "if these are bar, write 101300"),
        ("pressure = 15", "", FLAME, "if these are bar, write 1500000"),
        (
            "",
            "temperature = 1800",
            "type = \"flame\"\nn = 0.3\ndelay = 1e-3",
            "the gas is colder behind the flame, 293.15 K after 1800 K",
        ),
        (
            "",
            "temperature = 200",
            "type = \"flame\"\nn = 1\ntable = [[50, 80, 0], [100, 80, 0], [200, 80, 0]]",
            "its largest gain is 80.0, and a flame answers with about 1; if the table is in per cent",
        ),
        (
            "",
            "",
            "type = \"flame\"\ngain = 0.3\ntable = [[0.05, 1, -0.6], [0.15, 1, -1.8], [0.25, 1, -3], [0.35, 1, -4.2], [0.6, 1, -7.2]]\ntolerance = 0.01",
            "if its frequencies are in kHz, multiply them by 1000",
        ),
        (
            "",
            "",
            "type = \"orifice\"\nthickness = 1e-3\ndiameter = 0.01\nbias_velocity = 500",
            "faster than the 10",
        ),
    ] {
        let warnings = read(&tube(gas, duct, device)).unwrap().warnings;
        assert!(warnings.iter().any(|w| w.to_string().contains(says)), "no `{says}` in {warnings:?}");
    }
    for (device, says) in [
        ("type = \"orifice\"\nthickness = 1e-3\ndiameter = 0.06\nporosity = 0.1", "0.735 of the duct's area"),
        ("type = \"flame\"\ngain = 0.5\ndenominator = [1.0, -1e-3]", "grows for ever"),
    ] {
        let refused = read(&tube("", "", device)).unwrap_err().to_string();
        assert!(refused.contains(says) && refused.starts_with("line "), "{refused}");
    }
    let twice = tube("", "", FLAME).replace("\"b\"", "\"a\"");
    let refused = read(&twice).unwrap_err().to_string();
    assert!(refused.contains("element 1 has that name, too"), "{refused}");
}
