//! `rijke search`: every allowed combination of candidates, in one run or in shards that `rijke merge` joins.

use crate::{number, trust::Trust, ui::Ui};
use rijke_engine::folder::{observations, of_the_engine, open_study, warn_of_left_out, without_responses};
use rijke_engine::run::{Search, SearchOptions, SearchPart, SearchRecord, merge_searches};
use rijke_numerics::{Classify, Failed, Tell, write_output};
use rijke_rig::files::csv_table;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Train every allowed combination of candidates over the stages of a study. State the probability of each
/// combination, and of each candidate in it.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  rijke search examples/quarter-wave --one-start\n  \
    parallel rijke search examples/quarter-wave --one-start --shard {}/7 ::: 1 2 3 4 5 6 7\n  \
    rijke merge examples/quarter-wave/search/parts/*-of-7.json\n\n\
    Writes DIR/search/search.json and DIR/search/tables, or with --shard its part, DIR/search/parts/K-of-N.json. The result of each task is\n\
    kept in DIR/search/tasks under the hash of all that it depends on, so a run that was killed goes on where it was, and shards on one\n\
    file system share what they have. docs/search.md says what the numbers mean and how to use several machines.")]
pub(crate) struct Args {
    /// Folder of the study.
    dir: PathBuf,
    #[command(flatten)]
    trust: Trust,
    /// The stage at which combinations end [default: the one that stands on most stages].
    #[arg(long, value_name = "STAGE")]
    stage: Option<String>,
    /// Prune a model, and all combinations with it, if its ln evidence is more than this below that of the
    /// stage-by-stage choice twice: after its own stage, and after the last stage with the later candidates
    /// of that choice.
    #[arg(long, value_name = "NATS", default_value_t = 20.0, value_parser = number::not_negative)]
    within: f64,
    /// Prune nothing.
    #[arg(long, conflicts_with = "within")]
    every: bool,
    /// Train only shard K of N.
    #[arg(long, value_name = "K/N", value_parser = shard)]
    shard: Option<[usize; 2]>,
    /// How many threads; 0 is one for each processor.
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
}

/// Join the parts that `rijke search --shard` wrote.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  rijke merge examples/quarter-wave/search/parts/*-of-7.json\n\n\
    Writes search.json and tables as one run of `rijke search` would, byte for byte.")]
pub(crate) struct MergeArgs {
    /// Parts of one search, in any order.
    #[arg(required = true, value_name = "PART")]
    parts: Vec<PathBuf>,
    /// Where to write [default: the folder that holds the folder of the first part].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Which shard of how many.
fn shard(text: &str) -> Result<[usize; 2], String> {
    let found = text.split_once('/').and_then(|(k, n)| Some([k.parse().ok()?, n.parse().ok()?]));
    found.filter(|[k, n]| (1..=*n).contains(k)).ok_or_else(|| "give K/N, such as 1/7 to 7/7".to_owned())
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failed> {
    let dir = &args.dir;
    let study = open_study(dir)?;
    without_responses(&study, "a search")?;
    let observations = observations(&study)?;
    let wrong = |e: rijke_engine::EngineError| of_the_engine(&e, dir);
    let out = dir.join("search");
    let options = SearchOptions {
        stage: args.stage.clone(),
        within: if args.every { f64::INFINITY } else { args.within },
        trusted: args.trust.trusted()?,
        shard: args.shard.unwrap_or([1, 1]),
        threads: args.threads,
        tasks: Some(out.join("tasks")),
    };
    let search = Search::new(study, &observations, options).map_err(wrong)?;
    warn_of_left_out(search.left_out(), ui);
    let progress = ui.progress("models", search.tasks() as u64);
    let advance = |n: usize| {
        progress(n as u64);
        true
    };
    let part = search.run(&advance).map_err(wrong)?;
    drop(progress);
    if let Some([k, n]) = args.shard {
        let parts = out.join("parts");
        let path = parts.join(format!("{k}-of-{n}.json"));
        keep(&path, &part)?;
        ui.say(format!(
            "shard {k} of {n}: {} of {} models; {}",
            part.nodes.len(),
            part.models,
            path.display()
        ));
        return ui.result(&serde_json::json!({ "part": path, "models": part.nodes.len() }));
    }
    let found = merge_searches(&[part]).map_err(wrong)?;
    write(&found, &out, ui)
}

pub(crate) fn merge(args: &MergeArgs, ui: &Ui) -> Result<(), Failed> {
    let read = |path: &PathBuf| -> Result<SearchPart, Failed> {
        let remedy = "Give files that `rijke search --shard` wrote.";
        let text = rijke_numerics::read_text(path).or_bad_input().map_err(|f| f.at(path).remedy(remedy))?;
        serde_json::from_str(&text).or_bad_input().map_err(|f| f.at(path).remedy(remedy))
    };
    let parts = args.parts.iter().map(read).collect::<Result<Vec<_>, _>>()?;
    let above = args.parts[0].parent().and_then(Path::parent).unwrap_or(Path::new(""));
    let out = args.out.clone().unwrap_or_else(|| above.to_owned());
    write(&merge_searches(&parts).or_bad_input()?, &out, ui)
}

/// Writes and prints the result.
fn write(found: &SearchRecord, out: &Path, ui: &Ui) -> Result<(), Failed> {
    let tables = out.join("tables");
    put(&tables.join("combinations.csv"), csv_table(found.combinations_table())?.as_bytes())?;
    put(&tables.join("choices.csv"), csv_table(found.choices_table())?.as_bytes())?;
    keep(&out.join("search.json"), found)?;
    found.tell(ui);
    ui.note(format!("wrote {}", out.join("search.json").display()));
    ui.result(found)
}

fn keep(path: &Path, what: &impl Serialize) -> Result<(), Failed> {
    put(path, (serde_json::to_string_pretty(what).or_failed()? + "\n").as_bytes())
}

fn put(path: &Path, content: &[u8]) -> Result<(), Failed> {
    let folder = path.parent().unwrap_or(Path::new(""));
    std::fs::create_dir_all(folder).or_bad_input().map_err(|f| f.at(folder))?;
    write_output(path, content)
}
