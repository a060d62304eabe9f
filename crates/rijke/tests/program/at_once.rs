//! Several runs into one folder at once: one wins, the others say so, and nothing is mixed.

use crate::{rijke, scratch};
use std::{
    collections::BTreeMap,
    fs,
    path::Path,
    process::{Child, Command, Output, Stdio},
};

type Files = BTreeMap<String, Vec<u8>>;

/// What one seed writes: 14 files, quickly.
const WORDS: &str = "lab --row C3 --repeats 1 --seed";

fn start(folder: &Path, words: &str) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rijke"));
    command.args(words.split(' ')).current_dir(folder).stdin(Stdio::piped());
    command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Every file of a folder, by its path from there.
fn files(folder: &Path) -> Files {
    let mut found = Files::new();
    for entry in fs::read_dir(folder).unwrap() {
        let (path, name) =
            (entry.as_ref().unwrap().path(), entry.unwrap().file_name().into_string().unwrap());
        if path.is_dir() {
            found.extend(files(&path).into_iter().map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
        } else {
            found.insert(name, fs::read(path).unwrap());
        }
    }
    found
}

/// The names in a folder.
fn names(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.collect();
    names.sort();
    names
}

/// Ends of runs that were started together: how many won, and that each other one was refused for a good
/// reason.
fn winners(ends: Vec<Output>) -> Vec<usize> {
    let mut won = Vec::new();
    for (k, Output { status, stderr, .. }) in ends.into_iter().enumerate() {
        let said = String::from_utf8_lossy(&stderr);
        if status.success() {
            won.push(k);
            continue;
        }
        assert_eq!(status.code(), Some(2), "{said}");
        let refused = said.contains("another run is writing it") || said.contains("exists already");
        assert!(refused && said.contains("remedy: ") && said.contains("out"), "{said}");
    }
    won
}

/// Rounds of 2, 3 and 8 runs with a seed each.
fn rounds(name: &str, rounds: usize) {
    let folder = scratch(name);
    let alone: Vec<Files> = (0..8)
        .map(|seed| {
            assert!(start(&folder, &format!("{WORDS} {seed} --out alone-{seed}")).wait().unwrap().success());
            files(&folder.join(format!("alone-{seed}")))
        })
        .collect();
    let work = folder.join("work");
    for round in 0..rounds {
        for together in [2, 3, 8] {
            let force = if round % 2 == 1 { " --force" } else { "" };
            let _ = fs::remove_dir_all(&work);
            fs::create_dir(&work).unwrap();
            let runs: Vec<Child> =
                (0..together).map(|seed| start(&work, &format!("{WORDS} {seed} --out out{force}"))).collect();
            let won = winners(runs.into_iter().map(|run| run.wait_with_output().unwrap()).collect());
            // With --force, one that comes when another has ended replaces what that wrote.
            assert!(
                won.len() == 1 || (won.len() > 1 && !force.is_empty()),
                "{together} runs{force}: {won:?}"
            );
            let found = files(&work.join("out"));
            let seed = alone.iter().position(|files| *files == found);
            assert!(
                seed.is_some_and(|seed| won.contains(&seed)),
                "{together} runs{force} are mixed: {won:?}"
            );
            assert_eq!(names(&work), ["out"], "{together} runs{force}");
        }
    }
}

#[test]
fn behaviour_of_runs_into_one_folder_one_wins() {
    rounds("at-once", 2);
}

#[test]
#[ignore = "long: 150 rounds of 2, 3 and 8 runs, a minute"]
fn behaviour_of_many_rounds_into_one_folder_one_wins() {
    rounds("at-once-long", 50);
}

#[test]
fn behaviour_the_second_run_is_told_who_holds_the_folder() {
    let folder = scratch("at-once-told");
    // A run that stays in its folder until it is told to end: all of the campaign takes long enough.
    let mut first = start(&folder, "--until-stdin-closes lab --out out");
    while !names(&folder).iter().any(|name| name.starts_with(".out.partial")) {
        assert!(first.try_wait().unwrap().is_none(), "the first run ended before it was seen");
    }
    let second = rijke(&folder, &["lab", "--out", "out", "--force"]);
    let said = String::from_utf8_lossy(&second.stderr);
    assert_eq!(second.status.code(), Some(2), "{said}");
    let holder = format!("process {}, `rijke --until-stdin-closes lab --out out`", first.id());
    assert!(said.contains(&holder) && said.contains("Wait until that run has ended"), "{said}");

    // The parent's end of the pipe closes: the run ends by itself, and the next one works and cleans up.
    drop(first.stdin.take());
    let ended = first.wait().unwrap();
    assert_eq!(ended.code(), Some(130));
    assert_eq!(names(&folder).iter().filter(|name| name.starts_with(".out.partial")).count(), 1);
    let third = rijke(&folder, &["lab", "--row", "C3", "--repeats", "1", "--out", "out"]);
    assert!(third.status.success(), "{}", String::from_utf8_lossy(&third.stderr));
    assert_eq!(names(&folder), ["out"]);
}
