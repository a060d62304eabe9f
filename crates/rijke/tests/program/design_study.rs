//! The long study behind docs/records/designs.md: does `rijke next` save hours of the rig?
//! `cargo test --release --test program design_study -- --ignored --nocapture` prints its tables.

use crate::{copy, example, rijke, scratch};
use rijke_engine::run::{Aim, Next, Run, StageRecord, Trusted, Wish, forecast, next};
use rijke_engine::SavedModel;
use rijke_lab::{Truth, VirtualRig};
use rijke_rig::{Campaign, Observations, RecordSource, Rig};
use rijke_signal::{ProcessOptions, process};
use rijke_study::Study;
use std::{fs, path::PathBuf, time::Instant};

const SEEDS: u64 = 1;
const REPEATS: u32 = 4;
const POWERS: [u32; 7] = [7, 15, 30, 50, 80, 130, 180];
const EIGHT: [&str; 8] =
    ["H7-15", "H7-85", "H50-25", "H50-75", "H180-15", "H180-25", "H180-50", "H180-85"];

const STUDY: &str = r#"
name = "Designs"
[base.states]
points = { where = { Q_h = { above = 0 } } }
[cost]
point = "1 h"
installation = "1 h"
[[stage]]
id = "empty-tube"
points = { where = { X_h = "absent", Q_h = 0, thermocouples = false }, first = 1 }
with = { wall = "wall.zwikker-kosten", ends = "ends.calibrated" }
channels = true
[stage.noise]
growth_rate = 0.1
angular_frequency = 1.0
pressure = { median = 1e-3, ln_sd = 1.0 }
varying = [{ parameter = "k_r", sd = 7e-5 }, { parameter = "k_i", sd = 0.0031 }]
[[stage]]
id = "cold"
points = { where = { Q_h = 0, thermocouples = false, heater = true } }
on = "empty-tube"
with = { prongs = "prongs.6", heater = "heater.wires" }
channels = true
[stage.noise]
varying = [{ parameter = "k_r", sd = { median = 7e-5, ln_sd = 1.0 } }, { parameter = "k_i", sd = { median = 0.0031, ln_sd = 1.0 } }]
[[stage]]
id = "thermocouples"
points = { where = { Q_h = 0, thermocouples = true } }
on = "cold"
with = { thermocouples = "thermocouples.paper" }
channels = true
[stage.noise]
varying = [{ parameter = "k_r", sd = { median = 7e-5, ln_sd = 1.0 } }, { parameter = "k_i", sd = { median = 0.0031, ln_sd = 1.0 } }]
"#;

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

