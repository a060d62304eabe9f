//! `rijke watch`: beside the acquisition. Every step of a study again and again, as far as records are there.

mod page;
mod server;

use crate::{
    failure::{Classify, Failure},
    flow, number, process,
    results::Trust,
    run,
    staging::Lock,
    study::{observations, of_modes, of_the_engine, open},
    ui::Ui,
};
use page::Status;
use rijke_engine::run::{Leading, Run, StageRecord, Trusted, so_far, verdicts};
use rijke_report::{StudyHead, StudyPage};
use rijke_rig::{Arrivals, Arrived};
use rijke_signal::Kept;
use rijke_study::Study;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use std::{fs, thread};

/// Follow a study while its records are made: process each as it appears, keep the leading models trained, show a page that updates
/// itself.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  rijke watch rig-2026 --serve 8080\n\n\
    DIR is a study whose records/manifest.toml lists the files that are made, before or after they are there. A file counts once\n\
    it stopped growing and can be read as what the manifest says; others are listed with the reason and looked at again when they\n\
    change. Writes DIR/observations and DIR/live with its page index.html. When no file came for a while all models are trained\n\
    again; in between the leading ones of each stage. When every file of the manifest is there, DIR/results is made as by\n\
    `rijke run --force`, to the byte. End with Ctrl-C; started again it goes on with what is there.")]
pub(crate) struct Args {
    /// Folder of the study.
    dir: PathBuf,
    /// Show the page on this port of the loopback address, 127.0.0.1.
    #[arg(long, value_name = "PORT")]
    serve: Option<u16>,
    /// How many models of each stage are kept trained while records arrive.
    #[arg(long, value_name = "N", default_value_t = 5)]
    leading: usize,
    /// Seconds without a new file after which all models are trained.
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, value_parser = number::positive)]
    calm: f64,
    /// End when every file that the manifest lists has come.
    #[arg(long)]
    until_complete: bool,
    #[command(flatten)]
    trust: Trust,
}

/// Time between two looks at the folder.
const PAUSE: Duration = Duration::from_millis(100);

/// What is known between two looks.
struct Watch<'a> {
    args: &'a Args,
    ui: &'a Ui,
    live: PathBuf,
    kept: Kept,
    leading: Leading,
    status: Status,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failure> {
    let dir = &args.dir;
    let study = open(dir)?;
    of_modes(&study)?;
    let live = dir.join("live");
    // One watch at a time; what it calls takes locks of its own.
    let _lock = Lock::take(&live)?;
    fs::create_dir_all(&live).or_bad_input().map_err(|f| f.at(&live))?;
    let described = study.for_records().map(Some).or_bad_input()?;
    let mut arrivals = Arrivals::new(&dir.join("records"), described);
    let status = Status::default();
    let mut watch = Watch { args, ui, live, kept: Kept::default(), leading: Leading::default(), status };
    watch.status.write(&watch.live)?;
    if let Some(port) = args.serve {
        let address = server::serve(port, watch.live.clone())?;
        ui.note(format!("page: http://{address}/"));
    } else {
        ui.note(format!("page: {}", watch.live.join("index.html").display()));
    }
    // The same records were all processed, trained and finished.
    let (mut trained_all, mut finished) = (true, false);
    let mut last_change = Instant::now();
    if !dir.join("records/manifest.toml").is_file() {
        ui.note(format!(
            "waiting for {}, which lists the records",
            dir.join("records/manifest.toml").display()
        ));
    }
    loop {
        let look = arrivals.look();
        watch.tell_unusable(&look);
        if !look.changed.is_empty() {
            watch.update(&look, Trusted::Laplace)?;
            (trained_all, finished, last_change) = (false, false, Instant::now());
            continue;
        }
        let complete = look.records.is_some() && look.awaited == 0 && look.unusable.is_empty();
        if complete && !finished {
            match watch.finish() {
                Ok(()) => {}
                Err(failure) if args.until_complete => return Err(failure),
                // What is there is not enough for a study yet; the manifest may grow.
                Err(failure) => ui.note(failure.to_string()),
            }
            (trained_all, finished) = (true, true);
        }
        if complete && args.until_complete {
            return ui.result(&json!({ "dir": dir, "files": look.whole, "unusable": look.unusable }));
        }
        if !trained_all && last_change.elapsed().as_secs_f64() > args.calm {
            watch.states()?;
            watch.update(&look, args.trust.trusted()?)?;
            trained_all = true;
        }
        thread::sleep(PAUSE);
    }
}

