//! The base flow of the heated tube: from the mean clicks and readings of settled operating points, or from
//! samples over time; and what a study takes of it.

use rijke_flow::assimilate::{self, AssimilationMethod, NamedStates, Records, RunReport};
use rijke_flow::shown::{FlowDocument, settles, unknowns_table, velocity_table};
use rijke_flow::{
    BaseStates, Closures, FlowError, HeatedTube, PROFILES, TubeObservations, TubeRig, read_profiles, settled,
};
use rijke_numerics::{Classify, Failed, StagedFolder, Tell, write_within};
use rijke_rig::{DataKind, files::csv_table};
use rijke_study::{Study, plan::Base};
use std::path::{Path, PathBuf};

/// How the base flow is inferred.
#[derive(Clone, Debug)]
pub struct FlowOptions {
    /// How samples over time are assimilated.
    pub method: AssimilationMethod,
    /// Whether each place of the heat source is a fit of its own.
    pub separate: bool,
    /// Whether filters have the batch fits of the same runs beside them.
    pub beside: bool,
    /// The closures.
    pub closures: Closures,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// A base flow that was inferred.
#[derive(Clone, Debug)]
pub struct InferredFlow {
    /// All that was inferred.
    pub document: FlowDocument,
    /// A state for each operating point.
    pub states: BaseStates,
    /// The batch fits of the same runs, where they were asked for.
    pub beside: Vec<RunReport>,
    /// The observations that they are of; none of samples over time.
    observations: Option<TubeObservations>,
}

/// Samples, of all runs, from which on a filter or the smoother takes long enough to say so.
const MANY_SAMPLES: usize = 1000;

impl Default for FlowOptions {
    fn default() -> Self {
        let (method, closures) = (AssimilationMethod::Batch, Closures::default());
        Self { method, separate: false, beside: false, closures, seed: 1 }
    }
}

/// Whether a study wants states that are inferred, and has the observations of which they can be.
pub fn flow_is_due(study: &Study) -> bool {
    let observations = study.folder.join("observations");
    matches!(study.plan.base, Base::States(_))
        && ["pings.csv", HeatedTube::FILE].iter().all(|file| observations.join(file).exists())
}

impl InferredFlow {
    /// Infers it from observations in `dir`, or in `dir/observations`, or from samples over time in `dir`.
    pub fn infer(dir: &Path, options: &FlowOptions, tell: &dyn Tell) -> Result<Self, Failed> {
        let below = dir.join("observations");
        let settled = if below.is_dir() { below } else { dir.to_owned() };
        let is_settled = settled.join("observations.toml").is_file();
        let mut flow = if is_settled && !dir.join("flow.toml").is_file() {
            Self::of_observations(&settled, options, tell)?
        } else {
            Self::over_time(dir, options, tell)?
        };
        if is_settled {
            flow.observations = TubeObservations::read(&settled).ok();
        }
        Ok(flow)
    }

    /// When the flow of each ramp is settled, in words.
    pub fn settling(&self) -> Vec<String> {
        self.document.runs.iter().flat_map(|run| &run.settling).map(settles).collect()
    }

    /// Writes states, numbers and tables into the folder `out`; `beside` writes what else belongs there.
    ///
    /// # Errors
    /// The system's, and those of `beside`.
    pub fn write(
        &self,
        out: &Path,
        force: bool,
        beside: &dyn Fn(&Path) -> Result<(), Failed>,
        tell: &dyn Tell,
    ) -> Result<(), Failed> {
        let staged = StagedFolder::new(out, "flow.json", force)?;
        tell.after_killed_run(&staged);
        let folder = staged.path();
        self.states.write(&folder.join(BaseStates::FILE)).or_failed()?;
        if let Some(observations) = &self.observations {
            let file = self.states.for_laws(observations);
            write_within(folder, "states.json", serde_json::to_string(&file).or_failed()? + "\n")?;
        }
        let document = &self.document;
        write_within(folder, "flow.json", serde_json::to_string_pretty(document).or_failed()? + "\n")?;
        write_within(folder, "unknowns.csv", csv_table(unknowns_table(&document.runs))?)?;
        write_within(folder, "velocity.csv", csv_table(velocity_table(&document.runs))?)?;
        beside(folder)?;
        staged.commit()
    }

    /// From the mean clicks of settled operating points.
    fn of_observations(folder: &Path, options: &FlowOptions, tell: &dyn Tell) -> Result<Self, Failed> {
        if !folder.join("rig.toml").is_file() {
            let remedy = "`rijke flow` needs the rig.toml that `rijke process` writes beside the observations of a heated tube. A study with \
                [base.heated-flow] or [base.measured] needs none: `rijke rank` infers its gas from the readings.";
            return Err(Failed::bad_input("there is no rig.toml beside these observations")
                .at(folder)
                .remedy(remedy));
        }
        let observations = TubeObservations::read(folder).or_bad_input()?;
        if folder.join(PROFILES).is_file() {
            let states = read_profiles(folder, &observations).or_bad_input()?;
            let (kind, rig) = (states.kind, observations.rig.name);
            let document = FlowDocument { kind, rig, seed: options.seed, runs: Vec::new() };
            tell.say(format!(
                "the base flow of {} operating points is that of {PROFILES}",
                states.points.len()
            ));
            return Ok(Self { document, states, beside: Vec::new(), observations: None });
        }
        let (file, readings) = readings(folder, &observations)?;
        let runs = settled::heated(&observations, &readings, &options.closures);
        let runs = runs.or_bad_input().map_err(|f| f.at(folder))?;
        if runs.is_empty() {
            let message = "no heated operating point with clicks or readings, so there is no flow to infer";
            let remedy = "Process the clicks of points with power, write temperatures or speeds of sound into readings.csv beside the \
                observations, or give a record over time with flow.toml. Before anything is heated, `rijke rank DIR --until STAGE` trains the \
                stages at rest.";
            return Err(Failed::bad_input(message).at(folder).remedy(remedy));
        }
        let progress = tell.progress("places of the heat source", runs.len() as u64);
        let found = settled::infer(&runs, options.separate, &*progress);
        drop(progress);
        let (reports, states) = found.map_err(|error| match error {
            FlowError::FarOff { file: name, .. } => {
                let place = if name == settled::Readings::FILE { file.clone() } else { folder.join(name) };
                Failed::bad_input(error).at(&place).remedy(
                    "Compare the readings and their units with tube.toml (gas, length, places of microphones) and with the ambient temperatures of points.csv.",
                )
            }
            _ => blame(error).at(folder),
        })?;
        let TubeObservations { kind, rig, source, .. } = &observations;
        Ok(Self::of(*kind, rig, source.clone(), options, reports, states))
    }

