//! Modes of rigs: against network files that say the same, and, of rigs of unknown shape, against those with
//! numbers in their place.

use crate::common::tube::TUBE;
use rijke_engine::run::{Run, Trusted};
use rijke_engine::{Assembly, Conditions, PointModel};
use rijke_network::Workspace;
use rijke_numerics::check::{slopes_from, slopes_near};
use rijke_numerics::{C64, Order};
use rijke_study::{OneTable, PointState, Study};
use std::path::PathBuf;
use std::sync::Arc;

/// A plenum, a burner with a flame in it, and a hot chamber whose `LENGTH` and `WIDTH` may be unknown; two
/// microphones.
const RIG: &str = r#"
name = "burner"
[search]
frequency_hz = [60, 420]
[upstream]
type = "closed"
[downstream]
type = "unflanged"
wall_thickness = 0.003
[[element]]
name = "plenum"
type = "duct"
length = 0.25
diameter = 0.1
wall = "kirchhoff"
[[element]]
name = "burner"
type = "duct"
length = 0.12
diameter = 0.032
wall = "kirchhoff"
[[element]]
name = "damper"
type = "helmholtz"
at = 0.1
volume = VOLUME
neck_area = 2e-4
neck_length = 0.02
resistance = 10
[[element]]
name = "flame"
type = "flame"
n = "$n"
delay = 2e-3
[[element]]
name = "chamber"
type = "duct"
length = LENGTH
diameter = WIDTH
temperature = HOT
wall = "zwikker-kosten"
[microphones]
at = [0.05, 0.2, 0.33]
reference = 1
[unknown.n]
prior = { normal = { mean = 0.5, sd = 0.5 } }
"#;

const UNKNOWNS: &str = r#"
[unknown.chamber_length]
unit = "m"
prior = { normal = { mean = 0.5, sd = 0.2 } }
[unknown.chamber_width]
unit = "m"
prior = { normal = { mean = 0.07, sd = 0.01 } }
[unknown.volume]
unit = "m^3"
prior = { log_normal = { median = 2e-4, ln_sd = 0.3 } }
[unknown.hot]
unit = "K"
prior = { normal = { mean = 1350, sd = 150 } }
"#;

