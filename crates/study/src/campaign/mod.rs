//! The campaign: operating points with any factors, from a table or from TOML.

mod document;
mod points;
mod row;
mod table;

pub use points::{Campaign, Factor, Point, unit_behind};
pub use row::SURROUNDINGS;
pub(crate) use row::{COLDEST, RESERVED, si_text};

use crate::source::Source;
use crate::{StudyError, StudyProblem};
use std::path::Path;

impl Campaign {
    /// Reads the campaign of a study's folder: `campaign.csv`, or `campaign.toml`.
    ///
    /// # Errors
    /// File, line and remedy; both are there.
    pub fn of(folder: &Path) -> Result<Self, StudyError> {
        let [table, document] = ["campaign.csv", "campaign.toml"].map(|file| folder.join(file));
        match (table.exists(), document.exists()) {
            (true, true) => {
                let text = "stands beside campaign.csv; keep one of the two";
                let problem = Box::new(StudyProblem::Toml(text.into()));
                Err(StudyError { file: document.display().to_string(), line: None, problem })
            }
            (false, true) => document::parse(&Source::read(&document)?),
            _ => Self::read(&table),
        }
    }

    /// Reads a table of operating points.
    ///
    /// # Errors
    /// File, line and remedy.
    pub fn read(path: &Path) -> Result<Self, StudyError> {
        Self::parse(&Source::read_table(path)?)
    }

