//! A study folder, opened and run stage by stage. Wraps what `rijke run` calls, and nothing more.

use crate::fault::{Answer, Fault};
use crate::posterior::Posterior;
use crate::signals::listening;
use pyo3::prelude::*;
use rijke_engine::folder::Forecasts;
use rijke_engine::run::{
    Aim, Search, SearchOptions, SearchPart, Trusted, Wish, forecast, foresight, next, with_points,
};
use rijke_inference::SamplerKind;
use rijke_numerics::Tell;
use serde_json::json;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};

/// The remarks of a prediction.
#[derive(Default)]
struct Doubts(Mutex<Vec<String>>);

impl Tell for Doubts {
    fn note(&self, line: String) {
        if let Ok(mut all) = self.0.lock() {
            all.push(line);
        }
    }
}

/// See `rijke.Study`.
#[pyclass(frozen, module = "rijke._native")]
pub(crate) struct Study {
    study: rijke_study::Study,
}

#[pymethods]
impl Study {
    #[new]
    fn new(folder: PathBuf) -> Answer<Self> {
        Ok(Self { study: rijke_engine::run::open(&folder)? })
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

    /// What the campaign can tell of the parameters of every model, as JSON: see `rijke check`. `observed`:
    /// what was measured is read too.
    fn check(&self, py: Python<'_>, observed: bool, sd: [f64; 3], ambient: f64) -> Answer<String> {
        py.detach(|| {
            let observations = observed.then(|| self.study.observations()).transpose()?;
            let found = foresight(&self.study, observations.as_ref(), sd, ambient)?;
            serde_json::to_string(&json!({ "unused": self.study.unused(), "stages": found }))
                .map_err(Fault::failed)
        })
    }

    /// Reads the observations and gets ready for the first stage. `trusted`: `laplace`, `checked` or
    /// `nested`. No stage runs after `until`.
    #[pyo3(signature = (trusted, error, until))]
    fn start(&self, py: Python<'_>, trusted: &str, error: f64, until: Option<&str>) -> Answer<Run> {
        let trusted = trust(trusted, error)?;
        let run = py.detach(|| -> Answer<_> {
            let observations = self.study.observations()?;
            let mut study = self.study.clone();
            if let Some((place, _)) = until.and_then(|id| study.plan.stage(id)) {
                study.plan.end_after(place);
            }
            Ok(rijke_engine::run::Run::new(study, &observations, trusted)?)
        })?;
        Ok(Run { stopped: run.stopped.clone(), run: Mutex::new(run) })
    }

    /// Trains shard `[k, n]` of all combinations; the part as JSON, as `rijke search --shard` writes it.
    /// Ctrl-C stops. `progress` is called with the number of tasks done and of all.
    #[pyo3(signature = (stage, within, trusted, shard, threads, tasks, progress))]
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
        progress: Py<PyAny>,
    ) -> PyResult<String> {
        let within = within.unwrap_or(f64::INFINITY);
        let options = SearchOptions { stage, within, trusted: trust(trusted, 0.1)?, shard, threads, tasks };
        let stopped = Arc::new(AtomicBool::new(false));
        let [done, all] = [const { AtomicUsize::new(0) }; 2];
        let work = || -> Answer<SearchPart> {
            let search = Search::new(self.study.clone(), &self.study.observations()?, options)?;
            let search = search.stopped_by(stopped.clone());
            all.store(search.tasks(), Ordering::Relaxed);
            Ok(search.run(&|steps| {
                done.fetch_add(steps, Ordering::Relaxed);
                !stopped.load(Ordering::Relaxed)
            })?)
        };
        let mut told = 0;
        let news = || {
            let now = done.load(Ordering::Relaxed);
            if now > std::mem::replace(&mut told, now) {
                progress.call1(py, (now, all.load(Ordering::Relaxed)))?;
            }
            Ok(())
        };
        let part = listening(py, &stopped, news, work)??;
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

/// The study with the points asked for, or with those of the stage where none is, and their places.
fn places(
    study: &rijke_study::Study,
    id: &str,
    asked: &[BTreeMap<String, f64>],
) -> Answer<(rijke_study::Study, Vec<usize>)> {
    let Some((_, stage)) = study.plan.stage(id) else {
        return Err(Fault::input(format!("there is no stage called `{id}`")));
    };
    Ok(match asked {
        [] => (study.clone(), stage.points.places(&study.campaign)),
        _ => with_points(study, &stage.points, asked)?,
    })
}

/// `laplace`, `checked` or `nested`.
fn trust(trusted: &str, error: f64) -> Answer<Trusted> {
    match trusted {
        "laplace" => Ok(Trusted::Laplace),
        "checked" => Ok(Trusted::Checked),
        "nested" => Ok(Trusted::Sampled(SamplerKind::Nested, error)),
        other => Err(Fault::input(format!("the evidence cannot be trusted by `{other}`"))
            .remedy("Give laplace, checked or nested.")),
    }
}

/// A study that is being run.
#[pyclass(frozen, module = "rijke._native")]
pub(crate) struct Run {
    run: Mutex<rijke_engine::run::Run>,
    stopped: Arc<AtomicBool>,
}

impl Run {
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut rijke_engine::run::Run) -> Answer<T> + Send,
    ) -> Answer<T> {
        py.detach(|| work(&mut *self.locked()?))
    }

