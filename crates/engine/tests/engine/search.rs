//! The search over all combinations: the same evidence as single runs, the same winner when it gives models
//! up, and the same text whoever did which task.

use crate::common::folder::Folder;
use rand_distr::{Distribution, StandardNormal};
use rijke_engine::run::{
    Combination, GivenUp, Run, Search, SearchOptions, SearchPart, SearchRecord, Trusted, merge_searches,
};
use rijke_numerics::Streams;
use rijke_study::Study;
use std::path::{Path, PathBuf};

const RIG: &str = r#"
name = "tube"
[gas]
temperature = "20 degC"
[upstream]
type = "free"
[downstream]
type = "free"
[[element]]
name = "tube"
type = "duct"
length = "1 m"
diameter = "50 mm"
[[element]]
name = "screen"
type = "device"
at = "x_s"
"#;
const CAMPAIGN: &str = "point,x_s [m],Q,T_amb [degC]\na,,0,20\nb,,0,25\nc,0.2,0,20\nd,0.35,0,20\ne,0.1,0,21\nf,0.2,1,20\ng,0.3,1,20\nh,0.25,2,22\n";
const MODES: &str = "point,growth_rate,growth_rate_sd,frequency,frequency_sd\na,-36.1,0.5,171.5,0.2\nb,-36.6,0.5,173.2,0.2\n\
    c,-40.2,0.5,171.2,0.2\nd,-37.9,0.5,171.4,0.2\ne,-42.3,0.5,171.6,0.2\nf,-38.4,0.5,170.4,0.2\ng,-36.4,0.5,170.5,0.2\nh,-34.7,0.5,170.3,0.2\n";
const CANDIDATES: &str = r#"
[[candidate]]
id = "ends.flat"
role = "ends"
name = "one modulus"
cite = ["test"]
parameters.r = { prior = { normal = { mean = 0.9, sd = 0.1 } } }
[[candidate.effect]]
acts_at = "ends"
reflection = "-r"
[[candidate]]
id = "ends.sloped"
role = "ends"
name = "a modulus and a length"
cite = ["test"]
parameters.r = { prior = { normal = { mean = 0.9, sd = 0.1 } } }
parameters.q = { prior = { normal = { mean = 0.0, sd = 0.05 } } }
[[candidate.effect]]
acts_at = "ends"
reflection = "-r*(1 - q*s*D/c)"
[[candidate]]
id = "screen.drag"
role = "screen"
name = "drag"
cite = ["test"]
parameters.d = { prior = { normal = { mean = 0.02, sd = 0.02 } } }
[[candidate.effect]]
acts_at = "screen"
mu = "d*rho*c"
[[candidate]]
id = "screen.mass"
role = "screen"
name = "drag and mass"
cite = ["test"]
parameters.d = { prior = { normal = { mean = 0.02, sd = 0.02 } } }
parameters.m = { unit = "m", prior = { normal = { mean = 0.0, sd = 0.01 } } }
[[candidate.effect]]
acts_at = "screen"
mu = "d*rho*c + m*s*rho"
[[candidate]]
id = "screen.hot"
role = "hot-screen"
extends = "screen.drag"
name = "drag that grows with heat"
cite = ["test"]
parameters.d = { prior = { normal = { mean = 0.02, sd = 0.02 } } }
parameters.h = { prior = { normal = { mean = 0.0, sd = 0.3 } } }
[[candidate.effect]]
acts_at = "screen"
mu = "d*rho*c*(1 + h*Q)"
[[candidate]]
id = "heat.prompt"
role = "heat"
name = "at once"
cite = ["test"]
parameters.n = { prior = { normal = { mean = 0.02, sd = 0.02 } } }
[[candidate.effect]]
acts_at = "screen"
eu = "-n*Q"
[[candidate]]
id = "heat.late"
role = "heat"
name = "late"
cite = ["test"]
parameters.n = { prior = { normal = { mean = 0.02, sd = 0.02 } } }
parameters.t = { unit = "s", prior = { normal = { mean = 1e-3, sd = 1e-3 } } }
[[candidate.effect]]
acts_at = "screen"
eu = "-n*Q*exp(-s*t)"
"#;
/// `screen.hot` is possible on `screen.drag` only; the row of `ends.sloped` is a combination that is there
/// anyhow.
const PLAN: &str = r#"
name = "t"
[[stage]]
id = "ends"
points = { where = { x_s = "absent" } }
compete = "ends"
decides = 0.0
[stage.noise]
growth_rate = 0.1
angular_frequency = 0.3
[[stage]]
id = "screen"
points = { where = { x_s = "given", Q = 0 } }
on = "ends"
compete = "screen"
rows = [["screen.mass", "ends.sloped"]]
decides = 0.0
[stage.noise]
growth_rate = { median = 0.2, ln_sd = 1.0 }
angular_frequency = 0.3
[[stage]]
id = "aside"
points = { where = { x_s = "absent" } }
compete = "ends"
[[stage]]
id = "heat"
points = { where = { Q = { above = 0 } } }
on = "screen"
compete = "heat"
rows = [["heat.late", "screen.hot"]]
decides = 0.0
[stage.noise]
growth_rate = { like = "screen" }
angular_frequency = 0.3
"#;

