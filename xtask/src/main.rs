//! Tasks of the workspace, run as `cargo xtask TASK`. Knows no crate of the project: it starts programs and reads files.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program for the terminal")]

mod package;
mod page;
mod reference;
mod reproduce;
mod tidy;

use clap::{Parser, Subcommand};
use std::{
    path::PathBuf,
    process::{Command, ExitCode},
};

/// Tasks of the workspace.
#[derive(Parser)]
#[command(name = "cargo xtask", arg_required_else_help = true)]
struct Program {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Regenerate the tables and figures of the paper from raw records of the virtual laboratory, into results/.
    Reproduce(reproduce::Options),
    /// Open the page of results in headless Chromium, wide, narrow and on paper, and fail if anything is wrong with it.
    Page,
    /// Write docs/reference/commands.md from the help of the program.
    Reference,
    /// Pack every public crate, and check that the packed crates compile against each other, tests included.
    Package,
    /// Run the tests.
    Test {
        /// Include the long studies (tests marked as ignored).
        #[arg(long)]
        all: bool,
    },
    /// Check what the compiler does not: arrows between crates, files nobody uses, sizes, names of tests, links.
    Tidy,
}

fn main() -> ExitCode {
    let outcome = match Program::parse().task {
        Task::Reproduce(options) => reproduce::run(&options),
        Task::Page => page::run(),
        Task::Reference => reference::run(),
        Task::Package => package::run(),
        Task::Test { all } => test(all),
        Task::Tidy => tidy::run(&root()),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

/// What went wrong, for the terminal.
type Outcome = Result<(), String>;

/// The folder of the workspace.
fn root() -> PathBuf {
    let here = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    here.parent().map(PathBuf::from).unwrap_or(here)
}

fn test(all: bool) -> Outcome {
    let mut command = cargo();
    command.args(["test", "--release", "--workspace"]);
    if all {
        command.args(["--", "--include-ignored"]);
    }
    succeed(&mut command)
}

/// The cargo that runs this task.
fn cargo() -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root());
    command
}

/// Runs a program to its end.
fn succeed(command: &mut Command) -> Outcome {
    let shown = || {
        let words = std::iter::once(command.get_program()).chain(command.get_args());
        words.map(|w| w.to_string_lossy().into_owned()).collect::<Vec<_>>().join(" ")
    };
    let shown = shown();
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("`{shown}` ended with {status}")),
        Err(error) => Err(format!("cannot start `{shown}`: {error}")),
    }
}
