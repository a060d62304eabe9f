//! `rijke modes`: its formats agree, its figures and curves are written, its advice is true, bad files are
//! refused.

use crate::{rijke, scratch};
use serde_json::Value;
use std::{fs, path::Path};

const RIJKE: &str = include_str!("../../../../fixtures/networks/rijke-tube.toml");
const FLOW: &str = include_str!("../../../../fixtures/networks/combustor-flow.toml");

fn said(folder: &Path, arguments: &[&str]) -> String {
    let output = rijke(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn json(folder: &Path, arguments: &[&str]) -> Value {
    let all = [&["modes", "--format", "json"], arguments].concat();
    serde_json::from_str(&said(folder, &all)).unwrap()
}

fn number(mode: &Value, key: &str) -> f64 {
    mode[key].as_f64().unwrap()
}

#[test]
fn exact_table_csv_and_json_say_the_same() {
    let folder = scratch("modes-formats");
    for (name, text) in [("rest.toml", RIJKE), ("flow.toml", FLOW)] {
        fs::write(folder.join(name), text).unwrap();
        let answer = json(&folder, &[name]);
        assert_eq!(answer["found"], answer["counted"]);
        assert!(answer.get("sensitivity").is_none());
        let modes = answer["modes"].as_array().unwrap();
        assert_eq!(modes.len() as u64, answer["found"].as_u64().unwrap());
        let csv = said(&folder, &["modes", name, "--format", "csv"]);
        let table = said(&folder, &["modes", name]);
        assert!(table.contains(&format!("{0} of {0} modes found", modes.len())), "{table}");
        for (mode, row) in modes.iter().zip(csv.lines().skip(1)) {
            let row: Vec<f64> = row.split(',').map(|v| v.parse().unwrap()).collect();
            assert_eq!([row[0], row[1]], [number(mode, "frequency_hz"), number(mode, "growth_rate")]);
            // The parts of the growth rate add up to it.
            let parts: f64 = row[5..].iter().sum();
            let size: f64 = row[5..].iter().map(|v| v.abs()).sum();
            assert!((parts - row[1]).abs() < 1e-8 * size, "{parts} against {}", row[1]);
            assert!(table.contains(&format!("{:.4}", row[0])), "{table}");
            assert!(number(mode, "residual") < 1e-10);
        }
        assert_eq!(csv.lines().count(), modes.len() + 1);
    }
}

#[test]
fn exact_limits_choose_among_the_modes() {
    let folder = scratch("modes-limits");
    fs::write(folder.join("tube.toml"), RIJKE).unwrap();
    let frequencies = |arguments: &[&str]| -> Vec<f64> {
        let answer = json(&folder, arguments);
        answer["modes"].as_array().unwrap().iter().map(|m| number(m, "frequency_hz")).collect()
    };
    let all = frequencies(&["tube.toml"]);
    let some = frequencies(&["tube.toml", "--min-hz", "250", "--max-hz", "800"]);
    let expected: Vec<f64> = all.iter().copied().filter(|f| (250.0..800.0).contains(f)).collect();
    assert!(some.len() >= 2 && some.len() < all.len());
    for (a, b) in some.iter().zip(&expected) {
        assert!((a - b).abs() < 1e-9 * b, "{some:?} {expected:?}");
    }
}

#[test]
fn exact_curves_and_figure_are_written() {
    let folder = scratch("modes-curves");
    for (name, text, low, high) in [("rest", RIJKE, "100", "400"), ("flow", FLOW, "30", "400")] {
        let file = format!("{name}.toml");
        fs::write(folder.join(&file), text).unwrap();
        let (svg, csv) = (format!("{name}.svg"), format!("{name}.csv"));
        let limits = ["--min-hz", low, "--max-hz", high];
        said(&folder, &[&["modes", &file, "--plot", &svg, "--along", &csv], &limits[..]].concat());
        let svg = fs::read_to_string(folder.join(svg)).unwrap();
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>") && !svg.contains("NaN"));
        let text = fs::read_to_string(folder.join(csv)).unwrap();
        let mut lines = text.lines();
        assert_eq!(
            lines.next().unwrap(),
            "frequency [Hz],growth_rate [1/s],x [m],pressure,velocity_times_rho_c,by_screen [1/s],by_heat [1/s],\
             by_leak [1/s],by_area [1/(s m)],by_temperature [1/(s m)]"
        );
        let rows: Vec<Vec<f64>> = lines.map(|l| l.split(',').map(|v| v.parse().unwrap()).collect()).collect();
        assert!(rows.iter().flatten().all(|v| v.is_finite()) && rows.len() > 200);
        let loudest = rows.iter().map(|r| r[3]).fold(0.0, f64::max);
        assert!((loudest - 1.0).abs() < 1e-12);
    }
}

/// The advice on a screen, tried: the file with such a screen where it says changes the growth rate as it
/// says.
#[test]
fn oracle_advice_is_true_with_and_without_flow() {
    let folder = scratch("modes-advice");
    let tube = "[search]\nfrequency_hz = [50, 400]\ngrowth_rate = [-200, 200]\n[upstream]\ntype = 'constant'\n\
                modulus = 0.9\nangle = 3.0\n[downstream]\ntype = 'constant'\nmodulus = 0.9\nangle = 0.2\n\
                [[element]]\ntype = 'duct'\nlength = 1.0\ndiameter = 0.05\nsound_speed = 343.0\n\
                density = 1.2057\n";
    for flow in ["", "[flow]\nmach = 0.05\n"] {
        let text = format!("{flow}{tube}");
        fs::write(folder.join("tube.toml"), &text).unwrap();
        let before = json(&folder, &["tube.toml", "--sensitivity"]);
        let advice: Vec<&Value> = before["sensitivity"]
            .as_array()
            .unwrap()
            .iter()
            .filter(|a| a["proposal"].as_str().unwrap().starts_with("a screen"))
            .collect();
        let modes = before["modes"].as_array().unwrap();
        assert!(modes.len() >= 2 && advice.len() == modes.len());
        for (k, a) in advice.iter().enumerate() {
            // Nothing may act at the very ends with flow: a millimetre inside the change is the same to first
            // order.
            let at = number(a, "at").clamp(1e-3, 0.999);
            let screen = format!(
                "{text}[[element]]\ntype = 'feedback'\nmu = [{}, 0]\nat = {at}\n",
                0.01 * 343.0 * 1.2057
            );
            fs::write(folder.join("screen.toml"), screen).unwrap();
            let after = json(&folder, &["screen.toml"]);
            let [was, is] = [&modes[k], &after["modes"][k]].map(|m| number(m, "growth_rate"));
            let told = number(a, "growth_rate_change");
            assert!(told < -0.1, "{a}");
            assert!(((is - was) / told - 1.0).abs() < 0.03, "{flow}{a}: {was} {is}");
        }
        let table = said(&folder, &["modes", "tube.toml", "--sensitivity"]);
        assert!(
            table.contains("a screen that takes 0.01 rho c u") && table.contains("best place"),
            "{table}"
        );
    }
}

fn oscilos(folder: &Path) {
    for (name, text) in [
        ("Geometry.txt", "x[m] r[m] SectionIndex TubeIndex\n0 0.01 0 0\n1 0.01 11 0\n2 0.01 0 0\n"),
        ("Mean_flow.txt", "P1 T1 choice M1 gamma dT\n101325.0 293.0 1 0.001 1 3\n"),
        ("Flame.txt", "Type a_f tau_f\n1 0.5 3\n"),
        ("Inlet.txt", "Type Param_1 Param_2 Param_3\n2 - - -\n"),
        ("Outlet.txt", "Type Param_1 Param_2 Param_3\n1 - - -\n"),
        ("Scan_range.txt", "f f n g g n\n0 500 50 -200 200 50\n"),
    ] {
        fs::create_dir_all(folder).unwrap();
        fs::write(folder.join(name), text).unwrap();
    }
}

#[test]
fn exact_a_folder_of_oscilos_inputs_is_read_as_it_is() {
    let folder = scratch("modes-oscilos");
    oscilos(&folder.join("case/Inputs"));
    // The folder itself, or the one that holds it as Inputs.
    let whole = json(&folder, &["--oscilos", "case", "--sensitivity"]);
    let inner = json(&folder, &["--oscilos", "case/Inputs"]);
    assert_eq!(whole["modes"], inner["modes"]);
    assert!(whole["found"].as_u64().unwrap() >= 4 && whole["found"] == whole["counted"]);
    assert!(!whole["sensitivity"].as_array().unwrap().is_empty());
    said(&folder, &["modes", "--oscilos", "case", "--plot", "o.svg", "--along", "o.csv"]);
    assert!(folder.join("o.svg").exists() && folder.join("o.csv").exists());
}

/// A file that is wrong, and what the message must say beside its name.
const BAD: [(&str, &str, &str, [&str; 2]); 17] = [
    ("negative length", "length = 0.25", "length = -0.25", ["line 17", "must be positive"]),
    ("negative temperature", "temperature = 340", "temperature = -340", ["line 37", "must be positive"]),
    ("unknown element", "type = \"orifice\"", "type = \"horn\"", ["`heater plate`", "known here: duct"]),
    ("unknown key", "drag = 2.0", "dragg = 2.0", ["`heater plate`", "did you mean `drag`?"]),
    ("overlap", "name = \"above the heater\"", "at = 0.2", ["element 4", "overlaps element 1"]),
    ("gap", "name = \"above the heater\"", "at = 0.3", ["element 4", "put a duct between"]),
    ("outside", "gain = 0.06", "gain = 0.06\nat = 2.0", ["`heat release`", "reaches from 0 to 1 m"]),
    ("reference outside", "gain = 0.06", "gain = 0.06\nreference = 0.4", ["line 31", "reaches 0.25 m"]),
    (
        "both",
        "diameter = 0.0474\n",
        "diameter = 0.0474\narea = 1.0\n",
        ["line 17", "either diameter or area"],
    ),
    ("empty search", "[20, 1200]", "[1200, 20]", ["line 5", "two increasing finite numbers"]),
    (
        "text for a number",
        "gain = 0.06",
        "gain = 'much'",
        ["`heat release`", "stands where a number is needed"],
    ),
    ("too fast", "[search]", "[flow]\nmach = 0.4\n[search]", ["line 5", "below 0.3"]),
    (
        "flow twice",
        "[search]",
        "[flow]\nmach = 0.1\nvelocity = 3\n[search]",
        ["line 5", "either mach or velocity"],
    ),
    ("no temperature", "[search]", "[gas]\ntemperature = 0\n[search]", ["line 5: [gas]", "must be positive"]),
    ("broken", "[upstream]", "[upstream", ["TOML parse error at line 9", "^"]),
    ("no end", "[downstream]", "[downstraem]", ["downstraem", "did you mean `downstream`?"]),
    ("wall", "\"zwikker-kosten\"", "\"wood\"", ["line 17", "known here: none"]),
];

#[test]
fn exact_bad_files_are_refused_with_place_and_remedy() {
    let folder = scratch("modes-bad");
    let mut faults = Vec::new();
    let mut check = |what: &str, arguments: &[&str], says: &[&str]| {
        let output = rijke(&folder, arguments);
        let text = String::from_utf8(output.stderr).unwrap();
        let missing = says.iter().any(|part| !text.contains(part));
        let several = text.matches("error:").count() != 1 || text.contains("panicked");
        let written = folder.join("m.svg").exists() || folder.join("m.csv").exists();
        if missing || several || written || output.status.code() != Some(2) || !output.stdout.is_empty() {
            faults.push(format!("{what}: {says:?} in {}\n{text}", output.status));
        }
    };
    let options = ["--plot", "m.svg", "--along", "m.csv", "--sensitivity"];
    for (what, from, to, says) in BAD {
        assert!(RIJKE.contains(from), "{from}");
        fs::write(folder.join("bad.toml"), RIJKE.replacen(from, to, 1)).unwrap();
        let says = [&["bad.toml"], &says[..]].concat();
        check(what, &[&["modes", "bad.toml"], &options[..]].concat(), &says);
    }
    fs::write(folder.join("empty.toml"), "").unwrap();
    check("empty", &["modes", "empty.toml"], &["empty.toml", "the key `upstream` is missing"]);
    let ends = "[upstream]\ntype = 'open'\n[downstream]\ntype = 'open'\n";
    fs::write(folder.join("ends.toml"), ends).unwrap();
    check("no duct", &["modes", "ends.toml"], &["ends.toml", "no duct", "add an [[element]]"]);
    check("absent", &["modes", "absent.toml"], &["absent.toml", "docs/network-file.md"]);
    fs::write(folder.join("good.toml"), RIJKE).unwrap();
    let turned = ["modes", "good.toml", "--min-hz", "900", "--max-hz", "100"];
    check("limits", &turned, &["good.toml", "is empty", "--max-hz"]);
    oscilos(&folder.join("case"));
    fs::write(folder.join("case/Outlet.txt"), "Type a b c\n3 - - -\n").unwrap();
    check("boundary", &["modes", "--oscilos", "case"], &["case", "Outlet.txt", "supported are"]);
    fs::remove_file(folder.join("case/Inlet.txt")).unwrap();
    check("folder", &["modes", "--oscilos", "case"], &["Inlet.txt", "folder that holds the inputs"]);
    assert!(faults.is_empty(), "{}", faults.join("\n\n"));
}

#[test]
fn exact_doubtful_files_are_told_and_solved() {
    let folder = scratch("modes-doubtful");
    let text = "[upstream]\ntype = 'constant'\nmodulus = 1.05\nangle = 3.0\n[downstream]\ntype = 'open'\n\
                [[element]]\ntype = 'duct'\nlength = 1.0\ndiameter = 0.05\nsound_speed = 343.0\ndensity = 1.1\n";
    fs::write(folder.join("odd.toml"), text).unwrap();
    let output = rijke(&folder, &["modes", "odd.toml"]);
    let notes = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{notes}");
    assert!(notes.contains("rho c^2/gamma is 92439 Pa, but the pressure is 101325 Pa"), "{notes}");
    assert!(notes.contains("|R| = 1.05") && notes.contains("this end feeds the modes"), "{notes}");
}

#[test]
fn exact_numbers_with_units_and_unknowns_are_read_as_studies_read_them() {
    let folder = scratch("modes-units");
    let plain = "name = \"tube\"\n[upstream]\ntype = \"closed\"\n[downstream]\ntype = \"unflanged\"\n[[element]]\n\
                 type = \"duct\"\nlength = 0.8\ndiameter = 0.05\nwall = \"kirchhoff\"\n";
    let with_units = plain.replace("0.8", "\"80 cm\"").replace("0.05", "\"50 mm\"");
    let unknown = plain.replace("0.8", "\"$l\"")
        + "[unknown.l]\nunit = \"m\"\nprior = { normal = { mean = 0.8, sd = 0.1 } }\n";
    let texts = [("plain.toml", plain), ("units.toml", &with_units), ("unknown.toml", &unknown)];
    let [plain, with_units, unknown] = texts.map(|(name, text)| {
        fs::write(folder.join(name), text).unwrap();
        json(&folder, &[name])["modes"].as_array().unwrap().clone()
    });
    assert_eq!(plain.len(), 5);
    for same in [with_units, unknown] {
        assert_eq!(same.len(), 5);
        for (a, b) in same.iter().zip(&plain) {
            for key in ["frequency_hz", "growth_rate"] {
                assert!((number(a, key) - number(b, key)).abs() < 1e-9 * number(b, key).abs(), "{key}");
            }
        }
    }
    for (key, says) in [
        ("length = \"80 kg\"", "wrong.toml, line 6: `length`: `kg` is not a unit of this quantity"),
        (
            "length = 0.8\npresent = \"burner\"\nwidth = \"2 mm\"",
            "there is no factor called `burner`; known: none",
        ),
    ] {
        fs::write(folder.join("wrong.toml"), texts[1].1.replace("length = \"80 cm\"", key)).unwrap();
        let output = rijke(&folder, &["modes", "wrong.toml"]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && said.contains(says), "{said}");
    }
}

const TUBE: &str = "[search]\ngrowth_rate = [-20, 20]\nfrequency_hz = [10, 500]\n[upstream]\ntype = \"closed\"\n[downstream]\ntype = \"open\"\n\
    [[element]]\nname = \"lower\"\ntype = \"duct\"\nlength = 0.5\ndiameter = 0.05\n\
    [[element]]\nname = \"upper\"\ntype = \"duct\"\nlength = 0.5\ndiameter = 0.05\n";

#[test]
fn message_sizes_that_no_rig_has_are_told_and_impossible_ones_refused() {
    let folder = scratch("modes-sizes");
    let run = |text: &str| {
        fs::write(folder.join("tube.toml"), text).unwrap();
        let output = rijke(&folder, &["modes", "tube.toml"]);
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let with = |from: &str, to: &str| {
        assert!(TUBE.contains(from));
        run(&TUBE.replacen(from, to, 1))
    };
    assert_eq!(run(TUBE), (Some(0), String::new()));
    // A duct that is nothing beside the others once ended with status 1.
    for length in ["0.5e-181", "1e-308"] {
        let (code, said) = with("length = 0.5", &format!("length = {length}"));
        assert!(code == Some(2) && said.contains("line 8: element 1 `lower` (duct): length is "), "{said}");
        assert!(said.contains("nothing beside the 0.5 m of the tube"), "{said}");
    }
    let (code, said) = with("length = 0.5", "length = \"half a metre\"");
    assert!(
        code == Some(2) && said.contains("`lower` (duct): length: the text \"half a metre\" stands"),
        "{said}"
    );
    let told = |(code, said): (Option<i32>, String), parts: [&str; 2]| {
        assert_eq!(code, Some(0), "{said}");
        assert!(said.contains("warning: ") && parts.iter().all(|part| said.contains(part)), "{said}");
    };
    told(
        with("diameter = 0.05", "diameter = 50"),
        ["(duct): diameter is 50 m, wider", "if these are mm, write 0.05"],
    );
    let cold = with("diameter = 0.05", "diameter = 0.05\ntemperature = 20");
    told(cold, ["temperature is 20 K", "if these are degrees Celsius, write 293.15"]);
    told(run(&format!("[gas]\ntemperature = 25\n{TUBE}")), ["[gas]: temperature is 25 K", "write 298.15"]);
    let element = |text: &str| run(&format!("{TUBE}[[element]]\nat = 0.5\n{text}\n"));
    // 729 wavelengths at 500 Hz are no tube. A pipeline in which hum is sought is one, and so is a long duct
    // behind an end.
    let (_, said) = with("length = 0.5", "length = 500");
    assert!(said.contains("(duct): length is 500 m, 728 wavelengths at the highest"), "{said}");
    assert!(said.contains("if these are mm, write 0.5\n"), "{said}");
    let pipeline = TUBE.replacen("length = 0.5", "length = 150", 1).replace("500]", "12]");
    let pipeline = pipeline.replace("[10, ", "[2, ");
    assert_eq!(run(&pipeline), (Some(0), String::new()));
    let behind = "type = \"delayed\"\nfactor = -1.0\ndelay = 1.2";
    assert_eq!(run(&pipeline.replace("type = \"open\"", behind)), (Some(0), String::new()));
    let helium = "[gas]\ntemperature = 80\ngas_constant = 2077\ngamma = 1.667\n";
    assert_eq!(run(&format!("{helium}{TUBE}")), (Some(0), String::new()));
    told(
        element("type = \"flame\"\nn = 0.1\ndelay = 3"),
        ["(flame): delay is 3 s", "if these are ms, write 0.003"],
    );
    let neck = element("type = \"helmholtz\"\nvolume = 1e-3\nneck_area = 2\nneck_length = 0.01");
    told(neck, ["neck_area is 2 m^2, more than the 1.963e-3 m^2", "check its unit"]);
    // Said before the search, which may not succeed with such a number.
    let (_, said) = with("type = \"open\"", "type = \"delayed\"\nfactor = -1.0\ndelay = 1.5");
    assert!(said.contains("[downstream]: delay is 1.5 s") && said.contains("write 0.0015"), "{said}");
    // A delay of 3 ms in degrees, in steps of 1 Hz: it looks like one of 172 ms.
    let rows = |delay: f64, unit: f64| {
        let row = |k: i32| {
            let f = f64::from(100 + k);
            format!("[{f}, {}, {}]", (-0.02 * f64::from(k)).exp(), -f * delay * unit)
        };
        format!(
            "type = \"flame\"\nn = 0.01\ntolerance = 0.1\ntable = [{}]",
            (0..30).map(row).collect::<Vec<_>>().join(", ")
        )
    };
    let (_, said) = element(&rows(3e-3, 360.0));
    assert!(said.contains("falls as by a delay of 172 ms: it is in rad; if these are degrees"), "{said}");
    assert_eq!(said.matches("the table ends at 100 and 129 Hz").count(), 1, "{said}");
    let (_, said) = element(&rows(3e-3, std::f64::consts::TAU));
    assert!(!said.contains("degrees"), "{said}");
}

#[test]
fn message_devices_at_one_place_of_a_rig_with_quantities_are_named() {
    let folder = scratch("modes-one-place");
    let duct = |name: &str, length: &str| {
        format!("[[element]]\nname = '{name}'\ntype = 'duct'\nlength = '{length}'\ndiameter = '50 mm'\n")
    };
    let said = |between: &str| {
        let text = format!(
            "name = 'two'\n[upstream]\ntype = 'closed'\n[downstream]\ntype = 'open'\n{}[[element]]\nname = 'h'\ntype = 'helmholtz'\n\
             volume = 1e-4\nneck_area = 1e-4\nneck_length = '30 mm'\n{between}[[element]]\nname = 'sc'\ntype = 'screen'\nresistance = 400\n{}",
            duct("below", "0.5 m"),
            duct("above", "0.5 m")
        );
        fs::write(folder.join("two.toml"), text).unwrap();
        let output = rijke(&folder, &["modes", "two.toml"]);
        let error = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{error}");
        (error, String::from_utf8(output.stdout).unwrap())
    };
    let (error, at_one_place) = said("");
    assert!(error.contains("`h` and `sc` are at one place: both"), "{error}");
    assert!(error.contains("put a duct of 1e-6 m between them"), "{error}");
    let (error, apart) = said(&duct("between", "1e-6 m"));
    assert!(!error.contains("at one place") && at_one_place != apart, "{error}");
}
