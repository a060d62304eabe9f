//! The program `rijke`: each step from records to report, alone or in order, on a folder of records.
//!
//! A subcommand is one file with an `Args` (its options, help and example) and a `run`. To add one: a `mod`
//! line and a line in [`Command`] and in its `run`.

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use std::{io, process::ExitCode, thread};

mod check;
mod completions;
mod figure;
mod flow;
mod infer;
mod inspect;
mod lab;
mod man;
mod modes;
mod new;
mod next;
mod number;
mod predict;
mod process;
mod rank;
mod report;
mod response;
mod run;
mod search;
mod trust;
mod ui;
mod watch;

/// Fit physics-based models to microphone records of a thermoacoustic rig, and rank them by Bayesian
/// evidence.
#[derive(Parser)]
#[command(name = "rijke", version, arg_required_else_help = true, max_term_width = 100)]
#[command(
    after_help = "Exit status: 0 done, 1 the computation failed, 2 the input is wrong; 130 ended by Ctrl-C, with nothing half written."
)]
struct Program {
    #[command(flatten)]
    output: ui::Output,
    /// End when standard input is closed: for a program that starts this one and may be killed.
    #[arg(long, hide = true)]
    until_stdin_closes: bool,
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
    Watch(watch::Args),
    Process(process::Args),
    Flow(flow::Args),
    Rank(rank::Args),
    Search(search::Args),
    Merge(search::MergeArgs),
    Modes(modes::Args),
    Response(response::Args),
    Infer(infer::Args),
    Report(report::Args),
    Predict(predict::Args),
    Next(next::Args),
    Completions(completions::Args),
    Man(man::Args),
}

impl Command {
    fn run(&self, ui: &ui::Ui) -> Result<(), rijke_numerics::Failed> {
        match self {
            Self::New(args) => new::run(args, ui),
            Self::Lab(args) => lab::run(args, ui),
            Self::Inspect(args) => inspect::run(args, ui),
            Self::Check(args) => check::run(args, ui),
            Self::Run(args) => run::run(args, ui),
            Self::Watch(args) => watch::run(args, ui),
            Self::Process(args) => process::run(args, ui),
            Self::Flow(args) => flow::run(args, ui),
            Self::Rank(args) => rank::run(args, ui),
            Self::Search(args) => search::run(args, ui),
            Self::Merge(args) => search::merge(args, ui),
            Self::Modes(args) => modes::run(args, ui),
            Self::Response(args) => response::run(args, ui),
            Self::Infer(args) => infer::run(args, ui),
            Self::Report(args) => report::run(args, ui),
            Self::Predict(args) => predict::run(args, ui),
            Self::Next(args) => next::run(args, ui),
            Self::Completions(args) => completions::run(args, Program::command(), ui),
            Self::Man(args) => man::run(args, Program::command(), ui),
        }
    }
}

/// The exit status of a program that was ended from outside.
const ENDED: i32 = 130;

/// Ends the program as soon as standard input is closed, as it is by the system when the program at the other
/// end ends in whatever way. What was being written is left unfinished beside its place, as by any signal.
fn end_with_stdin() {
    thread::spawn(|| {
        let _ = io::copy(&mut io::stdin().lock(), &mut io::sink());
        std::process::exit(ENDED);
    });
}

fn main() -> ExitCode {
    let matches = number::negative_is_no_option(Program::command()).get_matches();
    let program = match Program::from_arg_matches(&matches) {
        Ok(program) => program,
        Err(error) => error.exit(),
    };
    if program.until_stdin_closes {
        end_with_stdin();
    }
    let ui = ui::Ui::new(&program.output);
    match program.command.run(&ui) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => ui.fail(&failure),
    }
}
