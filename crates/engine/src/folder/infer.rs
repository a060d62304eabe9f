//! Unknown numbers of network files from one table of measured modes, and which file explains them best: a
//! study of one stage for each file.

use super::study::{doubts_of, of_the_engine, warn_of_copies};
use crate::run::{EvidenceRecord, MeasuredRecord, ModelRecord, Run, StageRecord, Trusted};
use crate::{EngineError, SavedModel};
use rijke_network::file::{ElementProblem, FileError, read};
use rijke_numerics::{Classify, Failed, Tell, write_within};
use rijke_study::{ObservedModes, OneTable, Study, filled_rig};
use serde_json::json;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

/// A network file and what was inferred of it.
pub struct InferredNetwork {
    /// The file.
    pub file: PathBuf,
    /// The stage.
    pub stage: StageRecord,
    /// Of its model.
    pub evidence: EvidenceRecord,
    table: OneTable,
    study: Study,
    saved: SavedModel,
}

/// Infers the unknowns of every file, best first. Files of which nothing could be inferred are told, if
/// another could.
///
/// # Errors
/// File, line and remedy; a search that does not end, if none did.
pub fn infer_networks(
    files: &[PathBuf],
    data: &Path,
    trusted: Trusted,
    tell: &dyn Tell,
) -> Result<Vec<InferredNetwork>, Failed> {
    // All files are read before the first is trained.
    let read = |file: &PathBuf| {
        let table = OneTable::read(file, data).or_bad_input().map_err(|failure| {
            if !file.is_file() {
                failure.remedy("Name a network file; docs/network-file.md shows one.")
            } else if !data.is_file() {
                failure.remedy("Name the table of measured modes, a CSV file.")
            } else {
                failure
            }
        })?;
        let (study, observations) = table.study().or_bad_input()?;
        if study.rig.own.parameters.is_empty() {
            return Err(Failed::bad_input("has no unknown").at(file).remedy(
                "Write \"$name\" in the place of a number, and give [unknown.name] with prior = { normal = { mean = ..., sd = ... } }.",
            ));
        }
        Ok((file.clone(), table, study, observations))
    };
    let studies = files.iter().map(read).collect::<Result<Vec<_>, Failed>>()?;
    for (file, _, study, _) in &studies {
        // What is doubtful about a rig is said of the file that describes it.
        let of_the_file = |said: String| match said.strip_prefix("rig.toml: ") {
            Some(said) => format!("{}: {said}", file.display()),
            None => said,
        };
        tell.warn(&doubts_of(study).into_iter().map(of_the_file).collect::<Vec<_>>());
    }
    if let Some((_, _, study, observations)) = studies.first() {
        warn_of_copies(study, observations, tell);
        let names = study.campaign.factors.iter().map(|f| f.name.as_str());
        let nowhere = |name: &&str| !studies.iter().any(|(_, table, ..)| table.names(name));
        let unused: Vec<&str> = names.filter(nowhere).collect();
        if !unused.is_empty() {
            return Err(Failed::bad_input(format!("no network file names the column `{}`", unused.join("`, `")))
                .at(data)
                .remedy(
                    "A column is a factor that a network file names, or a measured number: growth_rate, frequency [Hz] or angular_frequency, each with \
                     _sd, and mode, day, T_amb. Write it so, or take the column out.",
                ));
        }
    }
    let progress = tell.progress("networks", studies.len() as u64);
    let (mut found, mut without) = (Vec::new(), Vec::new());
    for (file, table, study, observations) in studies {
        match InferredNetwork::train(&file, table, study, &observations, trusted, data) {
            Ok(network) => found.push(network),
            Err(failure) => without.push(failure),
        }
        progress(1);
    }
    drop(progress);
    if found.is_empty()
        && let Some(failure) = without.pop()
    {
        return Err(failure);
    }
    without.iter().for_each(|failure| tell.note(format!("no evidence: {failure}")));
    found.sort_by(|a, b| b.evidence.ln_marginal.total_cmp(&a.evidence.ln_marginal));
    Ok(found)
}

impl InferredNetwork {
    fn train(
        file: &Path,
        table: OneTable,
        study: Study,
        observations: &ObservedModes,
        trusted: Trusted,
        data: &Path,
    ) -> Result<Self, Failed> {
        // Points are called by their lines.
        let wrong = |e: EngineError| match e.point().and_then(|p| p.strip_prefix("line-")) {
            Some(line) => Failed::bad_input(format!("{}, line {line}: {e}", data.display()))
                .remedy(format!("Correct that row, or {} where it uses its numbers.", file.display())),
            None => of_the_engine(&e, file),
        };
        let mut run = Run::new(study.clone(), observations, trusted).map_err(wrong)?;
        let stage = run.next_stage().map_err(wrong)?;
        let stage = stage.ok_or_else(|| Failed::of_work("no stage was run").at(file))?;
        let Some(evidence) = stage.models[0].evidence else {
            let why = stage.models[0].remark.clone().unwrap_or_default();
            return Err(Failed::of_work(format!("the most probable unknowns were not found: {why}"))
                .at(file)
                .remedy("Give priors nearer to the truth, or fewer unknowns."));
        };
        let saved = run.saved("modes").map_err(wrong)?;
        Ok(Self { file: file.to_owned(), stage, evidence, table, study, saved })
    }

