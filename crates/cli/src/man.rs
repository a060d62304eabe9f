//! `rijke man`: the manual page.

use crate::{
    Program,
    failure::{Classify, Failure},
    ui::Ui,
};
use clap::CommandFactory;
use std::path::PathBuf;

/// Write the manual pages, one for the program and one for each command.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  rijke man --out ~/.local/share/man/man1\n  man rijke")]
pub(crate) struct Args {
    /// Folder to write the pages to; made if necessary.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failure> {
    std::fs::create_dir_all(&args.out)
        .or_bad_input()
        .map_err(|f| f.at(&args.out).remedy("Give a place in which you may write."))?;
    clap_mangen::generate_to(Program::command(), &args.out).or_failed().map_err(|f| f.at(&args.out))?;
    ui.note(format!("{}: rijke.1 and a page for each command", args.out.display()));
    Ok(())
}