fn study(name: &str) -> Folder {
    Folder::new(
        &format!("search-{name}"),
        &[
            ("rig.toml", RIG),
            ("campaign.csv", CAMPAIGN),
            ("study.toml", PLAN),
            ("candidates/all.toml", CANDIDATES),
            ("observations/observations.toml", "kind = \"virtual\"\nsource = \"test\"\n"),
            ("observations/modes.csv", MODES),
        ],
    )
}

fn part(folder: &Path, within: f64, shard: [usize; 2], tasks: Option<&Path>) -> SearchPart {
    let study = Study::open(folder).unwrap();
    let observations = study.observations().unwrap();
    let tasks = tasks.map(Path::to_owned);
    let options = SearchOptions { stage: None, within, trusted: Trusted::Laplace, shard, threads: 0, tasks };
    Search::new(study, &observations, options).unwrap().run(&|_| true).unwrap()
}

fn whole(folder: &Path, within: f64) -> SearchRecord {
    merge_searches(&[part(folder, within, [1, 1], None)]).unwrap()
}

/// ln evidence of every stage of a study whose stages have one row each: these candidates.
fn alone(folder: &Path, rows: [&[&str]; 3]) -> Vec<f64> {
    let mut study = Study::open(folder).unwrap();
    study.plan.stages.remove(2);
    for (stage, row) in study.plan.stages.iter_mut().zip(rows) {
        stage.compete.clear();
        stage.rows = vec![row.iter().map(|id| (*id).to_owned()).collect()];
    }
    let observations = study.observations().unwrap();
    let mut run = Run::new(study, &observations, Trusted::Laplace).unwrap();
    let next = |_| run.next_stage().unwrap().unwrap().models[0].evidence.unwrap().ln_marginal;
    (0..3).map(next).collect()
}

#[test]
fn oracle_combinations_have_the_evidence_of_runs_with_one_candidate_per_role() {
    let folder = study("alone");
    let found = whole(&folder.0, f64::INFINITY);
    assert_eq!((found.combinations, found.best.len()), (10, 10));
    assert_eq!(found.stages, ["ends", "screen", "heat"]);
    let mut total = 0.0;
    for combination in &found.best {
        let of = |role: &str| combination.candidates.get(role).map(String::as_str);
        let heat: Vec<&str> = of("heat").into_iter().chain(of("hot-screen")).collect();
        let alone = alone(&folder.0, [&[of("ends").unwrap()], &[of("screen").unwrap()], &heat]);
        for (searched, alone) in combination.stages.iter().zip(&alone) {
            assert!((searched - alone).abs() < 1e-9, "{searched} {alone}");
        }
        assert!((combination.ln_evidence - alone.iter().sum::<f64>()).abs() < 1e-9);
        total += combination.ln_evidence.exp();
    }
    for combination in &found.best {
        assert!((combination.probability - combination.ln_evidence.exp() / total).abs() < 1e-12);
    }
    let hot = found.choices.iter().find(|c| c.role == "hot-screen").unwrap();
    assert!(hot.candidates.iter().any(|(id, _)| id.is_empty()));
    for choice in &found.choices {
        assert!((choice.candidates.iter().map(|(_, p)| p).sum::<f64>() - 1.0).abs() < 1e-12, "{choice:?}");
    }
}

