//! Tasks of the workspace, run as `cargo xtask TASK`. Knows no crate of the project: it starts programs and
//! reads files.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program for the terminal")]

mod child;
mod mangle;
mod mutants;
mod package;
mod page;
mod python;
mod recovery;
mod reference;
mod reproduce;
mod scale;
mod tidy;
mod watch;
mod workspace;

use clap::{Parser, Subcommand};
use std::process::ExitCode;
use workspace::{Outcome, cargo, root, succeed};

/// Tasks of the workspace.
#[derive(Parser)]
#[command(name = "cargo xtask", arg_required_else_help = true)]
struct Program {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Regenerate the tables and figures of the paper from raw records of the virtual laboratory, into
    /// results/.
    Reproduce(reproduce::Options),
    /// Open the page of results in headless Chromium, wide, narrow and on paper, and that of a watch while a
    /// record arrives; fail if anything is wrong with them.
    Page,
    /// Write docs/reference/commands.md from the help of the program.
    Reference,
    /// Pack every public crate, and check that the packed crates compile against each other.
    Package,
    /// Install the Python package in a fresh environment under target/, run its tests and check its types.
    Python,
    /// Make each law of heat release of Table 4 the truth of the virtual laboratory in turn, and write which
    /// model wins into docs/records/recovery.md: some ten minutes.
    Recovery,
    /// Measure what `rijke flow`, `rank` and `process` cost against places, points, microphones, candidates
    /// and the length of a record, and write the table of docs/records/scale.md: some twenty minutes.
    Scale(scale::Options),
    /// Measure how fast `rijke watch` is with 175 points and with 7000 records, into target/watch.md: some
    /// fifteen minutes.
    Watch {
        /// Replay all 7000 records instead, from the first on: half an hour.
        #[arg(long)]
        all: bool,
    },
    /// Run the tests.
    Test {
        /// Include the long studies (tests marked as ignored), and a sample of what `mutants` changes: hours.
        #[arg(long)]
        all: bool,
    },
    /// Change physics and statistics one place at a time, and list the changes that no test notices: half a
    /// minute for each.
    Mutants(mutants::Options),
    /// Change the files that the program reads, at random, and list the cases that end with neither status 0
    /// nor 2, or take more than 10 s or 1 GiB: some twenty minutes for 20 000.
    Mangle(mangle::Options),
    /// Check what the compiler does not: arrows between crates, files nobody uses, sizes, names of tests,
    /// links.
    Tidy,
}

fn main() -> ExitCode {
    let task = Program::parse().task;
    if let (Task::Mutants(_), Some(remedy)) = (&task, mutants::lacking()) {
        eprintln!("error: {remedy}");
        return ExitCode::from(2);
    }
    let outcome = child::end_with_signals().and_then(|()| run(task));
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

fn run(task: Task) -> Outcome {
    match task {
        Task::Reproduce(options) => reproduce::run(&options),
        Task::Page => page::run(),
        Task::Reference => reference::run(),
        Task::Package => package::run(),
        Task::Python => python::run(),
        Task::Recovery => recovery::run(),
        Task::Scale(options) => scale::run(&options),
        Task::Watch { all } => watch::run(all),
        Task::Test { all } => test(all),
        Task::Mutants(options) => mutants::run(&options),
        Task::Mangle(options) => mangle::run(&options),
        Task::Tidy => tidy::run(&root()),
    }
}

fn test(all: bool) -> Outcome {
    let mut command = cargo();
    command.args(["test", "--release", "--workspace"]);
    if !all {
        return succeed(&mut command);
    }
    succeed(command.args(["--", "--include-ignored"]))?;
    match mutants::lacking() {
        None => mutants::sample(),
        Some(remedy) => {
            println!("What tests notice was not measured: {remedy}");
            Ok(())
        }
    }
}
