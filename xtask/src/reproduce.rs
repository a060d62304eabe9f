//! `cargo xtask reproduce`: builds `rijke`, runs its steps in order, and says what was run on what.

use crate::{Outcome, cargo, root, succeed};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::Command,
    time::Instant,
};

#[derive(clap::Args)]
pub(crate) struct Options {
    /// Four repeats of each operating point instead of the paper's forty.
    #[arg(long)]
    quick: bool,
    /// Seed of all random numbers of the virtual laboratory.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// The records of the virtual laboratory, in the root of the repository.
const RECORDS: &str = "virtual-rig";
/// Numbers, figures and the page.
const RESULTS: &str = "results";

/// The steps: name and arguments of `rijke`.
fn steps(options: &Options) -> Vec<Vec<String>> {
    let words = |text: &str| text.split(' ').map(String::from).collect::<Vec<_>>();
    let mut lab = words(&format!("lab --out {RECORDS} --force --row C3 --seed {}", options.seed));
    if options.quick {
        lab.extend(words("--repeats 4"));
    }
    let process = words(&format!("process {RECORDS} --force"));
    let rank = words(&format!("rank {RECORDS} --out {RESULTS} --force"));
    let report = words(&format!("report {RESULTS}"));
    vec![lab, process, rank, report]
}

pub(crate) fn run(options: &Options) -> Outcome {
    let start = Instant::now();
    succeed(cargo().args(["build", "--release", "--quiet", "--package", "rijke-cli"]))?;
    println!("{:>10}  {:6.1} s", "build", start.elapsed().as_secs_f64());

    let program = program();
    let (mut done, start) = (Vec::new(), Instant::now());
    for arguments in steps(options) {
        let step = Instant::now();
        succeed(Command::new(&program).args(&arguments).current_dir(root()))?;
        let seconds = step.elapsed().as_secs_f64();
        println!("{:>10}  {seconds:6.1} s", arguments[0]);
        done.push(json!({ "command": format!("rijke {}", arguments.join(" ")), "seconds": seconds }));
    }
    println!("{:>10}  {:6.1} s", "total", start.elapsed().as_secs_f64());

    let results = root().join(RESULTS);
    let manifest = manifest(options, done)?;
    let path = results.join("manifest.json");
    fs::write(&path, format!("{manifest:#}\n")).map_err(|e| format!("{}: {e}", path.display()))?;
    println!("open {}", results.join("index.html").display());
    Ok(())
}

/// Where cargo puts the program.
fn program() -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| "target".into(), PathBuf::from);
    root().join(target).join("release").join(format!("rijke{}", std::env::consts::EXE_SUFFIX))
}

/// What was run, on what, by what.
fn manifest(options: &Options, steps: Vec<Value>) -> Result<Value, String> {
    Ok(json!({
        "revision": first_line("git", &["describe", "--always", "--dirty", "--abbrev=40"]),
        "toolchain": first_line("rustc", &["--version"]),
        "seed": options.seed,
        "quick": options.quick,
        "steps": steps,
        "inputs_sha256": hashes(&root().join("fixtures"))?,
    }))
}

/// The first line that a program prints, if it is installed and succeeds.
fn first_line(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).current_dir(root()).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.lines().next().map(String::from))?
}

/// The hash of every file under a folder, by path from the root.
fn hashes(folder: &Path) -> Result<BTreeMap<String, String>, String> {
    let mut found = BTreeMap::new();
    let said = |e: std::io::Error| format!("{}: {e}", folder.display());
    for entry in fs::read_dir(folder).map_err(said)? {
        let path = entry.map_err(said)?.path();
        if path.is_dir() {
            found.extend(hashes(&path)?);
        } else {
            let digest = Sha256::digest(fs::read(&path).map_err(said)?);
            let name = path.strip_prefix(root()).unwrap_or(&path).to_string_lossy().replace('\\', "/");
            found.insert(name, digest.iter().map(|b| format!("{b:02x}")).collect());
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_options_reach_the_laboratory() {
        let steps = steps(&Options { quick: true, seed: 7 });
        assert_eq!(steps[0].join(" "), "lab --out virtual-rig --force --row C3 --seed 7 --repeats 4");
        let names: Vec<_> = steps.iter().map(|s| &*s[0]).collect();
        assert_eq!(names, ["lab", "process", "rank", "report"]);
    }

    #[test]
    fn exact_hashes_are_sha256() {
        let found = hashes(&root().join("fixtures/reference")).unwrap();
        assert!(
            found.keys().all(|k| k.starts_with("fixtures/reference/"))
                && found.values().all(|v| v.len() == 64)
        );
    }
}
