//! The campaign as a bench needs it: factors in SI units, ambient temperature and day of every point.

use super::error::BenchError;
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

/// Units of factors, and what one of each is in SI units.
const UNITS: [(&str, f64); 14] = [
    ("1", 1.0),
    ("m", 1.0),
    ("mm", 1e-3),
    ("cm", 1e-2),
    ("W", 1.0),
    ("kW", 1e3),
    ("L/min", 1e-3 / 60.0),
    ("m^3/s", 1.0),
    ("g/s", 1e-3),
    ("kg/s", 1.0),
    ("m/s", 1.0),
    ("K", 1.0),
    ("Pa", 1.0),
    ("kPa", 1e3),
];

/// Columns that are no factors.
const RESERVED: [&str; 7] = ["point", "row", "repeats", "installation", "day", "T_amb", "T_amb_sd"];

pub(crate) fn read(path: &Path) -> Result<Vec<Point>, BenchError> {
    let text =
        rijke_numerics::read_text(path).map_err(|cause| BenchError::Read { path: path.to_owned(), cause })?;
    parse(&text, path)
}

pub(crate) fn parse(text: &str, path: &Path) -> Result<Vec<Point>, BenchError> {
    let mut lines = (1..).zip(text.lines()).filter(|(_, l)| !l.trim().is_empty() && !l.starts_with('#'));
    let (line, header) = lines.next().unwrap_or((1, ""));
    let columns: Vec<(String, f64)> =
        header.split(',').map(|cell| column(path, line, cell)).collect::<Result<_, _>>()?;
    let find = |name: &str| columns.iter().position(|(known, _)| known == name);
    let need = |name: &'static str| {
        find(name).ok_or_else(|| BenchError::NoColumn { path: path.to_owned(), column: name })
    };
    let (id, ambient, ambient_sd) = (need("point")?, need("T_amb")?, find("T_amb_sd"));
    lines
        .map(|(line, row)| {
            let cells: Vec<&str> = row.split(',').map(str::trim).collect();
            let number = |k: usize| {
                let found = cells.get(k).copied().unwrap_or("");
                found.parse::<f64>().map(|value| value * columns[k].1).map_err(|_| BenchError::Cell {
                    path: path.to_owned(),
                    line,
                    column: columns[k].0.clone(),
                    found: found.to_owned(),
                })
            };
            let factors = (0..columns.len())
                .filter(|k| {
                    !RESERVED.contains(&&*columns[*k].0) && cells.get(*k).is_some_and(|c| !c.is_empty())
                })
                .map(|k| Ok((columns[k].0.clone(), number(k)?)))
                .collect::<Result<_, BenchError>>()?;
            Ok(Point {
                id: cells.get(id).copied().unwrap_or("").to_owned(),
                day: find("day").and_then(|k| cells.get(k)).map_or(String::new(), |day| (*day).to_owned()),
                ambient: [number(ambient)?, ambient_sd.map_or(Ok(0.0), number)?],
                factors,
            })
        })
        .collect()
}

/// Name and factor of unit of a cell of the header: `name` or `name [unit]`.
fn column(path: &Path, line: usize, cell: &str) -> Result<(String, f64), BenchError> {
    let (name, unit) = match cell.trim().split_once('[') {
        Some((name, unit)) => (name.trim(), unit.trim_end_matches(']').trim()),
        None => (cell.trim(), "1"),
    };
    match UNITS.iter().find(|(known, _)| *known == unit) {
        Some((_, size)) => Ok((name.to_owned(), *size)),
        None => Err(BenchError::Unit {
            path: path.to_owned(),
            line,
            column: cell.trim().to_owned(),
            known: UNITS.map(|(name, _)| name).join(", "),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(text: &str) -> Result<Vec<Point>, BenchError> {
        parse(text, Path::new("campaign.csv"))
    }

    #[test]
    fn exact_units_and_empty_cells() {
        let text = "# words\npoint,day,x [mm],flow [L/min],T_amb [K],T_amb_sd [K]\na,1,120,60,293,0.2\nb,2,,0,294,0.2\n";
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
            message("point,x [mile],T_amb [K]\n").contains("campaign.csv:1: the unit of column `x [mile]`")
        );
        assert!(message("point,x\na,1\n").contains("no column `T_amb`"));
        assert!(message("point,x,T_amb\na,far,293\n").contains("campaign.csv:2: column `x` holds `far`"));
    }
}