fn files(name: &str, rig: &str, table: &str) -> [PathBuf; 2] {
    let folder = std::env::temp_dir().join(format!("rijke-unknown-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let paths = ["rig.toml", "modes.csv"].map(|f| folder.join(f));
    std::fs::write(&paths[0], rig).unwrap();
    std::fs::write(&paths[1], table).unwrap();
    paths
}

const TABLE: &str = "growth_rate,growth_rate_sd,frequency,frequency_sd\n-20,1,110,0.2\n";

fn rig([volume, length, width, hot]: [&str; 4]) -> String {
    RIG.replace("VOLUME", volume).replace("LENGTH", length).replace("WIDTH", width).replace("HOT", hot)
}

fn study(name: &str, [volume, length, width, hot]: [&str; 4], unknowns: &str) -> Study {
    let rig = rig([volume, length, width, hot]) + unknowns;
    let [rig, table] = files(name, &rig, TABLE);
    OneTable::read(&rig, &table).unwrap().study().unwrap().0
}

fn unknown(name: &str) -> Study {
    study(name, ["\"$volume\"", "\"$chamber_length\"", "\"$chamber_width\"", "\"$hot\""], UNKNOWNS)
}

fn assembly(study: &Study) -> Assembly {
    Assembly::new(Arc::new(study.rig.clone()), Vec::new(), &Default::default()).unwrap()
}

fn conditions(study: &Study) -> Conditions {
    let point = study.campaign.points[0].clone();
    let layout = study.rig.at(&point, 293.15).unwrap();
    let base = PointState::of_the_rig(&study.rig, &layout, &point, [293.15, 0.0]).unwrap();
    Conditions { id: point.id.clone(), point, layout, base, displaced: Vec::new() }
}

const HEARD: [usize; 3] = [0, 1, 2];

/// s and the relative pressures.
fn numbers(study: &Study, values: &[f64], near: C64) -> Vec<C64> {
    let assembly = assembly(study);
    let model = PointModel::new(&assembly, &conditions(study), &HEARD).unwrap().starting_from(near);
    let found = model.respond(values, Order::Value, &mut Workspace::default()).unwrap();
    std::iter::once(found.s.value()).chain(found.pressures.iter().map(|p| p.value())).collect()
}

const NEAR: [C64; 2] = [C64::new(-20.0, 640.0), C64::new(-20.0, 1900.0)];

#[test]
fn oracle_unknown_lengths_have_the_modes_of_known_ones() {
    let study_of_unknowns = unknown("same");
    let names: Vec<String> =
        assembly(&study_of_unknowns).parameters().iter().map(|p| p.name.clone()).collect();
    assert_eq!(names, ["n", "chamber_length", "chamber_width", "volume", "hot"]);
    for [length, width, volume, hot] in
        [["0.5", "0.07", "2e-4", "1350"], ["0.43", "0.081", "3e-4", "1640"], ["0.8", "0.06", "1e-4", "900"]]
    {
        let known = study("known", [volume, length, width, hot], "");
        let [l, w, v, t]: [f64; 4] = [length, width, volume, hot].map(|text| text.parse().unwrap());
        for near in NEAR {
            let expected = numbers(&known, &[0.4], near);
            let found = numbers(&study_of_unknowns, &[0.4, l, w, v, t], expected[0] + C64::new(0.3, -0.4));
            for (found, expected) in found.iter().zip(&expected) {
                assert!((found - expected).norm() < 1e-9 * expected.norm().max(1.0), "{found} {expected}");
            }
        }
    }
}

/// A factor puts the burner between plenum and chamber; without it these stand side by side, with the flame
/// between them.
#[test]
fn exact_a_duct_is_there_where_its_factor_says() {
    let burner = "[[element]]\nname = \"burner\"\ntype = \"duct\"\nlength = 0.12\ndiameter = 0.032\nwall = \"kirchhoff\"\n";
    let table = |there: &str| {
        TABLE.replace("frequency_sd", "frequency_sd,spool").replace("0.2\n", &format!("0.2,{there}\n"))
    };
    let opened = |name: &str, rig: &str, table: &str| {
        let [rig, table] = files(name, rig, table);
        OneTable::read(&rig, &table).unwrap().study().unwrap().0
    };
    // The chamber's length known and unknown: both ways to a network.
    for (length, unknowns, values) in [
        ("0.5", "", &[0.4][..]),
        ("\"$chamber_length\"", UNKNOWNS.split_inclusive("}\n").next().unwrap(), &[0.4, 0.5]),
    ] {
        let with = rig(["2e-4", length, "0.07", "1350"]) + unknowns;
        let (without, may_have) = (
            with.replace(burner, ""),
            with.replace("\"burner\"\ntype", "\"burner\"\npresent = \"spool\"\ntype"),
        );
        assert!(without != with && may_have != with);
        for (there, fixed) in [("1", &with), ("0", &without), ("", &without)] {
            let [found, expected] = [&may_have, fixed].map(|rig| opened("spool", rig, &table(there)));
            let expected = numbers(&expected, values, NEAR[0]);
            let found = numbers(&found, values, expected[0] + C64::new(0.3, -0.4));
            for (found, expected) in found.iter().zip(&expected) {
                assert!((found - expected).norm() < 1e-11 * expected.norm().max(1.0), "{found} {expected}");
            }
        }
    }
    // A rig of which nothing is there is none.
    let only =
        TUBE.replace("type = \"duct\"", "present = \"spool\"\ntype = \"duct\"").replace("\"x\"", "1.0");
    let study = opened("nothing", &only, &table("0"));
    let said = study.rig.at(&study.campaign.points[0], 293.15).unwrap_err().to_string();
    assert!(said.contains("check the factors that their `present` names"), "{said}");
}

/// Lengths add up to a place only up to rounding: 0.3 + 0.15 is less than 0.45 by one bit, 0.1 + 0.2 more
/// than 0.3.
#[test]
fn exact_a_flame_at_the_border_of_two_ducts_has_the_gas_of_both() {
    for [first, second, at] in [["0.3", "0.15", "0.45"], ["0.1", "0.2", "0.3"], ["0.35", "0.1", "0.45"]] {
        let sum: f64 = [first, second].map(|text| text.parse::<f64>().unwrap()).iter().sum();
        assert_ne!(sum, at.parse::<f64>().unwrap());
        let [found, expected] = [format!("at = \"{at} m\"\n"), String::new()].map(|place| {
            let text = rig(["2e-4", "0.5", "0.07", "1350"]);
            let text = text.replace("length = 0.25", &format!("length = {first}"));
            let text = text.replace("length = 0.12", &format!("length = {second}"));
            let text = text.replace("type = \"flame\"\n", &format!("type = \"flame\"\n{place}"));
            let [rig, table] = files("border", &text.replace("at = 0.1\n", "at = 0.05\n"), TABLE);
            numbers(&OneTable::read(&rig, &table).unwrap().study().unwrap().0, &[0.8], NEAR[0])
        });
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).norm() < 1e-9 * expected.norm().max(1.0), "{at}: {found} {expected}");
        }
    }
}

