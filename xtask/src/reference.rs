//! `cargo xtask reference`: writes the page of the book that holds the help of every command.

use crate::workspace::{Outcome, cargo, root};
use std::fs;

const PAGE: &str = "docs/reference/commands.md";

/// Builds the program and lets it print the page.
pub(crate) fn run() -> Outcome {
    let mut program = cargo();
    program.args(["run", "--release", "--quiet", "--package", "rijke", "--", "man", "--markdown"]);
    let output = program.output().map_err(|error| format!("cannot start cargo: {error}"))?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into_owned());
    }
    let path = root().join(PAGE);
    fs::write(&path, output.stdout).map_err(|error| format!("{}: {error}", path.display()))?;
    println!("wrote {PAGE}");
    Ok(())
}
