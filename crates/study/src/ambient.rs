//! Ambient temperatures of the points as the records have them: `observations/points.csv`.

use crate::source::{Source, listed};
use crate::{Campaign, StudyError, StudyProblem};
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
        let Some((place, _)) = campaign.point(&point.id) else {
            let line = 1 + source
                .text
                .lines()
                .position(|l| l.split(',').any(|cell| cell.trim() == point.id))
                .unwrap_or(0);
            let known = listed(campaign.points.iter().map(|p| p.id.as_str()));
            return Err(source
                .at_line(line, StudyProblem::Unknown { what: "operating point", name: point.id, known }));
        };
        ambient.extend(point.ambient.map(|t| (place, t)));
    }
    Ok(ambient)
}