/// The study with a first stage that leaves both its models open.
fn left_open() -> (Folder, Study) {
    let folder = study("open");
    let mut open = Study::open(&folder.0).unwrap();
    open.plan.stages[0].decides = 50.0;
    (folder, open)
}

#[test]
fn oracle_open_models_are_carried_on_with_the_evidence_of_single_runs() {
    let (folder, study) = left_open();
    let observations = study.observations().unwrap();
    let mut run = Run::new(study, &observations, Trusted::Laplace).unwrap();
    let stage = run.next_stage().unwrap().unwrap();
    assert_eq!(stage.carried.len(), 2);
    for open in &stage.carried {
        let later = |k: usize| -> Vec<&str> { open.later[k].model.split(" + ").collect() };
        let alone: f64 = alone(&folder.0, [&[&open.id], &later(0), &later(1)]).iter().sum();
        // The others begin where the first one ended, so that they end a little elsewhere.
        assert!((open.ln_evidence.unwrap() - alone).abs() < 2e-6, "{open:?} {alone}");
    }
    let worth = |id: &str| stage.carried.iter().find(|c| c.id == id).unwrap().ln_evidence.unwrap();
    let best = stage.carried.iter().map(|c| c.ln_evidence.unwrap()).fold(f64::NEG_INFINITY, f64::max);
    assert_eq!(worth(&stage.chosen), best);
}

#[test]
fn oracle_parameters_are_averaged_over_open_models_as_weighted_draws() {
    let (_folder, study) = left_open();
    let observations = study.observations().unwrap();
    let mut run = Run::new(study, &observations, Trusted::Laplace).unwrap();
    let first = run.next_stage().unwrap().unwrap();
    let mut next = || run.next_stage().unwrap().unwrap();
    let (screen, _, heat) = (next(), next(), next());
    let model = heat.models.iter().find(|m| m.id == heat.chosen).unwrap();
    let parameter = model.parameters.iter().find(|p| p.name == "t").unwrap();
    let most = first.carried.iter().filter_map(|c| c.ln_evidence).fold(f64::NEG_INFINITY, f64::max);
    let mut normal = Streams::new(1).stream("draws");
    let mut draws: Vec<[f64; 2]> = Vec::new();
    for open in &first.carried {
        let later = open.later.iter().find(|l| l.stage == "heat").unwrap();
        assert_eq!(later.model, model.id);
        let t = later.parameters.iter().find(|p| p.name == "t").unwrap();
        let weight = (open.ln_evidence.unwrap() - most).exp();
        draws.extend((0..100_000).map(|_| {
            let white: f64 = StandardNormal.sample(&mut normal);
            [weight, t.value + t.sd * white]
        }));
    }
    let sum: f64 = draws.iter().map(|[w, _]| w).sum();
    let mean = draws.iter().map(|[w, x]| w * x).sum::<f64>() / sum;
    let sd = (draws.iter().map(|[w, x]| w * (x - mean).powi(2)).sum::<f64>() / sum).sqrt();
    let [value, stated] = parameter.averaged.unwrap();
    assert!(
        (value - mean).abs() < 0.01 * sd && (stated / sd - 1.0).abs() < 0.01,
        "{value} {mean} {stated} {sd}"
    );
    assert!(first.models.iter().flat_map(|m| &m.parameters).all(|p| p.averaged.is_none()));
    // With the other ends another screen is the best.
    assert!(
        screen.assumes.iter().any(|said| said.contains("`screen.drag` would be the best")),
        "{:?}",
        screen.assumes
    );
}

