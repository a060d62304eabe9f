//! Tables as HTML and as CSV.

use crate::draw::{html, plain};

/// A table. Cells are labels in the markup of figures; a CSV file gets them plain, with ordinary minus signs.
pub(crate) struct Table {
    /// File name without ending.
    pub(crate) id: &'static str,
    /// What it shows, in full sentences.
    pub(crate) caption: String,
    /// Names of the columns.
    pub(crate) head: Vec<String>,
    /// The rows, each as long as the head.
    pub(crate) rows: Vec<Vec<String>>,
    /// A row to mark.
    pub(crate) marked: Option<usize>,
}

impl Table {
    pub(crate) fn html(&self) -> String {
        let cell = |tag: &str, text: &String| format!("<{tag}>{}</{tag}>", html(text));
        let head: String = self.head.iter().map(|t| cell("th", t)).collect();
        let row = |(i, row): (usize, &Vec<String>)| {
            let class = if self.marked == Some(i) { " class=\"marked\"" } else { "" };
            let cells: String = row.iter().map(|t| cell("td", t)).collect();
            format!("<tr{class}>{cells}</tr>\n")
        };
        let rows: String = self.rows.iter().enumerate().map(row).collect();
        format!("<table><thead><tr>{head}</tr></thead><tbody>\n{rows}</tbody></table>")
    }

    pub(crate) fn csv(&self) -> Result<Vec<u8>, csv::Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        for row in std::iter::once(&self.head).chain(&self.rows) {
            writer.write_record(
                row.iter().map(|t| plain(t).replace('\u{2212}', "-").replace('\u{2013}', "")),
            )?;
        }
        writer.into_inner().map_err(|e| e.into_error().into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_csv_is_plain_numbers() {
        let table = Table {
            id: "t",
            caption: String::new(),
            head: vec!["*s*_{r} / s^{-1}".into(), "what".into()],
            rows: vec![vec!["\u{2212}1.5".into(), "a, b".into()]],
            marked: Some(0),
        };
        assert_eq!(table.csv().unwrap(), b"s_r / s^-1,what\n-1.5,\"a, b\"\n");
        assert!(table.html().contains("<tr class=\"marked\"><td>\u{2212}1.5</td>"));
    }
}