const PAIRS: [(&str, &str); 2] = [
    ("laws", r#"rows = [["heat-release.6"], ["heat-release.8"]]"#),
    ("drags", r#"rows = [["heat-release.wire", "mean-flow.convection", "steady-drag.quasi-steady"], ["heat-release.wire", "mean-flow.convection", "heater.hot-wires"]]"#),
];

struct Bench {
    folder: PathBuf,
    all: Observations,
    /// Names of the hot points, and their true growth rates.
    hot: Vec<(String, f64)>,
}

struct Found {
    study: Study,
    observations: rijke_study::Observations,
    stages: Vec<StageRecord>,
    saved: Vec<(SavedModel, Option<SavedModel>)>,
    /// predicted - true, sd per hot point by the last pair's winner
    off: Vec<[f64; 2]>,
}

impl Bench {
    fn new(seed: u64) -> Self {
        let campaign = Campaign::juniper_yoko_2022();
        let lab = VirtualRig::new(&Rig::juniper_yoko_2022(), &campaign, &Truth::standard(), &[], Some(REPEATS), seed)
            .unwrap();
        let all = process(&lab, &ProcessOptions::default(), &|| {}).unwrap().observations;
        let hot = lab.set().points.iter().enumerate().filter(|(_, p)| p.point.power > 0.0);
        let hot = hot.map(|(k, p)| (p.point.id.clone(), lab.true_mode(k).0.re)).collect();
        let folder = scratch(&format!("design-study-{seed}"));
        let paper = example("juniper-yoko-2022");
        copy(&paper.join("candidates"), &folder.join("candidates"));
        for file in ["rig.toml", "campaign.csv"] {
            fs::copy(paper.join(file), folder.join(file)).unwrap();
        }
        Self { folder, all, hot }
    }

    /// What is found if these hot points are measured, of the pairs numbered so.
    fn measured(&self, points: &[String], pairs: &[usize]) -> Found {
        let mut plan = STUDY.to_owned();
        for (name, rows) in pairs.iter().map(|k| PAIRS[*k]) {
            plan += &format!("[[stage]]\nid = \"{name}\"\n{rows}\n{NOISE}");
        }
        fs::write(self.folder.join("study.toml"), plan).unwrap();
        let mut observations = self.all.clone();
        for p in observations.points.iter_mut().filter(|p| p.point.power > 0.0 && !points.contains(&p.point.id)) {
            (p.ping, p.click, p.ping_count, p.click_count) = (None, None, 0, 0);
            (p.pings, p.clicks) = (Vec::new(), Vec::new());
        }
        let place = self.folder.join("observations");
        let _ = fs::remove_dir_all(&place);
        let t = Instant::now();
        observations.write(&place).unwrap();
        let output = rijke(&self.folder, &["flow", ".", "--out", "base", "--force", "--quiet"]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let flow = t.elapsed().as_secs_f64();
        let study = Study::open(&self.folder).unwrap();
        let observations = study.observations().unwrap();
        let mut run = Run::new(study.clone(), &observations, Trusted::Laplace).unwrap();
        let mut stages = Vec::new();
        while let Some(stage) = run.next_stage().unwrap() {
            stages.push(stage);
        }
        let stages = stages.split_off(3);
        let saved: Vec<_> =
            stages.iter().map(|s| (run.saved(&s.id).unwrap(), run.saved_rival(&s.id))).collect();
        let train = t.elapsed().as_secs_f64() - flow;
        let places: Vec<usize> = self.hot.iter().map(|(id, _)| study.campaign.point(id).unwrap().0).collect();
        let (forecasts, failed) =
            forecast(&study, &observations, &saved.last().unwrap().0, &places).unwrap();
        assert!(failed.is_empty(), "{failed:?}");
        let off = forecasts.iter().zip(&self.hot);
        let off = off.map(|(f, (_, truth))| [f.growth_rate[0] - truth, f.growth_rate[1]]).collect();
        println!("    flow {flow:.1} train {train:.1} forecast {:.1}", t.elapsed().as_secs_f64() - flow - train);
        Found { study, observations, stages, saved, off }
    }
}

impl Found {
    /// ln Bayes factor of the first row of pair `k` against the second.
    fn ln_bayes(&self, k: usize) -> f64 {
        self.stages[k].models[0].ln_evidence() - self.stages[k].models[1].ln_evidence()
    }

    fn next(&self, aim: Aim, points: usize, free: &[String], pressures: bool) -> Next {
        let candidates = free.iter().map(|id| self.study.campaign.point(id).unwrap().0).collect();
        let wish = Wish { aim, candidates, points, pressures, ..Wish::default() };
        let (model, rival) = &self.saved[0];
        next(&self.study, &self.observations, model, rival.as_ref(), &wish).unwrap()
    }

    fn line(&self, name: &str, hours: f64) {
        let n = self.off.len() as f64;
        let rms = (self.off.iter().map(|o| o[0] * o[0]).sum::<f64>() / n).sqrt();
        let sd = (self.off.iter().map(|o| o[1] * o[1]).sum::<f64>() / n).sqrt();
        let covered = self.off.iter().filter(|o| o[0].abs() < 1.96 * o[1]).count() as f64 / n;
        let pairs: Vec<String> = (0..self.stages.len())
            .map(|k| {
                let s = &self.stages[k];
                let missing = s.missing.as_ref().and_then(|m| m.families.first()).map(|f| f.beyond);
                format!("{} {:.1} (misfit {:.4?}; missing {:.2?})", s.id, self.ln_bayes(k), s.models.iter().map(|m| m.misfit).collect::<Vec<_>>(), missing)
            })
            .collect();
        println!("  {name} {hours} h: {} | rms {rms:.3} sd {sd:.3} covered {covered:.2}", pairs.join(", "));
    }
}

fn even<T: Copy>(all: &[T], count: usize) -> Vec<T> {
    if count == 1 {
        return vec![all[all.len() / 2]];
    }
    (0..count).map(|k| all[(k as f64 * (all.len() - 1) as f64 / (count - 1) as f64).round() as usize]).collect()
}

#[test]
#[ignore = "long: some hundred rankings, twenty minutes"]
fn behaviour_next_against_even_layouts() {
    let places: Vec<u32> = (0..15).map(|k| 15 + 5 * k).collect();
    for seed in 1..=SEEDS {
        let t = Instant::now();
        let bench = Bench::new(seed);
        println!("seed {seed}: made in {:.1}", t.elapsed().as_secs_f64());
        let every: Vec<String> = bench.hot.iter().map(|h| h.0.clone()).collect();
        bench.measured(&every, &[0, 1]).line("full", 120.0);
        let eight: Vec<String> = EIGHT.map(String::from).to_vec();
        bench.measured(&eight, &[0, 1]).line("eight", 13.0);
        for powers in [2, 3, 4].into_iter().filter(|_| seed > 1) {
            for n in [1, 2, 3, 4] {
                let ids: Vec<String> = even(&places, n).iter().flat_map(|x| even(&POWERS, powers).into_iter().map(move |p| format!("H{p}-{x}"))).collect();
                let hours = n * (1 + powers);
                bench.measured(&ids, &[0, 1]).line(&format!("even {powers} x {n}"), hours as f64);
            }
        }
        for (k, aim) in [(1, Aim::Models), (0, Aim::Models), (1, Aim::Parameters)] {
            let mut ids: Vec<String> = ["H7-50", "H50-50", "H180-50"].map(String::from).to_vec();
            let mut hours = 4.0;
            let mut found = bench.measured(&ids, &[k]);
            for _ in 0..4 {
                found.line(&format!("next {aim:?} {}", ids[3..].join(" ")), hours);
                let free: Vec<String> = every.iter().filter(|id| !ids.contains(id)).cloned().collect();
                let t = Instant::now();
                let plan = found.next(aim, 3, &free, true);
                println!("    next {:.2} s: {:?}, total {:?}, left out {:?}", t.elapsed().as_secs_f64(), plan.plan.iter().map(|s| (s.point.clone(), s.adds)).collect::<Vec<_>>(), plan.total, plan.left_out.len());
                let at = |id: &str| id.split('-').next_back().unwrap().to_owned();
                let here = at(&plan.plan[0].point);
                let visit: Vec<String> = plan.plan.iter().map(|s| s.point.clone()).filter(|id| at(id) == here).collect();
                let before = found.ln_bayes(0);
                let said = [false, true].map(|p| found.next(aim, visit.len(), &visit, p));
                hours += 1.0 + visit.len() as f64;
                ids.extend(visit);
                found = bench.measured(&ids, &[k]);
                for said in said {
                    println!("    foreseen {:?} {:?}, found {:.2}", said.plan.iter().map(|s| s.point.clone()).collect::<Vec<_>>(), said.factor, found.ln_bayes(0) - before);
                }
            }
            found.line(&format!("next {aim:?} {}", ids[3..].join(" ")), hours);
        }
    }
}
