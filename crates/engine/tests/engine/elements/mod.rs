//! Every element and end of network files in a rig: the same modes.

mod accounts;
mod along;
mod nearest;
mod refused;
mod tables;

use rijke_engine::{Assembly, Conditions, PointModel};
use rijke_network::Workspace;
use rijke_numerics::check::{slopes_from, slopes_near};
use rijke_numerics::{C64, Order};
use rijke_study::{OneTable, PointState, Study};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Keys of network files that rigs do not take, as docs/network-file.md says; what may stand there, and the
/// remedy that the refusal names.
const LEFT_OUT: [(&str, &str, &str, &str); 3] = [
    ("duct", "sound_speed", "343", "`temperature`, `gamma` and `gas_constant` of the duct: give these"),
    ("duct", "density", "1.2", "`temperature`, `gamma` and `gas_constant` of the duct: give these"),
    ("duct", "scheme", "'line'", "a candidate may let a law act at places instead"),
];

/// Elements between two ducts of other areas and temperatures, and how far the modes may be apart, relative
/// to |s|. Where the gas or the area changes along a duct the two readers cut it in other ways; outlets of
/// side holes are of second order in ka in rigs, here up to 0.1.
const ELEMENTS: [(&str, &str, f64); 47] = [
    ("duct", "length = 0.2\ndiameter = 0.035", 1e-9),
    ("duct", "length = 0.2\narea = 1e-3\ntemperature = 450\nwall = 'kirchhoff'\nwall_factor = 1.2", 1e-9),
    ("duct", "length = 0.2\narea = 1e-3\nwall = 'paper'", 1e-9),
    ("duct", "length = 0.2\narea = 1e-3\nwall = 'zwikker-kosten'", 1e-9),
    ("duct", "length = 0.2\ndiameter = 0.03\ndiameter_end = 0.04\npieces = 60", 1e-4),
    ("duct", "length = 0.2\narea = 7e-4\narea_end = 1.2e-3\npieces = 60", 1e-4),
    ("duct", "length = 0.2\narea = 7e-4\ntemperature = 300\ntemperature_end = 500\npieces = 1000", 3e-4),
    ("duct", "length = 0.2\narea = 7e-4\ntemperatures = [300, 420, 500]\npieces = 1000", 3e-4),
    ("duct", "length = 0.2\ndiameter = 0.035\ngamma = 1.3", 1e-9),
    (
        "duct",
        "length = 0.2\ndiameter = 0.035\ngas_constant = 319\ntemperature = 700\nwall = 'kirchhoff'",
        1e-9,
    ),
    ("duct", "length = 0.2\narea = 1e-3\ngamma = 1.25\ngas_constant = 310\nwall = 'zwikker-kosten'", 1e-9),
    (
        "duct",
        "length = 0.2\narea = 7e-4\ngamma = 1.3\ngas_constant = 300\ntemperature = 300\ntemperature_end = 500\npieces = 1000",
        3e-4,
    ),
    ("feedback", "mu = [20, 5]\nmp = [0.1, 0]\neu = [0.2, -0.1]\nep = [1e-4, 0]", 1e-9),
    (
        "feedback",
        "eu = { gain = 0.3, delay = 2e-3, cutoff_hz = 300 }\nmu = { gain = 12, delay = 1e-4 }",
        1e-9,
    ),
    ("feedback", "ep = { gain = 1e-4, numerator = [1, 1e-3], denominator = [1, 2e-4, 1e-7] }", 1e-9),
    ("feedback", "eu = { gain = 0.4, delay = 1e-3, table = TABLE, tolerance = 1e-3 }", 1e-9),
    ("orifice", "diameter = 0.012\nthickness = 0.003\ndrag = 30", 1e-9),
    ("orifice", "diameter = 0.001\nthickness = 0.003\ndrag = 30\nporosity = 0.06", 1e-9),
    ("screen", "resistance = 20\neffective_length = 0.004\nopen_area = 0.5", 1e-9),
    ("screen", "resistance = 20\nloss = 3", 1e-9),
    ("side-hole", "diameter = 0.008\nlength = 0.01\noutlet = 'flanged'\nwall = 'none'", 3e-5),
    ("side-hole", "diameter = 0.008\nlength = 0.01\noutlet = 'unflanged'", 3e-5),
    ("side-hole", "diameter = 0.008\nlength = 0.01\nwall = 'kirchhoff'", 3e-5),
    ("side-hole", "diameter = 0.008\nlength = 0.01\nwall = 'paper'", 3e-5),
    ("side-hole", "diameter = 0.008\nlength = 0.01\nwall = 'zwikker-kosten'", 3e-5),
    ("helmholtz", "volume = 2e-4\nneck_area = 1e-4\nneck_length = 0.02\nresistance = 10", 1e-9),
    ("orifice", "diameter = 0.004\nthickness = 0.003\nbias_velocity = 8", 1e-9),
    ("helmholtz", "volume = 2e-4\nneck_area = 1e-4\nneck_length = 0.02\nbias_velocity = 5", 1e-9),
    ("quarter-wave", "length = 0.2\narea = 1e-4", 1e-9),
    ("flame", "gain = 0.4\ndelay = 2e-3\ncutoff_hz = 400", 1e-9),
    ("flame", "n = 0.4\ndelay = 2e-3", 1e-9),
    ("flame", "n = 0.4\nnumerator = [1, 1e-4]\ndenominator = [1, 1e-3, 1e-7]", 1e-9),
    ("flame", "n = 0.4\ntable = TABLE\ntolerance = 1e-3", 1e-9),
    ("flame", "gain = 0.4\ntable = TABLE\ntolerance = 1e-3\ndelay = 5e-4", 1e-9),
    ("flame", "gain = 0.4\ndelay = 2e-3\nreference = 0.1", 1e-9),
    ("flame", "n = 0.3\ndelay = 2e-3\nreference = 0.45", 1e-9),
    ("flame", "gain = 0.2\ndelay = 2e-3\nreference = 0.1\nreference_side = 'downstream'", 1e-9),
    (
        "flame",
        "n = 0.2\ntable = TABLE\ntolerance = 1e-3\nreference = 0.4\nreference_side = 'downstream'",
        1e-9,
    ),
    ("flame", "n = 0.3\ndelay = 1e-3\nreference_side = 'downstream'", 1e-9),
    ("flame", "gain = 0.4\ndelay = 1e-3\nlength = 0.2", 1e-9),
    ("flame", "n = 0.4\ndelay = 1e-3\ndelay_end = 4e-3\nlength = 0.45\npieces = 12", 1e-9),
    ("flame", "gain = 0.4\ndelay_end = 4e-3\nlength = 0.3\npieces = 7\ndensity = [0, 2, 1]", 1e-9),
    ("flame", "n = 0.4\nlength = 0.3\npieces = 5\ncutoff_hz = 300\nreference = 0.2", 1e-9),
    ("flame", "n = 0.3\ndelay = 1e-3\nlength = 0.4\npieces = 9\nreference = 0.45\ndensity = [1, 3]", 1e-9),
    ("flame", "n = 0.4\nlength = 0.3\npieces = 6\ndelay_end = 1e-3\ntable = TABLE\ntolerance = 1e-3", 1e-9),
    (
        "flame",
        "n = 0.3\nlength = 0.2\ndelay = 1e-3\nnumerator = [1, 1e-4]\ndenominator = [1, 1e-3, 1e-7]\npieces = 4",
        1e-9,
    ),
    ("flame", "n = 0.3\nreference = 0.1\ntable = TABLE\ntolerance = 1e-3", 1e-9),
];

