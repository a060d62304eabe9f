//! The folder of a study, read as a whole.

use crate::ambient::read_ambient;
use crate::base::PointState;
use crate::plan::{Base, Plan};
use crate::source::Source;
use crate::{
    Campaign, Candidate, Catalogue, Claims, ObservedMode, ObservedModes, Rig, StudyError, StudyProblem,
};
use rijke_numerics::read_text;
use rijke_rig::{ChannelErrors, DataKind, RigError};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Table of the points that were passed while the state of the gas changed, among the observations.
const PASSED: &str = "ramps.csv";

/// Everything that a folder says of a rig, of what was measured on it, and of what is asked.
#[derive(Clone, Debug)]
pub struct Study {
    /// The folder.
    pub folder: PathBuf,
    /// The rig.
    pub rig: Rig,
    /// The operating points.
    pub campaign: Campaign,
    /// The candidates.
    pub catalogue: Catalogue,
    /// Stages and questions.
    pub plan: Plan,
    /// What somebody published of it.
    pub claims: Claims,
    /// States of operating points that `base/states.json` does not have.
    pub foreseen: BTreeMap<String, PointState>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Origin {
    kind: DataKind,
    source: String,
}

impl Origin {
    /// Of a file that declares responses as well, which [`Study::responses`] checks.
    fn beside_responses(source: &Source) -> Result<Self, StudyError> {
        #[derive(Deserialize)]
        struct Part {
            kind: DataKind,
            source: String,
        }
        let Part { kind, source } = source.toml()?;
        Ok(Self { kind, source })
    }
}

impl Study {
    /// Reads `rig.toml`, `campaign.csv` or `campaign.toml`, `candidates/*.toml`, `study.toml` and, if there,
    /// `paper.toml`; the observations are read by [`Study::observations`], because a study is checked before
    /// anything is measured.
    ///
    /// # Errors
    /// File, line and remedy.
    pub fn open(folder: &Path) -> Result<Self, StudyError> {
        let campaign = Campaign::of(folder)?;
        let rig = Rig::read(&folder.join("rig.toml"), &campaign)?;
        let catalogue = candidates(&folder.join("candidates"), &rig)?;
        let plan = Plan::read(&folder.join("study.toml"), &rig, &campaign, &catalogue)?;
        let claims = Claims::read(&folder.join("paper.toml"), &plan, &catalogue)?;
        Ok(Self {
            folder: folder.to_owned(),
            rig,
            campaign,
            catalogue,
            plan,
            claims,
            foreseen: BTreeMap::new(),
        })
    }

    /// What is declared and has no effect, each in a sentence with its file: candidates that are part of no
    /// model because no stage and no question names their role, which may be misspelt; noise that counts only
    /// where errors are shared; parts on which no law acts where they are; and errors of tables.
    #[must_use]
    pub fn unused(&self) -> Vec<String> {
        let (named, unused) = self.plan.unused(&self.catalogue);
        let said = |candidate: &Candidate| {
            let (file, line) = self.catalogue.place(&candidate.id).unwrap_or_default();
            format!(
                "{file}, line {line}: candidate `{}` is not used, because no stage and no question names its role `{}`; roles in use: {}",
                candidate.id,
                candidate.role,
                crate::source::listed(named.iter().copied())
            )
        };
        let idle = self.plan.idle_noise(&self.campaign);
        let lawless = self.plan.lawless(&self.rig, &self.campaign, &self.catalogue);
        let tolerated = self.plan.tolerated(&self.catalogue);
        unused.into_iter().map(said).chain(idle).chain(lawless).chain(tolerated).collect()
    }

