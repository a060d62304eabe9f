//! The campaign: which operating points were measured, and how often (Table 1 of the paper).

use super::point::TubePoint;
use super::ramp::Ramp;
use rijke_rig::files::{in_range, parse_toml, read_text};
use rijke_rig::{Problem, RigError};
use serde::Deserialize;
use std::path::Path;

/// All operating points of a campaign, in the order of its file.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct TubeCampaign {
    /// What the campaign is called in reports.
    pub name: String,
    /// The operating points.
    pub points: Vec<TubePoint>,
    /// The runs in which points were measured before the flow had settled.
    pub ramps: Vec<Ramp>,
}

/// A campaign file as written by hand.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CampaignFile {
    name: String,
    #[serde(default, rename = "source")]
    _source: String,
    #[serde(default)]
    ramps: Option<String>,
    #[serde(default)]
    row: Vec<Row>,
}

/// One row of the table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    id: String,
    plates: bool,
    thermometers: bool,
    power_w: f64,
    repeats: u32,
    #[serde(default)]
    empty_tube: bool,
    #[serde(default)]
    positions_cm: Vec<f64>,
}

impl TubeCampaign {
    /// Reads and validates a campaign file (TOML, one `[[row]]` per row of the paper's Table 1), and the file
    /// of ramps that it may name.
    ///
    /// # Errors
    /// The file, the line or key, and the remedy.
    pub fn read(path: &Path) -> Result<Self, RigError> {
        Self::parse(&read_text(path)?, path)
    }

    /// The campaign of the paper's Table 1: 175 operating points, 40 repeats each.
    #[must_use]
    #[allow(clippy::expect_used, reason = "the text is part of the program and a test parses it")]
    pub fn juniper_yoko_2022() -> Self {
        let text = include_str!("../../data/campaigns/juniper-yoko-2022.toml");
        Self::parse(text, Path::new("juniper-yoko-2022.toml")).expect("the campaign of the paper is valid")
    }

    /// As [`TubeCampaign::read`], from text; `path` appears in messages only.
    ///
    /// # Errors
    /// As [`TubeCampaign::read`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, RigError> {
        let file: CampaignFile = parse_toml(text, path)?;
        let mut points = Vec::new();
        for (k, row) in file.row.iter().enumerate() {
            let at = |key: &str| format!("row[{k}] `{}`: {key}", row.id);
            let wrong = |(place, problem): (String, Problem)| RigError::invalid(path, place, problem);
            if row.id.is_empty()
                || row.id.len() > 100
                || !row.id.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
            {
                let (text, expected) = (row.id.clone(), "a name of at most 100 letters, digits and _");
                return Err(wrong((at("id"), Problem::BadCell { text, expected })));
            }
            in_range(&at("power_w"), row.power_w, 0.0, 1e6, "W").map_err(wrong)?;
            in_range(&at("repeats"), f64::from(row.repeats), 1.0, 1e4, "").map_err(wrong)?;
            if !row.empty_tube && row.positions_cm.is_empty() {
                let problem = Problem::Empty { need: "one position, or set empty_tube = true" };
                return Err(wrong((at("positions_cm"), problem)));
            }
            if row.empty_tube {
                points.push(row.point(None));
            }
            for (j, &cm) in row.positions_cm.iter().enumerate() {
                in_range(&at(&format!("positions_cm[{j}]")), cm, 0.0, 1e5, "cm").map_err(wrong)?;
                points.push(row.point(Some(cm)));
            }
        }
        let mut campaign = Self { name: file.name, points, ramps: Vec::new() };
        campaign.validate().map_err(|(place, problem)| RigError::invalid(path, place, problem))?;
        if let Some(name) = &file.ramps {
            let known: Vec<&TubePoint> = campaign.points.iter().collect();
            campaign.ramps = Ramp::read(&path.with_file_name(name), &known)?;
        }
        Ok(campaign)
    }

    /// Checks that there is something to measure and that names are distinct.
    ///
    /// # Errors
    /// Place and problem.
    pub fn validate(&self) -> Result<(), (String, Problem)> {
        if self.points.is_empty() {
            return Err(("campaign".into(), Problem::Empty { need: "one [[row]] with one position" }));
        }
        let mut seen = std::collections::BTreeSet::new();
        for point in &self.points {
            if !seen.insert(point.id.as_str()) {
                return Err(("points".into(), Problem::Duplicate { name: point.id.clone() }));
            }
        }
        Ok(())
    }

    /// The campaign as a file: [`TubeCampaign::parse`] gives the same points back, provided that the points
    /// of a row differ only in position and their names follow from it. Its ramps are those of the file
    /// [`Ramp::FILE`] beside it.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut text = format!("name = {}\n", toml::Value::from(self.name.as_str()));
        if !self.ramps.is_empty() {
            text += &format!("ramps = \"{}\"\n", Ramp::FILE);
        }
        for row in self.rows() {
            let points: Vec<_> = self.row(&row).collect();
            let first = points.iter().find(|p| p.position.is_some()).unwrap_or(&points[0]);
            let (plates, thermometers) = (first.plates, first.thermometers);
            let empty = points.iter().any(|p| p.position.is_none());
            let centimetres = |p: &&TubePoint| p.position.map(|x| (x * 1e10).round() / 1e8);
            let positions: Vec<f64> = points.iter().filter_map(centimetres).collect();
            text += &format!(
                "\n[[row]]\nid = \"{row}\"\nplates = {plates}\nthermometers = {thermometers}\n\
                 power_w = {:?}\nrepeats = {}\nempty_tube = {empty}\npositions_cm = {positions:?}\n",
                first.power, first.repeats
            );
        }
        text
    }

    /// The points of one row, in order.
    pub fn row<'a>(&'a self, row: &'a str) -> impl Iterator<Item = &'a TubePoint> {
        self.points.iter().filter(move |point| point.row == row)
    }

    /// The names of the rows, in order.
    #[must_use]
    pub fn rows(&self) -> Vec<String> {
        let mut rows: Vec<String> = self.points.iter().map(|point| point.row.clone()).collect();
        rows.dedup();
        rows
    }
}

