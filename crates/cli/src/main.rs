//! The program `rijke`: each step from records to report, alone or in order, on a folder of records.
//!
//! A subcommand is one file with an `Args` (its options, help and example) and a `run`. To add one: a `mod` line
//! and a line in [`Command`], and a line in the `match` of [`main`].

use clap::{Parser, Subcommand};
use std::process::ExitCode;

mod check;
mod check_model;
mod completions;
mod failure;
mod flow;
mod lab;
mod modes;
mod process;
mod rank;
mod report;
mod staging;
mod ui;

/// From microphone records of a thermoacoustic rig to a physics-based model with known uncertainty, chosen by evidence.
#[derive(Parser)]
#[command(name = "rijke", version, arg_required_else_help = true, max_term_width = 100)]
#[command(after_help = "Exit status: 0 done, 1 the computation failed, 2 the input is wrong.")]
struct Program {
    #[command(flatten)]
    output: ui::Output,
    #[command(subcommand)]
    command: Command,
}

/// The steps, in the order in which data pass through them.
#[derive(Subcommand)]
enum Command {
    Lab(lab::Args),
    Check(check::Args),
    Process(process::Args),
    Flow(flow::Args),
    Rank(rank::Args),
    CheckModel(check_model::Args),
    Modes(modes::Args),
    Report(report::Args),
    Completions(completions::Args),
}

fn main() -> ExitCode {
    let program = Program::parse();
    let ui = ui::Ui::new(&program.output);
    let outcome: Result<(), failure::Failure> = match &program.command {
        Command::Lab(args) => lab::run(args, &ui),
        Command::Check(args) => check::run(args, &ui),
        Command::Process(args) => process::run(args, &ui),
        Command::Flow(args) => flow::run(args, &ui),
        Command::Rank(args) => rank::run(args, &ui),
        Command::CheckModel(args) => check_model::run(args, &ui),
        Command::Modes(args) => modes::run(args, &ui),
        Command::Report(args) => report::run(args, &ui),
        Command::Completions(args) => completions::run(args, &ui),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => ui.fail(&failure),
    }
}