#[test]
fn oracle_the_greedy_choice_is_that_of_the_ranking() {
    let folder = study("greedy");
    let study = Study::open(&folder.0).unwrap();
    let observations = study.observations().unwrap();
    let mut run = Run::new(study, &observations, Trusted::Laplace).unwrap();
    let mut candidates = std::collections::BTreeMap::new();
    while let Some(stage) = run.next_stage().unwrap() {
        if stage.id != "aside" {
            let model = stage.models.iter().find(|m| m.id == stage.chosen).unwrap();
            candidates.extend(model.candidates.clone());
        }
    }
    let found = whole(&folder.0, f64::INFINITY);
    assert_eq!(found.greedy.candidates, candidates);
    let place = found.greedy.rank.unwrap();
    assert_eq!(found.best[place - 1].candidates, candidates);
    assert_eq!(found.greedy.probability, found.best[place - 1].probability);
}

#[test]
fn oracle_a_search_that_gives_up_models_finds_the_same_winner() {
    let folder = study("pruned");
    let every = whole(&folder.0, f64::INFINITY);
    let found = whole(&folder.0, 0.01);
    assert!(!found.given_up.is_empty() && found.models_trained < every.models_trained);
    assert_eq!(found.best[0].candidates, every.best[0].candidates);
    assert_eq!(found.best[0].ln_evidence, every.best[0].ln_evidence);
    // What it left holds no more than it says.
    let followed = |c: &&Combination| found.best.iter().any(|f| f.candidates == c.candidates);
    let left: f64 = every.best.iter().filter(|c| !followed(c)).map(|c| c.probability).sum();
    // Nothing gains more than it does here, where all is followed.
    let more = every.gained.iter().zip(&found.gained).map(|(all, seen)| all - seen).fold(0.0, f64::max);
    assert!(left > 0.0 && left <= found.given_up_at_most * more.exp(), "{left} {}", found.given_up_at_most);
    // As much as the one that was followed in its place, and what its stage may gain.
    let weight = |ln: f64| (ln - found.best[0].ln_evidence).exp();
    let held = |g: &GivenUp| {
        let same = |c: &Combination| g.candidates.iter().all(|(role, id)| c.candidates.get(role) == Some(id));
        let followed: Vec<&Combination> = found.best.iter().filter(|c| same(c)).collect();
        let [followed] = followed[..] else { panic!("{g:?}") };
        let level = found.stages.iter().position(|stage| *stage == g.stage).unwrap();
        g.combinations as f64 * weight(followed.ln_evidence + found.gained[level])
    };
    let weights: Vec<f64> = found.given_up.iter().map(held).collect();
    let all: f64 = weights.iter().copied().chain(found.best.iter().map(|c| weight(c.ln_evidence))).sum();
    for (g, weight) in found.given_up.iter().zip(&weights) {
        assert!((g.at_most - weight / all).abs() < 1e-12, "{g:?} {}", weight / all);
    }
    let counted: usize = found.given_up.iter().map(|g| g.combinations).sum();
    assert_eq!(counted + found.best.len(), found.combinations);
}

#[test]
fn exact_parts_join_to_the_same_text() {
    let folder = study("shards");
    let text = |parts: &[SearchPart]| serde_json::to_string(&merge_searches(parts).unwrap()).unwrap();
    let one = text(&[part(&folder.0, 0.01, [1, 1], None)]);
    for n in [2, 7] {
        let mut parts: Vec<SearchPart> = (1..=n).map(|k| part(&folder.0, 0.01, [k, n], None)).collect();
        assert!(parts.iter().all(|p| p.nodes.len() < parts[0].models));
        parts.reverse();
        parts.push(part(&folder.0, 0.01, [1, n], None));
        assert_eq!(text(&parts), one, "{n} shards");
        // Through a file and back.
        let read = |p: &SearchPart| serde_json::from_str(&serde_json::to_string(p).unwrap()).unwrap();
        assert_eq!(text(&parts.iter().map(read).collect::<Vec<_>>()), one);
    }
}

