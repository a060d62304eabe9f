//! A study folder, opened and run stage by stage. Wraps what `rijke run` calls, and nothing more.

use crate::fault::{Answer, Fault};
use crate::posterior::Posterior;
use crate::signals::listening;
use pyo3::prelude::*;
use rijke_engine::run::{Search, SearchOptions, SearchPart, Trusted};
use rijke_inference::RefereeKind;
use serde_json::json;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// See `rijke.Study`.
#[pyclass(frozen, module = "rijke._native")]
pub(crate) struct Study {
    study: rijke_study::Study,
}

#[pymethods]
impl Study {
    #[new]
    fn new(folder: PathBuf) -> Answer<Self> {
        Ok(Self { study: rijke_study::Study::open(&folder)? })
    }

    /// What the files say, as JSON.
    fn summary(&self) -> String {
        let study = &self.study;
        let shown = |v: &f64| if v.is_nan() { None } else { Some(*v) };
        let points = study.campaign.points.iter().map(|p| {
            json!({ "point": p.id, "row": p.row, "installation": p.installation, "day": p.day,
                    "factors": p.factors.iter().map(shown).collect::<Vec<_>>() })
        });
        json!({
            "name": study.plan.name,
            "question": study.plan.question,
            "stages": study.plan.stages.iter().map(|s| [&s.id, &s.title]).collect::<Vec<_>>(),
            "factors": study.campaign.factors.iter().map(|f| [&f.name, &f.unit]).collect::<Vec<_>>(),
            "points": points.collect::<Vec<_>>(),
        })
        .to_string()
    }

    /// Reads the observations and gets ready for the first stage. `trusted`: `laplace`, `checked` or `nested`.
    fn start(&self, py: Python<'_>, trusted: &str, error: f64) -> Answer<Run> {
        let trusted = trust(trusted, error)?;
        let run = py.detach(|| -> Answer<_> {
            let observations = self.study.observations()?;
            Ok(rijke_engine::run::Run::new(self.study.clone(), &observations, trusted)?)
        })?;
        Ok(Run { run: Mutex::new(run) })
    }

    /// Trains shard `[k, n]` of all combinations; the part as JSON, as `rijke search --shard` writes it. Ctrl-C stops.
    #[pyo3(signature = (stage, within, trusted, shard, threads, tasks))]
    #[expect(clippy::too_many_arguments, reason = "those of the function of Python")]
    fn search(
        &self,
        py: Python<'_>,
        stage: Option<String>,
        within: Option<f64>,
        trusted: &str,
        shard: [usize; 2],
        threads: usize,
        tasks: Option<PathBuf>,
    ) -> PyResult<String> {
        let within = within.unwrap_or(f64::INFINITY);
        let options = SearchOptions { stage, within, trusted: trust(trusted, 0.1)?, shard, threads, tasks };
        let stopped = AtomicBool::new(false);
        let work = || -> Answer<SearchPart> {
            let search = Search::new(self.study.clone(), &self.study.observations()?, options)?;
            Ok(search.run(&|_| !stopped.load(Ordering::Relaxed))?)
        };
        let part = listening(py, &stopped, work)??;
        Ok(serde_json::to_string(&part).map_err(Fault::failed)?)
    }
}

/// Joins parts of a search, in any order; the result as JSON, as `rijke merge` writes it.
#[pyfunction]
pub(crate) fn merge_searches(parts: Vec<String>) -> Answer<String> {
    let read = |text: &String| serde_json::from_str(text).map_err(Fault::failed);
    let parts = parts.iter().map(read).collect::<Answer<Vec<SearchPart>>>()?;
    serde_json::to_string(&rijke_engine::run::merge_searches(&parts)?).map_err(Fault::failed)
}

/// `laplace`, `checked` or `nested`.
fn trust(trusted: &str, error: f64) -> Answer<Trusted> {
    match trusted {
        "laplace" => Ok(Trusted::Laplace),
        "checked" => Ok(Trusted::Checked),
        "nested" => Ok(Trusted::Refereed(RefereeKind::Nested, error)),
        other => Err(Fault::input(format!("the evidence cannot be trusted by `{other}`"))
            .remedy("Give laplace, checked or nested.")),
    }
}

/// A study that is being run.
#[pyclass(frozen, module = "rijke._native")]
pub(crate) struct Run {
    run: Mutex<rijke_engine::run::Run>,
}

impl Run {
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut rijke_engine::run::Run) -> Answer<T> + Send,
    ) -> Answer<T> {
        py.detach(|| match self.run.lock() {
            Ok(mut run) => work(&mut run),
            Err(_) => Err(Fault::failed("a stage of this run failed before").remedy("Start the study anew.")),
        })
    }
}

#[pymethods]
impl Run {
    /// The record of the next stage as JSON, as `rijke run` writes it; none after the last. Ctrl-C counts between stages.
    fn next_stage(&self, py: Python<'_>) -> PyResult<Option<String>> {
        py.check_signals()?;
        let record = self.with(py, |run| {
            let record = run.next_stage()?;
            record.map(|r| serde_json::to_string(&r).map_err(Fault::failed)).transpose()
        })?;
        py.check_signals()?;
        Ok(record)
    }

    /// What the stage called `id` chose.
    fn posterior(&self, py: Python<'_>, id: &str) -> Answer<Posterior> {
        self.with(py, |run| match run.chosen(id) {
            Some(chosen) => Ok(Posterior::of(chosen, None, run.misfit_of_predictions(id, chosen))),
            None => Err(Fault::input(format!("no stage called `{id}` has run"))),
        })
    }

    /// The same, trained with what enters predictions but not the comparison.
    fn for_predictions(&self, py: Python<'_>, id: &str) -> Answer<Posterior> {
        self.with(py, |run| match run.for_predictions(id)? {
            Some(chosen) => {
                Ok(Posterior::of(&chosen, run.law_error(id), run.misfit_of_predictions(id, &chosen)))
            }
            None => Err(Fault::input(format!("no stage called `{id}` has run"))),
        })
    }
}
