//! The campaign: a table of operating points with any factors.

use crate::names;
use crate::source::{Source, listed};
use crate::{StudyError, StudyProblem};
use rijke_rig::{Day, Heading, Unit};
use std::path::Path;

/// A column of the campaign that is set or measured at every operating point: a position, a power, a load.
#[derive(Clone, Debug, PartialEq)]
pub struct Factor {
    /// Its name, which formulas may use.
    pub name: String,
    /// Its unit in SI, as formulas see it.
    pub unit: String,
    /// Its unit in the file, for axes and tables.
    pub shown: Unit,
    /// Whether the file states a unit; without one a formula may take the factor for any quantity in SI.
    pub stated: bool,
}

impl Factor {
    /// The unit of its numbers as a reader knows it: the file's, where one of it is one in SI, as in W; else
    /// that of formulas.
    #[must_use]
    pub fn unit_in_print(&self) -> String {
        let one = (self.shown.to_si(1.0) - 1.0).abs() < 1e-12 && self.shown.to_si(0.0).abs() < 1e-12;
        match self.unit.as_str() {
            _ if one => self.shown.to_string(),
            // The names that these have.
            "kg m^2 s^-3" => "W".to_owned(),
            "kg m^2 s^-2" => "J".to_owned(),
            "kg m^-1 s^-2" => "Pa".to_owned(),
            "kg m s^-2" => "N".to_owned(),
            base => base.to_owned(),
        }
    }
}

/// One operating point.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Unique name.
    pub id: String,
    /// Label of the series that it belongs to; empty if it has none.
    pub row: String,
    /// Value of every factor, in SI; NaN where it has none.
    pub factors: Vec<f64>,
    /// Points of one installation share one assembly of the rig.
    pub installation: String,
    /// The day, or another label of what its readings share.
    pub day: String,
    /// Number of repeats planned or measured.
    pub repeats: u32,
    /// Ambient temperature and its standard deviation, K.
    pub ambient: Option<[f64; 2]>,
}

/// All operating points, in the order of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Campaign {
    /// The factors, in the order of the columns.
    pub factors: Vec<Factor>,
    /// The points.
    pub points: Vec<Point>,
}

/// Columns with a meaning of their own.
pub(crate) const RESERVED: [&str; 7] =
    ["point", "row", "installation", "day", "repeats", "T_amb", "T_amb_sd"];

/// The lowest and the highest temperature of surroundings, K: what lies beyond is taken for one in another
/// unit.
pub const SURROUNDINGS: [f64; 2] = [COLDEST, 2000.0];
pub(crate) const COLDEST: f64 = 100.0;

/// What stands for the empty cell in tables of other programs.
const EMPTY: [&str; 4] = ["", "-", "nan", "NaN"];

impl Campaign {
    /// Reads `campaign.csv`.
    ///
    /// # Errors
    /// File, line and remedy.
    pub fn read(path: &Path) -> Result<Self, StudyError> {
        Self::parse(&Source::read_table(path)?)
    }