    fn locked(&self) -> Answer<MutexGuard<'_, rijke_engine::run::Run>> {
        let failed = |_| Fault::failed("a stage of this run failed before").remedy("Start the study anew.");
        self.run.lock().map_err(failed)
    }
}

#[pymethods]
impl Run {
    /// The record of the next stage as JSON, as `rijke run` writes it; none after the last. Ctrl-C counts
    /// before each model.
    fn next_stage(&self, py: Python<'_>) -> PyResult<Option<String>> {
        self.stopped.store(false, Ordering::Relaxed);
        let record = listening(
            py,
            &self.stopped,
            || Ok(()),
            || -> Answer<_> {
                let record = self.locked()?.next_stage()?;
                record.map(|r| serde_json::to_string(&r).map_err(Fault::failed)).transpose()
            },
        )??;
        py.check_signals()?;
        Ok(record)
    }

    /// What the model that goes on from a stage says of points, given by their factors, or of those of the
    /// stage: JSON, see `rijke predict`.
    fn forecast(&self, py: Python<'_>, id: &str, asked: Vec<BTreeMap<String, f64>>) -> Answer<String> {
        self.with(py, |run| {
            let (study, places) = places(&run.study, id, &asked)?;
            let (model, open) = (run.saved(id)?, run.saved_open(id)?);
            let (found, mut left_out) = forecast(&study, &study.observations()?, &model, &open, &places)?;
            if found.is_empty() && !left_out.is_empty() {
                return Err(left_out.swap_remove(0).why.into());
            }
            let left_out: Vec<_> = left_out.iter().map(|u| (&u.point, u.why.to_string())).collect();
            let doubts = Doubts::default();
            let predicted = Forecasts { study: &study, model: &model, open: &open, found: &found };
            predicted.tell_doubts(&places, &[], &doubts);
            let doubts = doubts.0.into_inner().unwrap_or_default();
            Ok(json!({ "forecasts": found, "left_out": left_out, "doubts": doubts }).to_string())
        })
    }

    /// What to measure next, of points given by their factors or of those of the stage: JSON, see `rijke
    /// next`. `aim` is `models`, or nothing for the parameters, or for the growth rate at the point `about`.
    #[expect(clippy::too_many_arguments, reason = "those of the function of Python")]
    fn suggest(
        &self,
        py: Python<'_>,
        id: &str,
        asked: Vec<BTreeMap<String, f64>>,
        about: Option<BTreeMap<String, f64>>,
        models: bool,
        points: usize,
        pressures: bool,
    ) -> Answer<String> {
        self.with(py, |run| {
            let (study, mut candidates) = places(&run.study, id, &asked)?;
            let quantity = match &about {
                Some(about) => Some(places(&study, id, std::slice::from_ref(about))?),
                None => None,
            };
            let (study, about) = match quantity {
                Some((study, places)) => (study, places.first().copied()),
                None => (study, None),
            };
            candidates.dedup();
            let aim = match (models, about) {
                (true, _) => Aim::Models,
                (false, Some(_)) => Aim::Quantity,
                (false, None) => Aim::Parameters,
            };
            let wish = Wish { aim, candidates, about, points, without_pressures: !pressures };
            let (model, rivals) = (run.saved(id)?, run.rivals(id)?);
            let found = next(&study, &study.observations()?, &model, &rivals, &wish)?;
            serde_json::to_string(&found).map_err(Fault::failed)
        })
    }

    /// What the stage called `id` chose.
    fn posterior(&self, py: Python<'_>, id: &str) -> Answer<Posterior> {
        self.with(py, |run| match run.chosen(id) {
            Some(chosen) => {
                let data = run.data_of(id, chosen).unwrap_or_default();
                Ok(Posterior::of(chosen, None, run.misfit_of_predictions(id, chosen), data))
            }
            None => Err(Fault::input(format!("no stage called `{id}` has run"))),
        })
    }

    /// The same, trained with what enters predictions but not the comparison.
    fn for_predictions(&self, py: Python<'_>, id: &str) -> Answer<Posterior> {
        self.with(py, |run| match run.for_predictions(id)? {
            Some(chosen) => {
                let (misfit, data) = (run.misfit_of_predictions(id, &chosen), run.data_of(id, &chosen));
                Ok(Posterior::of(&chosen, run.law_error(id), misfit, data.unwrap_or_default()))
            }
            None => Err(Fault::input(format!("no stage called `{id}` has run"))),
        })
    }
}
