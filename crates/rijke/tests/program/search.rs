//! The search over combinations: one run, shards and runs that were killed write the same bytes.

use crate::{copy, example, rijke, scratch};
use std::{
    fs,
    path::Path,
    process::{Command, Stdio},
    thread,
    time::Duration,
};

/// The stage that is searched: the one after it takes most of the time.
const STAGE: &str = "burner";

const RESULTS: [&str; 3] = ["search.json", "tables/combinations.csv", "tables/choices.csv"];

fn results(folder: &Path) -> Vec<Vec<u8>> {
    RESULTS.iter().map(|name| fs::read(folder.join(name)).unwrap()).collect()
}

/// `rijke search` in a study, which must succeed.
fn search(folder: &Path, words: &[&str]) -> String {
    let output = rijke(folder, &[&["search", ".", "--stage", STAGE, "--one-start"], words].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn exact_shards_and_killed_runs_write_what_one_run_writes() {
    let folder = scratch("search");
    copy(&example("ducted-flame-stages"), &folder);
    let said = search(&folder, &[]);
    assert!(said.contains("32 combinations over tube, burner") && said.contains("stage by stage: place"));
    let own = folder.join("search");
    let one = results(&own);

    // Shards that share their tasks, in another order, one of them twice.
    for n in [2, 7] {
        let parts: Vec<String> = (1..=n).rev().map(|k| format!("search/parts/{k}-of-{n}.json")).collect();
        for k in 1..=n {
            search(&folder, &["--shard", &format!("{k}/{n}")]);
        }
        search(&folder, &["--shard", &format!("1/{n}")]);
        let mut words = vec!["merge", "--out", "merged", &parts[0]];
        words.extend(parts.iter().map(String::as_str));
        let output = rijke(&folder, &words);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(results(&folder.join("merged")) == one, "{n} shards");
        let refused = rijke(&folder, &["merge", &parts[0]]);
        assert_eq!(refused.status.code(), Some(2));
        assert!(String::from_utf8_lossy(&refused.stderr).contains("make shard 1"), "{refused:?}");
    }

    // A shard on a machine of its own, killed and run again.
    fs::remove_dir_all(&own).unwrap();
    let tasks = || fs::read_dir(own.join("tasks")).map_or(0, Iterator::count);
    let mut run = Command::new(env!("CARGO_BIN_EXE_rijke"))
        .args(["search", ".", "--stage", STAGE, "--one-start", "--shard", "1/2"])
        .current_dir(&folder)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    while tasks() < 6 {
        assert!(run.try_wait().unwrap().is_none(), "ended before it could be killed");
        thread::sleep(Duration::from_millis(5));
    }
    run.kill().unwrap();
    run.wait().unwrap();
    assert!(!own.join("parts").exists(), "a part is whole or absent");
    search(&folder, &["--shard", "1/2"]);
    let first = fs::read(own.join("parts/1-of-2.json")).unwrap();
    fs::remove_dir_all(own.join("tasks")).unwrap();
    search(&folder, &["--shard", "1/2"]);
    assert!(fs::read(own.join("parts/1-of-2.json")).unwrap() == first, "with and without what was kept");
    search(&folder, &["--shard", "2/2"]);
    let output = rijke(&folder, &["merge", "search/parts/1-of-2.json", "search/parts/2-of-2.json"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(results(&own) == one);
}

#[test]
fn message_a_search_says_what_it_cannot_take() {
    let folder = scratch("search-wrong");
    copy(&example("ducted-flame-stages"), &folder);
    let refused = |words: &[&str]| {
        let output = rijke(&folder, &[&["search", "."], words].concat());
        assert_eq!(output.status.code(), Some(2), "{words:?}");
        assert!(!folder.join("search").exists());
        String::from_utf8(output.stderr).unwrap()
    };
    assert!(refused(&["--shard", "3/2"]).contains("give K/N"));
    assert!(refused(&["--stage", "flames"]).contains("give one of tube, burner, flame"));
    fs::write(folder.join("part.json"), "{}").unwrap();
    let output = rijke(&folder, &["merge", "part.json"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        output.status.code() == Some(2) && said.contains("part.json") && said.contains("remedy"),
        "{said}"
    );
}
