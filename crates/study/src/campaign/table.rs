//! `campaign.csv`: a row for every operating point.

use super::points::{Campaign, Point};
use super::row::{Cell, Row, checked, column, factors};
use crate::source::Source;
use crate::{StudyError, StudyProblem};

/// The campaign of a table.
pub(super) fn parse(source: &Source) -> Result<Campaign, StudyError> {
    let mut reader = source.table();
    let wrong = |error: csv::Error| source.csv(&error);
    let header = reader.headers().map_err(wrong)?.clone();
    let top = source.header_line();
    let fail = |problem| source.at_line(top, problem);
    let columns = header.iter().map(|text| column(text).map_err(fail)).collect::<Result<Vec<_>, _>>()?;
    let has = |name: &str| columns.iter().any(|c| c.name == name);
    checked(&columns, has).map_err(fail)?;
    if !has("point") {
        let need = "give every operating point a name in a column `point`";
        return Err(fail(StudyProblem::Missing { key: "point".into(), need }));
    }
    let factors = factors(&columns);
    let mut points: Vec<Point> = Vec::new();
    for record in reader.records() {
        let record = record.map_err(wrong)?;
        let line = source.line_of(&record);
        let cells = record.iter().map(|text| Cell::Text(text.to_owned())).zip(&columns).collect();
        let point = Row { cells }.point(&factors).map_err(|problem| source.at_line(line, problem))?;
        if points.iter().any(|p| p.id == point.id) {
            return Err(source.at_line(line, StudyProblem::Duplicate { what: "point", name: point.id }));
        }
        points.push(point);
    }
    if points.is_empty() {
        return Err(fail(StudyProblem::Empty { what: "operating point", need: "add a row" }));
    }
    Ok(Campaign { factors, points, file: "campaign.csv".into() })
}
