//! A file that was changed, and how that is told.

use std::ops::Range;

/// What a file becomes, and what was done to it.
pub(super) type Changed = (Vec<u8>, String);

/// The first letters of a line, on one line.
pub(super) fn short(line: &str) -> String {
    line.chars().take(60).collect::<String>().escape_debug().to_string()
}

/// `text` with `range` replaced, and the line of it before and after.
pub(super) fn replaced(text: &str, range: Range<usize>, by: &str) -> Option<Changed> {
    let (head, tail) = (text.get(..range.start)?, text.get(range.end..)?);
    let line = head.matches('\n').count() + 1;
    let start = head.rfind('\n').map_or(0, |k| k + 1);
    let around = short(text.get(start..)?.lines().next().unwrap_or_default());
    let told = format!("line {line} ({around}): {} -> {}", short(text.get(range)?), short(by));
    Some((format!("{head}{by}{tail}").into_bytes(), told))
}
