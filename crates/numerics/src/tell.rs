//! How a long step says what it does, to whoever listens.

use crate::StagedFolder;

/// Hears what a step says while it works. A library prints nothing: a program, a page or a notebook
/// implements this; `()` hears nothing.
pub trait Tell: Sync {
    /// A line of the result.
    fn say(&self, _line: String) {}

    /// A table of the result: a heading for each column, and rows.
    fn table(&self, _head: Vec<String>, _rows: Vec<Vec<String>>) {}

    /// A remark on the result: a warning, or where something was written.
    fn note(&self, _line: String) {}

    /// Work of `total` steps called `what` begins. The function that is returned is called with the number of
    /// steps that are done, from any thread; the work has ended when it is dropped.
    fn progress(&self, _what: &'static str, _total: u64) -> Box<dyn Fn(u64) + Sync + '_> {
        Box::new(|_| {})
    }

    /// Remarks that a run which was killed before had left something unfinished beside a folder.
    fn after_killed_run(&self, folder: &StagedFolder) {
        if let Some(target) = folder.after_killed_run() {
            let shown = target.display();
            self.note(format!("{shown}: what a run before this one left unfinished beside it is removed"));
        }
    }

    /// Warns of each of these.
    fn warn(&self, doubts: &[String]) {
        doubts.iter().for_each(|said| self.note(format!("warning: {said}")));
    }
}

impl Tell for () {}
