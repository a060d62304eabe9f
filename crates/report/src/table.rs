//! Tables as HTML.

use crate::draw::html;

/// A table. Cells are labels in the markup of figures.
#[derive(Default)]
pub(crate) struct Table {
    /// Anchor on the page.
    pub(crate) id: &'static str,
    /// What it shows, in full sentences.
    pub(crate) caption: String,
    /// Names of the columns.
    pub(crate) head: Vec<String>,
    /// The rows, each as long as the head.
    pub(crate) rows: Vec<Vec<String>>,
    /// A row to mark.
    pub(crate) marked: Option<usize>,
    /// The first row of a second part, which a line sets off.
    pub(crate) line_above: Option<usize>,
    /// Many narrow columns.
    pub(crate) dense: bool,
}

impl Table {
    pub(crate) fn html(&self) -> String {
        let cell = |tag: &str, text: &String| format!("<{tag}>{}</{tag}>", html(text));
        let head: String = self.head.iter().map(|t| cell("th", t)).collect();
        let row = |(i, row): (usize, &Vec<String>)| {
            let classes = [("marked", self.marked), ("line-above", self.line_above)];
            let classes: Vec<_> =
                classes.into_iter().filter(|(_, at)| *at == Some(i)).map(|(c, _)| c).collect();
            let class =
                if classes.is_empty() { String::new() } else { format!(" class=\"{}\"", classes.join(" ")) };
            let cells: String = row.iter().map(|t| cell("td", t)).collect();
            format!("<tr{class}>{cells}</tr>\n")
        };
        let rows: String = self.rows.iter().enumerate().map(row).collect();
        format!("<table><thead><tr>{head}</tr></thead><tbody>\n{rows}</tbody></table>")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_cells_are_labels_and_one_row_is_marked() {
        let table = Table {
            id: "t",
            caption: String::new(),
            head: vec!["*s*_{r} / s^{-1}".into(), "what".into()],
            rows: vec![vec!["\u{2212}1.5".into(), "a, b".into()]],
            marked: Some(0),
            ..Table::default()
        };
        assert!(table.html().contains("<th><i>s</i><sub>r</sub> / s<sup>\u{2212}1</sup></th>"));
        assert!(table.html().contains("<tr class=\"marked\"><td>\u{2212}1.5</td>"));
    }
}
