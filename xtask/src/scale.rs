//! `cargo xtask scale`: what commands cost against the number of places, points, microphones and candidates,
//! and against the length of a record.

mod made;
mod records;

use crate::child::{self, peak_memory_mib, processor};
use crate::workspace::{Outcome, at, cargo, program, read, root, succeed, write};
use made::{Made, campaign, candidates, copies, microphones, rows};
use std::{fmt::Write as _, fs, path::Path, process::Command, time::Instant};

const HEAD: &str = "| command | size | points | processor, s | clock, s | memory, MiB | exponent |
|---|---|---|---|---|---|---|
";

/// What of the series is run.
#[derive(clap::Args)]
pub(crate) struct Options {
    /// Only series whose name holds this, as `flow` or `candidates`; the table goes to target/scale.md.
    #[arg(long, value_name = "WORD")]
    only: Option<String>,
    /// The largest sizes as well: some hours.
    #[arg(long)]
    all: bool,
}

/// A series: what is measured, its sizes, those that take long, how the folder of a size is made, and the
/// words of the command.
type Series = (&'static str, &'static [usize], &'static [usize], fn(&Path, usize) -> Made, &'static str);

const FLOW: &str = "flow . --out base --quiet";
const RANK: &str = "rank . --one-start --force --quiet";
const PROCESS: &str = "process records --out observations --force --quiet";

const SERIES: [Series; 7] = [
    ("`flow`, places of the heater", &[15, 29, 57], &[], |f, n| campaign(f, n, 8), FLOW),
    ("`flow`, microphones", &[5, 16, 64], &[], |f, n| campaign(f, 15, n), FLOW),
    ("`rank`, copies of all points", &[1, 2, 4], &[10], copies, RANK),
    ("`rank`, microphones", &[5, 16, 64], &[], microphones, RANK),
    ("`rank`, candidates", &[10, 100], &[1000, 10_000], candidates, RANK),
    ("`process`, seconds of a ping", &[6, 60, 360], &[3600], records::ping, PROCESS),
    ("`process`, seconds of noise", &[60, 360], &[3600], records::noise, PROCESS),
];

pub(crate) fn run(options: &Options) -> Outcome {
    let words = "build --release --workspace --bin rijke --example bench_data";
    succeed(cargo().args(words.split(' ')))?;
    let (mut text, place) = (String::from(HEAD), root().join("target/scale"));
    let _ = fs::remove_dir_all(&place);
    for (what, short, long, make, words) in SERIES {
        if options.only.as_ref().is_some_and(|word| !what.contains(word.as_str())) {
            continue;
        }
        let mut before: Option<(usize, f64)> = None;
        for &size in short.iter().chain(if options.all { long } else { &[] }) {
            let folder = place.join(format!("{}-{size}", what.replace([' ', ',', '`'], "-")));
            fs::create_dir_all(&folder).map_err(at(&folder))?;
            make(&folder, size)?;
            let table = ["observations/points.csv", "campaign.csv"]
                .map(|f| read(&folder.join(f)).unwrap_or_default());
            let points = table.iter().find(|t| !t.is_empty()).map_or(1, |t| rows(t).count() - 1);
            let (cpu, clock) = (processor("self", 13), Instant::now());
            let memory = peak_memory(Command::new(program()).args(words.split(' ')).current_dir(&folder))?;
            let (cpu, clock) = (processor("self", 13) - cpu, clock.elapsed().as_secs_f64());
            let grown =
                |(n, c): (usize, f64)| format!("{:.2}", (cpu / c).ln() / (size as f64 / n as f64).ln());
            let exponent = before.map_or(String::new(), grown);
            let row =
                format!("| {what} | {size} | {points} | {cpu:.2} | {clock:.1} | {memory} | {exponent} |");
            println!("{row}");
            let _ = writeln!(text, "{row}");
            before = Some((size, cpu));
            // Records of an hour are not kept.
            let _ = fs::remove_dir_all(&folder);
        }
    }
    if options.only.is_some() {
        return write(&root().join("target/scale.md"), text);
    }
    let path = root().join("docs/records/scale.md");
    let old = read(&path)?;
    let (intro, rest) = old.split_once("| command |").ok_or("docs/records/scale.md: there is no table")?;
    let (_, outro) = rest.split_once("\n\n").unwrap_or((rest, ""));
    write(&path, format!("{intro}{text}\n{outro}"))
}

/// Runs a command to its end; returns the most memory that it held, MiB.
fn peak_memory(command: &mut Command) -> Result<u64, String> {
    let mut peak = 0;
    let status = child::run(command, |child| peak = peak.max(peak_memory_mib(child.id()).unwrap_or(0)));
    let status = status.map_err(|e| format!("{command:?}: {e}"))?;
    if status.success() { Ok(peak) } else { Err(format!("{command:?} ended with {status}")) }
}
