//! What spreadsheets leave of cells that were used once: empty columns at the end of a table, and empty rows.

use std::borrow::Cow;

/// A cell behind the last heading of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BehindHeadings {
    /// Line of the cell, from 1.
    pub line: usize,
    /// Its column, from 1.
    pub column: usize,
    /// What stands there.
    pub cell: String,
}

impl BehindHeadings {
    /// What such a cell is not, and what to do.
    pub const EXPECTED: &'static str = "empty, but it stands behind the last heading: empty columns at the end are left out; give this one a heading, or \
                                        delete it";
}

impl std::fmt::Display for BehindHeadings {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "column {}: `{}` is not {}", self.column, self.cell, Self::EXPECTED)
    }
}

/// The text of a table without its empty columns at the end and without what stands in empty rows; every line
/// keeps its number. Cells stand `between` such characters, and may stand in quotes. Lines of which
/// `is_comment` stay as they are. The first other line of a table that `has_headings` says which columns
/// there are.
///
/// # Errors
/// A cell that is not empty behind the last heading.
pub fn without_empty_ends(
    text: &str,
    between: char,
    has_headings: bool,
    is_comment: fn(&str) -> bool,
) -> Result<Cow<'_, str>, BehindHeadings> {
    let rows = rows(text, is_comment);
    // Cells of a row up to the last one that is not empty, and whether any stands behind it.
    let ends: Vec<(Vec<usize>, usize)> = rows
        .iter()
        .map(|row| {
            if is_comment(row) {
                return (Vec::new(), 0);
            }
            let cuts = cuts(row, between);
            let cells = cells(row, &cuts);
            (cuts, cells.iter().rposition(|cell| !is_empty(cell)).map_or(0, |k| k + 1))
        })
        .collect();
    let of_rows = || ends.iter().filter(|(_, full)| *full > 0);
    let headed = match has_headings {
        true => of_rows().next(),
        false => of_rows().max_by_key(|(_, full)| *full),
    };
    let Some((_, width)) = headed else { return Ok(Cow::Borrowed(text)) };
    let mut line = 1;
    let mut all = String::with_capacity(text.len());
    for (row, (cuts, full)) in rows.iter().zip(&ends) {
        if full > width {
            let cell = cells(row, cuts)[full - 1].trim().to_owned();
            return Err(BehindHeadings { line, column: *full, cell });
        }
        let body = row.trim_end_matches(['\n', '\r']);
        let kept = match cuts.get(width.wrapping_sub(1)) {
            _ if is_comment(row) => body,
            _ if *full == 0 => "",
            Some(cut) => &body[..*cut],
            None => body,
        };
        all.push_str(kept);
        all.push_str(&row[body.len()..]);
        line += row.matches('\n').count();
    }
    Ok(if all == text { Cow::Borrowed(text) } else { Cow::Owned(all) })
}

/// As [`without_empty_ends`], of a table with headings, commas between its cells and comments behind `#`; a
/// byte-order mark is left out, too.
///
/// # Errors
/// A cell that is not empty behind the last heading.
pub fn csv_without_empty_ends(text: &str) -> Result<Cow<'_, str>, BehindHeadings> {
    let bare = text.strip_prefix('\u{feff}').unwrap_or(text);
    without_empty_ends(bare, ',', true, |row| row.starts_with('#'))
}

/// Whether a cell holds nothing.
fn is_empty(cell: &str) -> bool {
    cell.trim().trim_matches('"').trim().is_empty()
}

/// The rows with the ends of their lines. A quoted cell may go over several.
fn rows(text: &str, is_comment: fn(&str) -> bool) -> Vec<&str> {
    let (mut rows, mut first) = (Vec::new(), 0);
    let mut quoted = false;
    for (k, c) in text.char_indices() {
        match c {
            '"' if quoted || !is_comment(text[first..].lines().next().unwrap_or_default()) => {
                quoted = !quoted;
            }
            '\n' if !quoted => {
                rows.push(&text[first..=k]);
                first = k + 1;
            }
            _ => {}
        }
    }
    rows.extend((first < text.len()).then(|| &text[first..]));
    rows
}

/// Where the cells of a row end, but the last.
fn cuts(row: &str, between: char) -> Vec<usize> {
    let mut quoted = false;
    let mut cut = |(k, c): (usize, char)| {
        quoted ^= c == '"';
        (!quoted && c == between).then_some(k)
    };
    row.char_indices().filter_map(&mut cut).collect()
}

/// The cells of a row.
fn cells<'a>(row: &'a str, cuts: &[usize]) -> Vec<&'a str> {
    let starts = std::iter::once(0).chain(cuts.iter().map(|cut| cut + 1));
    let ends = cuts.iter().copied().chain([row.len()]);
    starts.zip(ends).map(|(from, to)| &row[from..to]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_comment(row: &str) -> bool {
        row.starts_with('#')
    }

    #[test]
    fn behaviour_empty_columns_and_rows_go_and_lines_keep_their_numbers() {
        let cut = |text, headings| without_empty_ends(text, ',', headings, is_comment).unwrap().into_owned();
        // Headings say what there is.
        assert_eq!(cut("a,b,,\r\n1,,,\r\n,,,\r\n3,4,\"\",\r\n", true), "a,b\r\n1,\r\n\r\n3,4\r\n");
        assert_eq!(
            cut("# by hand, 5\"\na,b\n1,2,,\n\"x,y\",\"\n\",\n", true),
            "# by hand, 5\"\na,b\n1,2\n\"x,y\",\"\n\"\n"
        );
        // Without them the widest row does; an empty cell within is one.
        assert_eq!(cut("1,2,,\n3,,5,\n", false), "1,2,\n3,,5\n");
        // What has none stays as it is.
        for text in ["a,b\n1,\n", "", "#\n", "a\n\n1", "1,2"] {
            assert!(
                matches!(without_empty_ends(text, ',', true, is_comment).unwrap(), Cow::Borrowed(_)),
                "{text:?}"
            );
        }
        // A column with a heading stays, however empty.
        assert_eq!(cut("a,b,\n1,,\n", true), "a,b\n1,\n");
    }

    #[test]
    fn message_a_cell_behind_the_headings_is_named() {
        let said = without_empty_ends("a;b;;\n1;2;;\n1;2;;7\n", ';', true, is_comment).unwrap_err();
        assert_eq!((said.line, said.cell.as_str(), said.column), (3, "7", 4));
        assert!(said.to_string().contains("empty columns at the end"), "{said}");
    }
}