/// Numbers of an end may name each other and those of parts; the law of the end calls them by bare names.
#[test]
fn exact_ends_have_numbers_as_parts_have() {
    let tube = TUBE.replacen("modulus = \"$r\"", "MODULUS", 1).replace("\"x\"", "1.0");
    let tube = tube.replace("diameter =", "numbers = { bore = \"50 mm\" }\ndiameter =")
        + "[microphones]\nat = [0.1, 0.4, 0.7]\n";
    let near = C64::new(-20.0, std::f64::consts::PI * 343.2);
    let with = |modulus: &str| {
        let [rig, table] = files("ends", &tube.replace("MODULUS", modulus), TABLE);
        numbers(&OneTable::read(&rig, &table).unwrap().study().unwrap().0, &[0.9], near)
    };
    let named = "modulus = \"1 - 4*lip/tube.bore\"\n\
                 numbers = { lip = { value = \"half + upstream.half\", unit = \"m\" }, half = \"0.5 mm\" }";
    for (found, expected) in with(named).iter().zip(with("modulus = 0.92")) {
        assert!((found - expected).norm() < 1e-12 * expected.norm(), "{found} {expected}");
    }
}

#[test]
fn order_modes_have_their_derivatives_in_lengths_and_areas() {
    let study = unknown("derivatives");
    let assembly = assembly(&study);
    let conditions = conditions(&study);
    let at = [0.4, 0.47, 0.073, 2.2e-4, 1280.0];
    let respond = |values: &[f64], order: Order, near: C64| {
        let model = PointModel::new(&assembly, &conditions, &HEARD).unwrap().starting_from(near);
        model.respond(values, order, &mut Workspace::default()).unwrap()
    };
    for near in NEAR {
        let found = respond(&at, Order::Second, near);
        let all: Vec<_> = std::iter::once(&found.s).chain(&found.pressures).collect();
        for direction in [
            [0.0, 0.02, 0.0, 0.0, 0.0],
            [0.0, 0.0, 4e-3, 1e-5, 0.0],
            [0.0, 0.0, 0.0, 0.0, 60.0],
            [0.05, 0.01, -2e-3, 2e-5, -30.0],
        ] {
            let moved = |h: f64, k: usize| {
                let values: Vec<f64> = at.iter().zip(&direction).map(|(a, d)| a + h * d).collect();
                let there = respond(&values, Order::Value, found.s.value());
                std::iter::once(&there.s).chain(&there.pressures).nth(k).unwrap().value() - all[k].value()
            };
            // The second pressure is the reference: one, always.
            for k in [0, 1, 3] {
                let slope: C64 = (0..5).map(|i| all[k].gradient()[i] * direction[i]).sum();
                let pairs = (0..5).flat_map(|i| (0..5).map(move |j| (i, j)));
                let bend: C64 =
                    pairs.map(|(i, j)| 0.5 * all[k].hessian(i, j) * direction[i] * direction[j]).sum();
                slopes_near(&slopes_from(0.3, |h| (moved(h, k) - slope * h).norm()), 2.0, 0.15);
                slopes_near(&slopes_from(0.3, |h| (moved(h, k) - slope * h - bend * h * h).norm()), 3.0, 0.4);
            }
        }
    }
}

