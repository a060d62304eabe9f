//! Settled runs made by the model itself, with truth drawn from the prior.

use super::fit::JointFit;
use super::of_run::Settled;
use super::run::{SettledRun, State};
use super::unknowns::{FIXED, shared_share, unknowns};
use crate::infer::sensor::SensorKind;
use crate::tube::closures::Closures;
use crate::tube::pipe::Pipe;
use crate::{Logged, Ramp, TubeRig};
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use rijke_numerics::{Matrix, Streams};

const POWERS: [f64; 4] = [0.0, 30.0, 80.0, 180.0];
pub(super) const SD: f64 = 0.5e-6;

pub(super) fn pipe(heater: f64) -> Pipe {
    Pipe::new(&TubeRig::juniper_yoko_2022(), &Closures::default(), heater, 1).unwrap()
}

/// A run with empty readings.
pub(super) fn empty(heater: f64, sensors: &[SensorKind], sd: f64) -> SettledRun {
    let n = sensors.len();
    let state = |&power: &f64| State {
        id: format!("H{power}-{heater}"),
        power,
        ambient: 293.0,
        ambient_sd: 0.1,
        day: format!("day of {heater}"),
        sensors: sensors.to_vec(),
        readings: vec![1e-3; n],
        noise: Matrix::diagonal(&vec![sd * sd; n]),
        moment: None,
    };
    let (states, common) = (POWERS.iter().map(state).collect(), Matrix::diagonal(&[1e-12; 8]));
    SettledRun { heater, states, common, offset_sd: 0.0, ramps: vec![] }
}

pub(super) fn arrivals() -> Vec<SensorKind> {
    (0..8).map(|microphone| SensorKind::Arrival { microphone }).collect()
}

/// Fills the readings with those at scores drawn from `stream`; returns the scores.
pub(super) fn read(
    pipe: &Pipe,
    run: &mut SettledRun,
    sd: f64,
    stream: &mut rijke_numerics::Stream,
) -> Vec<f64> {
    let model = Settled::at_prior(pipe, run);
    let scores: Vec<f64> = model.priors.iter().map(|_| StandardNormal.sample(stream)).collect();
    let states = model.states(&scores, None).unwrap();
    let shared: Vec<f64> = (0..8).map(|_| StandardNormal.sample(stream)).collect();
    for (state, predicted) in run.states.iter_mut().zip(states) {
        for (j, value) in predicted.readings.iter().enumerate() {
            let noise: f64 = StandardNormal.sample(stream);
            let common =
                if matches!(state.sensors[j], SensorKind::Arrival { .. }) { 1e-6 * shared[j] } else { 0.0 };
            state.readings[j] = value + common + sd * noise;
        }
    }
    scores
}

#[test]
fn oracle_differences_agree_with_the_implicit_function_theorem() {
    let pipe = pipe(0.45);
    let run = empty(0.45, &arrivals(), SD);
    let model = Settled::at_prior(&pipe, &run);
    let scores = vec![0.1; model.priors.len()];
    let states = model.states(&scores, None).unwrap();
    let (_, base) = model.slopes(&scores, &states).unwrap();
    // The six parameters and the power at 180 W, the last state: rows of base vectors count from the first.
    let first = base.rows() - states[3].base.len();
    let filled = super::unknowns::Filled::new(&model.priors, &scores, &Closures::default()).unwrap();
    let moved = pipe.altered(filled.heater_shift, &filled.closures).unwrap();
    let sensitivities = states[3].flow.settled().unwrap().sensitivities(&moved).unwrap();
    for (k, sensitivity) in sensitivities.iter().enumerate().take(7) {
        let h = 1e-6;
        let physical = |z: f64| crate::infer::scores::physical(&model.priors[k], z).unwrap();
        let mut slope = (physical(0.1 + h) - physical(0.1 - h)) / (2.0 * h);
        if k == 6 {
            slope /= filled.power_factor;
        }
        let (exact, found) = (sensitivity.heater_velocity * slope, base[(first + 1, k)]);
        assert!((found - exact).abs() < 1e-5 * exact.abs().max(1e-3), "{k}: {found} {exact}");
    }
}