const ENDS: [(&str, &str); 18] = [
    ("open", ""),
    ("closed", ""),
    ("anechoic", ""),
    ("constant", "modulus = 0.9\nangle = 2.5"),
    ("delayed", "factor = -0.9\ndelay = 1e-4"),
    ("unflanged", ""),
    ("unflanged", "wall_thickness = 0.003"),
    ("unflanged", "calibration = [0.98, 0.05]"),
    ("flanged", ""),
    ("choked", "mach = 0.1"),
    ("impedance", "numerator = [2, 1e-3]\ndenominator = [1, 1e-4]"),
    ("impedance", "numerator = [2]\ndelay = 1e-4"),
    ("impedance", "table = TABLE\ntolerance = 1e-3"),
    ("impedance", "table = TABLE\ntolerance = 1e-3\ndelay = 1e-4"),
    ("rational", "numerator = [-0.9, 1e-4]\ndenominator = [1, 4e-4]"),
    ("rational", "numerator = [-0.9]\ndenominator = [1]\ndelay = 1e-4"),
    ("table", "table = TABLE\ntolerance = 1e-3"),
    ("table", "table = TABLE\ntolerance = 1e-2\ngain = 0.9\ndelay = 1e-4"),
];

/// A filter of second order behind a delay of 1 ms, at 24 frequencies.
fn table() -> String {
    let row = |k: usize| {
        let hertz = 20.0 + 60.0 * k as f64;
        let s = C64::new(0.0, std::f64::consts::TAU * hertz);
        let value = 0.9 * (-1e-3 * s).exp() / (1.0 + s * 4e-4 + s * s * 1e-7);
        format!("[{hertz}, {:.9}, {:.9}]", value.norm(), value.arg())
    };
    format!("[{}]", (0..24).map(row).collect::<Vec<_>>().join(", "))
}