#[test]
fn behaviour_a_search_that_was_killed_goes_on_to_the_same_end() {
    let folder = study("killed");
    let tasks = folder.0.join("tasks");
    let first = part(&folder.0, f64::INFINITY, [1, 1], Some(&tasks));
    let mut kept: Vec<PathBuf> = std::fs::read_dir(&tasks).unwrap().map(|e| e.unwrap().path()).collect();
    kept.sort();
    assert_eq!(kept.len(), first.nodes.len() + 1, "a file for each model, and the greedy choice");
    // Killed at any moment: some tasks are missing, one file is torn.
    for (k, path) in kept.iter().enumerate() {
        match k % 3 {
            0 => std::fs::remove_file(path).unwrap(),
            1 if k < 6 => std::fs::write(path, "{\"evidence\":").unwrap(),
            _ => {}
        }
    }
    assert_eq!(part(&folder.0, f64::INFINITY, [1, 1], Some(&tasks)), first);
    assert_eq!(std::fs::read_dir(&tasks).unwrap().count(), kept.len());
    // Tasks of other data have other names.
    let modes = folder.0.join("observations/modes.csv");
    std::fs::write(&modes, MODES.replace("h,-34.7", "h,-34.8")).unwrap();
    let changed = part(&folder.0, f64::INFINITY, [1, 1], Some(&tasks));
    for (old, new) in first.nodes.iter().zip(&changed.nodes) {
        assert_eq!(old.task == new.task, old.level < 2, "only the last stage has that point");
    }
}

#[test]
fn message_parts_that_do_not_make_a_whole_are_refused() {
    let folder = study("parts");
    let parts: Vec<SearchPart> = (1..=3).map(|k| part(&folder.0, 20.0, [k, 3], None)).collect();
    let said = merge_searches(&parts[..2]).unwrap_err().to_string();
    assert!(said.contains("make shard 3 of 3 too"), "{said}");
    let other = part(&folder.0, 10.0, [3, 3], None);
    let said = merge_searches(&[parts[0].clone(), parts[1].clone(), other]).unwrap_err().to_string();
    assert!(said.contains("shard 3 of 3 is of another search"), "{said}");
}

/// One stage after the other, and both at once, where the noise is known: the sum of ln evidences is that of
/// all data.
#[test]
fn oracle_the_sum_over_stages_is_the_evidence_of_all_data() {
    let folder = study("joint");
    let known = |plan: &str| plan.replace("{ median = 0.2, ln_sd = 1.0 }", "0.1");
    std::fs::write(folder.0.join("study.toml"), known(PLAN)).unwrap();
    let [ends, screen, _] = alone(&folder.0, [&["ends.flat"], &["screen.drag"], &["heat.prompt"]])[..] else {
        panic!()
    };
    let at_once = "name = \"t\"\n[[stage]]\nid = \"all\"\npoints = { where = { Q = 0 } }\nwith = { ends = \"ends.flat\", screen = \"screen.drag\" }\n\
        [stage.noise]\ngrowth_rate = 0.1\nangular_frequency = 0.3\n";
    std::fs::write(folder.0.join("study.toml"), at_once).unwrap();
    let study = Study::open(&folder.0).unwrap();
    let observations = study.observations().unwrap();
    let mut run = Run::new(study, &observations, Trusted::Laplace).unwrap();
    let all = run.next_stage().unwrap().unwrap().models[0].evidence.unwrap().ln_marginal;
    assert!((ends + screen - all).abs() < 5e-4, "{} {all}", ends + screen);
}