#[test]
fn oracle_causes_rebuild_the_posterior_covariance() {
    let mut stream = Streams::new(3).stream("causes");
    let runs: Vec<(Pipe, SettledRun)> = [0.25, 0.7]
        .map(|heater| {
            let (pipe, mut run) = (pipe(heater), empty(heater, &arrivals(), SD));
            read(&pipe, &mut run, SD, &mut stream);
            (pipe, run)
        })
        .into();
    let fit = JointFit::new(&runs).unwrap();
    let states = fit.base_states().unwrap();
    let mut all = states.iter();
    for run in &fit.runs {
        let mut first = 0;
        for predicted in &run.predicted {
            let (id, base) = all.next().unwrap();
            // Variances of the velocity and of the outlet's temperature.
            let direct = |row: usize| run.covariance.quadratic(run.base_slopes.row(first + row)).sqrt();
            let last = predicted.base.len() - 1;
            let outlet = base.errors.iter().map(|e| e.temperature[last - 2].powi(2)).sum::<f64>().sqrt();
            for (found, exact) in [(base.heater_velocity_sd(), direct(1)), (outlet, direct(last))] {
                assert!((found - exact).abs() <= 0.005 * exact, "{id}: {found} {exact}");
            }
            first += predicted.base.len();
        }
    }
}

#[test]
fn exact_fit_gives_the_same_bytes_for_one_and_two_threads() {
    let runs: Vec<(Pipe, SettledRun)> = [0.25, 0.45, 0.7]
        .map(|heater| {
            let (pipe, mut run) = (pipe(heater), empty(heater, &arrivals(), SD));
            read(&pipe, &mut run, SD, &mut Streams::new(4).stream("threads"));
            (pipe, run)
        })
        .into();
    let fit = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let fit = JointFit::new(&runs).unwrap();
            (
                fit.base_states().unwrap(),
                fit.runs.into_iter().map(|r| (r.mean, r.covariance)).collect::<Vec<_>>(),
            )
        })
    };
    assert_eq!(fit(1), fit(2));
}

/// One rig at more and more places: the shared unknowns lie in a valley that gets ever narrower.
/// Linearisations are the work. Gauss and Newton's method alone takes 13 and 17 of them.
#[test]
fn behaviour_many_places_take_few_linearisations() {
    let count = |places: u32| {
        let mut stream = Streams::new(8).stream("many places");
        let mut draw = move || -> f64 { StandardNormal.sample(&mut stream) };
        let shared: Vec<f64> = (0..FIXED).map(|_| draw()).collect();
        let runs: Vec<(Pipe, SettledRun)> = (0..places)
            .map(|k| {
                let heater = 0.15 + 0.7 * f64::from(k) / f64::from(places - 1);
                let (pipe, mut run) = (pipe(heater), empty(heater, &arrivals(), SD));
                let size = unknowns(&run, &pipe).len();
                let of = |k: usize| if k < FIXED { shared_share(k) } else { 0.0 };
                let truth: Vec<f64> = (0..size)
                    .map(|k| of(k) * shared.get(k).unwrap_or(&0.0) + (1.0 - of(k).powi(2)).sqrt() * draw())
                    .collect();
                let states = Settled::at_prior(&pipe, &run).states(&truth, None).unwrap();
                for (state, predicted) in run.states.iter_mut().zip(states) {
                    state.readings = predicted.readings.iter().map(|r| r + SD * draw()).collect();
                }
                (pipe, run)
            })
            .collect();
        let fit = JointFit::new(&runs).unwrap();
        assert!(fit.runs.iter().all(|run| run.misfit.converged));
        fit.linearisations
    };
    for places in [12, 48] {
        let found = count(places);
        assert!(found <= 10, "{found} linearisations of {places} places");
    }
}

