//! Trainings, on a thread of their own: records never wait for them.

use crate::flow;
use rijke_draw::plot_svg;
use rijke_engine::EngineError;
use rijke_engine::folder::{observations, of_the_engine, open_study};
use rijke_engine::run::{Leading, Next, Run, Sequence, Trusted, Wish, so_far, verdicts};
use rijke_intake::flow_is_due;
use rijke_numerics::{Classify, Failed, keep_others};
use rijke_report::{StudyHead, StudyPage};
use rijke_study::{ObservedModes, Study};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::{fs, thread};

/// What is to be trained.
pub(super) struct Job {
    pub(super) leading: Leading,
    pub(super) trusted: Trusted,
    /// Whether the states of the gas are inferred before, where the study wants inferred ones.
    pub(super) states: bool,
    /// How many files had been processed.
    pub(super) files: usize,
}

impl Job {
    /// Whether all models are trained.
    pub(super) fn is_of_all(&self) -> bool {
        self.leading == Leading::default()
    }
}

/// What training found.
pub(super) struct Outcome {
    pub(super) job: Job,
    /// How many stages were trained.
    pub(super) stages: usize,
    pub(super) leading: Leading,
    /// The leading models, to be followed until the next training.
    pub(super) sequences: Vec<Sequence>,
    /// When the flow of each ramp is settled; none where states were not inferred again.
    pub(super) settling: Option<Vec<String>>,
    /// What to measure next, drawn; or why nobody can tell.
    pub(super) next: Result<(Next, String), String>,
    /// What a user should know.
    pub(super) notes: Vec<String>,
}

/// What comes back: none where no stage has points yet.
pub(super) type Found = Result<Option<Outcome>, Failed>;

/// The thread.
pub(super) struct Trainer {
    dir: PathBuf,
    seen: PathBuf,
    jobs: Sender<Job>,
    found: Receiver<Found>,
    busy: bool,
    stop: Arc<AtomicBool>,
}

/// Points that are suggested next.
const PLANNED: usize = 3;

impl Trainer {
    /// Of the study in `dir`, whose page so far is written below `live`; `count` models of each stage lead.
    pub(super) fn new(dir: &Path, live: &Path, count: usize) -> Result<Self, Failed> {
        // One processor is left to what records need at once.
        let threads = thread::available_parallelism().map_or(1, |n| n.get().saturating_sub(1).max(1));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().or_failed()?;
        let ((jobs, coming), (out, found)) = (channel::<Job>(), channel());
        let (seen, stop) = (live.join(".seen"), Arc::new(AtomicBool::new(false)));
        let work = Work {
            dir: dir.to_owned(),
            live: live.to_owned(),
            seen: seen.clone(),
            count,
            stop: stop.clone(),
        };
        thread::spawn(move || {
            for job in coming {
                if out.send(pool.install(|| work.take(job))).is_err() {
                    return;
                }
            }
        });
        Ok(Self { dir: dir.to_owned(), seen, jobs, found, busy: false, stop })
    }

    pub(super) fn is_busy(&self) -> bool {
        self.busy
    }

    /// Begins, on a copy of what was observed so far.
    pub(super) fn begin(&mut self, job: Job) -> Result<(), Failed> {
        let copy = || {
            if self.seen.exists() {
                fs::remove_dir_all(&self.seen)?;
            }
            for part in ["observations", "base"] {
                let (from, to) = (self.dir.join(part), self.seen.join(part));
                fs::create_dir_all(&to)?;
                if from.is_dir() {
                    keep_others(&from, &to, &[])?;
                }
            }
            // It may stand beside the study, too.
            let readings = self.dir.join("readings.csv");
            if readings.is_file() {
                fs::copy(&readings, self.seen.join("readings.csv"))?;
            }
            Ok::<_, std::io::Error>(())
        };
        copy().or_failed().map_err(|f| f.at(&self.seen))?;
        self.busy = self.jobs.send(job).is_ok();
        Ok(())
    }

    /// What was found since the last call.
    pub(super) fn found(&mut self) -> Option<Found> {
        let found = self.found.try_recv().ok();
        self.busy &= found.is_none();
        found
    }

    /// Ends what is being trained, which is lost.
    pub(super) fn end(&mut self) {
        if self.busy {
            self.stop.store(true, Ordering::Relaxed);
            // A thread that ended has nothing to say.
            let _ = self.found.recv();
            self.stop.store(false, Ordering::Relaxed);
            self.busy = false;
        }
    }
}

/// What the thread knows.
struct Work {
    dir: PathBuf,
    live: PathBuf,
    /// Copy of what was observed.
    seen: PathBuf,
    count: usize,
    stop: Arc<AtomicBool>,
}

impl Work {
    fn take(&self, job: Job) -> Found {
        // Candidates and plan may be written while one measures.
        let study = Study { folder: self.seen.clone(), ..open_study(&self.dir)? };
        let (mut settling, mut notes) = (None, Vec::new());
        if job.states && flow_is_due(&study) {
            let base = self.dir.join("base");
            match flow::of_study(&self.seen, &base, true, &()) {
                Ok(said) => {
                    keep_others(&base, &self.seen.join("base"), &[]).or_failed().map_err(|f| f.at(&base))?;
                    settling = Some(said);
                }
                Err(failure) => notes.push(format!("the flow cannot be inferred yet: {failure}")),
            }
        }
        let wrong = |e: EngineError| of_the_engine(&e, &self.dir);
        let observations = observations(&study)?;
        let Some(reduced) = so_far(&study, &observations, &job.leading).map_err(wrong)? else {
            return Ok(None);
        };
        let mut run = Run::new(reduced, &observations, job.trusted).map_err(wrong)?;
        run.stopped = self.stop.clone();
        let (mut stages, mut answers) = (Vec::new(), Vec::new());
        while let Some(stage) = run.next_stage().map_err(wrong)? {
            answers.push(run.overview(&stage.id).map_err(wrong)?);
            stages.push(stage);
        }
        let judged = verdicts(&study.claims, observations.kind, &stages, &answers);
        let page = StudyPage::new(&StudyHead::of(&study, &observations), &stages, &answers, &judged, None);
        page?.write(&self.live.join("study"))?;
        let next = stages.last().map_or_else(
            || Err("no stage was trained".to_owned()),
            |stage| suggested(&study, &observations, &run, &stage.id).map_err(|e| e.to_string()),
        );
        let leading = if job.is_of_all() { Leading::of(&stages, self.count) } else { job.leading.clone() };
        let sequences = run.sequences(self.count);
        Ok(Some(Outcome { job, stages: stages.len(), leading, sequences, settling, next, notes }))
    }
}

/// What the points of a stage would tell of its model's parameters.
fn suggested(
    study: &Study,
    observations: &ObservedModes,
    run: &Run,
    id: &str,
) -> Result<(Next, String), EngineError> {
    let candidates =
        study.plan.stage(id).map_or_else(Vec::new, |(_, stage)| stage.points.places(&study.campaign));
    let wish = Wish { candidates, points: PLANNED, without_pressures: true, ..Wish::default() };
    let found = rijke_engine::run::next(study, observations, &run.saved(id)?, &[], &wish)?;
    let drawn = plot_svg(&found.plot(&study.campaign, observations.kind));
    Ok((found, drawn))
}
