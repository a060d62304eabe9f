//! `cargo xtask reproduce`: builds `rijke`, runs its stages in order, and says what was run on what.

mod hashes;
mod items;
mod options;
mod reference;
mod stages;

use crate::child;
use crate::workspace::{Outcome, at, built, program, root, write};
use items::STUDY;
pub(crate) use options::Options;
use options::WORK;
use serde_json::{Value, json};
use stages::{Done, Made, Stage};
use std::{
    fs::{self, File, TryLockError},
    path::Path,
    process::{Child, Command, Stdio},
    time::Instant,
};

pub(crate) fn run(options: &Options) -> Outcome {
    let base = options.base();
    let _lock = lock(&base.join(WORK))?;
    let start = Instant::now();
    println!("[build] cargo build --release --workspace --bin rijke");
    built()?;
    println!("[build] done in {:.1} s", start.elapsed().as_secs_f64());

    let program = program();
    // The study itself counts among the reasons to run a stage again.
    let study = copy_study(&base.join(options.study()))?;
    let program_hash = hashes::text(&format!("{}{study}", hashes::file(&program)?));
    let stages = stages::stages(options);
    let (mut done, start) = (Vec::new(), Instant::now());
    for (number, stage) in stages.iter().enumerate() {
        let label = format!("[{}/{}]", number + 1, stages.len());
        let inputs = stage.input_hashes()?;
        let fingerprint = stage.fingerprint(&program_hash, &inputs);
        let command = format!("rijke {}", stage.arguments.join(" "));
        let before = if options.fresh { None } else { stage.finished(&fingerprint)? };
        let made = match &before {
            Some(made) => {
                println!("{label} {command}\n{label} kept from before: it took {:.1} s", made.seconds);
                made.clone()
            }
            None => {
                let left = stages::time_left(&stages[..number], &done, &stages[number..]);
                let left = left.map_or_else(String::new, |s| format!(" (about {s:.0} s left in all)"));
                println!("{label} {command}{left}");
                let made = take(stage, &program, &base)?;
                stage.mark(&fingerprint, &made)?;
                println!("{label} done in {:.1} s, at most {} MiB", made.seconds, made.peak_mib);
                made
            }
        };
        done.push((made, before.is_some(), inputs));
    }
    println!("all stages in {:.1} s", start.elapsed().as_secs_f64());

    let results = base.join(options.study()).join("results");
    let path = results.join("manifest.json");
    let manifest = manifest(options, &program_hash, &stages, &done)?;
    write(&path, format!("{manifest:#}\n"))?;
    println!("open {}", results.join("index.html").display());
    keep_picture(options)?;

    let reference = root().join("reference").join(if options.quick { "quick" } else { "full" });
    match (options.check, options.accept) {
        (true, _) => reference::check(&results.join("numbers"), &reference),
        (_, true) => reference::accept(&results.join("numbers"), &reference),
        _ => Ok(()),
    }
}

/// Copies the files of the study to where it is run; what they hold, as a hash.
pub(crate) fn copy_study(to: &Path) -> Result<String, String> {
    let from = root().join(STUDY);
    let mut all = String::new();
    for (name, hash) in hashes::folder(&from, &from)? {
        let written = [".toml", ".csv"].iter().any(|ending| name.ends_with(ending))
            && !["observations", "base", "results"].iter().any(|made| name.starts_with(made));
        if written {
            let (source, target) = (from.join(&name), to.join(&name));
            let made = target.parent().map_or(Ok(()), fs::create_dir_all);
            made.and_then(|()| fs::copy(&source, &target)).map_err(at(&target))?;
            all += &format!("{name} {hash}\n");
        }
    }
    Ok(hashes::text(&all))
}

/// The right to run the stages in a folder, which ends with this task.
fn lock(folder: &Path) -> Result<File, String> {
    let said = |error: std::io::Error| format!("{}: {error}", folder.display());
    fs::create_dir_all(folder).map_err(said)?;
    let path = folder.join(".lock");
    let file = File::options().write(true).create(true).truncate(false).open(&path).map_err(said)?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(format!(
            "{}: another `cargo xtask reproduce` is at work there; wait until it has ended, or name another folder \
             with --into",
            folder.display()
        )),
        Err(TryLockError::Error(error)) => Err(said(error)),
    }
}

/// Runs a stage to its end. Its result is discarded; its progress bar still reaches the terminal. It ends
/// with this task.
fn take(stage: &Stage, program: &Path, base: &Path) -> Result<Made, String> {
    let start = Instant::now();
    let mut command = Command::new(program);
    command.arg("--until-stdin-closes").args(&stage.arguments).current_dir(base);
    command.stdin(Stdio::piped()).stdout(Stdio::null());
    let mut peak_mib = 0;
    let look = |child: &Child| peak_mib = peak_mib.max(child::peak_memory_mib(child.id()).unwrap_or(0));
    let status = child::run(&mut command, look).map_err(at(program))?;
    if !status.success() {
        return Err(format!("`rijke {}` ended with {status}", stage.arguments.join(" ")));
    }
    Ok(Made { seconds: start.elapsed().as_secs_f64(), peak_mib })
}

/// The picture of the README is Fig. 4 of the full run with the usual seed.
fn keep_picture(options: &Options) -> Outcome {
    if options.quick || options.only.is_some() || options.into.is_some() || options.seed != 1 {
        return Ok(());
    }
    let folder = root().join("docs/images");
    let copy = || {
        fs::create_dir_all(&folder)?;
        fs::copy(
            root().join(options.study()).join("results/figures/figure-4.svg"),
            folder.join("figure-4.svg"),
        )
    };
    copy().map(drop).map_err(at(&folder))
}

/// What was run, on what, by what.
fn manifest(options: &Options, program_hash: &str, stages: &[Stage], done: &[Done]) -> Result<Value, String> {
    let stage = |(stage, (made, kept, inputs)): (&Stage, &Done)| {
        json!({
            "command": format!("rijke {}", stage.arguments.join(" ")),
            "inputs_sha256": inputs.iter().cloned().collect::<std::collections::BTreeMap<_, _>>(),
            "seconds": made.seconds,
            "peak_memory_mib": made.peak_mib,
            "kept": kept,
        })
    };
    Ok(json!({
        "revision": first_line("git", &["describe", "--always", "--dirty", "--abbrev=40"]),
        "toolchain": first_line("rustc", &["--version"]),
        "seed": options.seed,
        "quick": options.quick,
        "only": options.only.as_ref().map(|item| &item.name),
        "program_sha256": program_hash,
        "stages": stages.iter().zip(done).map(stage).collect::<Vec<_>>(),
        "seconds": done.iter().map(|(made, ..)| made.seconds).sum::<f64>(),
        "peak_memory_mib": done.iter().map(|(made, ..)| made.peak_mib).max(),
        "fixtures_sha256": hashes::folder(&root(), &root().join("fixtures"))?,
        "numbers_sha256": hashes::folder(&options.base(), &options.base().join(options.study()).join("results/numbers"))?,
    }))
}

/// The first line that a program prints, if it is installed and succeeds.
fn first_line(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).current_dir(root()).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.lines().next().map(String::from))?
}
