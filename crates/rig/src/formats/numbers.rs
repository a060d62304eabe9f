//! A text of numbers alone, whose columns are known by their places.

use super::text::{Form, HEAD, TextForm};
use rijke_numerics::without_empty_ends;

/// Columns of numbers, and the line of each row, from 1.
pub type NumberColumns = (Vec<Vec<f64>>, Vec<usize>);

/// Reads such a text as text records are read: commas, semicolons, tabs or blanks between columns, a decimal
/// point or a decimal comma, a byte order mark, comments, and lines without a number before the first row.
///
/// # Errors
/// The line, from 1, and what is wrong: a cell that is no finite number, a row of another width. A text
/// without any row has no columns.
pub fn number_columns(text: &str) -> Result<NumberColumns, (usize, String)> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let rows = || text.lines().filter(|row| !Form::is_passed_over(row));
    let between = [';', '\t', ','].into_iter().find(|c| rows().all(|row| row.contains(*c)));
    // Of rows without headings the widest says how many columns there are: nothing stands behind it.
    let cut = between.and_then(|between| without_empty_ends(text, between, false, Form::is_passed_over).ok());
    let text = cut.as_deref().unwrap_or(text);
    let head: Vec<String> = text.lines().take(HEAD).map(str::to_owned).collect();
    let said = |line: usize, column: Option<usize>, problem: String| {
        let place = column.map_or(String::new(), |column| format!("column {column}: "));
        (line, format!("{place}{problem}"))
    };
    let mut form =
        Form::find(&head, &TextForm::default()).map_err(|(k, c, problem)| said(k, c, problem.to_string()))?;
    let (mut columns, mut lines) = (vec![Vec::new(); form.width], Vec::new());
    for (k, row) in text.lines().enumerate().skip(form.before) {
        if Form::is_passed_over(row) {
            continue;
        }
        let mut bad = None;
        form.row(
            row,
            |_| true,
            |column, value| {
                if !value.is_finite() {
                    bad = bad.or(Some(column));
                }
                columns[column].push(value);
            },
        )
        .map_err(|(column, problem)| said(k + 1, column, problem.to_string()))?;
        if let Some(column) = bad {
            return Err(said(k + 1, Some(column + 1), "no finite number; leave the row out".to_owned()));
        }
        lines.push(k + 1);
    }
    Ok((columns, lines))
}

#[cfg(test)]
mod tests {
    use super::number_columns;

    #[test]
    fn behaviour_all_ways_of_writing_are_one_table() {
        let want = (vec![vec![40.0, 80.0], vec![0.5, 0.25]], vec![2, 3]);
        for text in [
            "# f, gain\n40 0.5\n80 0.25\n",
            "\u{feff}# f; gain\n40;0,5\n80;0,25\n",
            "# f\tgain\n40\t0,5\n80\t0,25\n",
            "f,gain\r\n40,0.5\r\n80,0.25\r\n",
            "# blanks\n40 0,5\n80 0,25\n",
            "# empty columns and rows of a spreadsheet\n40,0.5,,\n80,0.25,,\n,,,\n",
            "f;gain;;\n40;0,5;;\n80;0,25;;\n;;;\n",
        ] {
            assert_eq!(number_columns(text).unwrap(), want, "{text:?}");
        }
        let (line, said) = number_columns("40 0.5\n80 x\n").unwrap_err();
        assert!(line == 2 && said.contains("column 2") && said.contains('x'), "{said}");
        let (line, said) = number_columns("40 0.5\n80\n").unwrap_err();
        assert!(line == 2 && said.contains('1') && said.contains('2'), "{said}");
        assert_eq!(number_columns("# nothing\n").unwrap().1.len(), 0);
    }
}
