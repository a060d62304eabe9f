//! `rijke man`: the manual pages, and the page of the book that holds the help of every command.

use crate::ui::Ui;
use rijke_numerics::{Classify, Failed, Lock};
use std::fmt::Write as _;
use std::path::PathBuf;

/// Write the manual pages, one for the program and one for each command.
#[derive(clap::Args)]
#[command(
    override_usage = "rijke man --out <DIR>\n       rijke man --markdown",
    after_help = "Example:\n  rijke man --out ~/.local/share/man/man1\n  man rijke"
)]
pub(crate) struct Args {
    /// Folder to write the pages to; made if necessary.
    #[arg(long, value_name = "DIR", required_unless_present = "markdown")]
    out: Option<PathBuf>,
    /// Print the help of all commands as one page of Markdown instead.
    #[arg(long, conflicts_with = "out")]
    markdown: bool,
}

pub(crate) fn run(args: &Args, program: clap::Command, ui: &Ui) -> Result<(), Failed> {
    let Some(out) = &args.out else {
        ui.document(markdown(program).trim_end());
        return Ok(());
    };
    // The folder may hold the pages of other programs: each page is moved there when it is complete.
    let partial = out.join("rijke.partial");
    std::fs::create_dir_all(&partial)
        .or_bad_input()
        .map_err(|f| f.at(out).remedy("Give a place in which you may write."))?;
    let _lock = Lock::take(out)?;
    let moved = clap_mangen::generate_to(program, &partial).and_then(|()| {
        for page in std::fs::read_dir(&partial)? {
            let page = page?;
            std::fs::rename(page.path(), out.join(page.file_name()))?;
        }
        std::fs::remove_dir(&partial)
    });
    moved.or_failed().map_err(|f| f.at(out))?;
    ui.note(format!("{}: rijke.1 and a page for each command", out.display()));
    Ok(())
}

/// Every command with its help, as `--help` prints it.
fn markdown(program: clap::Command) -> String {
    let mut program = program.term_width(100);
    program.build();
    let mut page =
        "# Commands\n\nWritten by `cargo xtask reference`; a test compares it with the program.\n".to_owned();
    let help = |command: &mut clap::Command| {
        let text = command.render_long_help().to_string();
        text.lines().map(|line| format!("{}\n", line.trim_end())).collect::<String>()
    };
    let _ = write!(page, "\n```text\n{}```\n", help(&mut program));
    for command in program.get_subcommands_mut().filter(|c| c.get_name() != "help") {
        let name = command.get_name().to_owned();
        let _ = write!(page, "\n## rijke {name}\n\n```text\n{}```\n", help(command));
    }
    page
}