    /// The model.
    pub fn model(&self) -> &ModelRecord {
        &self.stage.models[0]
    }

    /// All of it as JSON.
    pub fn json(&self) -> serde_json::Value {
        let (e, model) = (self.evidence, self.model());
        let [growth, frequency, pressure] = model.misfit;
        let unknowns = model.parameters.iter();
        let unknowns =
            unknowns.map(|p| json!({ "name": p.name, "unit": p.unit, "value": p.value, "sd": p.sd }));
        json!({
            "file": self.file, "ln_best_fit": e.ln_best_fit, "ln_occam": e.ln_occam, "ln_marginal": e.ln_marginal,
            "unknowns": unknowns.collect::<Vec<_>>(),
            "model_error": { "growth_rate": growth, "frequency_hz": frequency / TAU, "pressure": pressure },
            "covariance": self.covariance(),
            "residuals": self.residuals(),
            "remark": Some(self.remarks().join("\n")).filter(|all| !all.is_empty()),
        })
    }

    /// What there is to say against it, a sentence each: what it misses, numbers that no network has, and
    /// what training says.
    pub fn remarks(&self) -> Vec<String> {
        let trained = self.model().remarks().map(str::to_owned);
        self.stage.missed.clone().into_iter().chain(self.impossible()).chain(trained).collect()
    }

    /// A number of the fitted network that no network can have.
    fn impossible(&self) -> Option<String> {
        let Err(FileError::Element { place, problem, .. }) = read(&self.fitted().ok()?) else { return None };
        use ElementProblem::{Angle, HoleTooWide, Negative, NotPositive, Part};
        matches!(problem, Angle { .. } | HoleTooWide { .. } | Negative { .. } | NotPositive { .. } | Part { .. })
            .then(|| {
                format!(
                    "no network has the most probable numbers: {place}: {problem}; give a prior on values that can be, or look for what the model lacks"
                )
            })
    }

    /// Names of what was inferred, in the order of rows and columns, and the covariance.
    fn covariance(&self) -> Option<serde_json::Value> {
        let known = self.saved.posterior().ok()?.gaussian;
        let n = known.names.len();
        let rows: Vec<Vec<f64>> =
            (0..n).map(|i| (0..n).map(|j| known.covariance[(i, j)]).collect()).collect();
        Some(json!({ "names": known.names, "rows": rows }))
    }

    /// Measured less predicted, for every row of the table, by its line.
    fn residuals(&self) -> Vec<serde_json::Value> {
        let less = |measured: Option<[f64; 2]>, predicted: f64| measured.map(|m| m[0] - predicted);
        let of = |(m, p): (&MeasuredRecord, &[f64; 2])| {
            let omega = less(m.angular_frequency, p[1]);
            json!({
                "row": m.point, "mode": m.mode, "growth_rate": less(m.growth_rate, p[0]),
                "frequency_hz": omega.map(|omega| omega / TAU),
            })
        };
        self.stage.measured.iter().zip(self.model().shown()).map(of).collect()
    }

    /// Writes the files of a study of one stage.
    pub fn write_study(&self, folder: &Path) -> Result<(), Failed> {
        let origin = "kind = \"measured\"\nsource = \"the table of `rijke infer`\"\n";
        let files = [
            ("rig.toml", self.table.rig.as_str()),
            ("campaign.csv", &self.table.campaign),
            ("study.toml", &self.table.plan),
            ("observations/modes.csv", &self.table.modes),
            ("observations/observations.toml", origin),
        ];
        files.iter().try_for_each(|(name, text)| write_within(folder, name, text))
    }

    /// The network file with numbers in the place of unknowns and factors, these as in the row whose mode
    /// grows most by the model: of an oscillation that limits itself no growth rate is measured.
    ///
    /// # Errors
    /// A name that is neither.
    pub fn fitted(&self) -> Result<String, Failed> {
        let measured = &self.stage.measured;
        let predicted = self.model().predicted.iter().map(|[growth, _]| growth).enumerate();
        let row = predicted.max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(row, _)| row);
        let factors = self.study.campaign.factors.iter().zip(&measured[row].factors);
        let mut numbers: Vec<(&str, f64)> =
            self.model().parameters.iter().map(|p| (p.name.as_str(), p.value)).collect();
        numbers.extend(factors.filter_map(|(f, v)| Some((f.name.as_str(), (*v)?))));
        filled_rig(&self.table.rig, &numbers).or_failed()
    }
}
