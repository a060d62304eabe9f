//! `rijke completions`: completion of commands and options in a shell.

use crate::ui::Ui;
use rijke_numerics::Failed;

/// Print a script that makes a shell complete commands and options.
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  rijke completions bash > ~/.local/share/bash-completion/completions/rijke"
)]
pub(crate) struct Args {
    /// The shell.
    shell: clap_complete::Shell,
}

pub(crate) fn run(args: &Args, mut program: clap::Command, ui: &Ui) -> Result<(), Failed> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut program, "rijke", &mut script);
    ui.say(String::from_utf8_lossy(&script).trim_end());
    Ok(())
}
