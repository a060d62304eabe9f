//! `cargo xtask mutants`: changes physics and statistics one place at a time (`.cargo/mutants.toml` says
//! where), and lists the changes that no test of the crate notices. cargo-mutants does it;
//! docs/records/mutants.md has what was found.

use crate::workspace::{Outcome, cargo, succeed};
use std::process::Stdio;

/// What to change.
#[derive(clap::Args)]
pub(crate) struct Options {
    /// The crate, by its folder below crates/, such as network [default: all].
    #[arg(value_name = "CRATE")]
    name: Option<String>,
    /// Only every N-th change, from the K-th on: a sample of all.
    #[arg(long, value_name = "K/N")]
    shard: Option<String>,
    /// Only changes of files that this pattern names, such as 'crates/network/src/laws/**'; may be repeated.
    #[arg(long, value_name = "GLOB")]
    file: Vec<String>,
}

/// Crates of physics and statistics whose own tests are to notice a change, and the share of their changes
/// that `cargo xtask test --all` makes: some hundred, spread over all.
const SAMPLED: [&str; 6] = ["numerics", "formula", "network", "inference", "flow", "signal"];
const SAMPLE: &str = "7/215";

/// The sample of changes that belongs to all tests: an hour and more.
pub(crate) fn sample() -> Outcome {
    let file = SAMPLED.iter().map(|name| format!("crates/{name}/**")).collect();
    run(&Options { name: None, shard: Some(SAMPLE.into()), file })
}

/// What to do where cargo-mutants is missing; nothing where it is there.
pub(crate) fn lacking() -> Option<&'static str> {
    let asked = cargo().args(["mutants", "--version"]).stdout(Stdio::null()).stderr(Stdio::null()).status();
    let found = asked.is_ok_and(|status| status.success());
    (!found).then_some(
        "cargo-mutants is not installed\n  remedy: Run `cargo install --locked cargo-mutants`, then this task again.",
    )
}

/// Runs the tests of a crate once for each change, on one core.
pub(crate) fn run(options: &Options) -> Outcome {
    let mut command = cargo();
    command.args(["mutants", "--jobs", "1", "--sharding", "round-robin", "--output", "target"]);
    match &options.name {
        Some(name) => command.args(["--package", &format!("rijke-{name}")]),
        None => command.arg("--workspace"),
    };
    if let Some(shard) = &options.shard {
        command.args(["--shard", shard]);
    }
    for glob in &options.file {
        command.args(["--file", glob]);
    }
    command.args(["--", "--lib", "--tests"]).env("CARGO_INCREMENTAL", "1");
    succeed(&mut command).map_err(|message| {
        format!("{message}\n  remedy: Write a test with a truth of its own for every change in target/mutants.out/missed.txt.")
    })
}
