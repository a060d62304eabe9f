//! Effects taken from the true model one and two at a time, in five sets of data each: what
//! docs/records/missing.md says of them.
#![allow(clippy::print_stdout, reason = "a study prints its tables")]

use super::record::{CASES, Change, Taken, drawn};
use super::variants::{Example, Variant};
use rijke_engine::run::{Asked, Missing, ModelRecord, Run, Trusted};
use rijke_numerics::Streams;
use rijke_study::ObservedModes;
use std::collections::BTreeMap;

/// Sets of data of every model.
const SEEDS: u64 = 5;

/// Nats by which the model with the effects must lead, both trained: below, their absence cannot be told from
/// chance by any method.
const TOLD: f64 = 5.0;

/// A model of one stage: candidates by their roles.
type Roles = BTreeMap<String, String>;

/// `with = { role = "candidate", ... }` of every stage, later ones over earlier ones.
fn roles_of(text: &str) -> Roles {
    let mut roles = Roles::new();
    for list in text.split("with = { ").skip(1).filter_map(|t| t.split_once(" }")) {
        for pair in list.0.split(", ").filter_map(|p| p.split_once(" = ")) {
            roles.insert(pair.0.to_owned(), pair.1.trim_matches('"').to_owned());
        }
    }
    roles
}

impl Taken {
    /// Everything that the example brings to its last stage.
    fn whole(&self) -> Roles {
        roles_of(&format!("{}{}", self.example.stages, self.last))
    }

    fn take(&self, roles: &mut Roles) {
        match self.change {
            Change::Without(role) => drop(roles.remove(role)),
            Change::Instead(other) => roles.extend(roles_of(&format!("with = {{ {other} }}"))),
            Change::Only => roles_of(self.last).keys().for_each(|role| drop(roles.remove(role))),
        }
    }
}

/// The last stage alone, with these candidates and its own noise.
fn stage(example: &Example, roles: &Roles) -> String {
    let last = example.stages.rsplit("[[stage]]").next().unwrap();
    let kept =
        |l: &&str| !l.starts_with("on = ") && !l.starts_with("base_errors") && !l.starts_with("with = ");
    let last: Vec<&str> = last.lines().filter(kept).collect();
    let roles: Vec<String> = roles.iter().map(|(role, id)| format!("{role} = \"{id}\"")).collect();
    format!(
        "[[stage]]{}\nwith = {{ {} }}\n[stage.noise]\nmeasured = false\n",
        last.join("\n"),
        roles.join(", ")
    )
}

fn variant(name: &str, example: &Example, roles: &Roles) -> Variant {
    let bare = Example { name: example.name, stages: "", more: example.more };
    Variant::new(name, &bare).stage(&stage(example, roles))
}

/// What a model makes of data: its evidence, and what it lacks.
fn found(variant: &Variant, data: &ObservedModes) -> Result<(f64, Missing), String> {
    let mut run = Run::new(variant.study(), data, Trusted::Laplace).map_err(|e| e.to_string())?;
    let stage = run.next_stage().map_err(|e| e.to_string())?.ok_or("no stage")?;
    let evidence = stage.models.first().map_or(f64::NAN, ModelRecord::ln_evidence);
    Ok((evidence, stage.missing.ok_or("nothing was asked")?))
}

/// Place of the first of the first families of which an effect is the first term, or a member.
fn among(taken: &Taken, missing: &Missing) -> [Option<usize>; 2] {
    let families = &missing.families;
    let first = families.iter().position(|f| taken.is(&f.first));
    let is = |words: &String| {
        let named = |a: &&Asked| words.starts_with(&format!("{} at {}", a.effect, a.place));
        missing.best.iter().filter(named).any(|a| taken.is(a))
    };
    [first, families.iter().position(|f| taken.is(&f.first) || f.like.iter().any(is))]
}

/// Counts over sets of data.
#[derive(Default)]
struct Count {
    sets: usize,
    refused: usize,
    quiet: usize,
    told: usize,
    alarms: usize,
    first: usize,
    member: usize,
}

