//! The pages of the examples of the repository, each made anew.

use crate::workspace::{built, entries, root, succeed};
use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

/// Of the paper's rig the page is that of `cargo xtask reproduce`.
const PAPER: &str = "juniper-yoko-2022";

/// The example whose README makes a study of networks.
const NETWORKS: &str = "ducted-flame";

/// Examples whose later stages take long, and their first stage: figures of all are alike.
const SLOW: [(&str, &str); 2] = [("side-hole-tube", "perfect-head"), ("flow-duct", "waves")];

/// The example whose posterior has maxima so poor that its last stage cannot stand on them.
const ALIASES: &str = "swirl-duct";

/// Where measured data are, which are no part of the repository.
const MEASURED: &str = "RIJKE_MEASURED";

/// Names and pages of all examples: of those that were measured only where the data are at hand.
pub(super) fn pages(scratch: &Path) -> Result<Vec<(String, PathBuf)>, String> {
    let folder = root().join("examples");
    let name = |path: PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let names = entries(&folder)?.into_iter().filter(|path| path.is_dir()).map(name);
    let at_hand = std::env::var_os(MEASURED).is_some();
    let mut pages = Vec::new();
    for name in names.filter(|name| name != PAPER) {
        let example = folder.join(&name);
        let readme = fs::read_to_string(example.join("README.md")).unwrap_or_default();
        if readme.contains(MEASURED) && !at_hand {
            println!("page: {name} is not opened, because {MEASURED} does not say where its data are");
            continue;
        }
        let page = made(&name, &example, &scratch.join(&name))?;
        pages.push((name, page));
    }
    Ok(pages)
}

/// The page of an example, made in a folder.
fn made(name: &str, example: &Path, folder: &Path) -> Result<PathBuf, String> {
    // Of an earlier run.
    let _ = fs::remove_dir_all(folder);
    if name == NETWORKS {
        let mut infer = Command::new(built()?);
        infer.arg("infer").current_dir(example);
        infer.args("n-tau.toml n-tau-filter.toml second-order.toml --data modes.csv --study".split(' '));
        succeed(infer.arg(folder))?;
    } else {
        succeed(Command::new("cp").arg("-r").arg(example).arg(folder))?;
    }
    let mut run = Command::new(built()?);
    if let Some((_, first)) = SLOW.iter().find(|(slow, _)| *slow == name) {
        let mut rank = Command::new(built()?);
        succeed(rank.args(["rank", "--force", "--one-start", "--until", first]).arg(folder))?;
        return Ok(folder.join("results/index.html"));
    }
    run.args(["run", "--force"]).arg(folder);
    // The page is looked at, not the maxima of its posteriors.
    if name != ALIASES {
        run.arg("--one-start");
    }
    succeed(&mut run)?;
    Ok(folder.join("results/index.html"))
}
