//! The program `rijke`: each step from records to report, alone or in order, on a folder of records.
//!
//! A subcommand is one file with an `Args` (its options, help and example) and a `run`. To add one: a `mod` line
//! and a line in [`Command`] and in its `run`.

use clap::{Parser, Subcommand};
use std::process::ExitCode;

mod candidate;
mod check;
mod check_model;
mod completions;
mod failure;
mod flow;
mod infer;
mod inspect;
mod lab;
mod man;
mod modes;
mod new;
mod predict;
mod process;
mod rank;
mod report;
mod run;
mod sensitivity;
mod staging;
mod study;
mod ui;

/// From microphone records of a thermoacoustic rig to a physics-based model with known uncertainty, chosen by evidence.
#[derive(Parser)]
#[command(name = "rijke", version, arg_required_else_help = true, max_term_width = 100)]
#[command(
    after_help = "Exit status: 0 done, 1 the computation failed, 2 the input is wrong; 130 ended by Ctrl-C, with nothing half written."
)]
struct Program {
    #[command(flatten)]
    output: ui::Output,
    #[command(subcommand)]
    command: Command,
}

/// The steps, in the order in which data pass through them.
#[derive(Subcommand)]
enum Command {
    New(new::Args),
    Lab(lab::Args),
    Inspect(inspect::Args),
    Check(check::Args),
    Run(run::Args),
    Process(process::Args),
    Flow(flow::Args),
    Candidate(candidate::Args),
    Rank(rank::Args),
    CheckModel(check_model::Args),
    Modes(modes::Args),
    Infer(infer::Args),
    Report(report::Args),
    Predict(predict::Args),
    Sensitivity(sensitivity::Args),
    Completions(completions::Args),
    Man(man::Args),
}

impl Command {
    fn run(&self, ui: &ui::Ui) -> Result<(), failure::Failure> {
        match self {
            Self::New(args) => new::run(args, ui),
            Self::Lab(args) => lab::run(args, ui),
            Self::Inspect(args) => inspect::run(args, ui),
            Self::Check(args) => check::run(args, ui),
            Self::Run(args) => run::run(args, ui),
            Self::Process(args) => process::run(args, ui),
            Self::Flow(args) => flow::run(args, ui),
            Self::Candidate(args) => candidate::run(args, ui),
            Self::Rank(args) => rank::run(args, ui),
            Self::CheckModel(args) => check_model::run(args, ui),
            Self::Modes(args) => modes::run(args, ui),
            Self::Infer(args) => infer::run(args, ui),
            Self::Report(args) => report::run(args, ui),
            Self::Predict(args) => predict::run(args, ui),
            Self::Sensitivity(args) => sensitivity::run(args, ui),
            Self::Completions(args) => completions::run(args, ui),
            Self::Man(args) => man::run(args, ui),
        }
    }
}

fn main() -> ExitCode {
    let program = Program::parse();
    let ui = ui::Ui::new(&program.output);
    match program.command.run(&ui) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => ui.fail(&failure),
    }
}
