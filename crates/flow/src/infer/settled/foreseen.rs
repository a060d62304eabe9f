//! Tests of states that are foreseen beside those that were read.

use super::fit::JointFit;
use super::run::{SettledRun, State};
use super::tests::{SD, arrivals, empty, pipe, read};
use crate::tube::pipe::Pipe;
use rijke_numerics::{Matrix, Streams};

/// What is foreseen of a state stands on the same equations as what is read there: readings of hopeless noise
/// say as little as none. One state at a place that was read, and a place of which nothing was.
#[test]
fn exact_a_state_that_was_not_read_is_one_of_hopeless_readings() {
    let mut stream = Streams::new(6).stream("foreseen");
    let [mut near, mut far] = [0.25, 0.7].map(|heater| {
        let (pipe, mut run) = (pipe(heater), empty(heater, &arrivals(), SD));
        read(&pipe, &mut run, SD, &mut stream);
        (pipe, run)
    });
    let known = JointFit::new(&[near.clone(), far.clone()]).unwrap().base_states().unwrap();
    let mut found = Vec::new();
    for read in [true, false] {
        for state in near.1.states[2..3].iter_mut().chain(&mut far.1.states) {
            if read {
                state.noise = Matrix::diagonal(&[1e6; 8]);
            } else {
                (state.sensors, state.readings, state.noise) = (Vec::new(), Vec::new(), Matrix::zeros(0, 0));
            }
        }
        let checked = |(pipe, run): (Pipe, SettledRun)| (pipe.clone(), run.checked(&pipe).unwrap());
        let runs = [near.clone(), far.clone()].map(checked);
        let (reports, states) = JointFit::new(&runs).unwrap().report().unwrap();
        assert_eq!(
            reports.len(),
            if read { 2 } else { 1 },
            "nothing is reported of a place that was not read"
        );
        found.push(states);
    }
    for ((id, a), (_, b)) in found[0].iter().zip(&found[1]) {
        assert!((a.mass_flux - b.mass_flux).abs() <= 1e-6 * a.mass_flux, "{id}");
        let [a, b] = [a, b].map(|s| s.heater_velocity_sd());
        // Each keeps 99.999 % of the variance, in its own causes.
        assert!((a - b).abs() <= 1e-5 * a, "{id}: {a} {b}");
    }
    // The place that was not read is known worse than if it had been, and shares causes with the one that
    // was.
    let last = |k: usize| &found[1][k].1;
    let [foreseen, read] = [last(7), &known[7].1].map(|s| s.heater_velocity_sd());
    assert!(foreseen > 1.1 * read, "{foreseen} {read}");
    let shared = |e: &&crate::ErrorComponent| last(3).errors.iter().any(|other| other.cause == e.cause);
    assert!(last(7).errors.iter().filter(shared).count() > 3);
}

/// What is known of a place that was read does not change its name or size because another place is asked
/// for: causes that a model was trained with can be met again.
#[test]
fn exact_foreseen_states_leave_the_causes_of_the_others_alone() {
    let mut stream = Streams::new(7).stream("asked");
    let mut runs: Vec<(Pipe, SettledRun)> = [0.25, 0.7]
        .map(|heater| {
            let (pipe, mut run) = (pipe(heater), empty(heater, &arrivals(), SD));
            read(&pipe, &mut run, SD, &mut stream);
            (pipe, run)
        })
        .into();
    let known = JointFit::new(&runs).unwrap().base_states().unwrap();
    let asked = |state: &State| State {
        id: format!("asked {}", state.id),
        sensors: Vec::new(),
        readings: Vec::new(),
        noise: Matrix::zeros(0, 0),
        ..state.clone()
    };
    let here = asked(&runs[0].1.states[2]);
    runs[0].1.states.push(State { power: 0.8 * here.power, ..here });
    let mut between = empty(0.5, &arrivals(), SD);
    between.states = between.states.iter().map(asked).collect();
    runs.insert(1, (pipe(0.5), between));
    let wider = JointFit::new(&runs).unwrap().base_states().unwrap();
    assert!(wider.len() > known.len() + 2);
    for (id, old) in &known {
        let new = &wider.iter().find(|(other, _)| other == id).unwrap().1;
        // A search ends a seventieth of a standard deviation from the most probable flow at the latest.
        let sd = old.errors.iter().map(|e| e.mass_flux.powi(2)).sum::<f64>().sqrt();
        let off = (old.mass_flux - new.mass_flux).abs();
        assert!(off <= 0.03 * sd, "{id}: {off} of {sd}");
        let sizes = old.errors.iter().flat_map(|e| &e.temperature).map(|t| t.abs());
        let largest = sizes.fold(0.0, f64::max);
        for error in &old.errors {
            let same = new.errors.iter().find(|e| e.cause == error.cause).unwrap();
            let off = |sign: f64| {
                let pairs = error.temperature.iter().zip(&same.temperature);
                pairs.fold(0.0, |a: f64, (x, y)| a.max((x - sign * y).abs()))
            };
            let closest = off(1.0).min(off(-1.0));
            assert!(closest <= 0.01 * largest, "{id}, {}: {closest} of {largest} K", error.cause);
        }
        // What is new moves none of the states that were read.
        for error in new.errors.iter().filter(|e| old.errors.iter().all(|o| o.cause != e.cause)) {
            assert!(error.temperature.iter().all(|t| t.abs() < 0.01 * largest), "{id}, {}", error.cause);
        }
    }
}
