//! Tables as CSV text.

use crate::failure::{Classify, Failure};

/// A table as CSV (RFC 4180); the first row has the names of the columns, and all rows have as many cells.
pub(crate) fn csv_table(rows: impl IntoIterator<Item = Vec<String>>) -> Result<String, Failure> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    rows.into_iter().try_for_each(|row| writer.write_record(row)).or_failed()?;
    String::from_utf8(writer.into_inner().or_failed()?).or_failed()
}

/// A row of texts.
pub(crate) fn texts(cells: &[&str]) -> Vec<String> {
    cells.iter().map(|cell| (*cell).to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_cell_with_a_comma_is_one_cell() {
        let rows = [texts(&["name", "p re"]), vec!["m1, upper".to_owned(), 0.5.to_string()]];
        assert_eq!(csv_table(rows).ok().unwrap(), "name,p re\n\"m1, upper\",0.5\n");
        assert!(csv_table([texts(&["a", "b"]), texts(&["1"])]).is_err());
    }
}