    pub(crate) fn parse(source: &Source) -> Result<Self, StudyError> {
        let mut reader = source.table();
        let wrong = |error: csv::Error| source.csv(&error);
        let header = reader.headers().map_err(wrong)?.clone();
        let top = source.header_line();
        let columns = header
            .iter()
            .map(|text| column(text).map_err(|problem| source.at_line(top, problem)))
            .collect::<Result<Vec<_>, _>>()?;
        for (k, a) in columns.iter().enumerate() {
            if columns[..k].iter().any(|b| b.name == a.name) {
                return Err(
                    source.at_line(top, StudyProblem::Duplicate { what: "column", name: a.name.clone() })
                );
            }
        }
        let has = |name: &str| columns.iter().any(|c| c.name == name);
        if has("T_amb_sd") && !has("T_amb") {
            let need = "a column `T_amb_sd` says how well it is known; correct the name of the column of ambient temperatures, or leave out T_amb_sd";
            return Err(source.at_line(top, StudyProblem::Missing { key: "T_amb".into(), need }));
        }
        let known = |name: &str| columns.iter().any(|c| c.name == name && !RESERVED.contains(&name));
        let of = |c: &Factor| c.name.strip_suffix("_sd").filter(|name| known(name)).map(str::to_owned);
        if let Some(factor) = columns.iter().find_map(of) {
            return Err(source.at_line(top, StudyProblem::SdOfFactor { factor }));
        }
        if !columns.iter().any(|c| c.name == "point") {
            let need = "give every operating point a name in a column `point`";
            return Err(source.at_line(top, StudyProblem::Missing { key: "point".into(), need }));
        }
        let factors: Vec<Factor> =
            columns.iter().filter(|c| !RESERVED.contains(&c.name.as_str())).cloned().collect();
        let mut points: Vec<Point> = Vec::new();
        for record in reader.records() {
            let record = record.map_err(wrong)?;
            let line = source.line_of(&record);
            let row = Row { cells: record.iter().zip(&columns).collect() };
            let point = row.point(&factors).map_err(|problem| source.at_line(line, problem))?;
            if points.iter().any(|p| p.id == point.id) {
                return Err(source.at_line(line, StudyProblem::Duplicate { what: "point", name: point.id }));
            }
            points.push(point);
        }
        if points.is_empty() {
            return Err(
                source.at_line(top, StudyProblem::Empty { what: "operating point", need: "add a row" })
            );
        }
        Ok(Self { factors, points })
    }

    /// The point called `id`.
    #[must_use]
    pub fn point(&self, id: &str) -> Option<(usize, &Point)> {
        self.points.iter().enumerate().find(|(_, p)| p.id == id)
    }

    /// The place of a factor among all.
    #[must_use]
    pub fn factor(&self, name: &str) -> Option<usize> {
        self.factors.iter().position(|f| f.name == name)
    }

    /// As [`Campaign::factor`].
    ///
    /// # Errors
    /// [`StudyProblem::Unknown`] with the factors that there are.
    pub fn known_factor(&self, name: &str) -> Result<usize, StudyProblem> {
        self.factor(name).ok_or_else(|| StudyProblem::Unknown {
            what: "factor",
            name: name.to_owned(),
            known: listed(self.factors.iter().map(|f| f.name.as_str())),
        })
    }

    /// Labels of the series, in order, each once.
    #[must_use]
    pub fn rows(&self) -> Vec<&str> {
        let mut seen = Vec::new();
        for point in &self.points {
            if !seen.contains(&point.row.as_str()) {
                seen.push(point.row.as_str());
            }
        }
        seen
    }
}

fn column(text: &str) -> Result<Factor, StudyProblem> {
    let heading =
        Heading::parse(text).map_err(|source| StudyProblem::Unit { key: text.to_owned(), source })?;
    let name = heading.name.clone();
    let wanted = match name.as_str() {
        "T_amb" | "T_amb_sd" => "K",
        _ => "",
    };
    let is_stated = heading.unit.is_some();
    let stated = heading.unit.clone().unwrap_or_else(Unit::one);
    let unit = if wanted.is_empty() { si_text(&stated) } else { wanted.to_owned() };
    let shown = if wanted.is_empty() {
        stated
    } else {
        heading.of(wanted).map_err(|source| StudyProblem::Unit { key: name.clone(), source })?
    };
    if !RESERVED.contains(&name.as_str()) {
        let good = name.starts_with(|c: char| c.is_alphabetic())
            && name.chars().all(|c| c.is_alphanumeric() || c == '_');
        if !good {
            let why =
                "formulas name it, so that it must start with a letter and have letters, digits and _ only";
            return Err(StudyProblem::Name { what: "factor", name, why });
        }
        names::free(&names::built_in()?, "factor", &name)?;
    }
    Ok(Factor { name, unit, shown, stated: is_stated })
}