    pub(crate) fn parse(source: &Source) -> Result<Self, StudyError> {
        table::parse(source)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Campaign, StudyError> {
        table::parse(&Source { file: "campaign.csv".into(), text: text.to_owned() })
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
        let of_a_factor = message("point,x [m],x_sd [s]\na,1,2\n");
        assert!(
            of_a_factor.starts_with("campaign.csv, line 1: `x_sd` is in s and `x` in m"),
            "{of_a_factor}"
        );
        let negative = message("point,x [m],x_sd [mm]\na,1,-2\n");
        assert!(negative.starts_with("campaign.csv, line 2: `x_sd` is `-0.002`"), "{negative}");
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

    #[test]
    fn message_nan_is_no_empty_cell() {
        let message = |text: &str| parse(text).unwrap_err().to_string();
        let number = message("point,x [m]\na,1\nb,nan\n");
        assert!(
            number.starts_with("campaign.csv, line 3: `x` is `nan`, but must be a finite number"),
            "{number}"
        );
        let label = message("point,x [m],day\na,1,\nb,2,NaN\n");
        assert!(label.starts_with("campaign.csv, line 3: `day` is `NaN`, but must be a label"), "{label}");
        assert!(message("point,T_amb [K]\na,NaN\n").contains("or empty"));
    }

    fn document(text: &str) -> Result<Campaign, StudyError> {
        document::parse(&Source { file: "campaign.toml".into(), text: text.to_owned() })
    }

    #[test]
    fn exact_a_document_is_the_campaign_of_its_table() {
        let table = parse(
            "point,row,x_g [mm],flow [L/min],gauze,repeats,day,T_amb [degC],T_amb_sd [K]\n\
             a-1,cold,120,6,true,20,1,20,0.2\nb,hot,,0,0,20,2024-05-01,21.5,0.2\n",
        );
        let text = "[units]\nx_g = \"mm\"\nflow = \"L/min\"\ngauze = \"\"\nT_amb = \"degC\"\n\
                    [defaults]\nrepeats = 20\nT_amb_sd = \"0.2 K\"\nflow = 0\n\
                    [[point]]\nid = \"a-1\"\nrow = \"cold\"\nx_g = \"120 mm\"\nflow = \"6 L/min\"\ngauze = true\nday = 1\n\
                    T_amb = \"293.15 K\"\n\
                    [[point]]\nid = \"b\"\nrow = \"hot\"\ngauze = false\nday = 2024-05-01\nT_amb = 21.5\n";
        let (table, document) = (table.unwrap(), document(text).unwrap());
        assert_eq!(document.factors.len(), 3);
        assert_eq!(document.file, "campaign.toml");
        // NaN is no equal of itself.
        assert_eq!(
            format!("{:?} {:?}", document.points, document.factors),
            format!("{:?} {:?}", table.points, table.factors)
        );
    }

    #[test]
    fn message_of_wrong_documents_names_line_and_remedy() {
        let head = "[units]\nx = \"m\"\n[defaults]\nx = 1\n";
        let message = |text: &str| document(&format!("{head}{text}")).unwrap_err().to_string();
        for (text, said) in [
            (
                "[[point]]\nid = \"a\"\ny = 2\n",
                "line 7: there is no factor (factors stand in [units], each with its unit) called `y`",
            ),
            ("[[point]]\nid = \"a\"\nT_abm = 2\n", "line 7: there is no factor"),
            ("[[point]]\nid = \"a\"\n[[point]]\nx = 2\nid = \"a\"\n", "line 9: a second point is called `a`"),
            (
                "[[point]]\nid = \"a\"\n[[point]]\nx = 2\n",
                "line 7: `id` is missing; give every [[point]] a name",
            ),
            ("[[point]]\nid = \"a\"\nx = \"2 s\"\n", "line 7: `x`: "),
            ("[[point]]\nid = \"a\"\nx = \"2 furlong\"\n", "line 7: `x`: "),
            ("[[point]]\nid = \"a\"\nx = nan\n", "line 7: `x` is `NaN`, but must be a finite number"),
            ("[[point]]\nid = \"a\"\nx = [1]\n", "line 7: `x` is `[1]`, but must be a number, a quantity"),
            ("[[point]]\nid = \"a\"\nrepeats = 1.5\n", "line 7: `repeats` is `1.5`"),
            ("[[point]]\nid = \"a\"\nT_amb = 20\n", "line 7: `T_amb` is `20 K`"),
            ("[[point]]\nid = \"a/b\"\n", "line 6: "),
            ("[[points]]\nid = \"a\"\n", "there is no key `points`; did you mean `point`?"),
            ("", "line 1: there is no operating point; add a table [[point]]"),
        ] {
            let found = message(text);
            assert!(found.starts_with("campaign.toml, line ") && found.contains(said), "{text}\n{found}");
        }
        let wrong = |text: &str| document(text).unwrap_err().to_string();
        let unit = wrong("[units]\nx = \"m\"\ny = \"furlong\"\n[[point]]\nid = \"a\"\n");
        assert!(unit.starts_with("campaign.toml, line 3: ") && unit.contains("furlong"), "{unit}");
        let id = wrong("[defaults]\nid = \"a\"\n[[point]]\nid = \"b\"\n");
        assert!(id.starts_with("campaign.toml, line 2: "), "{id}");
        let sd = wrong("[units]\nx = \"m\"\nx_sd = \"s\"\n[[point]]\nid = \"a\"\n");
        assert!(sd.contains("`x_sd` is in s"), "{sd}");
        let alone = wrong("[defaults]\nT_amb_sd = 0.2\n[[point]]\nid = \"a\"\n");
        assert!(alone.contains("`T_amb` is missing"), "{alone}");
    }

    #[test]
    fn message_two_files_of_one_campaign_are_refused() {
        let folder = std::env::temp_dir().join(format!("rijke-two-campaigns-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("campaign.csv"), "point\na\n").unwrap();
        assert_eq!(Campaign::of(&folder).unwrap().file, "campaign.csv");
        std::fs::write(folder.join("campaign.toml"), "[[point]]\nid = \"a\"\n").unwrap();
        let both = Campaign::of(&folder).unwrap_err().to_string();
        assert!(both.contains("campaign.toml: stands beside campaign.csv"), "{both}");
        std::fs::remove_file(folder.join("campaign.csv")).unwrap();
        assert_eq!(Campaign::of(&folder).unwrap().file, "campaign.toml");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
