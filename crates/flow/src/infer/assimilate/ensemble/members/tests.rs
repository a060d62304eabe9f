//! Members that fail, on the flow itself.

use super::*;
use crate::TubeRig;
use crate::infer::assimilate::ensemble::filter::{FilterOptions, filter};
use crate::infer::assimilate::twin::{Twin, TwinOptions, staircase};
use crate::tube::closures::Closures;
use crate::tube::parameters::unknowns;
use rijke_numerics::Streams;

/// A heater far up the tube and samples every `interval` seconds: a step too long for members whose wall
/// follows quickly.
fn record(pipe: &Pipe, interval: f64) -> FlowRecord {
    let options = TwinOptions { powers: staircase(&[0.0, 180.0], 10), interval, ..TwinOptions::default() };
    Twin::new(pipe, &options, &Streams::new(0), Some(&[0.0; 18])).unwrap().record
}

#[test]
fn oracle_failed_members_are_those_that_fail_alone_and_are_drawn_from_the_others() {
    const MEMBERS: usize = 12;
    let pipe = Pipe::new(&TubeRig::juniper_yoko_2022(), &Closures::default(), 0.85, 1).unwrap();
    let (record, priors) = (FlowRecord { interval: 900.0, ..record(&pipe, 600.0) }, unknowns());
    let layout = Layout { scores: UNKNOWNS + record.biased().count(), walls: pipe.size() };
    let mut counts = [0; 2];
    for seed in 0..4 {
        let mut stream = Streams::new(seed).stream("members");
        let (mut ensemble, members) =
            Members::draw(&pipe, &record, &priors, layout, MEMBERS, &mut stream).unwrap();
        let mut stream = Streams::new(seed).stream("forecast");
        for (step, power) in [0.0, 180.0, 180.0, 180.0].into_iter().enumerate() {
            // Each member by itself first: which fail, and where the others go.
            let before = ensemble.members().clone();
            let copy = |group: &Mutex<Transient<Lanes<GROUP>>>| Mutex::new(group.lock().unwrap().clone());
            let groups = members.groups.iter().map(copy).collect();
            let apart = Members { groups, implicit: members.implicit.clone(), ..members };
            let alone: Vec<Result<Vec<f64>, String>> = (0..MEMBERS)
                .map(|i| {
                    let mut row = before.row(i).to_vec();
                    let seen = apart.step(power, i, &mut row).pop().unwrap();
                    seen.map(|_| row).map_err(|e| e.to_string())
                })
                .collect();
            let model = |first: usize, rows: &mut [f64]| members.step(power, first, rows);
            if ensemble.forecast_in_groups(step, &mut stream, GROUP, model).is_err() {
                // A replacement failed as well: the filter ends with this error.
                break;
            }
            let failed: Vec<(usize, String)> = ensemble
                .failures()
                .iter()
                .filter(|f| f.step == step)
                .map(|f| (f.member, f.reason.clone()))
                .collect();
            let expected = alone.iter().enumerate().filter_map(|(i, r)| Some((i, r.as_ref().err()?.clone())));
            assert_eq!(failed, expected.collect::<Vec<_>>(), "seed {seed}, step {step}");
            let survivors: Vec<usize> = (0..MEMBERS).filter(|&i| alone[i].is_ok()).collect();
            for &i in &survivors {
                assert_eq!(ensemble.members().row(i), alone[i].as_ref().unwrap().as_slice(), "member {i}");
            }
            for (i, reason) in &failed {
                assert!(reason.contains("no mass flow") || reason.contains("air hold from 210"), "{reason}");
                let rest = beyond(&before, &survivors, &ensemble.members().row(*i)[..=layout.scores]);
                assert!(rest < 1e-9, "member {i} is no combination of the others: {rest}");
                let own = beyond(&before, &survivors, &before.row(*i)[..=layout.scores]);
                assert!(own > 1e-2, "any row would be a combination: {own}");
            }
            counts[0] += failed.len();
            counts[1] += survivors.len();
        }
    }
    assert!(counts[0] > 2 && counts[1] > 100, "failed and sound runs: {counts:?}");
}

/// How much of `row` less the mean of the rows `survivors` lies outside the span of their anomalies, over its
/// length; scores and ambient temperature, which a step does not change.
fn beyond(rows: &Matrix, survivors: &[usize], row: &[f64]) -> f64 {
    let n = survivors.len() as f64;
    let mean: Vec<f64> =
        (0..row.len()).map(|j| survivors.iter().map(|&i| rows[(i, j)]).sum::<f64>() / n).collect();
    let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let mut rest: Vec<f64> = row.iter().zip(&mean).map(|(v, m)| v - m).collect();
    let length = norm(&rest);
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for &i in survivors {
        let mut direction: Vec<f64> = (0..row.len()).map(|j| rows[(i, j)] - mean[j]).collect();
        let size = norm(&direction);
        for _ in 0..2 {
            basis.iter().for_each(|b| remove(&mut direction, b));
        }
        let left = norm(&direction);
        if left > 1e-8 * size {
            direction.iter_mut().for_each(|d| *d /= left);
            basis.push(direction);
        }
    }
    basis.iter().for_each(|b| remove(&mut rest, b));
    norm(&rest) / length
}

fn remove(from: &mut [f64], unit: &[f64]) {
    let along: f64 = from.iter().zip(unit).map(|(a, b)| a * b).sum();
    from.iter_mut().zip(unit).for_each(|(a, b)| *a -= along * b);
}

#[test]
fn exact_a_filter_with_failed_members_counts_them_and_goes_on() {
    let pipe = Pipe::new(&TubeRig::juniper_yoko_2022(), &Closures::default(), 0.85, 1).unwrap();
    let run = |interval: f64| {
        filter(&pipe, &record(&pipe, interval), &FilterOptions::default(), &Streams::new(0)).unwrap()
    };
    assert_eq!(run(15.0).failed, 0);
    let long = run(600.0);
    assert!((1..50).contains(&long.failed), "{}", long.failed);
    assert!(long.estimate.mean.iter().all(|m| m.is_finite()));
    let velocity = long.history.last().unwrap().heater_velocity;
    assert!(velocity[0] > 0.15 && velocity[0] < 0.4 && velocity[1] < 0.1, "{velocity:?}");
}
