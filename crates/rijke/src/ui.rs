//! What the user sees while a command works. Results go to standard output, everything else to standard
//! error.

use comfy_table::{CellAlignment, LineStyle, Table, TableStyle};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rijke_numerics::{Blame, Classify, Failed, Tell};
use serde::Serialize;
use serde_json::json;
use std::{
    io::{self, IsTerminal, Write},
    process::ExitCode,
    sync::{
        Mutex,
        mpsc::{RecvTimeoutError, Sender, channel},
    },
    thread::{JoinHandle, spawn},
    time::Duration,
};

/// How often a progress bar is drawn again.
const TICK: Duration = Duration::from_secs(1);

/// Options that every subcommand takes.
#[derive(clap::Args)]
pub(crate) struct Output {
    /// Print errors only.
    #[arg(long, short, global = true, help_heading = "Global options")]
    quiet: bool,
    /// Print the result as one JSON document instead of text; errors too, on standard error.
    #[arg(long, global = true, help_heading = "Global options")]
    json: bool,
}

/// The way to the user. Progress bars appear on a terminal, else lines now and then; neither with
/// `--quiet`.
pub(crate) struct Ui {
    quiet: bool,
    json: bool,
    /// What was said on standard error, which a JSON document repeats.
    notes: Mutex<Vec<String>>,
}

impl Ui {
    pub(crate) fn new(output: &Output) -> Self {
        Self { quiet: output.quiet, json: output.json, notes: Mutex::default() }
    }

    /// Prints nothing but errors.
    pub(crate) fn silent() -> Self {
        Self { quiet: true, json: false, notes: Mutex::default() }
    }

    /// For one step of a larger command. With `--json` the step prints nothing, because the command prints
    /// one result for all steps.
    pub(crate) fn of_a_step(&self) -> Self {
        Self { quiet: self.quiet || self.json, json: false, notes: Mutex::default() }
    }

    /// Whether the result is wanted as JSON.
    pub(crate) fn is_json(&self) -> bool {
        self.json
    }

    /// The result of a command, which is printed with `--json` only; without it the command says the same in
    /// words. Its `notes` are what the command said on standard error until now, if it said anything.
    pub(crate) fn result(&self, result: &impl Serialize) -> Result<(), Failed> {
        if !self.json {
            return Ok(());
        }
        let mut document = serde_json::to_value(result).or_failed()?;
        let notes = self.notes.lock().map(|notes| notes.clone()).unwrap_or_default();
        if let Some(fields) = document.as_object_mut().filter(|_| !notes.is_empty()) {
            fields.entry("notes").or_insert_with(|| notes.into());
        }
        self.json(&document)
    }

    /// A result as JSON on standard output, as it is.
    pub(crate) fn json(&self, result: &impl Serialize) -> Result<(), Failed> {
        self.document(serde_json::to_string_pretty(result).or_failed()?);
        Ok(())
    }

    /// A result in a form of its own on standard output, with or without `--json`.
    pub(crate) fn document(&self, text: impl AsRef<str>) {
        if !self.quiet {
            // A closed pipe (`rijke rank | head`) is no failure of ours.
            let _ = writeln!(io::stdout(), "{}", text.as_ref());
        }
    }

    /// A line of result on standard output.
    pub(crate) fn say(&self, line: impl AsRef<str>) {
        if !self.json {
            self.document(line);
        }
    }

    /// A table of results on standard output, a heading for each column. Columns of numbers stand to the
    /// right.
    pub(crate) fn table<H, R>(&self, head: H, rows: R)
    where
        H: IntoIterator<Item: Into<String>>,
        R: IntoIterator<Item: IntoIterator<Item = String>>,
    {
        let rows: Vec<Vec<String>> = rows.into_iter().map(|row| row.into_iter().collect()).collect();
        let mut table = Table::new();
        table.load_style(TableStyle::new().header_separator(LineStyle::none().fill('─').junction('─')));
        table.set_header(head.into_iter().map(Into::<String>::into)).add_rows(&rows);
        let number = |cell: &String| cell.is_empty() || cell.parse::<f64>().is_ok();
        for (k, column) in table.column_iter_mut().enumerate() {
            if rows.iter().filter_map(|row| row.get(k)).all(number) {
                column.set_cell_alignment(CellAlignment::Right);
            }
        }
        self.say(table.trim_fmt());
    }

    /// A remark on standard error.
    pub(crate) fn note(&self, line: impl AsRef<str>) {
        if let Ok(mut notes) = self.notes.lock() {
            notes.push(line.as_ref().to_owned());
        }
        if !self.quiet {
            let _ = writeln!(io::stderr(), "{}", line.as_ref());
        }
    }

    /// Prints a failure and gives its exit status.
    pub(crate) fn fail(&self, failure: &Failed) -> ExitCode {
        let status: u8 = if failure.kind == Blame::Input { 2 } else { 1 };
        let text = if self.json {
            let Failed { message, causes, remedy, .. } = failure;
            json!({ "error": message, "because": causes, "remedy": remedy, "exit_status": status })
                .to_string()
        } else {
            failure.to_string()
        };
        let _ = writeln!(io::stderr(), "{text}");
        ExitCode::from(status)
    }
}

impl Tell for Ui {
    fn say(&self, line: String) {
        Self::say(self, line);
    }

    fn table(&self, head: Vec<String>, rows: Vec<Vec<String>>) {
        Self::table(self, head, rows);
    }

    fn note(&self, line: String) {
        Self::note(self, line);
    }

    /// A bar for work that may take over two seconds.
    fn progress(&self, what: &'static str, total: u64) -> Box<dyn Fn(u64) + Sync + '_> {
        let target =
            if self.quiet || self.json { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(total), target).with_message(what);
        if let Ok(style) =
            ProgressStyle::with_template("{msg:>12} [{bar:40}] {pos}/{len}, {elapsed} so far, {eta} left")
        {
            bar.set_style(style.progress_chars("=> "));
        }
        // A step may last for minutes: the time goes on meanwhile.
        bar.enable_steady_tick(TICK);
        let told = !self.quiet && !self.json && !io::stderr().is_terminal();
        let lines = told.then(|| Lines::of(bar.clone(), what));
        let bar = Progress { bar, _lines: lines };
        Box::new(move |steps| bar.advance(steps))
    }
}

/// A progress bar, which vanishes when it is dropped.
struct Progress {
    bar: ProgressBar,
    _lines: Option<Lines>,
}

impl Progress {
    /// `steps` more are done.
    fn advance(&self, steps: u64) {
        self.bar.inc(steps);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Time from line to line where a bar cannot be drawn.
const LINES: Duration = Duration::from_secs(30);

/// How far the work is, now and then in a line, where errors go into a file. Ends when it is dropped.
struct Lines(Option<Sender<()>>, Option<JoinHandle<()>>);

impl Lines {
    fn of(bar: ProgressBar, what: &'static str) -> Self {
        let (end, ended) = channel();
        let told = move || {
            while let Err(RecvTimeoutError::Timeout) = ended.recv_timeout(LINES) {
                let (done, all) = (bar.position(), bar.length().unwrap_or(0));
                // Nobody may be left to read it.
                let _ =
                    writeln!(io::stderr(), "{what}: {done} of {all}, {} s so far", bar.elapsed().as_secs());
            }
        };
        Self(Some(end), Some(spawn(told)))
    }
}

impl Drop for Lines {
    fn drop(&mut self) {
        drop(self.0.take());
        // What it has printed is printed.
        let _ = self.1.take().map(JoinHandle::join);
    }
}
