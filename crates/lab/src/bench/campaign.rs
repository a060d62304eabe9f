//! The campaign as a bench needs it: factors in SI units, ambient temperature and day of every point.

use super::error::BenchError;
use rijke_rig::Heading;
use std::collections::BTreeMap;
use std::path::Path;

/// An operating point.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Point {
    pub(crate) id: String,
    pub(crate) day: String,
    /// Stated ambient temperature and its standard deviation, K.
    pub(crate) ambient: [f64; 2],
    /// Factors in SI units; those whose cell is empty are not there.
    pub(crate) factors: BTreeMap<String, f64>,
}

/// Columns that are no factors.
const RESERVED: [&str; 7] = ["point", "row", "repeats", "installation", "day", "T_amb", "T_amb_sd"];

pub(crate) fn read(path: &Path) -> Result<Vec<Point>, BenchError> {
    let text =
        rijke_numerics::read_text(path).map_err(|cause| BenchError::Read { path: path.to_owned(), cause })?;
    parse(&text, path)
}

pub(crate) fn parse(text: &str, path: &Path) -> Result<Vec<Point>, BenchError> {
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .flexible(true)
        .from_reader(text.as_bytes());
    let broken = |cause: csv::Error| BenchError::Csv { path: path.to_owned(), cause };
    let header = reader.headers().map_err(broken)?.clone();
    let line_of = |row: &csv::StringRecord| row.position().map_or(1, |at| at.line() as usize);
    let line = line_of(&header);
    let heading = |cell: &str| {
        Heading::parse(cell).map_err(|cause| BenchError::Unit {
            path: path.to_owned(),
            line,
            column: cell.to_owned(),
            said: cause.to_string(),
        })
    };
    let columns: Vec<Heading> = header.iter().map(heading).collect::<Result<_, _>>()?;
    let find = |name: &str| columns.iter().position(|column| column.name == name);
    let need = |name: &'static str| {
        find(name).ok_or_else(|| BenchError::NoColumn { path: path.to_owned(), column: name })
    };
    let (id, ambient, ambient_sd) = (need("point")?, need("T_amb")?, find("T_amb_sd"));
    let point = |row: csv::StringRecord| {
        let cell = |k: usize| row.get(k).unwrap_or("");
        let number = |k: usize| {
            let Heading { name, unit } = &columns[k];
            let value = cell(k).parse::<f64>().map_err(|_| BenchError::Cell {
                path: path.to_owned(),
                line: line_of(&row),
                column: name.clone(),
                found: cell(k).to_owned(),
            });
            value.map(|value| unit.as_ref().map_or(value, |unit| unit.to_si(value)))
        };
        let is_factor = |k: &usize| !RESERVED.contains(&&*columns[*k].name) && !cell(*k).is_empty();
        let factors = (0..columns.len())
            .filter(is_factor)
            .map(|k| Ok((columns[k].name.clone(), number(k)?)))
            .collect::<Result<_, BenchError>>()?;
        Ok(Point {
            id: cell(id).to_owned(),
            day: find("day").map_or("", cell).to_owned(),
            ambient: [number(ambient)?, ambient_sd.map_or(Ok(0.0), number)?],
            factors,
        })
    };
    reader.records().map(|row| point(row.map_err(broken)?)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(text: &str) -> Result<Vec<Point>, BenchError> {
        parse(text, Path::new("campaign.csv"))
    }

    #[test]
    fn exact_units_and_empty_cells() {
        let text = "# words\npoint,day,x [mm],flow [L/min],T_amb [K],T_amb_sd [K]\na,1,\"120\",60,293,0.2\nb,2,,0,294,0.2\n";
        let found = points(text).unwrap();
        assert!(
            (found[0].factors["x"] - 0.12).abs() < 1e-15 && (found[0].factors["flow"] - 1e-3).abs() < 1e-18
        );
        assert!(
            !found[1].factors.contains_key("x") && found[1].day == "2" && found[1].ambient == [294.0, 0.2]
        );
    }

    #[test]
    fn exact_messages_say_line_and_remedy() {
        let message = |text: &str| points(text).unwrap_err().to_string();
        assert!(
            message("point,x [mile],T_amb [K]\n")
                .contains("campaign.csv:1: column `x [mile]`: `mile` in `mile` is not a unit; known: ")
        );
        assert!(message("point,x\na,1\n").contains("no column `T_amb`"));
        assert!(message("point,x,T_amb\na,far,293\n").contains("campaign.csv:2: column `x` holds `far`"));
    }
}
