//! Ambient temperatures of the points as the records have them: `observations/points.csv`.

use crate::source::Source;
use crate::{Campaign, StudyError};
use std::collections::BTreeMap;
use std::path::Path;

/// Reads the ambient temperatures of `points.csv`: columns `point`, `T_amb [unit]`, `T_amb_sd [unit]`.
///
/// # Errors
/// File, line and remedy.
pub(crate) fn read_ambient(
    path: &Path,
    campaign: &Campaign,
) -> Result<BTreeMap<usize, [f64; 2]>, StudyError> {
    let source = Source::read_table(path)?;
    let read = Campaign::parse(&source)?;
    let mut ambient = BTreeMap::new();
    for point in read.points {
        let place = campaign
            .known_point(&point.id)
            .map_err(|problem| source.at_line(line_of_point(&source, &point.id), problem))?;
        ambient.extend(point.ambient.map(|t| (place, t)));
    }
    Ok(ambient)
}

/// Line of the row whose cell below `point` is this.
fn line_of_point(source: &Source, id: &str) -> usize {
    let mut table = source.table();
    let column = table.headers().ok().and_then(|h| h.iter().position(|name| name == "point"));
    let of_it = |record: &csv::StringRecord| column.and_then(|k| record.get(k)) == Some(id);
    let row = table.records().filter_map(Result::ok).find(of_it);
    row.map_or_else(|| source.header_line(), |record| source.line_of(&record))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn message_an_unknown_point_is_named_at_its_own_row() {
        let folder = std::env::temp_dir().join(format!("rijke-ambient-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let [table, points] = ["campaign.csv", "points.csv"].map(|file| folder.join(file));
        std::fs::write(&table, "point\na\nb\n").unwrap();
        std::fs::write(&points, "T_amb [K],T_amb_sd [K],point\n293,0.1,a\n294,0.1,293\n").unwrap();
        let error = read_ambient(&points, &Campaign::read(&table).unwrap()).unwrap_err().to_string();
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(error.contains("points.csv, line 3: ") && error.contains("called `293`"), "{error}");
    }
}
