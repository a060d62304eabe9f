//! The long study behind docs/records/missing.md: run it with `cargo test --release --test engine missing --
//! --ignored --nocapture`.
#![allow(clippy::print_stdout, reason = "a study prints its tables")]

use super::is;
use super::variants::{COMBUSTOR, DUCTED_FLAME, Example, QUARTER_WAVE, Variant, has_formula};
use rand_distr::{Distribution, StandardNormal};
use rijke_engine::run::{Asked, Chosen, Family, Missing, Run, Trusted};
use rijke_engine::{Conditions, Misfit, Observed, PointModel};
use rijke_inference::relative_noise;
use rijke_network::Workspace;
use rijke_numerics::{C64, Cholesky, Matrix, Order, Stream, Streams};
use rijke_study::{ObservedMode, ObservedModes, PointState};

const HEAT: &str = "with = { heat-release = \"heat.king-lighthill\" }\n";

/// An effect that is taken out of the model: its name, the example, the last stage with and without it, what
/// counts as found, and where that is, m; anywhere if that is no number.
pub(crate) struct Taken {
    pub(crate) what: &'static str,
    pub(crate) example: &'static Example,
    pub(crate) last: &'static str,
    pub(crate) change: Change,
    effects: &'static [&'static str],
    x: f64,
}

pub(crate) enum Change {
    Without(&'static str),
    Instead(&'static str),
    /// The candidates that stay.
    Only,
}

const FLAME: &str = "with = { flame = \"flame.table\" }\n";
const DRAG: &[&str] = &["inertia", "resistance"];
const HEATS: &[&str] = &["heat release"];
const ENDS: &[&str] = &["reflection"];
const WALLS: &[&str] = &["friction of walls", "heat to walls", "boundary layers"];

const fn taken(
    what: &'static str,
    example: &'static Example,
    last: &'static str,
    change: Change,
    effects: &'static [&'static str],
    x: f64,
) -> Taken {
    Taken { what, example, last, change, effects, x }
}

pub(crate) static CASES: [Taken; 12] = [
    taken("gauze", &QUARTER_WAVE, HEAT, Change::Without("gauze"), DRAG, 0.32),
    taken("heat release", &QUARTER_WAVE, HEAT, Change::Only, HEATS, 0.32),
    taken("loss of the inlet", &QUARTER_WAVE, HEAT, Change::Instead("inlet = \"inlet.rigid\""), ENDS, 0.0),
    taken("length of the mouth", &QUARTER_WAVE, HEAT, Change::Instead("mouth = \"mouth.thin\""), ENDS, 0.8),
    taken("wall", &QUARTER_WAVE, HEAT, Change::Without("wall"), WALLS, f64::NAN),
    taken("swirler", &DUCTED_FLAME, FLAME, Change::Without("swirler"), DRAG, 0.33),
    taken("mouth of the burner", &DUCTED_FLAME, FLAME, Change::Without("mouth"), DRAG, 0.369),
    taken("junction", &DUCTED_FLAME, FLAME, Change::Without("junction"), DRAG, 0.249),
    taken("flame", &DUCTED_FLAME, FLAME, Change::Only, HEATS, 0.40),
    taken(
        "length of the outlet",
        &DUCTED_FLAME,
        FLAME,
        Change::Instead("outlet = \"outlet.thin\""),
        ENDS,
        f64::NAN,
    ),
    taken("wall", &DUCTED_FLAME, FLAME, Change::Without("wall"), WALLS, f64::NAN),
    taken(
        "mass of junctions",
        &COMBUSTOR,
        "with = { damper = \"damper.layers\" }\n",
        Change::Instead("junctions = \"junctions.none\""),
        DRAG,
        0.4,
    ),
];

impl Taken {
    fn last(&self) -> String {
        match self.change {
            Change::Without(role) => format!("{}without = [\"{role}\"]\n", self.last),
            Change::Instead(other) => self.last.replace(" }", &format!(", {other} }}")),
            Change::Only => String::new(),
        }
    }

