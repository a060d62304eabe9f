//! `rijke watch`: beside the acquisition. Every step of a study again and again, as far as records are there.

mod server;
mod training;

use crate::{number, run, trust::Trust, ui::Ui};
use rijke_draw::plot_svg;
use rijke_engine::folder::{observations, open_study, without_responses};
use rijke_engine::run::{Leading, Sequence, Trusted};
use rijke_intake::{Intake, ObserveOptions, Out, described};
use rijke_numerics::words::counted;
use rijke_numerics::{Classify, Failed, Lock, keep_others};
use rijke_report::{LivePage, LivePart};
use rijke_rig::{Arrivals, Arrived, PointObservations, RecordFolder, RecordSource};
use rijke_signal::{Kept, Processed};
use rijke_study::Study;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use std::{fs, thread};
use training::{Job, Trainer};

/// Follow a study while its records are made: process each as it appears, keep the leading models trained,
/// show a page that updates itself.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  rijke watch rig-2026 --serve 8080\n\n\
    DIR is a study. Its records/manifest.toml lists the files, whether they are there yet or not. A file counts as soon as it has\n\
    stopped growing and can be read as the manifest says. Other files are listed with the reason, and read again when they change.\n\
    The command writes DIR/observations and DIR/live with its page index.html. Every record moves the leading models of each stage\n\
    at once, to first order; these models are trained again in the background, and all models when no file has come for a while.\n\
    When every file is there, copies of others apart, DIR/results is written as `rijke run --force` writes it, to the byte. End it\n\
    with Ctrl-C. Started again, it goes on with what is there.")]
pub(crate) struct Args {
    /// Folder of the study.
    dir: PathBuf,
    /// Show the page on this port of the loopback address, 127.0.0.1.
    #[arg(long, value_name = "PORT")]
    serve: Option<u16>,
    /// How many models of each stage are followed while records arrive.
    #[arg(long, value_name = "N", default_value_t = 5)]
    leading: usize,
    /// Seconds without a new file after which all models are trained.
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, value_parser = number::positive)]
    calm: f64,
    /// End as soon as every file that the manifest lists has come.
    #[arg(long)]
    until_complete: bool,
    #[command(flatten)]
    trust: Trust,
}

/// Time between two looks at the folder.
const PAUSE: Duration = Duration::from_millis(50);

