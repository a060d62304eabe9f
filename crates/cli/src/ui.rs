//! What the user sees while a command works. Results go to standard output, everything else to standard error.

use crate::failure::Failure;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::{
    io::{self, Write},
    process::ExitCode,
};

/// Options that every subcommand takes.
#[derive(clap::Args)]
pub(crate) struct Output {
    /// Print errors only.
    #[arg(long, short, global = true)]
    quiet: bool,
}

/// The way to the user. Progress bars appear on a terminal only, and never with `--quiet`.
pub(crate) struct Ui {
    quiet: bool,
}

impl Ui {
    pub(crate) fn new(output: &Output) -> Self {
        Self { quiet: output.quiet }
    }

    /// A line of result on standard output.
    pub(crate) fn say(&self, line: impl AsRef<str>) {
        if !self.quiet {
            // A closed pipe (`rijke rank | head`) is no failure of ours.
            let _ = writeln!(io::stdout(), "{}", line.as_ref());
        }
    }

    /// A remark on standard error.
    pub(crate) fn note(&self, line: impl AsRef<str>) {
        if !self.quiet {
            let _ = writeln!(io::stderr(), "{}", line.as_ref());
        }
    }

    /// A bar for work of `total` steps that may take over two seconds. Can be advanced from several threads; vanishes
    /// when dropped.
    pub(crate) fn progress(&self, what: &'static str, total: u64) -> Progress {
        let target = if self.quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(total), target).with_message(what);
        if let Ok(style) = ProgressStyle::with_template("{msg:>12} [{bar:40}] {pos}/{len}, {eta} left") {
            bar.set_style(style.progress_chars("=> "));
        }
        Progress(bar)
    }

    /// Prints a failure and gives its exit status.
    pub(crate) fn fail(&self, failure: &Failure) -> ExitCode {
        let _ = writeln!(io::stderr(), "{failure}");
        failure.exit_code()
    }
}

/// A progress bar; see [`Ui::progress`].
#[derive(Clone)]
pub(crate) struct Progress(ProgressBar);

impl Progress {
    /// `steps` more are done.
    pub(crate) fn advance(&self, steps: u64) {
        self.0.inc(steps);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