/// A slip of units must not set a search going that no flow can end.
#[test]
fn message_clicks_of_another_sound_speed_are_refused_before_the_search() {
    let (pipe, mut run) = (pipe(0.45), empty(0.45, &arrivals(), SD));
    read(&pipe, &mut run, SD, &mut Streams::new(2).stream("far off"));
    run.states.iter_mut().for_each(|s| s.readings.iter_mut().for_each(|r| *r *= 0.5));
    let runs = [(pipe, run)];
    let said = JointFit::new(&runs).unwrap_err().to_string();
    for part in ["operating point H", "-0.45: the arrival at microphone", "no flow fits the readings"] {
        assert!(said.contains(part), "{said}");
    }
    // Nor does a long tube have cells without end.
    let mut rig = TubeRig::juniper_yoko_2022();
    rig.tube.length = 1000.0;
    assert!(Pipe::new(&rig, &Closures::default(), 0.45, 1).unwrap().size() < 600);
}

#[test]
fn lab_settled_runs_cover_their_truth() {
    // Twelve draws of the truth: error of the velocity at 180 W over its sd, and chi-squared.
    let pipe = pipe(0.35);
    let (mut squares, mut chi) = (0.0, 0.0);
    for seed in 0..12 {
        let mut run = empty(0.35, &arrivals(), SD);
        let truth = read(&pipe, &mut run, SD, &mut Streams::new(seed).stream("settled twin"));
        let real = Settled::at_prior(&pipe, &run).states(&truth, None).unwrap()[3].base[1];
        let runs = [(pipe.clone(), run)];
        let fit = JointFit::new(&runs).unwrap();
        let base = &fit.base_states().unwrap()[3].1;
        squares += ((base.heater_velocity - real) / base.heater_velocity_sd()).powi(2) / 12.0;
        chi += fit.runs[0].misfit.chi_squared / fit.runs[0].misfit.readings as f64 / 12.0;
    }
    assert!((0.3..2.3).contains(&squares), "mean square of error over sd {squares}");
    assert!((0.85..1.15).contains(&chi), "chi-squared {chi}");
}

/// Two powers in twenty minutes beside two settled states, and a moment without clicks three minutes after a
/// step.
pub(super) fn ramped() -> SettledRun {
    let mut run = empty(0.35, &arrivals(), SD);
    run.states[2].moment = Some((0, 550.0));
    run.states[3].moment = Some((0, 1150.0));
    let hot = run.states[3].clone();
    let (sensors, readings, noise) = (Vec::new(), Vec::new(), Matrix::zeros(0, 0));
    run.states.push(State { id: "silent".into(), moment: Some((0, 780.0)), sensors, readings, noise, ..hot });
    let logged = |(time, power): (f64, f64)| Logged { time, power, point: None };
    run.ramps = vec![Ramp { id: "a".into(), log: [(0.0, 80.0), (600.0, 180.0)].map(logged).to_vec() }];
    run
}

#[test]
#[ignore = "long: 60 fits with a ramp, five minutes of CPU"]
fn coverage_of_moments_of_a_ramp() {
    // Truth drawn from the priors: share of velocities and sound speeds within 1.96 sd, of the settled state
    // and of three moments.
    let pipe = pipe(0.35);
    let draws = (0..60).into_par_iter().map(|seed| {
        let mut run = ramped();
        let truth = read(&pipe, &mut run, SD, &mut Streams::new(seed).stream("ramp coverage"));
        let real = Settled::at_prior(&pipe, &run).states(&truth, None).unwrap();
        let runs = [(pipe.clone(), run.checked(&pipe).unwrap())];
        let bases = JointFit::new(&runs).unwrap().base_states().unwrap();
        let off = |k: usize| {
            let (base, real) = (&bases[k].1, &real[k].base);
            let velocity = (base.heater_velocity - real[1]) / base.heater_velocity_sd();
            let at = |x: f64| base.places.iter().position(|p| *p > x).unwrap();
            let heat = [0.5, 0.9].map(at).map(|j| {
                let sd = base.errors.iter().map(|e| e.temperature[j].powi(2)).sum::<f64>().sqrt();
                (base.temperature[j] - real[2 + j]) / sd
            });
            [velocity, heat[0], heat[1]]
        };
        [1, 2, 3, 4].map(off)
    });
    let draws: Vec<[[f64; 3]; 4]> = draws.collect();
    for k in 0..4 {
        for q in 0..3 {
            let off: Vec<f64> = draws.iter().map(|d| d[k][q]).collect();
            let within = off.iter().filter(|z| z.abs() < 1.96).count() as f64 / off.len() as f64;
            let rms = (off.iter().map(|z| z * z).sum::<f64>() / off.len() as f64).sqrt();
            println!("state {}, quantity {q}: {within:.3}, rms {rms:.2}", k + 1);
        }
    }
    let within = draws.iter().flatten().flatten().filter(|z| z.abs() < 1.96).count() as f64 / (60.0 * 12.0);
    println!("all: {within:.3}");
    assert!((0.90..0.985).contains(&within), "{within}");
}

