//! `cargo xtask reproduce`: builds `rijke`, runs its steps in order, and says what was run on what.

mod hashes;
mod reference;
mod steps;

use crate::{Outcome, cargo, root, succeed};
use serde_json::{Value, json};
use std::{
    fs,
    path::PathBuf,
    process::{Command, Stdio},
    time::Instant,
};
use steps::{Step, steps};

#[derive(clap::Args)]
pub(crate) struct Options {
    /// Four repeats of each operating point instead of the paper's forty.
    #[arg(long)]
    quick: bool,
    /// Seed of all random numbers of the virtual laboratory.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Run every step, also those that were finished before with the same inputs.
    #[arg(long)]
    fresh: bool,
    /// Afterwards compare the numbers with those kept in reference/, and fail if one moved beyond its tolerance.
    #[arg(long)]
    check: bool,
    /// Afterwards keep the numbers in reference/, to be compared with by --check.
    #[arg(long, conflicts_with = "check")]
    accept: bool,
}

/// The records of the virtual laboratory, in the root of the repository.
const RECORDS: &str = "virtual-rig";
/// Numbers, figures and the page.
const RESULTS: &str = "results";

pub(crate) fn run(options: &Options) -> Outcome {
    let start = Instant::now();
    succeed(cargo().args(["build", "--release", "--quiet", "--package", "rijke-cli"]))?;
    say("build", start.elapsed().as_secs_f64());

    let program = program();
    let mut fingerprint = hashes::file(&program)?;
    let (mut done, start) = (Vec::new(), Instant::now());
    for step in steps(options) {
        // What a step makes depends on the program, its arguments and, through the step before, on all that went before.
        fingerprint = hashes::text(&format!("{fingerprint}\n{}", step.arguments.join("\n")));
        let (seconds, kept) = match step.finished(&fingerprint).filter(|_| !options.fresh) {
            Some(seconds) => (seconds, true),
            None => (take(&step, &program, &fingerprint)?, false),
        };
        if kept {
            println!("{:>10}  kept from before ({seconds:.1} s)", step.arguments[0]);
        } else {
            say(&step.arguments[0], seconds);
        }
        let command = format!("rijke {}", step.arguments.join(" "));
        done.push(json!({ "command": command, "seconds": seconds, "kept": kept }));
    }
    say("total", start.elapsed().as_secs_f64());

    let results = root().join(RESULTS);
    let path = results.join("manifest.json");
    let manifest = manifest(options, &fingerprint, done)?;
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

fn say(what: &str, seconds: f64) {
    println!("{what:>10}  {seconds:6.1} s");
}

/// Takes a step and leaves the mark of its completion; returns its duration in seconds.
fn take(step: &Step, program: &PathBuf, fingerprint: &str) -> Result<f64, String> {
    let start = Instant::now();
    succeed(Command::new(program).args(&step.arguments).current_dir(root()).stdout(Stdio::null()))?;
    let seconds = start.elapsed().as_secs_f64();
    step.mark(fingerprint, seconds)?;
    Ok(seconds)
}

/// The picture of the README is Fig. 4 of the full run with the usual seed.
fn keep_picture(options: &Options) -> Outcome {
    if options.quick || options.seed != 1 {
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

/// What was run, on what, by what.
fn manifest(options: &Options, fingerprint: &str, steps: Vec<Value>) -> Result<Value, String> {
    Ok(json!({
        "revision": first_line("git", &["describe", "--always", "--dirty", "--abbrev=40"]),
        "toolchain": first_line("rustc", &["--version"]),
        "seed": options.seed,
        "quick": options.quick,
        "steps": steps,
        "fingerprint_sha256": fingerprint,
        "inputs_sha256": hashes::folder(&root(), &root().join("fixtures"))?,
        "numbers_sha256": hashes::folder(&root(), &root().join(RESULTS).join("numbers"))?,
    }))
}

/// The first line that a program prints, if it is installed and succeeds.
fn first_line(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).current_dir(root()).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.lines().next().map(String::from))?
}
