//! Files that an option names, figures above all.

use crate::ui::Ui;
use rijke_draw::{is_file_of_figures, write_figure_as};
use rijke_numerics::Failed;
use std::path::{Path, PathBuf};

/// The file that an option names for a figure.
pub(crate) fn file(name: &str) -> Result<PathBuf, String> {
    let path = any_file(name)?;
    match is_file_of_figures(&path) {
        true => Ok(path),
        false => Err("a figure is written as SVG or PDF: name a file that ends in .svg or .pdf".to_owned()),
    }
}

/// The file that an option names for a table or a text. Its folder must be there before anything is computed.
pub(crate) fn any_file(name: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(name);
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            Err(format!("there is no folder {}; make it first, or name another place", folder.display()))
        }
        _ => Ok(path),
    }
}

/// Writes a figure into such a file, and says so.
pub(crate) fn write(path: &Path, svg: &str, ui: &Ui) -> Result<(), Failed> {
    write_figure_as(path, svg)?;
    ui.note(format!("wrote {}", path.display()));
    Ok(())
}