    /// From samples over time.
    fn over_time(dir: &Path, options: &FlowOptions, tell: &dyn Tell) -> Result<Self, Failed> {
        if !dir.is_dir() {
            return Err(Failed::bad_input("there is no such folder")
                .at(dir)
                .remedy("Name a folder of observations or of a record over time."));
        }
        let records = Records::read(dir).map_err(|error| {
            let remedy = match error {
                FlowError::InLine { .. } | FlowError::InRun { .. } => "Correct the file. Samples lie at equal intervals, so none can be left out.",
                _ => "`rijke process` makes observations of records; `rijke flow --twin --out DIR` writes a record over time.",
            };
            Failed::bad_input(error).remedy(remedy)
        })?;
        let FlowOptions { method, beside, ref closures, seed, .. } = *options;
        let samples: usize = records.runs.iter().map(|(_, run)| run.samples.len()).sum();
        if !matches!(method, AssimilationMethod::Batch) && samples > MANY_SAMPLES {
            tell.note(format!(
                "{samples} samples: this method takes the whole ensemble through each, which takes minutes; --method batch needs seconds"
            ));
        }
        let progress = tell.progress("places of the heat source", records.runs.len() as u64);
        let found = assimilate::infer(&records, closures, method, seed, beside, &|| progress(1));
        drop(progress);
        let assimilate::OverTime { runs, states, batch } = found.map_err(|e| blame(e).at(dir))?;
        let source = dir.display().to_string();
        Ok(Self { beside: batch, ..Self::of(records.kind, &records.rig, source, options, runs, states) })
    }

    fn of(
        kind: DataKind,
        rig: &TubeRig,
        source: String,
        options: &FlowOptions,
        runs: Vec<RunReport>,
        states: NamedStates,
    ) -> Self {
        let document = FlowDocument { kind, rig: rig.name.clone(), seed: options.seed, runs };
        let states = BaseStates { kind, source, points: states.into_iter().collect() };
        Self { document, states, beside: Vec::new(), observations: None }
    }
}

/// What stands in `readings.csv` among the observations or beside the study; nothing without the file.
pub(crate) fn readings(
    folder: &Path,
    observations: &TubeObservations,
) -> Result<(PathBuf, settled::Readings), Failed> {
    let beside = folder.parent().filter(|p| p.join("study.toml").exists());
    let mut files = [Some(folder), beside].into_iter().flatten().map(|f| f.join(settled::Readings::FILE));
    let file = files.find(|f| f.exists()).unwrap_or_else(|| folder.join(settled::Readings::FILE));
    let known = |id: &str| observations.points.iter().any(|p| p.point.id == id);
    let readings = match file.exists() {
        true => settled::Readings::read(&file, &known).or_bad_input()?,
        false => settled::Readings::default(),
    };
    Ok((file, readings))
}

/// Readings under which no flow exists are the user's to mend; a search that gives up on sound ones is not.
pub(crate) fn blame(error: FlowError) -> Failed {
    use FlowError::{Ensemble, NoFlow, NotSteady, Power, Pulled, Range};
    match error {
        NoFlow { .. } | NotSteady { .. } | Power { .. } | Pulled { .. } | Range { .. } | Ensemble(_) => {
            Failed::bad_input(error)
                .remedy("Compare powers, ambient temperatures and readings of the samples with the rig; give samples at shorter intervals if \
                    theirs are longer than a few minutes.")
        }
        _ => Failed::of_work(error)
            .remedy("Compare the readings with the rig; --method smoother needs no derivatives."),
    }
}

#[cfg(test)]
mod tests {
    use super::blame;
    use rijke_flow::FlowError;
    use rijke_numerics::Blame;

    #[test]
    fn behaviour_readings_that_no_flow_fits_are_the_users_to_mend() {
        let pulled = FlowError::Pulled { name: "emissivity", value: 1.0002, need: "at most 1" };
        let failed = blame(pulled);
        assert_eq!(failed.kind, Blame::Input);
        assert!(
            failed.message.contains("the readings pull the closure emissivity to 1.000200"),
            "{failed:?}"
        );
        // A closure of the program itself is not.
        let own = FlowError::Closure { name: "emissivity", value: 1.0002, need: "at most 1" };
        assert_eq!(blame(own).kind, Blame::Work);
    }
}
