//! Options of `cargo xtask reproduce`, and the folders that it makes.

use super::items;
use crate::workspace::root;
use std::path::PathBuf;

/// What of the campaign is run, and where.
#[derive(clap::Args)]
pub(crate) struct Options {
    /// Only this stage, question or map of study.toml and what it rests on, as `heater` or `figure-4`.
    #[arg(long, value_name = "ITEM", value_parser = items::parse)]
    pub(super) only: Option<items::Item>,
    /// Four repeats of each operating point instead of the paper's forty.
    #[arg(long)]
    pub(super) quick: bool,
    /// Seed of all random numbers of the virtual laboratory.
    #[arg(long, default_value_t = 1)]
    pub(super) seed: u64,
    /// Run every stage, also those that were finished before with the same inputs.
    #[arg(long)]
    pub(super) fresh: bool,
    /// Afterwards compare the numbers with those kept in reference/, and fail if one moved beyond its
    /// tolerance.
    #[arg(long)]
    pub(super) check: bool,
    /// Afterwards keep the numbers in reference/, to be compared with by --check.
    #[arg(long, conflicts_with_all = ["check", "only"])]
    pub(super) accept: bool,
    /// Folder in which virtual-rig/ is made [default: the repository].
    #[arg(long, value_name = "DIR", conflicts_with = "accept")]
    pub(super) into: Option<PathBuf>,
}

impl Options {
    /// The folder of the study: runs of different size do not replace each other's observations.
    pub(super) fn study(&self) -> String {
        let size = if self.quick { "quick" } else { "full" };
        self.only
            .as_ref()
            .map_or_else(|| format!("{WORK}/{size}"), |item| format!("{WORK}/{size}-{}", item.name))
    }

    /// Where everything is made.
    pub(super) fn base(&self) -> PathBuf {
        self.into
            .as_deref()
            .map_or_else(root, |into| std::path::absolute(into).unwrap_or_else(|_| into.into()))
    }
}

/// Where the study of the paper is run on records of the virtual laboratory.
pub(super) const WORK: &str = "virtual-rig";
