//! Folders of inputs.

use crate::workspace::{entries, program, read, root, succeed, write};
use std::{fmt::Write as _, fs, path::Path, process::Command};

/// A folder of text files, written, and changed by what follows.
pub(super) type Made = Result<(), String>;

/// Lines that are no comments.
pub(super) fn rows(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter(|line| !line.starts_with('#') && !line.is_empty())
}

/// Numbers from `low` to `high`, `count` of them.
fn spread(low: f64, high: f64, count: usize) -> Vec<f64> {
    (0..count)
        .map(|k| low + (high - low) * k as f64 / (count - 1) as f64)
        .map(|x| (x * 1e4).round() / 1e4)
        .collect()
}

/// Observations of the virtual laboratory with the heater at `places`, at least 1 cm apart, because points
/// are called by it.
pub(super) fn campaign(folder: &Path, places: usize, microphones: usize) -> Made {
    let text = read(&root().join("crates/flow/data/campaigns/juniper-yoko-2022.toml"))?;
    let mut all = String::from("name = \"scale\"\nsource = \"cargo xtask scale\"\n");
    for row in text.split("\n[[row]]").skip(1).filter(|row| row.contains("id = \"H")) {
        let own = row.lines().filter(|line| !line.starts_with("positions_cm")).collect::<Vec<_>>().join("\n");
        let _ = write!(all, "\n[[row]]{own}\npositions_cm = {:?}\n", spread(15.0, 85.0, places));
    }
    write(&folder.join("campaign.toml"), &all)?;
    rig_of(folder, microphones)?;
    let words = "process --virtual-rig --rig tube.toml --campaign campaign.toml --repeats 2 --out observations --quiet";
    succeed(Command::new(program()).args(words.split(' ')).current_dir(folder))
}

/// Records of one row of the paper's campaign.
pub(super) fn laboratory(folder: &Path, microphones: usize) -> Made {
    rig_of(folder, microphones)?;
    let words = "lab --rig tube.toml --rows C3 --repeats 1 --out records --quiet";
    succeed(Command::new(program()).args(words.split(' ')).current_dir(folder))
}

/// The paper's rig with so many microphones.
fn rig_of(folder: &Path, microphones: usize) -> Made {
    let rig = read(&root().join("crates/flow/data/rigs/juniper-yoko-2022.toml"))?;
    let kept = rig.lines().map(|line| match line.split(' ').next() {
        Some("positions") => format!("positions = {:?}", spread(0.25, 0.95, microphones)),
        Some("reference") => format!("reference = {}", microphones / 2),
        _ => line.to_owned(),
    });
    write(&folder.join("tube.toml"), &(kept.collect::<Vec<_>>().join("\n") + "\n"))
}

/// The example quarter-wave, its files changed by `change`, which has the name and the text of each.
pub(super) fn example(folder: &Path, change: &dyn Fn(&str, String) -> String) -> Made {
    let from = root().join("examples/quarter-wave");
    for sub in ["", "candidates", "observations"] {
        let source = from.join(sub);
        fs::create_dir_all(folder.join(sub)).map_err(|e| e.to_string())?;
        for path in entries(&source)? {
            let Some(name) = path.file_name().and_then(|n| n.to_str()).filter(|_| path.is_file()) else {
                continue;
            };
            write(&folder.join(sub).join(name), change(name, read(&path)?))?;
        }
    }
    Ok(())
}

/// Every point and what was observed there `count` times, under other names.
pub(super) fn copies(folder: &Path, count: usize) -> Made {
    example(folder, &|name, text| {
        if !["campaign.csv", "modes.csv", "readings.csv"].contains(&name) {
            return text;
        }
        let mut lines = rows(&text);
        let mut all = lines.next().unwrap_or_default().to_owned() + "\n";
        for line in lines {
            for k in 0..count {
                let mut cells: Vec<String> = line.split(',').map(String::from).collect();
                cells[0] += &format!("-{k}");
                if name == "campaign.csv" {
                    cells[7] += &format!("-{k}");
                }
                all += &(cells.join(",") + "\n");
            }
        }
        all
    })
}

/// Observed again, by `count` microphones.
pub(super) fn microphones(folder: &Path, count: usize) -> Made {
    let at = spread(0.1, 0.7, count);
    let names: Vec<String> = (1..=count).map(|k| format!("p{k}")).collect();
    let table = format!("[microphones]\nat = {at:?}\n");
    example(folder, &|name, text| {
        let Some((before, rest)) = text.split_once("[microphones]").filter(|_| name != "study.toml") else {
            return text;
        };
        let after = rest.split_once("\n[").map_or(String::new(), |(_, after)| format!("\n[{after}"));
        match name {
            "rig.toml" => format!("{before}{table}names = {names:?}\nreference = \"p1\"\n{after}"),
            "truth.toml" => format!("{before}{table}reference = 1\ndead = []\n{after}"),
            _ => text,
        }
    })?;
    let [truth, out] = ["truth.toml", "sets"].map(|f| folder.join(f));
    let bench = program().with_file_name(format!("examples/bench_data{}", std::env::consts::EXE_SUFFIX));
    succeed(Command::new(bench).args([&truth, &out]).arg("1"))?;
    for file in ["modes.csv", "readings.csv", "observations.toml"] {
        write(&folder.join("observations").join(file), &read(&out.join("1").join(file))?)?;
    }
    Ok(())
}

/// With `count` laws of heat release, all alike but for their prior.
pub(super) fn candidates(folder: &Path, count: usize) -> Made {
    example(folder, &|name, text| match name {
        "heat-release.toml" => {
            let mut blocks =
                text.split("[[candidate]]\n").filter(|b| b.starts_with("id = \"heat.king-lighthill\""));
            let block = blocks.next().unwrap_or_default();
            let one = |k: usize| {
                let other = block.replacen("king-lighthill", &format!("law-{k}"), 1);
                format!(
                    "[[candidate]]\n{}",
                    other.replacen(
                        "mean = 0.9",
                        &format!("mean = {:.6}", 0.8 + 0.2 * k as f64 / count as f64),
                        1
                    )
                )
            };
            (0..count).map(one).collect()
        }
        "study.toml" => {
            text.lines().filter(|l| !l.starts_with("rows = ")).collect::<Vec<_>>().join("\n") + "\n"
        }
        _ => text,
    })
}