/// A tube of two ducts with this between them, and these ends.
fn network(element: &str, ends: [&str; 2]) -> String {
    let [upstream, downstream] = ends;
    let text = format!(
        "name = 'tube'\n[search]\nfrequency_hz = [50, 1200]\ngrowth_rate = [-300, 200]\n[upstream]\n{upstream}\n[downstream]\n\
         {downstream}\n[[element]]\ntype = 'duct'\nlength = 0.12\ndiameter = 0.04\n[[element]]\ntype = 'duct'\nlength = 0.4\n\
         diameter = 0.03\nwall = 'kirchhoff'\n{element}[[element]]\ntype = 'duct'\nlength = 0.35\ndiameter = 0.036\ntemperature = 600\n\
         [[element]]\ntype = 'duct'\nlength = 0.2\ndiameter = 0.05\ntemperature = 500\n"
    );
    text.replace("TABLE", &table())
}

const CLOSED: &str = "type = 'closed'";
const LOSSY: &str = "type = 'constant'\nmodulus = 0.95\nangle = 3.0";

fn study(name: &str, rig: &str) -> Result<Study, String> {
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let (process, count) = (std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
    let folder = std::env::temp_dir().join(format!("rijke-elements-{name}-{process}-{count}"));
    std::fs::create_dir_all(&folder).unwrap();
    let [path, modes] = ["rig.toml", "modes.csv"].map(|f| folder.join(f));
    std::fs::write(&path, rig).unwrap();
    std::fs::write(&modes, "growth_rate,growth_rate_sd,frequency,frequency_sd\n-20,1,110,0.2\n").unwrap();
    let read = OneTable::read(&path, &modes).and_then(|files| files.study());
    std::fs::remove_dir_all(&folder).unwrap();
    read.map(|(study, _)| study).map_err(|error| error.to_string())
}

fn assembly(study: &Study) -> Assembly {
    Assembly::new(Arc::new(study.rig.clone()), Vec::new(), &BTreeMap::new()).unwrap()
}

fn conditions(study: &Study) -> Conditions {
    let point = study.campaign.points[0].clone();
    let layout = study.rig.at(&point, 293.15).unwrap();
    let base = PointState::of_the_rig(&study.rig, &layout, &point, [293.15, 0.0]).unwrap();
    Conditions { id: point.id.clone(), point, layout, base, displaced: Vec::new() }
}

/// All modes of the network and of the rig.
fn modes(text: &str) -> Result<[Vec<C64>; 2], String> {
    let built = rijke_network::file::read(text).map_err(|e| e.to_string())?;
    let found = built.network.modes(&built.laws, &built.region, &mut Workspace::default()).unwrap();
    let study = study("modes", &(text.to_owned() + "[microphones]\nat = [0.1]\n"))?;
    let (assembly, conditions) = (assembly(&study), conditions(&study));
    let model = PointModel::new(&assembly, &conditions, &[]).unwrap();
    let (_, spectrum) = model.spectrum(&[], [None, None]).unwrap();
    Ok([found, spectrum.modes].map(|all| all.modes.iter().map(|m| m.s).collect()))
}

fn compare(what: &str, text: &str, part: f64) -> Option<String> {
    let [network, rig] = modes(text).unwrap_or_else(|said| panic!("{what}: {said}"));
    let apart = |(a, b): (&C64, &C64)| (a - b).norm() / a.norm();
    let worst = network.iter().zip(&rig).map(apart).fold(0.0, f64::max);
    let same = network.len() == rig.len() && network.len() >= 3 && worst < part;
    (!same).then(|| format!("{what}: apart by {worst:.1e}, {} and {} modes", network.len(), rig.len()))
}

#[test]
fn oracle_every_element_has_the_modes_of_the_network_file() {
    let wrong: Vec<String> = ELEMENTS
        .iter()
        .filter_map(|(kind, keys, part)| {
            let element = format!("[[element]]\ntype = '{kind}'\n{keys}\n");
            compare(&format!("{kind}: {keys}"), &network(&element, [CLOSED, LOSSY]), *part)
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn oracle_every_end_has_the_modes_of_the_network_file() {
    let mut wrong = Vec::new();
    for (kind, keys) in ENDS {
        let end = format!("type = '{kind}'\n{keys}");
        wrong.extend(compare(&format!("upstream {end}"), &network("", [&end, LOSSY]), 1e-9));
        wrong.extend(compare(&format!("downstream {end}"), &network("", [CLOSED, &end]), 1e-9));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn exact_keys_that_rigs_leave_out_are_refused_with_the_remedy() {
    for (kind, key, value, remedy) in LEFT_OUT {
        let keys = "length = 0.2\ndiameter = 0.035";
        let text =
            network(&format!("[[element]]\ntype = '{kind}'\n{keys}\n{key} = {value}\n"), [CLOSED, LOSSY]);
        let error = study("left-out", &text).map(|_| ()).unwrap_err();
        assert!(error.contains("rig.toml, line 20: ") && error.contains(key), "{error}");
        assert!(error.contains(remedy), "{error}");
    }
}

/// Gas of a duct of its own before a flame with `n` and behind it, and around a spread one.
#[test]
fn oracle_flames_between_ducts_of_other_gases_have_the_modes_of_the_network_file() {
    let gas = |gamma: f64, constant: f64, keys: &str| {
        format!(
            "[[element]]\ntype = 'duct'\nlength = 0.2\ndiameter = 0.03\ngamma = {gamma}\ngas_constant = {constant}\n{keys}\n"
        )
    };
    let flame = |keys: &str| format!("[[element]]\ntype = 'flame'\n{keys}\n");
    let (fresh, burnt) = (gas(1.38, 280.0, ""), gas(1.25, 310.0, "temperature = 1500"));
    for keys in [
        "n = 0.3\ndelay = 2e-3",
        "n = 0.3\ndelay = 2e-3\nreference = 0.3",
        "n = 0.2\ndelay = 2e-3\nreference = 0.1\nreference_side = 'downstream'",
        "n = 0.3\ndelay = 1e-3\ndelay_end = 2e-3\nlength = 0.3\npieces = 11",
        "n = 0.3\ndelay = 1e-3\ndelay_end = 2e-3\nlength = 0.2\nreference = 0.3",
    ] {
        let text = network(&format!("{fresh}{}{burnt}", flame(keys)), [CLOSED, LOSSY]);
        assert_eq!(compare(keys, &text, 1e-9), None);
    }
}

/// The names that a message lists.
fn listed(message: &str) -> Vec<String> {
    let Some(after) = message.split("nown here: ").nth(1) else {
        assert!(message.contains("there is no key"), "{message}");
        return Vec::new();
    };
    after.lines().next().unwrap_or_default().split(", ").map(str::to_owned).collect()
}

#[test]
fn exact_every_key_of_network_files_is_compared_or_left_out_in_words() {
    let message = |text: &str| rijke_network::file::read(text).unwrap_err().to_string();
    let elements = listed(&message(&network("[[element]]\ntype = 'nothing'\n", [CLOSED, LOSSY])));
    let ends = listed(&message(&network("", ["type = 'nothing'", LOSSY])));
    assert!(elements.len() >= 8 && ends.len() >= 11, "{elements:?} {ends:?}");
    let has = |text: &str, key: &str| text.lines().any(|line| line.starts_with(&format!("{key} =")));
    for kind in &elements {
        let cases: Vec<&str> =
            ELEMENTS.iter().filter(|(k, ..)| k == kind).map(|(_, keys, _)| *keys).collect();
        let needed = cases.first().unwrap_or_else(|| panic!("no case of {kind}"));
        let element = format!("[[element]]\ntype = '{kind}'\n{needed}\nnothing = 1\n");
        for key in listed(&message(&network(&element, [CLOSED, LOSSY]))) {
            let known = cases.iter().any(|keys| has(keys, &key))
                || LEFT_OUT.iter().any(|(of, left, ..)| of == kind && *left == key);
            assert!(known, "no case of {kind} has {key}");
        }
    }
    // A coupling's own keys.
    let coupling = network("[[element]]\ntype = 'feedback'\neu = { nothing = 1 }\n", [CLOSED, LOSSY]);
    for key in listed(&message(&coupling)) {
        assert!(
            ELEMENTS.iter().any(|(k, keys, _)| *k == "feedback" && keys.contains(&format!("{key} ="))),
            "{key}"
        );
    }
    for kind in &ends {
        let cases: Vec<&str> = ENDS.iter().filter(|(k, _)| k == kind).map(|(_, keys)| *keys).collect();
        let needed = cases.first().unwrap_or_else(|| panic!("no case of {kind}"));
        let end = format!("type = '{kind}'\n{needed}\nnothing = 1");
        let said = message(&network("", [&end, LOSSY]));
        let keys = if said.contains("there are no fields") { Vec::new() } else { listed(&said) };
        for key in keys {
            assert!(cases.iter().any(|keys| has(keys, &key)), "no case of {kind} has {key}");
        }
    }
}

const UNKNOWNS: &str = "[unknown.gain_here]\nprior = { normal = { mean = 1, sd = 0.3 } }\n[unknown.delay_here]\nunit = 's'\n\
                        prior = { normal = { mean = 3e-4, sd = 2e-4 } }\n[microphones]\nat = [0.1, 0.3]\n";

/// A table measured elsewhere whose gain and delay are unknown here; a reference elsewhere; an end of both
/// kinds.
#[test]
fn order_modes_have_their_derivatives_in_gain_and_delay_of_tables() {
    let keys = "table = TABLE\ntolerance = 1e-3\ngain = '$gain_here'\ndelay = '$delay_here'";
    let flame = |more: &str| format!("[[element]]\ntype = 'flame'\n{keys}\n{more}\n");
    let end = format!("type = 'table'\n{keys}");
    let coupling = "[[element]]\ntype = 'feedback'\neu = { gain = '-0.5*$gain_here', delay = '$delay_here', table = TABLE, tolerance = 1e-3 }\n";
    let gas = "[[element]]\ntype = 'duct'\nlength = 0.2\ndiameter = 0.035\ngamma = '1 + 0.5*$gain_here'\n\
               gas_constant = '250 + 1e5*$delay_here'\n[[element]]\ntype = 'flame'\nn = 0.3\n";
    let lossy = |element: &str| network(element, [CLOSED, LOSSY]);
    for (name, text) in [
        ("flame", lossy(&flame(""))),
        ("upstream", lossy(&flame("reference = 0.45"))),
        ("downstream", lossy(&flame("reference = 0.4\nreference_side = 'downstream'"))),
        ("coupling", lossy(coupling)),
        ("spread", lossy(&flame("length = 0.3\npieces = 6\ndelay_end = '3*$delay_here'\nreference = 0.2"))),
        ("gas", lossy(gas)),
        ("end", network("", [CLOSED, &end])),
    ] {
        let study = study(name, &(text + UNKNOWNS)).unwrap();
        let (assembly, conditions) = (assembly(&study), conditions(&study));
        let respond = |values: [f64; 2], order: Order, near: C64| {
            let model = PointModel::new(&assembly, &conditions, &[0, 1]).unwrap().starting_from(near);
            model.prepared().respond(&values, order, &mut Workspace::default()).unwrap()
        };
        let at = [0.6, 3e-4];
        let found = respond(at, Order::Second, C64::new(-20.0, 1500.0));
        for direction in [[0.05, 0.0], [0.0, 3e-5], [0.04, -2e-5]] {
            for k in 0..2 {
                let number =
                    |r: &rijke_network::Response| if k == 0 { r.s.clone() } else { r.pressures[1].clone() };
                let jet = number(&found);
                let moved = |h: f64| {
                    let there = [at[0] + h * direction[0], at[1] + h * direction[1]];
                    number(&respond(there, Order::Value, found.s.value())).value() - jet.value()
                };
                let slope: C64 = (0..2).map(|i| jet.gradient()[i] * direction[i]).sum();
                let pairs = (0..2).flat_map(|i| (0..2).map(move |j| (i, j)));
                let bend: C64 =
                    pairs.map(|(i, j)| 0.5 * jet.hessian(i, j) * direction[i] * direction[j]).sum();
                slopes_near(&slopes_from(0.3, |h| (moved(h) - slope * h).norm()), 2.0, 0.2);
                slopes_near(&slopes_from(0.3, |h| (moved(h) - slope * h - bend * h * h).norm()), 3.0, 0.4);
            }
        }
    }
}