    /// The factors that count as exact though predictions follow from them, in a sentence; none where each
    /// states its errors.
    #[must_use]
    pub fn taken_as_exact(&self) -> Option<String> {
        let names = self.plan.exact_factors(&self.rig, &self.campaign, &self.catalogue);
        let (has, them) = match names.len() {
            0 => return None,
            1 => ("has no stated error and counts", "it"),
            _ => ("have no stated errors and count", "them"),
        };
        let columns: Vec<String> = names.iter().map(|name| format!("{name}_sd")).collect();
        Some(format!(
            "{} {has} as exact: an error of the instrument that is the same at all points moves the parameters, and residuals need not show it; \
             state {} in the campaign, and name {them} in `common_errors` of study.toml where one instrument was read at all points",
            crate::source::listed(names.iter().copied()),
            crate::source::listed(columns.iter().map(String::as_str))
        ))
    }

    /// What was observed: the rows of `observations/modes.csv`, then those of `pings.csv` as signal
    /// processing writes it. A study that has stages of responses too may lack both: then no mode was
    /// observed.
    ///
    /// # Errors
    /// File, line and remedy; a mode that both tables have; a rig beside the observations that is another.
    /// Points of `ramps.csv` are refused where their states would be taken for settled.
    pub fn observations(&self) -> Result<ObservedModes, StudyError> {
        let folder = self.folder.join("observations");
        self.is_the_rig_of(&folder)?;
        self.knows_states_of(&folder.join(PASSED))?;
        let source = Source::read(&folder.join("observations.toml"))?;
        let responses = !self.plan.responses.is_empty();
        let origin = if responses { Origin::beside_responses(&source) } else { source.toml() }?;
        let [by_hand, processed] = ["modes.csv", "pings.csv"].map(|name| folder.join(name));
        // What is there and no regular file is refused by whoever reads it; so is `pings.csv` where one of
        // the two is needed and neither is there.
        let needed = !responses && !by_hand.exists();
        let tables = [(by_hand, false), (processed, needed)];
        let mut modes: Vec<ObservedMode> = Vec::new();
        for (table, _) in tables.iter().filter(|(table, needed)| *needed || table.exists()) {
            let source = Source::read_table(table)?;
            let found = crate::modes::parse(&source, &self.rig, &self.campaign)?;
            let twice = |m: &ObservedMode| modes.iter().any(|o| o.point == m.point && o.label == m.label);
            if let Some((line, mode)) = found.iter().find(|(_, mode)| twice(mode)) {
                let point = self.campaign.points[mode.point].id.clone();
                return Err(source.at_line(*line, StudyProblem::InBoth { point, mode: mode.label.clone() }));
            }
            modes.extend(self.with_channels(&source, found)?);
        }
        crate::modes::side_by_side(&mut modes, |mode| mode);
        let ambient = self.ambient_of_records(&folder)?;
        Ok(ObservedModes { kind: origin.kind, source: origin.source, modes, ambient })
    }

    /// Ambient temperatures that were read with the records, where `points.csv` has them.
    pub(crate) fn ambient_of_records(&self, folder: &Path) -> Result<BTreeMap<usize, [f64; 2]>, StudyError> {
        let points = folder.join("points.csv");
        if points.exists() { read_ambient(&points, &self.campaign) } else { Ok(BTreeMap::new()) }
    }

    /// Refuses a file of ramps with a point whose state is not inferred.
    fn knows_states_of(&self, path: &Path) -> Result<(), StudyError> {
        if !path.exists() {
            return Ok(());
        }
        let source = Source::read(path)?;
        let wrong = |error: csv::Error| source.csv(&error);
        let mut reader = source.table();
        let column = reader.headers().map_err(wrong)?.iter().position(|name| name == "point");
        for record in reader.records() {
            let record = record.map_err(wrong)?;
            let id = column.and_then(|k| record.get(k)).unwrap_or_default();
            let inferred =
                |p| matches!(&self.plan.base, Base::States(points) if points.holds(&self.campaign, p));
            if self.campaign.point(id).is_some_and(|(_, point)| !inferred(point)) {
                let (key, value) = ("point".to_owned(), id.to_owned());
                let need = "a point whose state study.toml takes from the flow, because it was passed on a ramp: add it to `points` of [base.states], or take it out of the campaign";
                return Err(source.at_line(source.line_of(&record), StudyProblem::Value { key, value, need }));
            }
        }
        Ok(())
    }