/// The damper's law has a pole among the modes, where its mass and spring are in tune.
#[test]
fn exact_all_modes_are_counted_beside_the_pole_of_a_formula() {
    let known = study("poles", ["2e-4", "0.46", "0.07", "1350"], "");
    let unknown = unknown("poles-unknown");
    let all = |study: &Study, values: &[f64]| {
        let assembly = assembly(study);
        let model = PointModel::new(&assembly, &conditions(study), &[]).unwrap();
        let (_, spectrum) = model.spectrum(values, [None, None]).unwrap();
        (spectrum.modes.modes.iter().map(|m| m.s).collect::<Vec<_>>(), spectrum.poles)
    };
    let (modes, poles) = all(&known, &[0.4]);
    let (same, same_poles) = all(&unknown, &[0.4, 0.46, 0.07, 2e-4, 1350.0]);
    // s^2 m + s r + k = 0 with the neck's mass rho l, its resistance and the spring rho c^2 A_n/V.
    let (rho, c) = (1.204, 343.2);
    let (m, r, k) = (rho * 0.02, 10.0, rho * c * c * 2e-4 / 2e-4);
    let pole = C64::new(-r / (2.0 * m), (k / m - (r / (2.0 * m)).powi(2)).sqrt());
    assert!(poles.len() == 1 && (poles[0] - pole).norm() < 5e-3 * pole.norm(), "{poles:?} {pole}");
    assert!(modes.len() >= 2 && modes.len() == same.len(), "{modes:?} {same:?}");
    for (a, b) in modes.iter().chain(&poles).zip(same.iter().chain(&same_poles)) {
        assert!((a - b).norm() < 1e-9 * a.norm(), "{a} {b}");
    }
}

#[test]
fn behaviour_an_unknown_length_and_temperature_are_found_from_modes() {
    let truth = study("truth", ["2e-4", "0.46", "0.07", "1350"], "");
    let mut table = String::from("growth_rate,growth_rate_sd,frequency [Hz],frequency_sd [Hz]\n");
    for near in NEAR {
        let s = numbers(&truth, &[0.4], near)[0];
        table += &format!("{},0.5,{},0.05\n", s.re, s.im / std::f64::consts::TAU);
    }
    let rig = rig(["2e-4", "\"$chamber_length\"", "0.07", "\"$hot\""]);
    let parts: Vec<&str> = UNKNOWNS.split_inclusive("}\n").collect();
    let [rig, table] = files("found", &(rig + parts[0] + parts[3]), &table);
    let (study, observations) = OneTable::read(&rig, &table).unwrap().study().unwrap();
    let stage = Run::new(study, &observations, Trusted::Laplace).unwrap().next_stage().unwrap().unwrap();
    let model = &stage.models[0];
    let length = model.parameters.iter().find(|p| p.name == "chamber_length").unwrap();
    let hot = model.parameters.iter().find(|p| p.name == "hot").unwrap();
    assert!((length.value - 0.46).abs() < 0.1 * length.sd && length.sd < 0.03, "{length:?}");
    assert!((hot.value - 1350.0).abs() < 0.1 * hot.sd && hot.sd < 100.0, "{hot:?}");
}

/// A tube with a device at half its length, in the language of rigs and in that of networks.
fn modes_in_both(name: &str, device: &str) -> [Vec<C64>; 2] {
    let duct = "[[element]]\ntype = 'duct'\nlength = 0.4\ndiameter = 0.03\n";
    let text = format!(
        "name = 'tube'\n[search]\nfrequency_hz = [50, 1200]\ngrowth_rate = [-200, 50]\n[upstream]\ntype = 'closed'\n\
         [downstream]\ntype = 'constant'\nmodulus = 0.95\nangle = 3.0\n{duct}{device}{duct}"
    );
    let network = rijke_network::file::read(&text).unwrap();
    let found = network.network.modes(&network.laws, &network.region, &mut Workspace::default()).unwrap();
    let [rig, table] = files(name, &(text + "[microphones]\nat = [0.1]\n"), TABLE);
    let (study, _) = OneTable::read(&rig, &table).unwrap().study().unwrap();
    let assembly = assembly(&study);
    let model = PointModel::new(&assembly, &conditions(&study), &[]).unwrap();
    let (_, spectrum) = model.spectrum(&[], [None, None]).unwrap();
    [found, spectrum.modes].map(|all| all.modes.iter().map(|m| m.s).collect())
}

