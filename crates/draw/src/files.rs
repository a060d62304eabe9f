//! Figures into files: SVG or PDF, as the name ends.

use crate::pdf;
use rijke_numerics::{Failed, write_output, write_within};
use std::path::Path;

/// Whether a figure can be written into a file of this name: its ending is `svg` or `pdf`.
pub fn is_file_of_figures(path: &Path) -> bool {
    matches!(ending(path), "svg" | "pdf")
}

/// Writes a figure, given as the text of its SVG file, into a file that a user named.
pub fn write_figure_as(path: &Path, svg: &str) -> Result<(), Failed> {
    match ending(path) {
        "pdf" => write_output(path, &pdf(svg)?),
        _ => write_output(path, svg.as_bytes()),
    }
}

/// Writes a figure into a folder that no one else writes: `NAME.svg` and `NAME.pdf`.
pub fn write_figure(folder: &Path, name: &str, svg: &str) -> Result<(), Failed> {
    write_within(folder, &format!("{name}.svg"), svg)?;
    write_within(folder, &format!("{name}.pdf"), pdf(svg)?)
}

/// The ending of the name of a file.
fn ending(path: &Path) -> &str {
    path.extension().and_then(|e| e.to_str()).unwrap_or("")
}
