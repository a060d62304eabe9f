//! The inputs that are changed: small studies, networks and records of every kind that the program reads,
//! made once for each run of the task.

mod bench;
mod flows;
mod models;
mod records;
mod results;
mod samples;

pub(super) use bench::Seed;

use super::{
    folder::copy,
    limits::{self, End, LIMITS},
};
use crate::workspace::Outcome;
use bench::Bench;
use std::{fs, path::Path};

/// What makes the seeds of a kind.
type Maker = fn(&mut Bench<'_>) -> Outcome;

/// The kinds of input, and what makes their seeds.
const KINDS: [(&str, Maker); 21] = [
    ("network", models::networks),
    ("oscilos", models::oscilos),
    ("flame-table", models::flame_tables),
    ("study", models::studies),
    ("observations", models::observations),
    ("channels", models::channels),
    ("responses", models::responses),
    ("responses", records::pressures),
    ("base-states", results::states),
    ("infer", results::infer),
    ("results", results::results),
    ("search", results::search),
    ("records-wav", records::wav),
    ("records-text", records::text),
    ("records-mat", records::mat),
    ("records-hdf5", records::hdf5),
    ("random", records::random),
    ("sweep", records::sweep),
    ("blow", records::blow),
    ("lab", flows::lab),
    ("flow", flows::flow),
];

/// Makes the seeds of all kinds, or of one, and sees that the program takes each as it is, in less than two
/// seconds.
pub(super) fn make(program: &Path, place: &Path, only: Option<&str>) -> Result<Vec<Seed>, String> {
    let mut bench = Bench { program, place, seeds: Vec::new() };
    for (_, make) in KINDS.iter().filter(|(kind, _)| only.is_none_or(|o| o == *kind)) {
        make(&mut bench)?;
    }
    if bench.seeds.is_empty() {
        let all = KINDS.map(|(kind, _)| kind).join(", ").replace("responses, responses", "responses");
        return Err(format!(
            "no kind of input is called `{}`\n  remedy: Name one of {all}.",
            only.unwrap_or_default()
        ));
    }
    let trial = place.join("trial");
    for seed in &bench.seeds {
        for command in &seed.commands {
            let _ = fs::remove_dir_all(&trial);
            copy(&seed.folder, &trial).map_err(|e| format!("{}: {e}", seed.folder.display()))?;
            let words: Vec<&str> = command.split(' ').collect();
            let run = limits::run(program, &words, &trial, &LIMITS)?;
            let what = format!("{} {}: `rijke {command}`", seed.kind, seed.name);
            if run.end != End::Done {
                return Err(format!(
                    "{what} of the input as it was made ends with {}\n{}",
                    run.end.word(),
                    run.error
                ));
            }
            if run.seconds > 2.0 {
                println!("warning: {what} of the input as it was made takes {:.1} s", run.seconds);
            }
        }
    }
    Ok(bench.seeds)
}