impl Watch<'_> {
    /// Says once of each file why it does not count.
    fn tell_unusable(&mut self, look: &Arrived) {
        if self.status.unusable == look.unusable && self.status.awaited == look.awaited {
            return;
        }
        for (file, why) in &look.unusable {
            if self.status.unusable.get(file) != Some(why) {
                self.ui.note(format!("not counted: {file}: {why}"));
            }
        }
        (self.status.unusable, self.status.awaited) = (look.unusable.clone(), look.awaited);
        // A page that cannot be written now can be with the next record.
        let _ = self.status.write(&self.live);
    }

    /// Processes what is there, and trains: the leading models, or all if they are also checked.
    fn update(&mut self, look: &Arrived, trusted: Trusted) -> Result<(), Failure> {
        look.changed.iter().for_each(|file| self.kept.forget(file));
        (self.status.whole, self.status.awaited) = (look.whole, look.awaited);
        let Some(records) = look.records.clone() else { return self.status.write(&self.live) };
        // Candidates and plan may be written while one measures.
        let study = open(&self.args.dir)?;
        let out = self.args.dir.join("observations");
        let silent = Ui::silent();
        let all = trusted != Trusted::Laplace || self.leading == Leading::default();
        let outcome =
            process::so_far(records, study.clone(), &out, &self.kept, &silent).and_then(|processed| {
                let measured = |p: &&rijke_rig::PointObservations| p.ping.is_some() || p.click.is_some();
                let points = processed.observations.points.iter().filter(measured).count();
                self.status.rejected = processed
                    .observations
                    .rejections
                    .iter()
                    .map(|r| (r.record.clone(), r.reason.clone()))
                    .collect();
                self.status.points = points;
                self.train(&study, trusted, all)
            });
        match outcome {
            Ok(Some(stages)) => {
                if all {
                    self.leading = Leading::of(&stages, self.args.leading);
                }
                self.status.trained(&stages, all);
            }
            Ok(None) => self.status.said = "no stage has observed points yet".to_owned(),
            // Too little is there, or a record is of another kind: more may come.
            Err(failure) => self.status.said = failure.to_string(),
        }
        self.status.write(&self.live)?;
        self.ui.note(self.status.line(&look.changed));
        Ok(())
    }

    /// Trains the stages that have points, and draws them.
    fn train(&self, study: &Study, trusted: Trusted, all: bool) -> Result<Option<Vec<StageRecord>>, Failure> {
        let dir = &self.args.dir;
        let wrong = |e: rijke_engine::EngineError| of_the_engine(&e, dir);
        let observations = observations(study)?;
        let leading = if all { Leading::default() } else { self.leading.clone() };
        let Some(reduced) = so_far(study, &observations, &leading).map_err(wrong)? else { return Ok(None) };
        let mut run = Run::new(reduced, &observations, trusted).map_err(wrong)?;
        let (mut stages, mut answers) = (Vec::new(), Vec::new());
        while let Some(stage) = run.next_stage().map_err(wrong)? {
            answers.push(run.overview(&stage.id).map_err(wrong)?);
            stages.push(stage);
        }
        let verdicts = verdicts(&study.claims, observations.kind, &stages, &answers);
        let page = StudyPage::new(&StudyHead::of(study, &observations), &stages, &answers, &verdicts, None);
        page.or_failed()?.write(&self.live.join("study")).or_failed()?;
        Ok(Some(stages))
    }

    /// Infers the states of the gas again, where the study wants inferred ones.
    fn states(&mut self) -> Result<(), Failure> {
        let dir = &self.args.dir;
        if !flow::is_due(&open(dir)?) {
            return Ok(());
        }
        match flow::of_study(dir, &dir.join("base"), true, &Ui::silent()) {
            Ok(settling) => {
                settling.iter().for_each(|said| self.ui.note(said.clone()));
                self.status.settling = settling;
            }
            Err(failure) => self.ui.note(format!("the flow cannot be inferred yet: {failure}")),
        }
        Ok(())
    }

    /// Everything from the start, as one run does it.
    fn finish(&mut self) -> Result<(), Failure> {
        self.status.said = "all files are there: training all models".to_owned();
        self.status.write(&self.live)?;
        self.ui.note("all files of the manifest are there");
        let page = run::from_the_start(&self.args.dir, self.args.trust, &Ui::silent())?;
        self.status.finished(Path::new("../results/index.html"));
        self.status.write(&self.live)?;
        self.ui.note(format!("finished: {}", page.display()));
        Ok(())
    }
}
