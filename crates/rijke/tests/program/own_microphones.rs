//! Microphones of somebody's own that drift, are dead or hum: the program names them, and what to write.

use crate::own_records::study;
use crate::rijke;
use std::{fs, path::Path};

/// Changes every sample of the records: time (s), microphone, value.
fn change(folder: &Path, of: impl Fn(f64, usize, f64) -> f64) {
    for name in ["a", "b", "c"] {
        let path = folder.join(format!("records/{name}.csv"));
        let text = fs::read_to_string(&path).unwrap();
        let row = |line: &str| {
            let numbers: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
            let changed = numbers[1..].iter().enumerate().map(|(m, v)| of(numbers[0], m, *v).to_string());
            format!("{},{}\n", numbers[0], changed.collect::<Vec<_>>().join(","))
        };
        let mut lines = text.lines();
        let head = format!("{}\n", lines.next().unwrap());
        fs::write(&path, head + &lines.map(row).collect::<String>()).unwrap();
    }
}

fn process(folder: &Path) -> (Option<i32>, String) {
    let output = rijke(folder, &["process", ".", "--force"]);
    let said = [output.stdout, output.stderr].map(|o| String::from_utf8_lossy(&o).into_owned()).concat();
    (output.status.code(), said)
}

#[test]
fn behaviour_a_gain_that_drifts_is_said_and_left_out() {
    let folder = study("own-drift");
    change(&folder, |t, m, v| if m == 3 { v * (1.0 + 0.08 * t) } else { v });
    let (code, said) = process(&folder);
    assert!(code == Some(0) && said.contains("0 rejected") && said.contains("3 put right"), "{said}");
    for part in [
        "microphone 3 (p4) was left out of 3 of 3 pings",
        "e-0, e-40",
        "the growth rate of microphone 3 (p4) differs from that of the others",
        "write `dead = [3]`",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let corrections = fs::read_to_string(folder.join("observations/corrections.csv")).unwrap();
    assert!(
        corrections.contains("a.csv,\"left out: the growth rate of microphone 3 (p4) differs"),
        "{corrections}"
    );
    let pings = fs::read_to_string(folder.join("observations/pings.csv")).unwrap();
    let mut rows = pings.lines().map(|l| l.split(',').collect::<Vec<_>>());
    let head = rows.next().unwrap();
    let at = |name: &str| head.iter().position(|c| *c == name).unwrap();
    for row in rows {
        assert!(row[at("p4_re")].is_empty() && !row[at("p5_re")].is_empty());
        let growth_rate: f64 = row[at("growth_rate [1/s]")].parse().unwrap();
        assert!((growth_rate + 4.0).abs() < 0.01, "{growth_rate}");
    }
}

#[test]
fn message_a_dead_microphone_and_other_mains_are_named_with_what_to_write() {
    let folder = study("own-undeclared");
    let hum = |t: f64| 0.02 * ((376.99 * t).sin() + 0.4 * (753.98 * t).sin());
    change(&folder, |t, m, v| if m == 3 { 1e-5 * (1e4 * t).sin().round() } else { v + hum(t) });
    let (code, said) = process(&folder);
    // It costs its channel only.
    assert_eq!(code, Some(0), "{said}");
    for part in [
        "microphone 3 (p4) was left out of 3 of 3 pings",
        "microphone 3 (p4) carries no signal: its amplitude is",
        "the median of the channels",
        "write `dead = [3]`",
        "3 records, 0 rejected",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let path = folder.join("records/manifest.toml");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, format!("dead = [3]\n{text}")).unwrap();
    let (code, said) = process(&folder);
    let hint = "hums at 60 Hz and its multiples, and the mains are said to have 50 Hz: write `mains_hz = 60`";
    assert!(code == Some(0) && said.contains(hint), "{said}");
    fs::write(&path, format!("mains_hz = 60\ndead = [3]\n{text}")).unwrap();
    let (code, said) = process(&folder);
    assert!(code == Some(0) && !said.contains("hums at"), "{said}");
}

#[test]
fn message_a_thermometer_that_the_rig_lacks_is_refused_with_those_it_has() {
    let folder = study("own-thermometer");
    let path = folder.join("observations/readings.csv");
    let head = "point,thermometer,at [m],temperature [degC],sd [K]\n";
    for (row, part) in [
        ("h150-25-40,T9,0.24,43.1,2.0\n", "there is no thermometer called `T9`; known: T1, T2, T3"),
        ("h150-25-40,T1,0.3,43.1,2.0\n", "`0.3 m, at h150-25-40`; known: T1 at 0.2400 m, T2 at 0.4800 m"),
    ] {
        fs::write(&path, format!("{head}{row}")).unwrap();
        let output = rijke(&folder, &["check", "."]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && said.contains(part), "{said}");
    }
    fs::write(&path, format!("{head}h150-25-40,T1,0.24,43.1,2.0\n")).unwrap();
    let output = rijke(&folder, &["check", "."]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn behaviour_a_polarity_that_as_many_pings_have_as_have_not_is_said_and_left_out() {
    let folder = study("own-tie");
    let turn = |name: &str, sign: fn(usize) -> f64| {
        let path = folder.join(format!("records/{name}.csv"));
        let text = fs::read_to_string(&path).unwrap();
        let mut lines = text.lines();
        let head = format!("{}\n", lines.next().unwrap());
        let row = |line: &str| {
            let cells = line.split(',').enumerate();
            let turned = cells.map(|(k, v)| (v.parse::<f64>().unwrap() * sign(k)).to_string());
            turned.collect::<Vec<_>>().join(",") + "\n"
        };
        fs::write(&path, head + &lines.map(row).collect::<String>()).unwrap();
    };
    turn("b", |column| if column == 4 { -1.0 } else { 1.0 });
    let (code, said) = process(&folder);
    let named = "microphone 3 (p4) has one polarity in a.csv and the opposite one in b.csv";
    assert!(code == Some(0) && said.contains(named) && said.contains("e-0 has no pressure of it"), "{said}");
    let pings = fs::read_to_string(folder.join("observations/pings.csv")).unwrap();
    let rows: Vec<Vec<&str>> = pings.lines().map(|l| l.split(',').collect()).collect();
    let at = |name: &str| rows[0].iter().position(|c| *c == name).unwrap();
    let row = |point: &str| rows.iter().find(|r| r[0] == point).unwrap();
    assert!(row("e-0")[at("p4_re")].is_empty() && !row("e-0")[at("p5_re")].is_empty(), "{pings}");
    assert!(!row("e-40")[at("p4_re")].is_empty(), "{pings}");
    // What no sign explains is no reversal.
    turn("b", |column| [1.0, 1.0, 1.0, 1.0, 0.7, 1.0][column]);
    let (code, said) = process(&folder);
    let named = "the gain of microphone 3 (p4) changes between the repeats of e-0";
    assert!(code == Some(0) && said.contains(named) && !said.contains("polarity"), "{said}");
}

#[test]
fn behaviour_a_copy_that_was_cut_and_scaled_is_named_and_left_out() {
    let folder = study("own-copy");
    let text = fs::read_to_string(folder.join("records/a.csv")).unwrap();
    let kept = text.lines().count() - 37;
    let cut: String = text.lines().take(kept).map(|line| format!("{line}\n")).collect();
    let of_b = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let scaled = cells[1..].iter().map(|v| (1.001 * v.parse::<f64>().unwrap()).to_string());
        format!("{},{}\n", cells[0], scaled.collect::<Vec<_>>().join(","))
    };
    let head = cut.lines().next().unwrap();
    let rows: String = cut.lines().skip(1).map(of_b).collect();
    fs::write(folder.join("records/b.csv"), format!("{head}\n{rows}")).unwrap();
    let (code, said) = process(&folder);
    let named = "1 of 3 records is a copy of another one of the same point";
    assert!(code == Some(0) && said.contains(named) && said.contains("b.csv, is a copy of a.csv"), "{said}");
    let rejections = fs::read_to_string(folder.join("observations/rejections.csv")).unwrap();
    assert!(
        rejections.contains("b.csv,\"a copy of a.csv: ") || rejections.contains("b.csv,a copy of a.csv: ")
    );
}