#[test]
fn lab_states_of_a_ramp_cover_their_truth_beside_settled_ones() {
    let pipe = pipe(0.35);
    for seed in 0..3 {
        let mut run = ramped();
        let truth = read(&pipe, &mut run, SD, &mut Streams::new(seed).stream("ramp twin"));
        let real = Settled::at_prior(&pipe, &run).states(&truth, None).unwrap();
        let runs = [(pipe.clone(), run.checked(&pipe).unwrap())];
        let fit = JointFit::new(&runs).unwrap();
        let bases = fit.base_states().unwrap();
        for (k, (_, base)) in bases.iter().enumerate().skip(1) {
            let off = (base.heater_velocity - real[k].base[1]) / base.heater_velocity_sd();
            assert!(off.abs() < 3.0, "seed {seed}, state {k}: {off} sd");
        }
        let shared = |k: usize| bases[k].1.errors.iter().map(|e| e.cause.clone()).collect::<Vec<_>>();
        assert_eq!(shared(1), shared(3), "a settled state and a moment share their errors");
        assert_eq!(shared(3), shared(4));
        // Three minutes after the step the wall is not yet warm.
        assert!(bases[4].1.temperature(0.9) < bases[3].1.temperature(0.9) - 2.0);
    }
}

#[test]
fn lab_thermocouples_and_sound_speeds_serve_instead_of_clicks() {
    let pipe = pipe(0.35);
    for temperature in [true, false] {
        let sensors: Vec<SensorKind> = (1..10)
            .map(|k| 0.1 * f64::from(k))
            .map(|place| {
                if temperature { SensorKind::Temperature { place } } else { SensorKind::SoundSpeed { place } }
            })
            .collect();
        let mut run = empty(0.35, &sensors, 0.5);
        let truth = read(&pipe, &mut run, 0.5, &mut Streams::new(5).stream("thermocouples"));
        let real = Settled::at_prior(&pipe, &run).states(&truth, None).unwrap()[3].base.clone();
        let runs = [(pipe.clone(), run.checked(&pipe).unwrap())];
        let fit = JointFit::new(&runs).unwrap();
        let base = &fit.base_states().unwrap()[3].1;
        for (k, t) in real[2..].iter().enumerate() {
            let sd = base.errors.iter().map(|e| e.temperature[k].powi(2)).sum::<f64>().sqrt();
            assert!(
                (base.temperature[k] - t).abs() < 4.0 * sd.max(0.1),
                "{k}: {} {t} {sd}",
                base.temperature[k]
            );
        }
    }
}

