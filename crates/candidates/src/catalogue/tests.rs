//! Order of parameters, messages about faults, and the catalogues of the paper: numbers of parameters and laws.

use super::*;
use crate::Here;
use crate::testing::surroundings;
use rijke_numerics::{C64, JetSpace, Order};

const GOOD: &str = r#"
[[candidate]]
id = "a"
role = "heater"
name = "n-tau"
cite = ["own judgement"]
parameters.k2 = { symbol = "k_2", unit = "s", prior = { normal = { mean = 1e-3, sd = 1e-3 } } }
parameters.k1 = { symbol = "k_1", unit = "1/W", prior = { normal = { mean = 0.0, sd = 1.0 } } }
[[candidate.effect]]
acts_at = "heater"
eu = "-k1*Q_h*exp(-s*k2)"
"#;

fn message(change: &str, to: &str) -> String {
    assert!(GOOD.contains(change), "{change}");
    Catalogue::from_toml(&GOOD.replacen(change, to, 1), "mine.toml").unwrap_err().to_string()
}

#[test]
fn exact_parameters_keep_the_order_of_the_file() {
    let catalogue = Catalogue::from_toml(GOOD, "mine.toml").unwrap();
    let names: Vec<_> = catalogue.candidates()[0].parameters.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["k2", "k1"]);
}

#[test]
fn exact_faults_are_named_with_file_line_and_what_is_known() {
    for (change, to, expected) in [
        ("acts_at", "act_at", ["mine.toml, line 10", "acts_at"]),
        ("\"heater\"\neu", "\"heeter\"\neu", ["line 10", "prong-end"]),
        ("eu =", "ue =", ["line 11", "`ep`"]),
        ("Q_h", "Qh", ["line 11", "Q_h"]),
        ("exp(", "expp(", ["line 11", "did you mean `exp`"]),
        ("-s*k2", "-im(s)*k2", ["line 11", "not analytic"]),
        ("parameters.k2", "parameters.rho", ["line 7", "call it something else"]),
        ("normal = { mean = 1e-3", "normal = { mean = 1e-3, low = 2", ["line 7", "low"]),
        ("sd = 1e-3", "sd = -1e-3", ["line 7", "k2"]),
        ("prior = { normal", "prior = { gauss", ["line 7", "normal"]),
        ("[\"own judgement\"]", "[]", ["line 6", "cite"]),
    ] {
        let text = message(change, to);
        for part in expected {
            assert!(text.contains(part), "`{change}` -> `{to}`: {text}");
        }
    }
    assert!(message("exp(-s*k2)", "exp(-s)").contains("`k2` appears in no formula"));
    let twice = format!("{GOOD}{GOOD}");
    assert!(
        Catalogue::from_toml(&twice, "f").unwrap_err().to_string().contains("line 14: a second candidate")
    );
    assert!(message("eu = \"-k1*Q_h*exp(-s*k2)\"", "reflection = \"k1*k2\"").contains("cannot act at"));
    assert!(
        Catalogue::read(Path::new("absent.toml")).unwrap_err().to_string().starts_with("absent.toml: cannot")
    );
}

fn fixture(name: &str) -> Catalogue {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/candidates/");
    Catalogue::read(Path::new(&format!("{folder}{name}"))).unwrap()
}

#[test]
fn paper_table_2_has_seven_models_with_the_printed_numbers_of_parameters() {
    let catalogue = fixture("prongs.toml");
    let counts: Vec<usize> = catalogue.competing("prongs").iter().map(|c| c.parameters.len()).collect();
    assert_eq!(counts[..7], [1, 2, 2, 4, 1, 2, 3]);
}

#[test]
fn paper_tables_3_and_4_have_the_printed_numbers_of_parameters() {
    let counts = |role: &str, file: &str| -> Vec<usize> {
        fixture(file).competing(role).iter().map(|c| c.parameters.len()).collect()
    };
    assert_eq!(counts("heater", "heater.toml"), [1, 2, 4]);
    assert_eq!(counts("heat-release", "heat-release.toml"), [2, 2, 3, 2, 2, 2, 4, 6, 6]);
}

#[test]
fn exact_a_hot_heater_adds_heat_in_phase_and_a_cold_one_none() {
    let (hot, cold) = (crate::testing::at("H130-25", 0.5), surroundings());
    let space = JetSpace::new(7, Order::Second);
    let s = space.seed(6, C64::new(-12.0, 1070.0));
    for candidate in fixture("heat-release.toml").candidates() {
        let eu = candidate.effects.iter().find(|e| e.coefficient == Coefficient::Eu).unwrap();
        let value = |around, delay: f64| {
            let here = Here { space, surroundings: around, s: &s, wall: None, levine_schwinger: None };
            let values = [1e-3, delay, 1.0, 0.0, 0.0, 0.0];
            let seeds: Vec<_> = (0..6).map(|k| space.seed(k, C64::new(values[k], 0.0))).collect();
            eu.law.evaluate(&here, &seeds)
        };
        let prompt = value(&hot, 0.0).value();
        assert!(prompt.re < 0.0 && prompt.im.abs() < 1e-15, "{}: {prompt}", candidate.id);
        let late = value(&hot, 1e-4).value();
        assert!((late / prompt).im < 0.0, "{}: heat comes later", candidate.id);
        // King's law needs a flow; the others have no heat release without power, derivatives included.
        if !candidate.name.contains("King") {
            let none = value(&cold, 1e-4);
            assert!(none.value() == C64::ZERO && none.gradient().iter().all(|g| *g == C64::ZERO));
        }
    }
}