/// The cells of a line with their columns.
struct Row<'a> {
    cells: Vec<(&'a str, &'a Factor)>,
}

impl Row<'_> {
    fn cell(&self, name: &str) -> Option<&str> {
        let found = self.cells.iter().find(|(_, column)| column.name == name).map(|(text, _)| *text);
        found.filter(|text| !EMPTY.contains(text))
    }

    /// The number in a column, in SI.
    fn number(&self, name: &str, difference: bool) -> Result<Option<f64>, StudyProblem> {
        let Some((text, column)) = self.cells.iter().find(|(_, c)| c.name == name) else { return Ok(None) };
        if EMPTY.contains(text) {
            return Ok(None);
        }
        let value = match *text {
            "true" | "yes" => 1.0,
            "false" | "no" => 0.0,
            text => {
                text.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(|| StudyProblem::Value {
                    key: name.to_owned(),
                    value: text.to_owned(),
                    need: "a finite number with a decimal point, true, false, or empty",
                })?
            }
        };
        let unit = &column.shown;
        Ok(Some(if difference { unit.difference_to_si(value) } else { unit.to_si(value) }))
    }

    fn point(&self, factors: &[Factor]) -> Result<Point, StudyProblem> {
        let id = self.cell("point").unwrap_or_default().to_owned();
        let good = |c: char| c.is_alphanumeric() || "-_.+".contains(c);
        if id.is_empty() || !id.chars().all(good) {
            let why = "it is also a folder name, so give letters, digits and - _ . +";
            return Err(StudyProblem::Name { what: "point", name: id, why });
        }
        let values = factors
            .iter()
            .map(|f| Ok(self.number(&f.name, false)?.unwrap_or(f64::NAN)))
            .collect::<Result<Vec<_>, StudyProblem>>()?;
        let repeats = self.number("repeats", false)?.unwrap_or(1.0);
        if !(repeats >= 0.0 && repeats.fract() == 0.0 && repeats <= 1e9) {
            let (key, value) = ("repeats".to_owned(), repeats.to_string());
            return Err(StudyProblem::Value { key, value, need: "a whole number of repeats" });
        }
        let ambient = self.number("T_amb", false)?;
        if let Some(t) = ambient.filter(|t| !(SURROUNDINGS[0]..=SURROUNDINGS[1]).contains(t)) {
            let (key, value) = ("T_amb".to_owned(), format!("{t} K"));
            return Err(StudyProblem::Value {
                key,
                value,
                need: "an ambient temperature above 100 K and below 2000 K; say its unit in the heading, as in T_amb [degC]",
            });
        }
        let sd = self.number("T_amb_sd", true)?.unwrap_or(0.0);
        if !(0.0..=Day::LARGEST_SD).contains(&sd) {
            let need = "a standard deviation from 0 to 50 K";
            return Err(StudyProblem::Value { key: "T_amb_sd".into(), value: format!("{sd} K"), need });
        }
        Ok(Point {
            row: self.cell("row").unwrap_or_default().to_owned(),
            installation: self.cell("installation").unwrap_or(&id).to_owned(),
            day: self.cell("day").unwrap_or_default().to_owned(),
            repeats: repeats as u32,
            ambient: ambient.map(|t| [t, sd]),
            factors: values,
            id,
        })
    }
}