    pub(crate) fn is(&self, asked: &Asked) -> bool {
        if self.x.is_nan() {
            return self.effects.iter().any(|e| asked.effect.starts_with(e));
        }
        is(asked, self.effects, self.x)
    }
}

/// Places of the removed effect among the families of `missing`: as their first term, and as a member.
fn places(taken: &Taken, missing: &Missing) -> [Option<usize>; 2] {
    let first = missing.families.iter().position(|f| taken.is(&f.first));
    let alike = |f: &Family| {
        let is = |words: &String| {
            missing
                .best
                .iter()
                .any(|a| words.starts_with(&format!("{} at {}", a.effect, a.place)) && taken.is(a))
        };
        taken.is(&f.first) || f.like.iter().any(is)
    };
    [first, missing.families.iter().position(alike)]
}

fn told(taken: &Taken, missing: &Missing) -> [bool; 2] {
    let found = places(taken, missing);
    let shown = |place: Option<usize>| place.map_or("-".into(), |k| (k + 1).to_string());
    let first = |f: &Family| format!("{} ({:.1})", f.first.words(), f.beyond.0);
    println!(
        "| {} | {} | {} | {} | {} |",
        taken.example.name,
        taken.what,
        shown(found[0]),
        shown(found[1]),
        missing.families.iter().take(3).map(first).collect::<Vec<_>>().join("; ")
    );
    found.map(|place| place.is_some_and(|k| k < 3))
}

const HEAD: &str = "| example | taken away | first term of family | member of family | first terms, nats beyond those before |\n|---|---|---|---|---|";

#[test]
#[ignore = "a study of some minutes"]
fn lab_effects_that_are_taken_away_are_asked_for() {
    println!("{HEAD}");
    let mut count = [0, 0];
    for (k, taken) in CASES.iter().enumerate() {
        let stages = Variant::new(&format!("taken-{k}"), taken.example).stage(&taken.last()).try_run();
        match stages.map(|mut all| all.pop().and_then(|s| s.missing)) {
            Ok(Some(missing)) => {
                let found = told(taken, &missing);
                (0..2).for_each(|i| count[i] += usize::from(found[i]));
            }
            other => println!(
                "| {} | {} | - | - | {:?} |",
                taken.example.name,
                taken.what,
                other.err().map(|e| e.to_string())
            ),
        }
    }
    println!("{count:?} of {} among the first three", CASES.len());
    assert!(count[1] >= 6, "{count:?}");
}

/// The same where the model with the effect is the truth: its last stage alone, with its own noise.
#[test]
#[ignore = "a study of some minutes"]
fn oracle_effects_that_are_taken_from_the_true_model_are_asked_for() {
    println!("{HEAD}");
    let mut count = [0, 0];
    for (k, taken) in CASES.iter().enumerate() {
        // One stage: the last, with everything that the earlier ones bring.
        let stages: Vec<&str> = taken.example.stages.split("[[stage]]").collect();
        let with = |text: &str| {
            text.split_once("with = { ").and_then(|(_, t)| t.split_once(" }")).map(|(t, _)| t.to_owned())
        };
        let brought: Vec<String> = stages.iter().filter_map(|s| with(s)).collect();
        let last = stages
            .last()
            .unwrap()
            .lines()
            .filter(|l| !l.starts_with("on = ") && !l.starts_with("base_errors"))
            .collect::<Vec<_>>()
            .join("\n");
        let alone = |own: &str| {
            let mut roles: Vec<String> =
                brought.iter().flat_map(|b| b.split(", ")).map(str::to_owned).collect();
            roles.extend(with(own).iter().flat_map(|b| b.split(", ")).map(str::to_owned));
            // A later choice takes the place of an earlier one of its role.
            let role = |text: &str| text.split(" = ").next().unwrap().to_owned();
            let without =
                own.split_once("without = [\"").map(|(_, t)| t.split('"').next().unwrap().to_owned());
            let kept: Vec<String> = (0..roles.len())
                .filter(|&i| roles[i + 1..].iter().all(|later| role(later) != role(&roles[i])))
                .filter(|&i| without.as_deref() != Some(&role(&roles[i])))
                .map(|i| roles[i].clone())
                .collect();
            format!("[[stage]]{last}\nwith = {{ {} }}\n[stage.noise]\nmeasured = false\n", kept.join(", "))
        };
        let bare = Example { name: taken.example.name, stages: "", more: taken.example.more };
        let whole = Variant::new(&format!("true-{k}"), &bare).stage(&alone(taken.last));
        let truth = whole.study();
        let observations = truth.observations().unwrap();
        let mut run = Run::new(truth.clone(), &observations, Trusted::Laplace).unwrap();
        let id = truth.plan.stages[0].id.clone();
        run.next_stage().unwrap();
        let drawn = drawn(run.chosen(&id).unwrap(), &observations, &Streams::new(5), &format!("{k}"), false);
        let less = Variant::new(&format!("less-{k}"), &bare).stage(&alone(&taken.last()));
        let found = Run::new(less.study(), &drawn, Trusted::Laplace).and_then(|mut run| run.next_stage());
        match found.map(|s| s.and_then(|s| s.missing)) {
            Ok(Some(missing)) => {
                let found = told(taken, &missing);
                (0..2).for_each(|i| count[i] += usize::from(found[i]));
            }
            other => println!(
                "| {} | {} | - | - | {:?} |",
                taken.example.name,
                taken.what,
                other.err().map(|e| e.to_string())
            ),
        }
    }
    println!("{count:?} of {} among the first three", CASES.len());
    assert!(count[1] >= 9, "{count:?}");
}

#[test]
#[ignore = "a study of some minutes"]
fn oracle_gains_follow_trainings_with_the_terms() {
    for (name, example, last) in [
        ("complete", &QUARTER_WAVE, HEAT.to_owned()),
        ("without the gauze", &QUARTER_WAVE, format!("{HEAT}without = [\"gauze\"]\n")),
        ("complete", &DUCTED_FLAME, "with = { flame = \"flame.table\" }\n".to_owned()),
    ] {
        let found = Variant::new("all", example).stage(&last).run().pop().unwrap().missing.unwrap();
        let terms: Vec<&Asked> = found.best.iter().filter(|a| has_formula(a)).collect();
        let chosen: Vec<&Asked> = terms.iter().copied().step_by((terms.len() / 24).max(1)).collect();
        let gains = Variant::new("refits", example).refits(&last, &chosen);
        println!(
            "\n{} {name}: {} terms\n| term | foreseen | trained |\n|---|---|---|",
            example.name,
            chosen.len()
        );
        for (asked, gain) in chosen.iter().zip(&gains) {
            println!("| {} | {:.2} | {gain:.2} |", asked.words(), asked.gain);
        }
        let foreseen: Vec<f64> = chosen.iter().map(|a| a.gain).collect();
        let spearman = correlation(&ranks(&foreseen), &ranks(&gains));
        println!("rank correlation {spearman:.3}");
        assert!(chosen.len() >= 20 && spearman > 0.9, "{spearman}");
    }
}

#[test]
#[ignore = "a study of some minutes"]
fn coverage_data_of_the_model_itself_ask_for_nothing() {
    let whole = "[[stage]]\nid = \"all\"\ntitle = \"all\"\npoints = { where = { Q = { above = 0 } } }\nwith = { wall = \"wall.kirchhoff\", inlet = \"inlet.blown\", mouth = \"mouth.thick\", \
                 gauze = \"gauze.wires\", heat-release = \"heat.king-lighthill\" }\n";
    const ALL: Example = Example { name: "quarter-wave", stages: "", more: ["", ""] };
    for (name, noise) in [
        ("measured errors and misfit", ""),
        ("misfit alone", "[stage.noise]\nmeasured = false\n"),
        ("misfit alone, 36 modes of the cold gauze", "[stage.noise]\nmeasured = false\n"),
    ] {
        let text = if name.contains("36") {
            whole
                .replace("Q = { above = 0 }", "gauze = true, Q = 0")
                .replace(", heat-release = \"heat.king-lighthill\"", "")
        } else {
            whole.to_owned()
        };
        let variant = Variant::new("null", &ALL).stage(&format!("{text}{noise}"));
        let study = variant.study();
        let observations = study.observations().unwrap();
        let mut run = Run::new(study.clone(), &observations, Trusted::Laplace).unwrap();
        run.next_stage().unwrap();
        let chosen = run.chosen("all").unwrap();
        let streams = Streams::new(11);
        let sets = 200;
        let alarms: Vec<bool> = (0..sets)
            .map(|k| {
                let drawn = drawn(chosen, &observations, &streams, &format!("{name}/{k}"), noise.is_empty());
                let mut run = Run::new(study.clone(), &drawn, Trusted::Laplace).unwrap();
                let missing = run.next_stage().unwrap().unwrap().missing.unwrap();
                missing.families[0].first.probability <= 0.05
            })
            .collect();
        let count = alarms.iter().filter(|a| **a).count();
        println!("{name}: {count} of {sets} data sets ask for something at 5 %");
        // 5 % of 200, and two standard deviations of chance.
        assert!(count <= 16, "{count}");
    }
}

/// Observations as the trained model would give them, with its own noise.
pub(crate) fn drawn(
    chosen: &Chosen,
    like: &ObservedModes,
    streams: &Streams,
    name: &str,
    measured: bool,
) -> ObservedModes {
    let mut stream = streams.stream(name);
    let base = |o: &Observed| o.conditions.base.clone();
    drawn_in(chosen, like, &mut stream, [1.0, if measured { 1.0 } else { 0.0 }], &base)
}

/// As [`drawn`], in gas that differs from what is stated of it; misfit and measured errors are so many times
/// as large.
pub(crate) fn drawn_in(
    chosen: &Chosen,
    like: &ObservedModes,
    stream: &mut Stream,
    [misfit_times, measured_times]: [f64; 2],
    base: &dyn Fn(&Observed) -> PointState,
) -> ObservedModes {
    let values = &chosen.trained.values[..chosen.trained.own];
    let sds = Misfit::of(&chosen.trained.noise).measured.map(|sd| misfit_times * sd);
    let count = chosen.assembly.rig.microphones.at.len();
    let modes = chosen.observed.iter().map(|o| {
        let microphones: Vec<usize> = (0..count).collect();
        let conditions = Conditions { base: base(o), ..(*o.conditions).clone() };
        let model =
            PointModel::new(&chosen.assembly, &conditions, &microphones).unwrap().starting_from(o.near);
        let response = model.respond(values, Order::Value, &mut Workspace::default()).unwrap();
        let s = response.s.value();
        let pressures: Vec<(usize, C64)> =
            o.mode.pressures.iter().map(|(m, _)| (*m, response.pressures[*m].value())).collect();
        let n = 2 + 2 * pressures.len();
        let shape = relative_noise(&pressures.iter().map(|p| p.1).collect::<Vec<_>>());
        let misfit = Matrix::from_fn(n, n, |i, j| match (i, j) {
            (0 | 1, _) | (_, 0 | 1) => {
                if i == j {
                    sds[i].powi(2)
                } else {
                    0.0
                }
            }
            _ => sds[2].powi(2) * shape[(i - 2, j - 2)],
        });
        let covariance = misfit.plus(measured_times * measured_times, &o.mode.covariance);
        let xi: Vec<f64> = (0..n).map(|_| StandardNormal.sample(stream)).collect();
        let noise = Cholesky::new(&covariance).unwrap().lower().times(&xi);
        let pressure =
            |(k, (m, p)): (usize, &(usize, C64))| (*m, p + C64::new(noise[2 + 2 * k], noise[3 + 2 * k]));
        ObservedMode {
            growth_rate: Some(s.re + noise[0]),
            angular_frequency: Some(s.im + noise[1]),
            pressures: pressures.iter().enumerate().map(pressure).collect(),
            ..o.mode.clone()
        }
    });
    ObservedModes { modes: modes.collect(), ..like.clone() }
}

fn ranks(values: &[f64]) -> Vec<f64> {
    values.iter().map(|v| values.iter().filter(|w| *w < v).count() as f64).collect()
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let (ma, mb) = (mean(a), mean(b));
    let sum = |f: &dyn Fn(f64, f64) -> f64| a.iter().zip(b).map(|(x, y)| f(x - ma, y - mb)).sum::<f64>();
    sum(&|x, y| x * y) / (sum(&|x, _| x * x) * sum(&|_, y| y * y)).sqrt()
}