/// What is known between two looks.
struct Watch<'a> {
    args: &'a Args,
    ui: &'a Ui,
    live: PathBuf,
    kept: Kept,
    trainer: Trainer,
    leading: Leading,
    /// The leading models, until they are trained again.
    sequences: Vec<Sequence>,
    /// Whether something was observed that no training counts.
    untrained: bool,
    status: LivePage,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failed> {
    let dir = &args.dir;
    let study = open_study(dir)?;
    without_responses(&study, "a watch")?;
    let live = dir.join("live");
    // One watch at a time; what it calls takes locks of its own.
    let _lock = Lock::take(&live)?;
    fs::create_dir_all(&live).or_bad_input().map_err(|f| f.at(&live))?;
    let described = described(&dir.join("records"), Some(&study))?;
    let mut arrivals = Arrivals::new(&dir.join("records"), described);
    let mut watch = Watch {
        args,
        ui,
        kept: Kept::default(),
        trainer: Trainer::new(dir, &live, args.leading)?,
        leading: Leading::default(),
        sequences: Vec::new(),
        untrained: false,
        status: LivePage::default(),
        live,
    };
    watch.status.write(&watch.live)?;
    if let Some(port) = args.serve {
        let address = server::serve(port, watch.live.clone())?;
        ui.note(format!("page: http://{address}/"));
    } else {
        ui.note(format!("page: {}", watch.live.join("index.html").display()));
    }
    // What is there was all checked, and finished.
    let (mut checked, mut finished) = (true, false);
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
            watch.update(&look)?;
            (checked, finished, last_change) = (false, false, Instant::now());
        }
        watch.collect()?;
        let complete = look.records.is_some() && look.awaited == 0 && look.unusable.len() == look.copies;
        let calm = last_change.elapsed().as_secs_f64() > args.calm;
        if complete && !finished && (calm || args.until_complete) {
            match watch.finish() {
                Ok(()) => {}
                Err(failure) if args.until_complete => return Err(failure),
                // What is there is not enough for a study yet; the manifest may grow.
                Err(failure) => ui.note(failure.to_string()),
            }
            (checked, finished) = (true, true);
        }
        if complete && args.until_complete {
            return ui.result(&json!({ "dir": dir, "files": look.whole, "unusable": look.unusable }));
        }
        if !watch.trainer.is_busy() && !finished {
            if calm && !checked {
                watch.train(Leading::default(), args.trust.trusted()?, true)?;
                checked = true;
            } else if watch.untrained {
                watch.train(watch.leading.clone(), Trusted::Laplace, false)?;
            }
        }
        if look.changed.is_empty() {
            thread::sleep(PAUSE);
        }
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
        let awaited = std::mem::replace(&mut self.status.awaited, look.awaited);
        let same = self.status.unusable == look.unusable;
        self.status.unusable.clone_from(&look.unusable);
        // What came is written with what it says; a page that cannot be written now can be with the next
        // record.
        if look.changed.is_empty() && (!same || awaited < look.awaited) {
            let _ = self.status.write(&self.live);
        }
    }

    /// Processes what is there, and moves the leading models by it.
    fn update(&mut self, look: &Arrived) -> Result<(), Failed> {
        look.changed.iter().for_each(|file| self.kept.forget(file));
        (self.status.whole, self.status.awaited) = (look.whole, look.awaited);
        let Some(records) = look.records.clone() else { return self.status.write(&self.live) };
        // Candidates and plan may be written while one measures.
        let study = open_study(&self.args.dir)?;
        let point = |name: &String| Some((name.clone(), records.set().point_of(name)?.to_owned()));
        let last = look.changed.iter().rev().find_map(point);
        let shown = last.as_ref().map(|(name, _)| name.as_str());
        match self.process(records, study, shown) {
            Ok((processed, figure)) => {
                self.tell(&processed, last.as_ref());
                if let Some(svg) = figure {
                    self.status.draw(&self.live, LivePart::Last, &svg)?;
                }
                self.untrained = true;
                self.follow();
            }
            // Too little is there, or a record is of another kind: more may come.
            Err(failure) => self.status.said = failure.to_string(),
        }
        self.status.write(&self.live)?;
        self.ui.note(self.status.line(&look.changed));
        Ok(())
    }

    /// Processes the records that are there, with a figure of the one called `shown`.
    fn process(
        &self,
        records: RecordFolder,
        study: Study,
        shown: Option<&str>,
    ) -> Result<(Processed, Option<String>), Failed> {
        let intake = Intake::of(records, Some(study))?;
        let folder = &self.args.dir.join("observations");
        let out = Out { folder, force: true, beside: &|_, _| Ok(()) };
        let processed = intake.observe(&ObserveOptions::default(), Some(&self.kept), &out, &())?;
        let figure = shown.map(|name| intake.plot_of(&processed, name)).transpose()?.flatten();
        Ok((processed, figure.as_ref().map(plot_svg)))
    }

    /// What was processed, in words.
    fn tell(&mut self, Processed { observations, .. }: &Processed, last: Option<&(String, String)>) {
        let measured = |p: &&PointObservations| p.ping.is_some() || p.click.is_some();
        self.status.points = observations.points.iter().filter(measured).count();
        let of = |r: &rijke_rig::Rejection| (r.record.clone(), r.reason.clone());
        self.status.rejected = observations.rejections.iter().map(of).collect();
        let Some((name, point)) = last else { return };
        let rejected = self.status.rejected.iter().find(|(record, _)| record == name);
        let of_point = || observations.points.iter().find(|p| p.point.id == *point).map(|p| p.said());
        let said = rejected.map(|(_, why)| format!("rejected, {why}")).or_else(of_point);
        self.status.last = said.map_or_else(|| name.clone(), |said| format!("{name}: {said}"));
    }

    /// Moves the leading models by what was observed since they were trained.
    fn follow(&mut self) {
        let read = || {
            let study = open_study(&self.args.dir)?;
            let observations = observations(&study)?;
            let with = |s: &Sequence| s.with(&study, &observations).or_failed();
            self.sequences.iter().map(with).collect::<Result<Vec<_>, Failed>>()
        };
        match read() {
            Ok(stages) => self.status.stages = stages,
            // The next training says what is wrong.
            Err(failure) => self.status.said = failure.to_string(),
        }
    }

    /// Begins a training of what is there.
    fn train(&mut self, leading: Leading, trusted: Trusted, states: bool) -> Result<(), Failed> {
        self.untrained = false;
        self.trainer.begin(Job { leading, trusted, states, files: self.status.whole })
    }

    /// Takes over what was trained.
    fn collect(&mut self) -> Result<(), Failed> {
        match self.trainer.found() {
            None => return Ok(()),
            Some(Ok(Some(outcome))) => {
                let which = if outcome.job.is_of_all() { "all models" } else { "the leading models" };
                let (stages, files) = (outcome.stages, outcome.job.files);
                self.status.said =
                    format!("{which} of {} trained on {}", counted(stages, "stage"), counted(files, "file"));
                outcome.notes.iter().for_each(|said| self.ui.note(said.clone()));
                if let Some(settling) = outcome.settling {
                    settling.iter().for_each(|said| self.ui.note(said.clone()));
                    self.status.settling = settling;
                }
                match outcome.next {
                    Ok((found, svg)) => {
                        self.status.suggest(&found);
                        self.status.draw(&self.live, LivePart::Next, &svg)?;
                    }
                    Err(why) => self.status.next = vec![why],
                }
                (self.leading, self.sequences) = (outcome.leading, outcome.sequences);
                self.status.renewed(LivePart::Study);
                self.follow();
            }
            Some(Ok(None)) => self.status.said = "no stage has observed points yet".to_owned(),
            Some(Err(failure)) => self.status.said = failure.to_string(),
        }
        self.status.write(&self.live)?;
        self.ui.note(self.status.line(&[]));
        Ok(())
    }

    /// Everything from the start, as one run does it.
    fn finish(&mut self) -> Result<(), Failed> {
        self.trainer.end();
        self.status.said = "all files are there: training all models".to_owned();
        self.status.write(&self.live)?;
        self.ui.note("all files of the manifest are there");
        let page = run::from_the_start(&self.args.dir, self.args.trust, &Ui::silent())?;
        let shown = self.live.join("study");
        let copy = || {
            fs::create_dir_all(&shown)?;
            for part in ["figures", "tables"] {
                let from = page.with_file_name(part);
                if from.is_dir() {
                    fs::create_dir_all(shown.join(part))?;
                    keep_others(&from, &shown.join(part), &[])?;
                }
            }
            fs::copy(&page, shown.join("index.html"))
        };
        copy().or_failed().map_err(|f| f.at(&shown))?;
        self.status.finished(Path::new("../results/index.html"));
        self.status.write(&self.live)?;
        self.ui.note(format!("finished: {}", page.display()));
        Ok(())
    }
}