#[test]
fn exact_wall_and_prongs_are_the_laws_of_the_paper() {
    let (around, space) = (surroundings(), JetSpace::new(1, Order::Value));
    let s = space.seed(0, C64::new(-12.0, 1070.0));
    let mut here = Here { space, surroundings: &around, s: &s, wall: None, levine_schwinger: None };
    let air = rijke_rig::Gas::air().at(293.15, 101_325.0);
    let (tube, prongs) = (fixture("tube.toml"), fixture("prongs.toml"));
    let wall = tube.get("wall.rayleigh").unwrap();
    let eta = [space.real(1.2)];
    let loss: Vec<_> = wall.effects.iter().map(|e| e.law.evaluate(&here, &eta)).collect();
    let root = 1.2 * 4.0 / 0.0474 * (s.value() * air.density * air.viscosity).sqrt();
    let ep = (air.gamma - 1.0) / (air.density * air.sound_speed).powi(2) * air.prandtl.powf(-2.0 / 3.0);
    assert!((loss[0].value() - root).norm() < 1e-12 * root.norm());
    assert!((loss[1].value() - root * ep).norm() < 1e-12 * (root * ep).norm());

    here.wall = Some([&loss[0], &loss[1]]);
    let model = prongs.get("prongs.6").unwrap();
    let parameters = [space.real(0.8), space.real(1.1)];
    let values: Vec<_> = model.effects.iter().map(|e| e.law.evaluate(&here, &parameters).value()).collect();
    let ratio = (2.0 * 3.0 + 2.0 * 4.0) / 47.4; // perimeters in millimetres, pi cancelled
    assert!((values[0] - 0.8 * ratio * root).norm() < 1e-12 * root.norm());
    let blockage = (2.0 * 9.0 + 2.0 * 16.0) / (47.4 * 47.4);
    assert!((values[2] - 1.1 * blockage).norm() < 1e-15, "blockage is positive: {}", values[2]);
}

#[test]
fn exact_the_short_cuts_of_every_law_give_the_law() {
    // evaluate_in_s is the jet in the seed s, and a law with a scale is that scale times the same thing in hot gas.
    let space = JetSpace::new(1, Order::First);
    let s = space.seed(0, C64::new(-12.0, 1070.0));
    let dual = |j: &rijke_numerics::Jet| crate::Dual { value: j.value(), slope: j.gradient()[0] };
    let wall_law = fixture("tube.toml").get("wall.rayleigh").unwrap().clone();
    let mut scaled = Vec::new();
    for file in ["tube.toml", "prongs.toml", "heater.toml", "heat-release.toml"] {
        for candidate in fixture(file).candidates() {
            let numbers: Vec<f64> = (0..candidate.parameters.len()).map(|k| 0.3 + 0.2 * k as f64).collect();
            let jets: Vec<_> = numbers.iter().map(|&v| space.real(v)).collect();
            for effect in &candidate.effects {
                let at = |temperature: f64| {
                    let around = crate::testing::heated("H130-25", 0.5, temperature);
                    let bare =
                        Here { space, surroundings: &around, s: &s, wall: None, levine_schwinger: Some(&s) };
                    let wall: Vec<_> =
                        wall_law.effects.iter().map(|e| e.law.evaluate(&bare, &[space.real(1.1)])).collect();
                    let inside = effect.place != crate::Place::Tube;
                    let here = Here { wall: inside.then_some([&wall[0], &wall[1]]), ..bare };
                    let value = effect.law.evaluate(&here, &jets);
                    let duals = [dual(&wall[0]), dual(&wall[1])];
                    let (s, end) = (dual(&s), dual(&s));
                    let here = Here {
                        space,
                        surroundings: &around,
                        s: &s,
                        wall: inside.then_some([&duals[0], &duals[1]]),
                        levine_schwinger: Some(&end),
                    };
                    let short = effect.law.evaluate_in_s(&here, &numbers);
                    for (a, b) in [(short.value, value.value()), (short.slope, value.gradient()[0])] {
                        assert!((a - b).norm() <= 1e-13 * b.norm(), "{}: {a} {b}", candidate.id);
                    }
                    let g = [0, 1].map(|i| wall_law.effects[i].law.scale(&around, [None; 2]));
                    (value.value(), effect.law.scale(&around, g))
                };
                let ((cold, g_cold), (hot, g_hot)) = (at(293.15), at(520.0));
                assert_eq!(g_cold.is_some(), g_hot.is_some());
                if let (Some(a), Some(b)) = (g_cold, g_hot) {
                    assert!((hot - cold * (b / a)).norm() <= 1e-12 * hot.norm(), "{}", candidate.id);
                    scaled.push(candidate.id.clone());
                }
            }
        }
    }
    for id in ["wall.rayleigh", "wall.kirchhoff", "prongs.4", "prongs.6", "thermocouples.paper"] {
        assert!(scaled.iter().filter(|s| *s == id).count() >= 2, "{id} should be evaluated once: {scaled:?}");
    }
}

/// Every file of the project, cut, turned, spliced and filled with hostile numbers.
#[test]
fn exact_no_damaged_file_makes_the_reader_panic() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/candidates/");
    for name in ["tube", "prongs", "heater", "heat-release", "beyond"] {
        let whole = std::fs::read(format!("{folder}{name}.toml")).unwrap();
        for k in 0..600 {
            let mut stream = rijke_numerics::Streams::new(0).stream(&format!("{name}/{k}"));
            let bytes = rijke_numerics::check::damaged(&whole, &mut stream);
            let Ok(read) = Catalogue::from_toml(&String::from_utf8_lossy(&bytes), name) else { continue };
            for candidate in read.candidates() {
                candidate.effects.iter().for_each(|effect| drop(crate::unit_fault(candidate, effect)));
            }
        }
    }
}