    /// Where the readings of thermometers stand: `readings.csv` in the folder, or in `observations/`. None if
    /// they may be missing and are.
    ///
    /// # Errors
    /// Both are there and differ, or there is none and they are `needed`.
    pub fn readings(&self, needed: bool) -> Result<Option<PathBuf>, StudyError> {
        let [here, observed] =
            [self.folder.clone(), self.folder.join("observations")].map(|f| f.join("readings.csv"));
        match (here.exists(), observed.exists()) {
            (false, true) => Ok(Some(observed)),
            (true, true) if read_text(&here).ok() != read_text(&observed).ok() => {
                let text = format!("{} says otherwise; keep one of the two", observed.display());
                let problem = Box::new(StudyProblem::Toml(text));
                Err(StudyError { file: here.display().to_string(), line: None, problem })
            }
            (false, false) if needed => {
                let text = "is missing, and [base.heated-flow] of study.toml needs it; write the readings there, or in \
                            observations/: point, at [m], temperature [K], sd [K]";
                let problem = Box::new(StudyProblem::Toml(text.into()));
                Err(StudyError { file: here.display().to_string(), line: None, problem })
            }
            (false, false) => Ok(None),
            _ => Ok(Some(here)),
        }
    }

    /// What the calibration leaves of the channels, if `observations/channels.toml` says it.
    ///
    /// # Errors
    /// File and remedy.
    pub fn channels(&self) -> Result<Option<ChannelErrors>, StudyError> {
        let path = self.folder.join("observations").join("channels.toml");
        let others = self.rig.microphones.names.len().saturating_sub(1);
        ChannelErrors::read(&path, others).map_err(|error| {
            // The error names the file itself.
            let file = path.display().to_string();
            let (line, text) = match error {
                RigError::Syntax { line, message, .. } => (Some(line), message),
                error => (None, error.to_string()),
            };
            let text = text.strip_prefix(&format!("{file}: ")).unwrap_or(&text).to_owned();
            StudyError { file, line, problem: Box::new(StudyProblem::Toml(text)) }
        })
    }

    /// What is not known of the channels that hear responses: by `observations/channels.toml`, or else by
    /// `gain_sd` and `delay_sd` of the microphones of the rig.
    ///
    /// # Errors
    /// File and remedy.
    pub fn channels_of_responses(&self) -> Result<Option<ChannelErrors>, StudyError> {
        Ok(self.channels()?.or_else(|| self.rig.microphones.channel_errors()))
    }
}

fn candidates(folder: &Path, rig: &Rig) -> Result<Catalogue, StudyError> {
    let mut catalogue = Catalogue::default();
    let Ok(entries) = std::fs::read_dir(folder) else { return Ok(catalogue) };
    let mut files: Vec<PathBuf> = entries.filter_map(|e| Some(e.ok()?.path())).collect();
    files.retain(|f| f.extension().is_some_and(|e| e == "toml"));
    files.sort();
    for file in files {
        catalogue.join(Catalogue::read(&file, rig)?)?;
    }
    extends_what_there_is(&catalogue)?;
    Ok(catalogue)
}

/// Checks that every candidate that extends another extends one that there is: else no model would have it.
fn extends_what_there_is(catalogue: &Catalogue) -> Result<(), StudyError> {
    let of_none = |c: &&Candidate| c.extends.as_ref().is_some_and(|id| catalogue.get(id).is_none());
    let Some(first) = catalogue.candidates().iter().find(of_none) else { return Ok(()) };
    let name = first.extends.clone().unwrap_or_default();
    let known = crate::source::listed(catalogue.candidates().iter().map(|c| c.id.as_str()));
    let (file, line) = catalogue.place(&first.id).unwrap_or_default();
    let problem = Box::new(StudyProblem::Unknown { what: "candidate for `extends`", name, known });
    Err(StudyError { file: file.into(), line: Some(line), problem })
}
