//! A study of one stage: a network file, and one table with factors and measured modes side by side.

use crate::law::words;
use crate::modes::{is_of_modes, parse};
use crate::plan::Plan;
use crate::source::Source;
use crate::{Campaign, Catalogue, Claims, ObservedModes, Rig, Study, StudyError};
use rijke_rig::DataKind;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The one stage: all rows, a model error of growth rates and one of frequencies.
const PLAN: &str = "base = \"rig\"\n\n[[stage]]\nid = \"modes\"\ntitle = \"All modes\"\npoints = {}\n";

/// The files of such a study, as they stand in its folder.
#[derive(Clone, Debug, PartialEq)]
pub struct OneTable {
    /// `rig.toml`.
    pub rig: String,
    /// `campaign.csv`: a point for every row, called by its line.
    pub campaign: String,
    /// `observations/modes.csv`.
    pub modes: String,
    /// `study.toml`.
    pub plan: String,
    files: [PathBuf; 2],
}

impl OneTable {
    /// Reads a network file and a table whose rows are measured modes. Its columns are those of `modes.csv`;
    /// every other column is a factor.
    ///
    /// # Errors
    /// Files that cannot be read; a table whose rows differ in length.
    pub fn read(network: &Path, table: &Path) -> Result<Self, StudyError> {
        let (rig, source) = (Source::read(network)?, Source::read_table(table)?);
        let mut reader = source.table();
        let wrong = |error: csv::Error| source.csv(&error);
        let header = reader.headers().map_err(wrong)?.clone();
        // Points are called by their lines.
        let named = (0..header.len()).filter(|k| &header[*k] != "point");
        let (observed, factors): (Vec<usize>, Vec<usize>) = named.partition(|k| is_of_modes(&header[*k]));
        // Every line stays where it is, so that errors name lines of the one table.
        let top = "\n".repeat(source.header_line() - 1);
        let line = |first: &str, record: &csv::StringRecord, columns: &[usize]| {
            let cells = columns.iter().map(|k| record.get(*k).unwrap_or_default());
            std::iter::once(first).chain(cells).collect::<Vec<_>>().join(",")
        };
        let mut campaign = top.clone() + &line("point", &header, &factors) + "\n";
        let mut modes = top + &line("point", &header, &observed) + "\n";
        for record in reader.records() {
            let record = record.map_err(wrong)?;
            let number = source.line_of(&record);
            for (text, columns) in [(&mut campaign, &factors), (&mut modes, &observed)] {
                let missing = number.saturating_sub(1 + text.lines().count());
                *text += &"\n".repeat(missing);
                *text += &(line(&format!("line-{number}"), &record, columns) + "\n");
            }
        }
        let plan = format!("name = {:?}\n{PLAN}", stem(network));
        let files = [network.to_owned(), table.to_owned()];
        Ok(Self { rig: rig.text, campaign, modes, plan, files })
    }

    /// The study and what was observed.
    ///
    /// # Errors
    /// File, line and remedy; the files are the two that were read.
    pub fn study(&self) -> Result<(Study, ObservedModes), StudyError> {
        let study = self.without_modes()?;
        let table = &self.files[1];
        let modes = parse(&source(table, &self.modes), &study.rig, &study.campaign)?;
        let (kind, source) = (DataKind::Measured, table.display().to_string());
        let modes = modes.into_iter().map(|(_, mode)| mode).collect();
        Ok((study, ObservedModes { kind, source, modes, ambient: BTreeMap::new() }))
    }

    /// Whether the network file has this word, as the name of a factor say.
    #[must_use]
    pub fn names(&self, word: &str) -> bool {
        words(&self.rig).any(|known| known == word)
    }

    fn without_modes(&self) -> Result<Study, StudyError> {
        let [network, table] = &self.files;
        let campaign = Campaign::parse(&source(table, &self.campaign))?;
        let rig = Rig::parse(&source(network, &self.rig), &campaign)?;
        let catalogue = Catalogue::default();
        let plan = Plan::parse(&source(network, &self.plan), &rig, &campaign, &catalogue)?;
        let folder = network.parent().unwrap_or(Path::new("")).to_owned();
        let claims = Claims::default();
        Ok(Study { folder, rig, campaign, catalogue, plan, claims, foreseen: BTreeMap::new() })
    }
}

impl Study {
    /// A rig at one operating point without factors and without candidates.
    ///
    /// # Errors
    /// File, line and remedy.
    pub fn of_rig(file: &Path) -> Result<Self, StudyError> {
        let rig = Source::read(file)?.text;
        let plan = format!("name = {:?}\n{PLAN}", stem(file));
        let files = [file.to_owned(), file.to_owned()];
        let (campaign, modes) = ("point\nrig\n".to_owned(), String::new());
        OneTable { rig, campaign, modes, plan, files }.without_modes()
    }
}

fn source(file: &Path, text: &str) -> Source {
    Source { file: file.display().to_string(), text: text.to_owned() }
}

fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files(name: &str, network: &str, table: &str) -> [PathBuf; 2] {
        let folder = std::env::temp_dir().join(format!("rijke-one-table-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let paths = ["rig.toml", "modes.csv"].map(|f| folder.join(f));
        std::fs::write(&paths[0], network).unwrap();
        std::fs::write(&paths[1], table).unwrap();
        paths
    }

    const TUBE: &str = "name = \"tube\"\n[upstream]\ntype = \"closed\"\n[downstream]\ntype = \"open\"\n\
                        [[element]]\ntype = \"duct\"\nlength = \"L0\"\ndiameter = 0.05\n";

    #[test]
    fn exact_a_table_is_split_into_factors_and_modes() {
        let table = "# measured\n\nL0 [mm],growth_rate,growth_rate_sd,frequency [Hz],frequency_sd [Hz]\n\
                     800,-3,0.5,107,0.1\n\n# again\n900,-4,0.5,95,0.1\n";
        let [network, table] = files("split", TUBE, table);
        let one = OneTable::read(&network, &table).unwrap();
        let (study, observations) = one.study().unwrap();
        let points: Vec<_> = study.campaign.points.iter().map(|p| (p.id.as_str(), p.factors[0])).collect();
        assert_eq!(points, [("line-4", 0.8), ("line-7", 0.9)]);
        assert_eq!(observations.modes.len(), 2);
        assert_eq!(observations.modes[1].growth_rate, Some(-4.0));
        assert_eq!(study.plan.stages.len(), 1);
    }

    #[test]
    fn message_errors_name_the_line_of_the_one_table() {
        let table = "# measured\n\nL0 [mm],growth_rate,growth_rate_sd,frequency [Hz],frequency_sd [Hz]\n\
                     800,-3,0.5,107,0.1\n\n# again\n900,-4,0.5,fast,0.1\n";
        let [network, table] = files("message", TUBE, table);
        let error = OneTable::read(&network, &table).unwrap().study().unwrap_err().to_string();
        assert!(error.contains("modes.csv, line 7: `frequency [Hz]` is `fast`"), "{error}");
    }
}
