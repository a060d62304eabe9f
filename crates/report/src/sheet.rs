//! Numbers behind figures and tables as CSV, in full precision.

use crate::ReportError;

/// A CSV file: one header line, a point as decimal mark, units in the headers.
pub(crate) struct Sheet {
    /// File name without ending.
    pub(crate) id: &'static str,
    /// Names of the columns, with units.
    pub(crate) head: Vec<String>,
    /// The rows, each as long as the head.
    pub(crate) rows: Vec<Vec<Cell>>,
}

/// One entry.
pub(crate) enum Cell {
    /// A word.
    Text(String),
    /// A number, written with the fewest digits that give it back.
    Number(f64),
    /// Nothing.
    Empty,
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl Sheet {
    pub(crate) fn csv(&self) -> Result<Vec<u8>, ReportError> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(&self.head)?;
        for row in &self.rows {
            writer.write_record(row.iter().map(|cell| match cell {
                Cell::Text(text) => text.clone(),
                Cell::Number(value) => value.to_string(),
                Cell::Empty => String::new(),
            }))?;
        }
        writer.into_inner().map_err(|e| csv::Error::from(e.into_error()).into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_numbers_survive() {
        let rows = vec![vec![Cell::from("a, b"), Cell::from(-1.0 / 3.0), Cell::Empty]];
        let sheet = Sheet { id: "s", head: ["what", "x_m", "y"].map(String::from).to_vec(), rows };
        assert_eq!(sheet.csv().unwrap(), b"what,x_m,y\n\"a, b\",-0.3333333333333333,\n");
    }
}
