//! The long study behind docs/records/designs.md: does `rijke next` save hours of the rig?
//! `cargo test --release --test program design_study -- --ignored --nocapture` prints its tables.

use crate::{copy, example, ramp_study, rijke, scratch};
use rand::seq::IndexedRandom;
use rayon::prelude::*;
use rijke_engine::SavedModel;
use rijke_engine::run::{Aim, Next, OpenModel, Run, StageRecord, Trusted, Wish, forecast, next};
use rijke_flow::{HeatedTube, POWER, TubeCampaign, TubePoint, TubeRig};
use rijke_lab::{Truth, VirtualRig};
use rijke_numerics::{Streams, median};
use rijke_rig::{Observations, OperatingPoint, RecordSource};
use rijke_signal::{ProcessOptions, process};
use rijke_study::Study;
use std::{fs, path::PathBuf};

/// Laboratories.
pub(crate) const SEEDS: u64 = 5;
const REPEATS: u32 = 4;
/// The grid of hot points: W, and cm.
const POWERS: [u32; 7] = [7, 15, 30, 50, 80, 130, 180];
const PLACES: [u32; 7] = [15, 25, 35, 50, 60, 75, 85];
/// Those of Fig. 11.
pub(crate) const EIGHT: [&str; 8] =
    ["H7-15", "H7-85", "H50-25", "H50-75", "H180-15", "H180-25", "H180-50", "H180-85"];
/// Where the growth rate is asked for, before and after each visit.
const ABOUT: &str = "H130-60";
/// Nats that decide.
const DECIDED: [f64; 3] = [5.0, 10.0, 20.0];

/// As in `hours`.
const COST: &str = "[cost]\npoint = \"1 h\"\ninstallation = \"1 h\"\n";

const NOISE: &str = r#"
points = { where = { Q_h = { above = 0 } } }
on = "thermocouples"
base_errors = true
[stage.noise]
growth_rate = { like = "thermocouples", ln_sd = 1.0 }
angular_frequency = { like = "thermocouples", ln_sd = 1.0 }
pressure = { like = "thermocouples", ln_sd = 1.0 }
varying = [{ parameter = "k_r", sd = { like = "thermocouples" } }, { parameter = "k_i", sd = { like = "thermocouples" } }]
"#;