#[test]
fn exact_unusable_runs_are_refused_with_numbers() {
    use crate::error::FlowError;
    let pipe = pipe(0.25);
    let good = empty(0.25, &arrivals(), SD);
    assert!(good.clone().checked(&pipe).is_ok());
    let broken = |change: &dyn Fn(&mut SettledRun)| {
        let mut run = good.clone();
        change(&mut run);
        run.checked(&pipe).unwrap_err()
    };
    let said = |change: &dyn Fn(&mut SettledRun)| broken(change).to_string();
    let watts = said(&|r| r.states[1].power = -3.0);
    assert!(watts.ends_with("the heater power is -3 W; it must be zero or positive"), "{watts}");
    let cold = said(&|r| r.states[2].ambient = 180.0);
    assert!(
        cold.starts_with("operating point ") && cold.contains("180 K; the properties of air hold from 210"),
        "{cold}"
    );
    assert!(matches!(broken(&|r| r.states[1].readings[2] = f64::NAN), FlowError::Readings { index: 1, .. }));
    assert!(matches!(broken(&|r| r.states.truncate(1)), FlowError::TooFewSamples { have: 0, need: 6 }));
    let outside = SensorKind::Temperature { place: 1.3 };
    assert!(matches!(broken(&|r| r.states[1].sensors[0] = outside), FlowError::Sensor { .. }));
    let days = said(&|r| {
        r.states[1].moment = Some((0, 10.0));
        r.states[2] = State { moment: Some((0, 20.0)), day: "next".into(), ..r.states[2].clone() };
    });
    assert!(days.contains("are of one ramp and have different days"), "{days}");
    assert_eq!(unknowns(&good, &pipe).len(), 19 + 1 + 8);
}

#[test]
fn lab_readings_beside_the_observations_serve_instead_of_clicks() {
    use super::observed::runs;
    use super::readings::Readings;
    use crate::error::FlowError;
    use crate::tube::parameters::TubeParameters;
    use crate::{ObservedTube, TubeCampaign, TubeObservations};
    use rijke_rig::{DataKind, Day};
    let rig = TubeRig::juniper_yoko_2022();
    let truth = TubeParameters { inner_nusselt: 1.5, heater_drag: 10.0, ..TubeParameters::default() };
    let pipe = pipe(0.25);
    let mut readings = Readings::default();
    let mut points = Vec::new();
    for point in TubeCampaign::juniper_yoko_2022().points {
        if !["H30-25", "H180-25"].contains(&point.id.as_str()) {
            continue;
        }
        let real = pipe.steady(&truth, point.power, 293.0).unwrap().base_state(&pipe);
        let reading = |place: f64| (SensorKind::Temperature { place }, real.temperature(place), 1.0);
        let list = (1..10).map(|k| reading(0.1 * f64::from(k))).collect();
        readings.points.insert(point.id.clone(), list);
        let day = Day { id: "one".into(), ambient_temperature: 293.0, ambient_temperature_sd: 0.1 };
        points.push(ObservedTube { point, ambient: day, click: None, is_planned: true });
    }
    let observations = TubeObservations {
        rig: rig.clone(),
        kind: DataKind::Virtual,
        source: "test".into(),
        points,
        ramps: vec![],
    };
    let make = |heater: f64| -> Result<Pipe, FlowError> { Pipe::new(&rig, &Closures::default(), heater, 1) };
    assert!(runs(&observations, &Readings::default(), &make).unwrap().is_empty());
    // Errors in standard deviations, and these, m/s.
    let errors = |readings: &Readings| {
        let runs = runs(&observations, readings, &make).unwrap();
        let mut all = Vec::new();
        for (id, base) in JointFit::new(&runs).unwrap().base_states().unwrap() {
            let power = if id == "H30-25" { 30.0 } else { 180.0 };
            let real = pipe.steady(&truth, power, 293.0).unwrap().base_state(&pipe);
            all.extend([0.35, 0.55, 0.75, 0.95].map(|x| {
                let sd = base.sound_speed_covariance(&[x])[(0, 0)].sqrt();
                ((base.sound_speed(x) - real.sound_speed(x)).abs() / sd, sd)
            }));
        }
        all
    };
    let good = errors(&readings);
    assert!(good.iter().all(|(off, sd)| *off < 3.0 && *sd < 2.0), "{good:?}");
    // All thermometers 3 K too high: told only by the column of it.
    readings.points.values_mut().flatten().for_each(|reading| reading.1 += 3.0);
    let silent = errors(&readings);
    assert!(silent.iter().any(|(off, _)| *off > 3.0), "{silent:?}");
    readings.offset_sd = 3.0;
    let stated = errors(&readings);
    assert!(stated.iter().all(|(off, sd)| *off < 2.0 && *sd < 3.0), "{stated:?}");
}