#[test]
#[ignore = "a study of some ten minutes"]
fn oracle_effects_taken_one_and_two_at_a_time_are_asked_for() {
    let mut pairs: Vec<Vec<&Taken>> = CASES.iter().map(|t| vec![t]).collect();
    for (k, a) in CASES.iter().enumerate() {
        let others = CASES[k + 1..].iter().filter(|b| b.example.name == a.example.name);
        pairs.extend(others.map(|b| vec![a, b]));
    }
    let (mut one, mut two) = (Count::default(), Count::default());
    println!(
        "| example | taken | seed | lead of the whole model, nats | by chance | places (first, member) | first three |\n|---|---|---|---|---|---|---|"
    );
    // Effects of which alone no method could tell most sets of data.
    let mut absent: BTreeMap<(&str, &str), u64> = BTreeMap::new();
    let verbose = |missing: &Missing| {
        let all = missing.families.iter().take(3);
        all.map(|f| format!("{} ({:.1}, {:.1})", f.first.words(), f.first.gain, f.beyond.0))
            .collect::<Vec<_>>()
            .join("; ")
    };
    for (k, taken) in pairs.iter().enumerate() {
        let example = taken[0].example;
        let mut less = taken[0].whole();
        let whole = variant(&format!("whole-{k}"), example, &less);
        taken.iter().for_each(|t| t.take(&mut less));
        let less = variant(&format!("fewer-{k}"), example, &less);
        let truth = whole.study();
        let observations = truth.observations().unwrap();
        let mut run = Run::new(truth.clone(), &observations, Trusted::Laplace).unwrap();
        let id = truth.plan.stages[0].id.clone();
        if let Err(why) = run.next_stage() {
            println!("| {} | {} | | refused | {why}", example.name, taken[0].what);
            continue;
        }
        let name = taken.iter().map(|t| t.what).collect::<Vec<_>>().join(" + ");
        for seed in 0..SEEDS {
            let data = drawn(run.chosen(&id).unwrap(), &observations, &Streams::new(5 + seed), &name, false);
            let count = if taken.len() == 1 { &mut one } else { &mut two };
            let both = found(&whole, &data).and_then(|(with, _)| Ok((with, found(&less, &data)?)));
            let (with, (without, missing)) = match both {
                Ok(found) => found,
                Err(why) => {
                    count.refused += 1;
                    println!(
                        "| {} | {name} | {seed} | - | - | refused | {} |",
                        example.name,
                        why.replace('\n', " ")
                    );
                    continue;
                }
            };
            let lead = with - without;
            let p = missing.families.first().map_or(1.0, |f| f.first.probability);
            let places: Vec<[Option<usize>; 2]> = taken.iter().map(|t| among(t, &missing)).collect();
            println!(
                "| {} | {name} | {seed} | {lead:.1} | {p:.3} | {places:?} | {} |",
                example.name,
                verbose(&missing)
            );
            for t in taken {
                let best = missing.best.iter().filter(|a| t.is(a)).max_by(|a, b| a.gain.total_cmp(&b.gain));
                println!("    the best like {}: {:?}", t.what, best.map(|a| (a.words(), a.gain)));
            }
            if lead < TOLD {
                count.quiet += 1;
                if let [alone] = taken[..] {
                    *absent.entry((example.name, alone.what)).or_default() += 1;
                }
                continue;
            }
            count.alarms += usize::from(p <= Missing::CHANCE);
            count.told += 1;
            let is_there = |t: &&&Taken| absent.get(&(example.name, t.what)).is_none_or(|n| 2 * n < SEEDS);
            for (_, place) in taken.iter().zip(&places).filter(|(t, _)| is_there(t)) {
                count.sets += 1;
                count.first += usize::from(place[0].is_some_and(|k| k < 3));
                count.member += usize::from(place[1].is_some_and(|k| k < 3));
            }
        }
    }
    for (what, c) in [("one", &one), ("two", &two)] {
        println!(
            "{what} at a time: {} refused, {} below {TOLD} nats; of {} sets {} raise an alarm; of {} effects {} lead one of the first three families, {} are in one",
            c.refused, c.quiet, c.told, c.alarms, c.sets, c.first, c.member
        );
    }
    assert!(one.sets > 20 && two.sets > 20);
}
