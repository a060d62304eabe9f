//! `cargo xtask scale`: what `rijke flow` and `rijke rank` cost against the number of points, microphones and
//! candidates.

use crate::reproduce::program;
use crate::workspace::{Outcome, cargo, root, succeed};
use std::{fmt::Write as _, fs, path::Path, process::Command, time::Instant};

const HEAD: &str = "# What size costs

Written by `cargo xtask scale`, which makes every input. Seconds of processor and seconds of the clock, on two cores that other work may share. The exponent is that of
processor time against size, from the row above.

`rijke flow`: rows H0 to H180 of the paper's campaign with the heater at more places, 8 powers each, two repeats of the virtual laboratory. `rijke rank --one-start`: the example quarter-wave,
its points and observations copied so many times, observed by so many microphones, or with so many laws of heat release in the last stage.

| command | size | points | processor, s | clock, s | exponent |
|---|---|---|---|---|---|
";

/// A folder of text files, written, and changed by what follows.
type Made = Result<(), String>;

pub(crate) fn run() -> Outcome {
    succeed(cargo().args([
        "build",
        "--release",
        "--workspace",
        "--bin",
        "rijke",
        "--example",
        "bench_data",
    ]))?;
    let (mut text, place) = (String::from(HEAD), root().join("target/scale"));
    let _ = fs::remove_dir_all(&place);
    let mut series = |what: &str, sizes: &[usize], make: &dyn Fn(&Path, usize) -> Made, words: &str| {
        let mut before = None;
        for &size in sizes {
            let folder = place.join(format!("{}-{size}", what.replace([' ', ',', '`'], "-")));
            fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
            make(&folder, size)?;
            let table = ["observations/points.csv", "campaign.csv"]
                .map(|f| read(&folder.join(f)).unwrap_or_default());
            let points = table.iter().find(|t| !t.is_empty()).map_or(0, |t| rows(t).count() - 1);
            let (cpu, clock) = (children(), Instant::now());
            succeed(Command::new(program()).args(words.split(' ')).current_dir(&folder))?;
            let (cpu, clock) = (children() - cpu, clock.elapsed().as_secs_f64());
            let grown =
                |(n, c): (usize, f64)| format!("{:.2}", (cpu / c).ln() / (size as f64 / n as f64).ln());
            let exponent = before.map_or(String::new(), grown);
            let _ = writeln!(text, "| {what} | {size} | {points} | {cpu:.1} | {clock:.1} | {exponent} |");
            println!("{what} {size}: {cpu:.1} s {exponent}");
            before = Some((size, cpu));
        }
        write(&root().join("docs/records/scale.md"), &text)
    };
    let rank = "rank . --one-start --force --quiet";
    series(
        "`flow`, places of the heater",
        &[15, 29, 57],
        &|f, n| campaign(f, n, 8),
        "flow . --out base --quiet",
    )?;
    series("`flow`, microphones", &[5, 16, 64], &|f, n| campaign(f, 15, n), "flow . --out base --quiet")?;
    series("`rank`, copies of all points", &[1, 2, 4], &copies, rank)?;
    series("`rank`, microphones", &[5, 16, 64], &microphones, rank)?;
    series("`rank`, candidates", &[10, 100], &candidates, rank)
}

/// Seconds of processor of all programs that have ended, as Linux counts them: hundredths (proc(5), `cutime`
/// and `cstime`).
fn children() -> f64 {
    let stat = fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let numbers = stat.rsplit(')').next().unwrap_or_default().split_whitespace().skip(13).take(2);
    numbers.filter_map(|n| n.parse::<f64>().ok()).sum::<f64>() / 100.0
}

fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))
}

fn write(path: &Path, text: &str) -> Outcome {
    fs::write(path, text).map_err(|e| format!("{}: {e}", path.display()))
}

/// Lines that are no comments.
fn rows(text: &str) -> impl Iterator<Item = &str> {
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
fn campaign(folder: &Path, places: usize, microphones: usize) -> Made {
    let text = read(&root().join("crates/rig/data/campaigns/juniper-yoko-2022.toml"))?;
    let mut all = String::from("name = \"scale\"\nsource = \"cargo xtask scale\"\n");
    for row in text.split("\n[[row]]").skip(1).filter(|row| row.contains("id = \"H")) {
        let own = row.lines().filter(|line| !line.starts_with("positions_cm")).collect::<Vec<_>>().join("\n");
        let _ = write!(all, "\n[[row]]{own}\npositions_cm = {:?}\n", spread(15.0, 85.0, places));
    }
    write(&folder.join("campaign.toml"), &all)?;
    let rig = read(&root().join("crates/rig/data/rigs/juniper-yoko-2022.toml"))?;
    let kept = rig.lines().map(|line| match line.split(' ').next() {
        Some("positions") => format!("positions = {:?}", spread(0.25, 0.95, microphones)),
        Some("reference") => format!("reference = {}", microphones / 2),
        _ => line.to_owned(),
    });
    write(&folder.join("rig.toml"), &(kept.collect::<Vec<_>>().join("\n") + "\n"))?;
    let words = "process --virtual-rig --rig rig.toml --campaign campaign.toml --repeats 2 --out observations --quiet";
    succeed(Command::new(program()).args(words.split(' ')).current_dir(folder))
}

/// The example quarter-wave, its files changed by `change`, which has the name and the text of each.
fn example(folder: &Path, change: &dyn Fn(&str, String) -> String) -> Made {
    let from = root().join("examples/quarter-wave");
    for sub in ["", "candidates", "observations"] {
        let source = from.join(sub);
        fs::create_dir_all(folder.join(sub)).map_err(|e| e.to_string())?;
        for entry in fs::read_dir(&source).map_err(|e| format!("{}: {e}", source.display()))? {
            let path = entry.map_err(|e| e.to_string())?.path();
            let Some(name) = path.file_name().and_then(|n| n.to_str()).filter(|_| path.is_file()) else {
                continue;
            };
            write(&folder.join(sub).join(name), &change(name, read(&path)?))?;
        }
    }
    Ok(())
}

/// Every point and what was observed there `count` times, under other names.
fn copies(folder: &Path, count: usize) -> Made {
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
fn microphones(folder: &Path, count: usize) -> Made {
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
fn candidates(folder: &Path, count: usize) -> Made {
    example(folder, &|name, text| match name {
        "heat-release.toml" => {
            let mut blocks =
                text.split("[[candidate]]\n").filter(|b| b.starts_with("id = \"heat.king-lighthill\""));
            let block = blocks.next().unwrap_or_default();
            let one = |k: usize| {
                let other = block.replacen("king-lighthill", &format!("law-{k}"), 1);
                format!(
                    "[[candidate]]\n{}",
                    other.replacen("mean = 0.9", &format!("mean = {:.4}", 0.8 + 2e-4 * k as f64), 1)
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