#[test]
fn oracle_rigs_have_the_side_holes_and_screens_of_network_files() {
    let [plain, _] = modes_in_both("plain", "");
    // A screen's numbers are the same; outlets of side holes are taken to second order in ka, here up to 0.1,
    // and walls to first order.
    for (name, device, part) in [
        (
            "screen",
            "[[element]]\ntype = 'screen'\nresistance = 20\neffective_length = 0.004\nopen_area = 0.5\n",
            1e-8,
        ),
        (
            "flanged",
            "[[element]]\ntype = 'side-hole'\ndiameter = 0.008\nlength = 0.01\noutlet = 'flanged'\n",
            5e-4,
        ),
        (
            "thin",
            "[[element]]\ntype = 'side-hole'\ndiameter = 0.008\nlength = 0.01\noutlet = 'unflanged'\n",
            2e-3,
        ),
        (
            "lossy",
            "[[element]]\ntype = 'side-hole'\ndiameter = 0.008\nlength = 0.01\noutlet = 'flanged'\nwall = 'kirchhoff'\n",
            5e-4,
        ),
    ] {
        let [of_network, of_rig] = modes_in_both(name, device);
        assert!(of_network.len() == of_rig.len() && of_rig.len() >= 4, "{name}: {of_network:?} {of_rig:?}");
        for ((a, b), without) in of_network.iter().zip(&of_rig).zip(&plain) {
            let moved = (a - without).norm();
            assert!((a - b).norm() < part * moved.max(1.0), "{name}: {a} {b}, moved by {moved}");
        }
    }
}

/// The states of gas at three points of a rig whose last duct begins with this `temperature`, which `ends`
/// with another, where the ambient temperature is known to `ambient_sd`.
fn states(name: &str, [temperature, ends]: [&str; 2], ambient_sd: f64) -> Vec<PointState> {
    let rig = rig(["2e-4", "0.5", "0.07", &format!("{temperature}\ntemperature_end = {ends}")]);
    let table = "T_f [K],growth_rate,growth_rate_sd,frequency,frequency_sd\n293.15,-20,1,110,0.2\n300,-20,1,110,0.2\n\
                 500,-20,1,110,0.2\n";
    let [rig, table] = files(name, &rig, table);
    let study = OneTable::read(&rig, &table).unwrap().study().unwrap().0;
    let at = |p: &rijke_study::Point| study.rig.at(p, 293.15).unwrap();
    let of = |p| PointState::of_the_rig(&study.rig, &at(p), p, [293.15, ambient_sd]).unwrap();
    study.campaign.points.iter().map(of).collect()
}

/// One error of a duct that all points share does not make the cold ones uncertain.
#[test]
fn exact_gas_that_a_factor_heats_is_wrong_by_no_more_than_it_is_heated() {
    let near = |temperature: &str, expected: [f64; 3]| {
        let all = states("heated", [temperature, "600\ntemperature_sd = 25"], 0.0);
        for (base, expected) in all.iter().zip(expected) {
            let last = base.places.len() - 2;
            let found: Vec<_> = base.errors.iter().map(|e| &e.temperature[last..]).collect();
            assert!(found.len() == 1 && (found[0][0] - expected).abs() < 1e-9, "{found:?} {expected}");
            assert_eq!(found[0][1], 25.0);
        }
    };
    near("\"T_f\"", [0.0, 6.85, 25.0]);
    near("293.15", [25.0; 3]);
}

/// A duct whose temperature is a formula of T_amb is as wrong as T_amb is.
#[test]
fn exact_gas_that_follows_the_ambient_has_the_error_of_the_ambient() {
    for base in states("following", ["\"T_amb + 0.5*(T_f - 293.15)\"", "\"2*T_amb\""], 0.4) {
        assert_eq!(base.errors.len(), 1, "{:?}", base.errors);
        let error = &base.errors[0].temperature;
        let last = error.len() - 1;
        let expected = |k: usize| if k == last { 0.8 } else { 0.4 };
        assert!((0..=last).all(|k| (error[k] - expected(k)).abs() < 1e-9), "{error:?}");
    }
}
