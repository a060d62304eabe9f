//! What became of every case: a file that grows with them, from which an interrupted task goes on, and the
//! table at the end.

use super::limits::{End, Run};
use std::{
    collections::BTreeMap,
    fs::{self, File, OpenOptions},
    io::Write as _,
    path::Path,
};

/// One line of the file.
#[derive(Clone, Copy)]
struct Entry {
    end: End,
    seconds: f64,
    mib: u64,
}

/// The cases that were run.
pub(super) struct Journal {
    file: File,
    /// By kind and number.
    entries: BTreeMap<(String, u64), Entry>,
}

impl Journal {
    /// Opens `cases.tsv` of a folder. One that other seeds or another program made is begun anew.
    pub(super) fn open(folder: &Path, head: &str) -> Result<Self, String> {
        let path = folder.join("cases.tsv");
        let cannot = |e| format!("{}: {e}", path.display());
        fs::create_dir_all(folder).map_err(cannot)?;
        let old = fs::read_to_string(&path).unwrap_or_default();
        let first = format!("# {head}\n");
        if !old.starts_with(&first) {
            for old in ["failures", "others"] {
                let _ = fs::remove_dir_all(folder.join(old));
            }
            fs::write(
                &path,
                first + "# kind, case, status, s, MiB, seed, command, changes, first words of the error\n",
            )
            .map_err(cannot)?;
        }
        let file = OpenOptions::new().append(true).open(&path).map_err(cannot)?;
        let known =
            old.lines().filter(|_| old.starts_with(&format!("# {head}\n"))).filter_map(entry).collect();
        Ok(Self { file, entries: known })
    }

    pub(super) fn has(&self, kind: &str, number: u64) -> bool {
        self.entries.contains_key(&(kind.to_owned(), number))
    }

    pub(super) fn count(&self) -> usize {
        self.entries.len()
    }

    pub(super) fn failed(&self) -> usize {
        self.entries.values().filter(|e| e.end.failed()).count()
    }

    /// Writes what a case did; `rest` is seed, command and changes.
    pub(super) fn add(&mut self, kind: &str, number: u64, run: &Run, rest: [&str; 3]) -> Result<(), String> {
        let Run { end, seconds, mib, error } = run;
        let plain = |text: &str| {
            text.chars().take(900).map(|c| if c.is_control() { ' ' } else { c }).collect::<String>()
        };
        let (error, rest) = (plain(&error.replace('\n', " | ")), rest.map(plain).join("\t"));
        let line = format!("{kind}\t{number}\t{}\t{seconds:.2}\t{mib}\t{rest}\t{error}\n", end.word());
        self.file.write_all(line.as_bytes()).map_err(|e| e.to_string())?;
        self.entries.insert((kind.to_owned(), number), Entry { end: *end, seconds: *seconds, mib: *mib });
        Ok(())
    }

    /// The table in Markdown: kinds, and all together.
    pub(super) fn table(&self) -> String {
        let mut text = String::from(
            "| kind of input | cases | status 0 | status 2 | other status | over time | over memory | longest, s | largest, MiB |\n\
             |---|---|---|---|---|---|---|---|---|\n",
        );
        let mut kinds: Vec<&str> = self.entries.keys().map(|(kind, _)| kind.as_str()).collect();
        kinds.dedup();
        for (name, only) in kinds.iter().map(|k| (*k, Some(*k))).chain([("all", None)]) {
            let mine: Vec<&Entry> = self
                .entries
                .iter()
                .filter(|((k, _), _)| only.is_none_or(|o| o == k))
                .map(|(_, e)| e)
                .collect();
            let counts = End::ALL.map(|end| mine.iter().filter(|e| e.end == end).count().to_string());
            let seconds = mine.iter().map(|e| e.seconds).fold(0.0, f64::max);
            let mib = mine.iter().map(|e| e.mib).max().unwrap_or(0);
            text += &format!("| {name} | {} | {} | {seconds:.1} | {mib} |\n", mine.len(), counts.join(" | "));
        }
        text
    }
}

/// What a line says.
fn entry(line: &str) -> Option<((String, u64), Entry)> {
    let mut cells = line.split('\t');
    let (kind, number, word) = (cells.next()?, cells.next()?.parse().ok()?, cells.next()?);
    let end = End::ALL.into_iter().find(|end| end.word() == word)?;
    let (seconds, mib) = (cells.next()?.parse().ok()?, cells.next()?.parse().ok()?);
    Some(((kind.to_owned(), number), Entry { end, seconds, mib }))
}
