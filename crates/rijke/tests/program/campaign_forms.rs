//! A campaign as a table and as TOML.

use crate::{copy, example, rijke, scratch};
use std::{collections::BTreeMap, fmt::Write as _, fs, path::Path};

/// The campaign of the quarter-wave tube as TOML: numbers in other units, defaults, keys left out.
fn document(table: &str) -> String {
    let mut rows = table.lines().filter(|line| !line.starts_with('#')).map(|line| line.split(',').collect());
    let header: Vec<&str> = rows.next().unwrap();
    let mut text = String::from(
        "[units]\nx_g = \"mm\"\nQ = \"W\"\nflow = \"L/min\"\ngauze = \"\"\n[defaults]\nrepeats = 20\nT_amb_sd = \"0.15 K\"\n",
    );
    for row in rows {
        let row: Vec<&str> = row;
        text += "[[point]]\n";
        for (name, cell) in header.iter().zip(row).filter(|(_, cell)| !cell.is_empty()) {
            let name = name.split(' ').next().unwrap();
            let _ = match name {
                "repeats" | "T_amb_sd" => Ok(()),
                "point" => writeln!(text, "id = \"{cell}\""),
                "row" | "installation" => writeln!(text, "{name} = \"{cell}\""),
                "x_g" => writeln!(text, "x_g = \"{cell} mm\""),
                "flow" if cell == "40" => writeln!(text, "flow = \"40 L/min\""),
                "gauze" => writeln!(text, "gauze = {}", cell == "1"),
                _ => writeln!(text, "{name} = {cell}"),
            };
        }
    }
    text
}

/// All files below a folder, but the list of what it was made of.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let name = entry.file_name().into_string().unwrap();
        if entry.path().is_dir() {
            all.extend(files(&entry.path()).into_iter().map(|(path, text)| (format!("{name}/{path}"), text)));
        } else if name != "made_of.json" {
            all.insert(name, fs::read(entry.path()).unwrap());
        }
    }
    all
}

#[test]
fn exact_a_campaign_gives_the_same_results_as_a_table_and_as_toml() {
    let mut results = Vec::new();
    for form in ["table", "document"] {
        let folder = scratch(&format!("campaign-{form}"));
        copy(&example("quarter-wave"), &folder.join("rig"));
        let table = folder.join("rig/campaign.csv");
        if form == "document" {
            let text = document(&fs::read_to_string(&table).unwrap());
            fs::write(folder.join("rig/campaign.toml"), text).unwrap();
            let both = rijke(&folder, &["check", "rig"]);
            let said = String::from_utf8(both.stderr).unwrap();
            assert!(both.status.code() == Some(2) && said.contains("campaign.toml: stands beside"), "{said}");
            fs::remove_file(&table).unwrap();
        }
        let check = rijke(&folder, &["check", "rig", "--json"]);
        assert!(check.status.success(), "{}", String::from_utf8_lossy(&check.stderr));
        let run = rijke(&folder, &["run", "rig", "--one-start"]);
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        results.push((check.stdout, files(&folder.join("rig/results"))));
    }
    assert_eq!(results[0].0, results[1].0);
    assert!(results[0].1.len() > 10);
    for (name, bytes) in &results[0].1 {
        assert!(results[1].1.get(name) == Some(bytes), "{name} differs");
    }
    assert_eq!(results[0].1.len(), results[1].1.len());
}

/// A length that the campaign makes negative at one planned point that nobody measured.
#[test]
fn message_a_length_that_is_negative_at_a_planned_point_is_refused_by_check() {
    let folder = scratch("campaign-negative");
    copy(&example("quarter-wave"), &folder.join("rig"));
    let rig = folder.join("rig/rig.toml");
    let text = fs::read_to_string(&rig).unwrap();
    let over = "{ over = \"Q\", rows = [[0, 0.8], [50, 0.8], [900, -0.1]] }";
    assert!(text.contains("length = \"0.8 m\""));
    fs::write(&rig, text.replacen("\"0.8 m\"", over, 1)).unwrap();
    let table = folder.join("rig/campaign.csv");
    let text = fs::read_to_string(&table).unwrap();
    let planned = text.clone() + "h120-900-40,hot,120,900,40,1,20,gauze-120,11,291.6,0.15\n";
    for (text, sound) in [(text, true), (planned, false)] {
        fs::write(&table, text).unwrap();
        let output = rijke(&folder, &["check", "rig"]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(if sound { 0 } else { 2 }), "{said}");
        for part in [
            "rig.toml: at operating point h120-900-40: `tube: length` is `-",
            "correct it in rig.toml, or the factors of this point",
        ] {
            assert_eq!(said.contains(part), !sound, "{part}\n{said}");
        }
    }
}