impl Row {
    /// The operating point at a position, or of the empty tube.
    fn point(&self, position_cm: Option<f64>) -> TubePoint {
        let suffix = match position_cm {
            None => "E".to_owned(),
            Some(cm) if cm.fract() == 0.0 => format!("{cm:02}"),
            Some(cm) => format!("{cm}"),
        };
        TubePoint {
            id: format!("{}-{suffix}", self.id),
            row: self.id.clone(),
            position: position_cm.map(|cm| cm / 100.0),
            plates: self.plates && position_cm.is_some(),
            thermometers: self.thermometers,
            power: self.power_w,
            repeats: self.repeats,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paper_table_1_has_175_operating_points() {
        let campaign = TubeCampaign::juniper_yoko_2022();
        let count = |row: &str| campaign.row(row).count();
        assert_eq!([count("C1"), count("C2"), count("C3"), count("H0")], [15, 19, 20, 16]);
        let hot = campaign.points.iter().filter(|p| p.power > 0.0).count();
        assert_eq!((hot, campaign.points.len()), (105, 175));
        assert_eq!(campaign.points.iter().map(|p| p.repeats).sum::<u32>(), 7000);
        assert_eq!(campaign.rows().len(), 11);
        let first: Vec<_> = campaign.row("C3").take(2).map(|p| (p.id.as_str(), p.position)).collect();
        assert_eq!(first, [("C3-E", None), ("C3-05", Some(0.05))]);
    }

    #[test]
    fn exact_campaign_survives_a_round_trip() {
        let campaign = TubeCampaign::juniper_yoko_2022();
        assert_eq!(TubeCampaign::parse(&campaign.to_toml(), Path::new("x")).unwrap(), campaign);
    }

    #[test]
    fn exact_messages_of_a_wrong_campaign() {
        let message = |text: &str| TubeCampaign::parse(text, Path::new("c.toml")).unwrap_err().to_string();
        assert_eq!(
            message("name = 'x'"),
            "c.toml: campaign: is empty; give at least one [[row]] with one position"
        );
        let row =
            "name = 'x'\n[[row]]\nid = 'A'\nplates = true\nthermometers = false\npower_w = 0\nrepeats = 4\n";
        assert_eq!(
            message(row),
            "c.toml: row[0] `A`: positions_cm: is empty; give at least one position, or set empty_tube = true"
        );
        let twice = format!("{row}positions_cm = [5, 5]\n");
        assert_eq!(message(&twice), "c.toml: points: `A-05` appears twice; every name must be different");
        let typo = format!("{row}position_cm = [5]\n");
        assert!(message(&typo).starts_with("c.toml:8:1: there is no key `position_cm`; "));
    }
}