/// Stages of two models. Of the laws neither is true, nor has the mean flow that all other points ask for; of
/// the drags the laboratory has both.
const PAIRS: [(&str, &str); 2] = [
    ("laws", r#"[["heat-release.6"], ["heat-release.8"]]"#),
    (
        "drags",
        r#"[["heat-release.wire", "mean-flow.convection", "steady-drag.quasi-steady"], ["heat-release.wire", "mean-flow.convection", "heater.hot-wires"]]"#,
    ),
];

/// A laboratory whose whole grid was measured once. Every layout is a part of it.
pub(crate) struct Bench {
    folder: PathBuf,
    all: Observations,
    tube: HeatedTube,
    /// Names of the hot points, and their true growth rates.
    pub(crate) hot: Vec<(String, f64)>,
}

/// What is known after a layout.
pub(crate) struct Found {
    study: Study,
    observations: rijke_study::ObservedModes,
    stages: Vec<StageRecord>,
    /// The model that goes on from the last stage, and its rival.
    saved: (SavedModel, Vec<OpenModel>),
    /// Of every hot point: how far the prediction of that model is off, the standard deviation stated for a
    /// measurement, and that of the model alone.
    pub(crate) off: Vec<[f64; 3]>,
}

/// A line of the table.
struct Line {
    layout: String,
    hours: f64,
    /// ln of the Bayes factor for the first model of each pair; none where it was not trained.
    ln: [Option<f64>; 2],
    /// Root mean square error of predicted growth rates, 1/s, and the stated standard deviation.
    predicted: Option<[f64; 2]>,
    /// Whether the data are said to ask for a further term after the better law.
    asks: Option<bool>,
}

/// What was foreseen of a visit, and what it brought.
struct Foreseen {
    aim: &'static str,
    /// ln of the Bayes factor if the model is right that the whole grid decides for: mean and standard
    /// deviation, and what was found.
    factor: [f64; 3],
    /// The same from growth rates and frequencies alone.
    bare: [f64; 2],
    /// The standard deviation of the growth rate asked for.
    sd: [f64; 2],
}

fn place_of(id: &str) -> &str {
    id.rsplit_once('-').map_or("", |(_, place)| place)
}

/// An hour for every point, and one to mount the heater at every place.
pub(crate) fn hours(ids: &[String]) -> f64 {
    let mut places: Vec<&str> = ids.iter().map(|id| place_of(id)).collect();
    places.sort_unstable();
    places.dedup();
    (ids.len() + places.len()) as f64
}

impl Bench {
    /// `name` is that of its folder.
    pub(crate) fn new(name: &str, seed: u64) -> Self {
        let wanted = |p: &TubePoint| {
            let on_the_grid = p.position.is_some_and(|x| PLACES.contains(&((100.0 * x).round() as u32)));
            p.id == "C3-E" || p.row == "C1" || p.row == "H0" || (p.power > 0.0 && on_the_grid)
        };
        let mut campaign = TubeCampaign::juniper_yoko_2022();
        campaign.points.retain(wanted);
        let (rig, truth) = (TubeRig::juniper_yoko_2022(), Truth::standard());
        let lab = VirtualRig::new(&rig, &campaign, &truth, &[], Some(REPEATS), seed).unwrap();
        let all = process(&lab, &ProcessOptions::default(), &|| {}).unwrap().observations;
        let hot = lab.set().points.iter().enumerate().filter(|(_, p)| p.point.factor(POWER) > Some(0.0));
        let hot = hot.map(|(k, p)| (p.point.id.clone(), lab.true_mode(k).0.re)).collect();
        let folder = scratch(&format!("design-study-{name}"));
        let paper = example("juniper-yoko-2022");
        copy(&paper.join("candidates"), &folder.join("candidates"));
        for file in ["rig.toml", "campaign.csv"] {
            fs::copy(paper.join(file), folder.join(file)).unwrap();
        }
        Self { folder, all, tube: lab.tube().clone(), hot }
    }

    /// What is found of the pairs if these hot points are measured; the others are planned.
    pub(crate) fn measured(&self, points: &[String], pairs: &[usize]) -> Found {
        let cold = ramp_study::STUDY.split("[[stage]]\nid = \"heat-release\"").next();
        let mut plan = cold.unwrap().to_owned() + COST;
        for (name, rows) in pairs.iter().map(|k| PAIRS[*k]) {
            plan += &format!("[[stage]]\nid = \"{name}\"\nrows = {rows}\n{NOISE}");
        }
        fs::write(self.folder.join("study.toml"), plan).unwrap();
        let mut observations = self.all.clone();
        let planned = |p: &OperatingPoint| p.factor(POWER) > Some(0.0) && !points.contains(&p.id);
        for p in observations.points.iter_mut().filter(|p| planned(&p.point)) {
            (p.ping, p.click, p.ping_count, p.click_count) = (None, None, 0, 0);
            (p.pings, p.clicks) = (Vec::new(), Vec::new());
        }
        let written = self.folder.join("observations");
        let _ = fs::remove_dir_all(&written);
        observations.write(&written).unwrap();
        self.tube.write_within(&written, &|_| true).unwrap();
        let output = rijke(&self.folder, &["flow", ".", "--out", "base", "--force", "--quiet"]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let study = Study::open(&self.folder).unwrap();
        let observations = study.observations().unwrap();
        let mut run = Run::new(study.clone(), &observations, Trusted::Laplace).unwrap();
        let mut stages = Vec::new();
        while let Some(stage) = run.next_stage().unwrap() {
            stages.push(stage);
        }
        let stages = stages.split_off(stages.len() - pairs.len());
        let last = &stages[stages.len() - 1].id;
        let rival = run.saved_rival(last).unwrap().map(|model| OpenModel { odds: 0.0, model });
        let saved = (run.saved(last).unwrap(), rival.into_iter().collect());
        let places: Vec<usize> = self.hot.iter().map(|(id, _)| study.campaign.point(id).unwrap().0).collect();
        let (forecasts, failed) = forecast(&study, &observations, &saved.0, &[], &places).unwrap();
        assert!(failed.is_empty(), "{failed:?}");
        let off = forecasts.iter().zip(&self.hot);
        let off = off.map(|(f, (_, truth))| [f.growth_rate[0] - truth, f.growth_rate[1], f.growth_rate[2]]);
        Found { study, observations, saved, off: off.collect(), stages }
    }

    /// Visits that `next` plans one after the other, each to a place where the heater was not yet.
    fn visits(&self, aim: Aim, pair: usize, pilot: &[&str], count: usize) -> (Vec<Line>, Vec<Foreseen>) {
        let name = match (aim, pair) {
            (Aim::Models, 0) => "next, laws",
            (Aim::Models, _) => "next, drags",
            _ => "next, parameters",
        };
        let mut ids: Vec<String> = pilot.iter().map(|id| (*id).to_owned()).collect();
        let mut found = self.measured(&ids, &[pair]);
        let (mut lines, mut foreseen) =
            (vec![found.line(&format!("{name}: pilot"), &ids, &[pair])], Vec::new());
        for k in 1..=count {
            let new = |id: &&String| ids.iter().all(|old| place_of(old) != place_of(id));
            let free: Vec<String> = self.hot.iter().map(|h| h.0.clone()).filter(|id| new(&id)).collect();
            let plan = found.next(aim, 3, &free, false).plan;
            let here = |id: &&String| place_of(id) == place_of(&plan[0].point);
            let mut visit: Vec<String> = plan.iter().map(|s| &s.point).filter(here).cloned().collect();
            visit.sort();
            visit.dedup();
            // The greedy plan of these points is these points: a repeat within a visit tells nothing new.
            let said = [false, true].map(|bare| found.next(aim, visit.len(), &visit, bare));
            ids.extend(visit);
            let after = self.measured(&ids, &[pair]);
            let of = |next: &Next| next.factor.unwrap()[usize::from(!found.first_goes_on())];
            let about = self.hot.iter().position(|(id, _)| id == ABOUT).unwrap();
            let gained = after.ln_bayes(0) - found.ln_bayes(0);
            let ([mean, sd], bare) = (of(&said[0]), of(&said[1]));
            foreseen.push(Foreseen {
                aim: name,
                factor: [mean, sd, gained],
                bare,
                sd: [said[0].quantity_sd.unwrap()[1], after.off[about][2]],
            });
            found = after;
            lines.push(found.line(&format!("{name}: {k} visits"), &ids, &[pair]));
        }
        (lines, foreseen)
    }
}

impl Found {
    /// ln of the Bayes factor of the first model of stage `k` for the second.
    fn ln_bayes(&self, k: usize) -> f64 {
        self.stages[k].models[0].ln_evidence() - self.stages[k].models[1].ln_evidence()
    }

    fn first_goes_on(&self) -> bool {
        self.stages[0].models[0].candidates == self.saved.0.candidates
    }

    pub(crate) fn next(&self, aim: Aim, points: usize, free: &[String], without_pressures: bool) -> Next {
        let place = |id: &str| self.study.campaign.point(id).unwrap().0;
        let candidates = free.iter().map(|id| place(id)).collect();
        let wish = Wish { aim, candidates, points, without_pressures, about: Some(place(ABOUT)) };
        next(&self.study, &self.observations, &self.saved.0, &self.saved.1, &wish).unwrap()
    }

    fn line(&self, layout: &str, ids: &[String], pairs: &[usize]) -> Line {
        let mean_square =
            |k: usize| (self.off.iter().map(|o| o[k] * o[k]).sum::<f64>() / self.off.len() as f64).sqrt();
        let mut line = Line {
            layout: layout.to_owned(),
            hours: hours(ids),
            ln: [None; 2],
            predicted: pairs.contains(&1).then(|| [0, 1].map(mean_square)),
            asks: None,
        };
        for (k, pair) in pairs.iter().enumerate() {
            line.ln[*pair] = Some(self.ln_bayes(k));
            if *pair == 0 {
                let missing = self.stages[k].missing.as_ref();
                line.asks =
                    Some(missing.is_some_and(|m| m.families.first().is_some_and(|f| f.beyond.1 < 0.05)));
            }
        }
        line
    }
}

/// Two or more of a list, evenly from its first to its last.
fn even(all: &[u32], count: usize) -> Vec<u32> {
    let place = |k: usize| (k as f64 * (all.len() - 1) as f64 / (count - 1) as f64).round() as usize;
    (0..count).map(|k| all[place(k)]).collect()
}

fn grid(powers: &[u32], places: &[u32]) -> Vec<String> {
    places.iter().flat_map(|x| powers.iter().map(move |p| format!("H{p}-{x}"))).collect()
}

/// All layouts in the laboratory of one seed.
fn one_rig(seed: u64) -> (Vec<Line>, Vec<Foreseen>) {
    let bench = Bench::new(&seed.to_string(), seed);
    let mut layouts = vec![
        ("all".to_owned(), grid(&POWERS, &PLACES)),
        ("the paper's eight".to_owned(), EIGHT.map(String::from).to_vec()),
    ];
    let mut stream = Streams::new(seed).stream("design study");
    let mut any = |of: &[u32]| of.sample(&mut stream, 3).copied().collect::<Vec<_>>();
    layouts.push(("random, 3 powers at 3 places".to_owned(), grid(&any(&POWERS), &any(&PLACES))));
    for powers in 2..=4 {
        for places in 2..=4 {
            let name = format!("even, {powers} powers at {places} places");
            layouts.push((name, grid(&even(&POWERS, powers), &even(&PLACES, places))));
        }
    }
    let line = |(name, ids): &(String, Vec<String>)| bench.measured(ids, &[0, 1]).line(name, ids, &[0, 1]);
    let mut lines: Vec<Line> = layouts.iter().map(line).collect();
    let (two, three) = (["H7-50", "H180-50"], ["H7-50", "H50-50", "H180-50"]);
    let series = [
        bench.visits(Aim::Models, 1, &two, 4),
        bench.visits(Aim::Parameters, 1, &two, 4),
        bench.visits(Aim::Models, 0, &three, 3),
    ];
    let (more, foreseen): (Vec<_>, Vec<_>) = series.into_iter().unzip();
    lines.extend(more.into_iter().flatten());
    fs::remove_dir_all(&bench.folder).unwrap();
    (lines, foreseen.into_iter().flatten().collect())
}

/// Least hours of a layout called so that has `nats`.
fn decided(lines: &[Line], kind: &str, pair: usize, nats: f64) -> f64 {
    let enough =
        lines.iter().filter(|l| l.layout.starts_with(kind) && l.ln[pair].is_some_and(|ln| ln >= nats));
    enough.map(|l| l.hours).fold(f64::INFINITY, f64::min)
}

#[test]
#[ignore = "long: five laboratories and a hundred and fifty rankings, seven minutes"]
fn coverage_of_layouts_that_next_plans_beside_even_ones() {
    let rigs: Vec<(Vec<Line>, Vec<Foreseen>)> = (1..=SEEDS).into_par_iter().map(one_rig).collect();
    println!(
        "| layout | hours | ln Bayes factor, drags | ln Bayes factor, laws | asks for more | rms error, 1/s | stated sd, 1/s |"
    );
    println!("|---|---|---|---|---|---|---|");
    for k in 0..rigs[0].0.len() {
        let of: Vec<&Line> = rigs.iter().map(|(lines, _)| &lines[k]).collect();
        let range = |pair: usize| {
            let all: Option<Vec<f64>> = of.iter().map(|l| l.ln[pair]).collect();
            all.map_or(String::new(), |all| {
                let [low, high] = [f64::min, f64::max].map(|f| all.iter().copied().reduce(f).unwrap());
                format!("{:.0} ({low:.0} to {high:.0})", median(all))
            })
        };
        let predicted = [0, 1].map(|i| {
            let all: Option<Vec<f64>> = of.iter().map(|l| l.predicted.map(|p| p[i])).collect();
            all.map_or(String::new(), |all| format!("{:.3}", median(all)))
        });
        let asks: Option<Vec<bool>> = of.iter().map(|l| l.asks).collect();
        let asks =
            asks.map_or(String::new(), |a| format!("{} of {}", a.iter().filter(|x| **x).count(), a.len()));
        let hours = median(of.iter().map(|l| l.hours).collect());
        let [rms, sd] = predicted;
        println!("| {} | {hours} | {} | {} | {asks} | {rms} | {sd} |", of[0].layout, range(1), range(0));
    }
    println!("\n| pair, nats | `next`, h | best even layout, h | ratio |\n|---|---|---|---|");
    let mut ratios = Vec::new();
    for (pair, kind) in [(1, "next, drags"), (1, "next, parameters"), (0, "next, laws")] {
        for nats in DECIDED {
            let both: Vec<[f64; 2]> =
                rigs.iter().map(|(l, _)| [kind, "even"].map(|k| decided(l, k, pair, nats))).collect();
            let of = |i: usize| both.iter().map(|b| format!("{}", b[i])).collect::<Vec<_>>().join(", ");
            let ratio = median(both.iter().map(|b| b[0] / b[1]).collect());
            println!("| {kind}, {nats} | {} | {} | {ratio:.2} |", of(0), of(1));
            ratios.push((kind, nats, ratio));
        }
    }
    println!(
        "\n| plan for | visits | foreseen, nats | found, nats | within 2 sd | without pressures: foreseen, within 2 sd | foreseen sd over stated |"
    );
    println!("|---|---|---|---|---|---|---|");
    for kind in ["next, drags", "next, parameters", "next, laws"] {
        let all: Vec<&Foreseen> = rigs.iter().flat_map(|(_, f)| f).filter(|f| f.aim == kind).collect();
        let of = |pick: &dyn Fn(&Foreseen) -> f64| median(all.iter().map(|f| pick(f)).collect());
        let share = |pick: &dyn Fn(&Foreseen) -> [f64; 2]| {
            let within = all.iter().filter(|f| (f.factor[2] - pick(f)[0]).abs() < 2.0 * pick(f)[1]).count();
            100.0 * within as f64 / all.len() as f64
        };
        println!(
            "| {kind} | {} | {:.1} | {:.1} | {:.0} % | {:.1}, {:.0} % | {:.2} ({:.0} % within 15 %) |",
            all.len(),
            of(&|f| f.factor[0]),
            of(&|f| f.factor[2]),
            share(&|f| [f.factor[0], f.factor[1]]),
            of(&|f| f.bare[0]),
            share(&|f| f.bare),
            of(&|f| f.sd[0] / f.sd[1]),
            100.0 * all.iter().filter(|f| (f.sd[0] / f.sd[1] - 1.0).abs() < 0.15).count() as f64
                / all.len() as f64
        );
    }
    let all = |what: &str, test: &dyn Fn(&Line) -> bool| {
        let wrong = rigs.iter().flat_map(|(lines, _)| lines).filter(|l| !test(l));
        let wrong: Vec<&str> = wrong.map(|l| l.layout.as_str()).collect();
        assert!(wrong.is_empty(), "{what}: {wrong:?}");
    };
    all("decides for the model of the whole grid", &|l| l.hours < 8.0 || l.ln[1].is_none_or(|ln| ln > 0.0));
    all("errors like those stated", &|l| l.predicted.is_none_or(|[rms, sd]| rms < 2.0 * sd));
    let rms = |kind: &str| {
        let lines = rigs.iter().flat_map(|(lines, _)| lines).filter(|l| l.layout.starts_with(kind));
        median(lines.filter_map(|l| Some(l.predicted?[0])).collect())
    };
    assert!(rms("next, parameters") < rms("even"), "predictions are worse than those of even layouts");
    let mut decides = ratios.iter().filter(|(kind, nats, _)| *kind == "next, drags" && *nats > 5.0);
    assert!(decides.all(|(.., ratio)| *ratio < 2.0), "{ratios:?}");
}
