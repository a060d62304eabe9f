//! `cargo xtask reproduce`: builds `rijke`, runs its stages in order, and says what was run on what.

mod hashes;
mod items;
mod reference;
mod stages;

use crate::{Outcome, cargo, root, succeed};
use serde_json::{Value, json};
use stages::{Made, Stage};
use std::{
    fs,
    path::PathBuf,
    process::{Command, Stdio},
    thread,
    time::{Duration, Instant},
};

#[derive(clap::Args)]
pub(crate) struct Options {
    /// Only this table or figure of the paper and what it rests on: table-1 to table-4, figure-2 to figure-12.
    #[arg(long, value_name = "ITEM", value_parser = items::parse)]
    only: Option<&'static items::Item>,
    /// Four repeats of each operating point instead of the paper's forty.
    #[arg(long)]
    quick: bool,
    /// Seed of all random numbers of the virtual laboratory.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Run every stage, also those that were finished before with the same inputs.
    #[arg(long)]
    fresh: bool,
    /// Afterwards compare the numbers with those kept in reference/, and fail if one moved beyond its tolerance.
    #[arg(long)]
    check: bool,
    /// Afterwards keep the numbers in reference/, to be compared with by --check.
    #[arg(long, conflicts_with_all = ["check", "only"])]
    accept: bool,
}

/// What `rijke` makes before it ranks: observations and base flow, in the root of the repository.
const WORK: &str = "virtual-rig";
/// Numbers, figures and the page.
const RESULTS: &str = "results";

pub(crate) fn run(options: &Options) -> Outcome {
    let start = Instant::now();
    println!("[build] cargo build --release --package rijke-cli");
    succeed(cargo().args(["build", "--release", "--quiet", "--package", "rijke-cli"]))?;
    println!("[build] done in {:.1} s", start.elapsed().as_secs_f64());

    let program = program();
    let program_hash = hashes::file(&program)?;
    let stages = stages::stages(options);
    let (mut done, start) = (Vec::new(), Instant::now());
    for (number, stage) in stages.iter().enumerate() {
        let label = format!("[{}/{}]", number + 1, stages.len());
        let inputs = stage.input_hashes()?;
        let fingerprint = stage.fingerprint(&program_hash, &inputs);
        let command = format!("rijke {}", stage.arguments.join(" "));
        let before = if options.fresh { None } else { stage.finished(&fingerprint)? };
        let made = match &before {
            Some(made) => {
                println!("{label} {command}\n{label} kept from before: it took {:.1} s", made.seconds);
                made.clone()
            }
            None => {
                let left = stages::time_left(&stages[..number], &done, &stages[number..]);
                let left = left.map_or_else(String::new, |s| format!(" (about {s:.0} s left in all)"));
                println!("{label} {command}{left}");
                let made = take(stage, &program)?;
                stage.mark(&fingerprint, &made)?;
                println!("{label} done in {:.1} s, at most {} MiB", made.seconds, made.peak_mib);
                made
            }
        };
        done.push((made, before.is_some(), inputs));
    }
    println!("all stages in {:.1} s", start.elapsed().as_secs_f64());

    let results = root().join(RESULTS);
    let path = results.join("manifest.json");
    let manifest = manifest(options, &program_hash, &stages, &done)?;
    fs::write(&path, format!("{manifest:#}\n")).map_err(|e| format!("{}: {e}", path.display()))?;
    println!("open {}", results.join("index.html").display());
    keep_picture(options)?;

    let reference = root().join("reference").join(if options.quick { "quick" } else { "full" });
    match (options.check, options.accept) {
        (true, _) => reference::check(&results.join("numbers"), &reference),
        (_, true) => reference::accept(&results.join("numbers"), &reference),
        _ => Ok(()),
    }
}

/// Runs a stage to its end. What it prints as a result is left out; its progress with the time left, which it shows on a
/// terminal, is not.
fn take(stage: &Stage, program: &PathBuf) -> Result<Made, String> {
    let start = Instant::now();
    let mut child = Command::new(program)
        .args(&stage.arguments)
        .current_dir(root())
        .stdout(Stdio::null())
        .spawn()
        .map_err(|e| format!("cannot start {}: {e}", program.display()))?;
    let mut peak_mib = 0;
    let status = loop {
        peak_mib = peak_mib.max(peak_memory_mib(child.id()).unwrap_or(0));
        match child.try_wait() {
            Ok(Some(status)) => break status,
            Ok(None) => thread::sleep(Duration::from_millis(10)),
            Err(error) => return Err(format!("{}: {error}", program.display())),
        }
    };
    if !status.success() {
        return Err(format!("`rijke {}` ended with {status}", stage.arguments.join(" ")));
    }
    Ok(Made { seconds: start.elapsed().as_secs_f64(), peak_mib })
}

/// The most memory that a running process has held so far; none where the system does not tell.
fn peak_memory_mib(process: u32) -> Option<u64> {
    let status = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kib: u64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(kib.div_ceil(1024))
}

/// The picture of the README is Fig. 4 of the full run with the usual seed.
fn keep_picture(options: &Options) -> Outcome {
    if options.quick || options.only.is_some() || options.seed != 1 {
        return Ok(());
    }
    let folder = root().join("docs/images");
    let copy = || {
        fs::create_dir_all(&folder)?;
        fs::copy(root().join(RESULTS).join("figures/figure-4.svg"), folder.join("figure-4.svg"))
    };
    copy().map(drop).map_err(|e| format!("{}: {e}", folder.display()))
}

/// Where cargo puts the program.
fn program() -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| "target".into(), PathBuf::from);
    root().join(target).join("release").join(format!("rijke{}", std::env::consts::EXE_SUFFIX))
}

/// A finished stage: what it took, whether it was kept from before, and the hashes of its inputs.
type Done = (Made, bool, Vec<(String, String)>);

/// What was run, on what, by what.
fn manifest(options: &Options, program_hash: &str, stages: &[Stage], done: &[Done]) -> Result<Value, String> {
    let stage = |(stage, (made, kept, inputs)): (&Stage, &Done)| {
        json!({
            "command": format!("rijke {}", stage.arguments.join(" ")),
            "inputs_sha256": inputs.iter().cloned().collect::<std::collections::BTreeMap<_, _>>(),
            "seconds": made.seconds,
            "peak_memory_mib": made.peak_mib,
            "kept": kept,
        })
    };
    Ok(json!({
        "revision": first_line("git", &["describe", "--always", "--dirty", "--abbrev=40"]),
        "toolchain": first_line("rustc", &["--version"]),
        "seed": options.seed,
        "quick": options.quick,
        "only": options.only.map(|item| item.name),
        "program_sha256": program_hash,
        "stages": stages.iter().zip(done).map(stage).collect::<Vec<_>>(),
        "seconds": done.iter().map(|(made, ..)| made.seconds).sum::<f64>(),
        "peak_memory_mib": done.iter().map(|(made, ..)| made.peak_mib).max(),
        "fixtures_sha256": hashes::folder(&root(), &root().join("fixtures"))?,
        "numbers_sha256": hashes::folder(&root(), &root().join(RESULTS).join("numbers"))?,
    }))
}

/// The first line that a program prints, if it is installed and succeeds.
fn first_line(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).current_dir(root()).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.lines().next().map(String::from))?
}
