//! Figures into files: SVG or PDF, as the name ends.

use crate::failure::{Classify, Failure};
use crate::ui::Ui;
use rijke_numerics::write_output;
use std::path::{Path, PathBuf};

/// The file that an option names for a figure.
pub(crate) fn file(name: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(name);
    match ending(&path) {
        "svg" | "pdf" => Ok(path),
        _ => Err("a figure is written as SVG or PDF: name a file that ends in .svg or .pdf".to_owned()),
    }
}

/// Writes a figure into the file that an option named, and says so.
pub(crate) fn write(path: &Path, svg: &str, ui: &Ui) -> Result<(), Failure> {
    match ending(path) {
        "pdf" => write_output(path, &rijke_report::pdf(svg).or_failed()?)?,
        _ => write_output(path, svg.as_bytes())?,
    }
    ui.note(format!("wrote {}", path.display()));
    Ok(())
}

/// Writes a figure into a folder that no one else writes: `NAME.svg` and `NAME.pdf`.
pub(crate) fn both(folder: &Path, name: &str, svg: &str) -> Result<(), Failure> {
    let pdf = rijke_report::pdf(svg).or_failed()?;
    for (ending, content) in [("svg", svg.as_bytes()), ("pdf", &pdf)] {
        let path = folder.join(format!("{name}.{ending}"));
        let written = path.parent().map_or(Ok(()), std::fs::create_dir_all);
        written.and_then(|()| std::fs::write(&path, content)).or_failed().map_err(|f| f.at(&path))?;
    }
    Ok(())
}

fn ending(path: &Path) -> &str {
    path.extension().and_then(|e| e.to_str()).unwrap_or("")
}