/// A unit in base units, as formulas read it: `kg m^2 s^-3`.
pub(crate) fn si_text(unit: &Unit) -> String {
    let names = ["kg", "m", "s", "K", "A", "mol"];
    let parts: Vec<String> = (names.iter().zip(unit.dimension()))
        .filter(|(_, power)| *power != 0)
        .map(|(name, power)| if power == 1 { (*name).to_owned() } else { format!("{name}^{power}") })
        .collect();
    if parts.is_empty() { "1".to_owned() } else { parts.join(" ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Campaign, StudyError> {
        Campaign::parse(&Source { file: "campaign.csv".into(), text: text.to_owned() })
    }

    #[test]
    fn exact_columns_become_factors_in_si() {
        let text = "# a comment\npoint,row,x_g [mm],flow [L/min],gauze,T_amb [degC],T_amb_sd [K]\n\
                    a-1,cold,120,6,true,20,0.2\nb,hot,,0,0,21,0.2\n";
        let campaign = parse(text).unwrap();
        let names: Vec<_> = campaign.factors.iter().map(|f| (f.name.as_str(), f.unit.as_str())).collect();
        assert_eq!(names, [("x_g", "m"), ("flow", "m^3 s^-1"), ("gauze", "1")]);
        let [a, b] = &campaign.points[..] else { panic!("two points") };
        assert!((a.factors[0] - 0.12).abs() < 1e-15 && (a.factors[1] - 1e-4).abs() < 1e-18);
        assert_eq!((a.factors[2], a.installation.as_str()), (1.0, "a-1"));
        assert_eq!(a.ambient.map(|t| t[0]), Some(293.15));
        assert!(b.factors[0].is_nan());
        assert_eq!(campaign.rows(), ["cold", "hot"]);
    }

    #[test]
    fn behaviour_semicolons_and_decimal_commas_are_read() {
        let folder = std::env::temp_dir().join(format!("rijke-semicolons-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join("campaign.csv");
        std::fs::write(&file, "# from a spreadsheet; x, y\npoint;x [mm]\na;120,5\nb;;3\n").unwrap();
        let error = Campaign::read(&file).unwrap_err().to_string();
        assert!(error.contains("line 4"), "{error}");
        std::fs::write(&file, "# from a spreadsheet; x, y\npoint;x [mm]\na;120,5\n").unwrap();
        let x = Campaign::read(&file).unwrap().points[0].factors[0];
        std::fs::write(&file, "point\tx [mm]\na\t120.5\n").unwrap();
        assert_eq!(Campaign::read(&file).unwrap().points[0].factors[0], x);
        assert!((x - 0.1205).abs() < 1e-15, "{x}");
    }

    #[test]
    fn message_of_wrong_campaigns_names_line_and_remedy() {
        let message = |text: &str| parse(text).unwrap_err().to_string();
        assert_eq!(
            message("point,x [m]\na,1\na,2\n"),
            "campaign.csv, line 3: a second point is called `a`; every name must be different"
        );
        let of_a_factor = message("point,x [m],x_sd [mm]\na,1,2\n");
        assert!(of_a_factor.starts_with("campaign.csv, line 1: `x_sd` would be"), "{of_a_factor}");
        assert!(of_a_factor.contains("[unknown.x]"), "{of_a_factor}");
        assert!(message("id,x\na,1\n").starts_with("campaign.csv, line 1: `point` is missing; "));
        assert!(message("point,x [furlong]\na,1\n").contains("furlong"));
        assert!(message("point,x [m]\na,1;2\n").contains("`x` is `1;2`, but must be a finite number"));
        let long = message("point,x [m]\n# a comment\na,1,2\n");
        assert!(
            long.starts_with("campaign.csv, line 3: the row has 3 cells, but the heading has 2"),
            "{long}"
        );
        let alone = message("point,T_abm [K],T_amb_sd [K]\na,293,0.2\n");
        assert!(alone.starts_with("campaign.csv, line 1: `T_amb` is missing"), "{alone}");
        assert!(message("point,T_amb [K]\na,-3\n").contains("above 100 K"));
        assert!(message("point,T_amb [K]\na,20\n").contains("T_amb [degC]"));
        let of_a_symbol = message("point,P [W]\na,20\n");
        assert!(of_a_symbol.starts_with("campaign.csv, line 1: `P`"), "{of_a_symbol}");
        assert!(of_a_symbol.contains("know it as perimeter of the duct"), "{of_a_symbol}");
    }
}
