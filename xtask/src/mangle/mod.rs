//! `cargo xtask mangle`: gives every reader of the program thousands of changed inputs. Each must end with
//! status 0 or 2, within 10 s and 1 GiB. docs/records/mangle.md has what was found.

mod binary;
mod case;
mod changed;
mod folder;
mod journal;
mod limits;
mod lines;
mod seeds;
mod stream;
mod text;

use crate::workspace::{Outcome, at, built, root};
use journal::Journal;
use limits::LIMITS;
use seeds::Seed;
use sha2::{Digest, Sha256};
use std::{
    fs,
    path::{Path, PathBuf},
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
    thread,
};

/// How many cases, and which.
#[derive(clap::Args)]
pub(crate) struct Options {
    /// Number of cases, shared out evenly among the kinds of input.
    #[arg(long, value_name = "N", default_value_t = 2000)]
    count: u64,
    /// Seed of all changes: the same seed gives the same cases.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Only this kind of input, such as network; an unknown one lists all.
    #[arg(long, value_name = "KIND")]
    only: Option<String>,
    /// Number of the first case of each kind.
    #[arg(long, value_name = "K", default_value_t = 0)]
    from: u64,
    /// Folder for the list of all cases and for the failures, each with its input. What the list has is not
    /// run again.
    #[arg(long, value_name = "DIR", default_value = "target/mangle")]
    keep: PathBuf,
    /// Keep the input and the output of every case that is run, not of failures alone.
    #[arg(long)]
    every: bool,
    /// The program [default: the workspace's, built first].
    #[arg(long, value_name = "FILE")]
    program: Option<PathBuf>,
}

/// What all cases share.
struct Task<'a> {
    options: &'a Options,
    program: PathBuf,
    keep: PathBuf,
    place: PathBuf,
    kinds: Vec<Vec<&'a Seed>>,
}

/// Makes the seeds, runs the cases on all cores, and prints the table.
pub(crate) fn run(options: &Options) -> Outcome {
    let program = match &options.program {
        Some(file) => fs::canonicalize(file).map_err(at(file))?,
        None => built()?,
    };
    let place = std::env::temp_dir().join(format!("rijke-mangle-{}", std::process::id()));
    let outcome = all(options, program, &place);
    let _ = fs::remove_dir_all(&place);
    outcome
}

fn all(options: &Options, program: PathBuf, place: &Path) -> Outcome {
    let made = seeds::make(&program, &place.join("seeds"), options.only.as_deref())?;
    let mut names: Vec<&str> = made.iter().map(|s| s.kind).collect();
    names.dedup();
    let kinds: Vec<Vec<&Seed>> =
        names.iter().map(|k| made.iter().filter(|s| s.kind == *k).collect()).collect();
    println!("{} seeds of {} kinds: {}", made.len(), kinds.len(), names.join(", "));
    let bytes = fs::read(&program).map_err(at(&program))?;
    let hash: String = Sha256::digest(bytes).iter().take(4).map(|b| format!("{b:02x}")).collect();
    let keep = root().join(&options.keep);
    let journal = Journal::open(&keep, &format!("seed {}, program {hash}", options.seed))?;
    let journal = Mutex::new(journal);
    let task = Task { options, program, keep, place: place.to_owned(), kinds };
    let next = AtomicU64::new(0);
    thread::scope(|scope| {
        let cores = thread::available_parallelism().map_or(1, usize::from);
        let workers: Vec<_> = (0..cores).map(|k| (k, &task, &next, &journal)).collect();
        let workers: Vec<_> = workers
            .into_iter()
            .map(|(k, task, next, journal)| scope.spawn(move || task.work(k, next, journal)))
            .collect();
        workers.into_iter().try_for_each(|w| w.join().unwrap_or_else(|_| Err("a worker panicked".into())))
    })?;
    let journal = journal.into_inner().unwrap_or_else(PoisonError::into_inner);
    println!("{}", journal.table());
    match journal.failed() {
        0 => Ok(()),
        n => Err(format!(
            "{n} cases ended with neither status 0 nor 2, or over a limit\n  remedy: {}/failures has the input of each, and the command that repeats it.",
            task.keep.display()
        )),
    }
}

impl Task<'_> {
    /// Takes case after case, as the other workers do.
    fn work(&self, worker: usize, next: &AtomicU64, journal: &Mutex<Journal>) -> Outcome {
        let journal = || journal.lock().unwrap_or_else(PoisonError::into_inner);
        let folder = self.place.join(format!("worker-{worker}"));
        loop {
            let k = next.fetch_add(1, Ordering::Relaxed);
            if k >= self.options.count {
                return Ok(());
            }
            let (index, number) =
                (k % self.kinds.len() as u64, self.options.from + k / self.kinds.len() as u64);
            let Some(seeds) = self.kinds.get(index as usize) else { return Ok(()) };
            let kind = seeds.first().map_or("", |s| s.kind);
            if journal().has(kind, number) {
                continue;
            }
            let case = case::make(seeds, self.options.seed, number, &folder)?;
            let run = limits::run(&self.program, &case.words, &folder, &LIMITS)?;
            if run.end.failed() || self.options.every {
                let said = fs::read(folder.with_extension("out")).unwrap_or_default();
                self.keep(seeds, number, &run, &said)?;
            }
            if run.end.failed() {
                println!(
                    "{kind} {number}: {}, {:.1} s, {} MiB: {}",
                    run.end.word(),
                    run.seconds,
                    run.mib,
                    case.told
                );
            }
            let mut journal = journal();
            journal.add(kind, number, &run, [&case.seed.name, &case.words.join(" "), &case.told])?;
            if journal.count() % 500 == 0 {
                println!(
                    "{} of {} cases, {} failures",
                    journal.count(),
                    self.options.count,
                    journal.failed()
                );
            }
        }
    }

    /// Makes a case once more, in the folder of failures, with what happened beside it.
    fn keep(&self, seeds: &[&Seed], number: u64, run: &limits::Run, said: &[u8]) -> Outcome {
        let kind = seeds.first().map_or("", |s| s.kind);
        let folder = self
            .keep
            .join(if run.end.failed() { "failures" } else { "others" })
            .join(format!("{kind}-{number}"));
        let case = case::make(seeds, self.options.seed, number, &folder.join("input"))?;
        let text = format!(
            "changed: {}\nin input/: rijke {}\nrepeat: cargo xtask mangle --seed {} --only {kind} --from {number} --count 1\n\
             ended: {}, {:.1} s, {} MiB\n\n{}",
            case.told,
            case.words.join(" "),
            self.options.seed,
            run.end.word(),
            run.seconds,
            run.mib,
            run.error
        );
        let cannot = |e| format!("{}: {e}", folder.display());
        fs::write(folder.join("case.txt"), text).map_err(cannot)?;
        fs::write(folder.join("output.txt"), said).map_err(cannot)
    }
}
