//! Twins: the truth comes back within its stated uncertainty, whatever the instrument; and bad records are
//! refused.

use super::{AMBIENT, pipe};
use rijke_flow::assimilate::{
    Batch, FilterOptions, FlowRecord, Sensor, SensorKind, Twin, TwinOptions, Variant, filter, smooth,
    staircase,
};
use rijke_flow::{FlowError, Pipe, UNKNOWNS};
use rijke_inference::ensemble::Smoother;
use rijke_numerics::Streams;

fn short(pipe: &Pipe, seed: u64) -> Twin {
    let options = TwinOptions { powers: staircase(&[0.0, 30.0, 180.0], 60), ..TwinOptions::default() };
    Twin::new(pipe, &options, &Streams::new(seed), None).unwrap()
}

/// Mean square of error over sd of the unknowns; 1 is expected.
fn misfit(mean: &[f64], covariance: &rijke_numerics::Matrix, truth: &[f64]) -> f64 {
    let term = |i: usize| (mean[i] - truth[i]).powi(2) / covariance[(i, i)];
    (0..UNKNOWNS).map(term).sum::<f64>() / UNKNOWNS as f64
}

#[test]
fn lab_batch_finds_the_truth_of_a_short_twin() {
    let pipe = pipe(0.25, 1);
    let twin = short(&pipe, 4);
    let record = twin.record.checked(&pipe).unwrap();
    let estimate = Batch::new(&pipe, &record, 10).unwrap().fit().unwrap();
    let health = estimate.health.clone().unwrap();
    assert!(health.converged && health.warnings().is_empty(), "{health:?}");
    assert!((health.chi_squared - 1.0).abs() < 4.0 * health.chi_squared_sd, "{health:?}");
    let worst = misfit(&estimate.mean, &estimate.covariance, &twin.scores);
    assert!(worst < 3.0, "{worst} {:?} {:?}", estimate.mean, twin.scores);
    // The data shrink the drag to below a third of its prior.
    assert!(estimate.covariance[(0, 0)] < 0.1, "{}", estimate.covariance[(0, 0)]);
    let base = estimate.base_state(&pipe, 180.0, AMBIENT).unwrap();
    assert!(base.heater_velocity_sd() > 1e-3 && base.heater_velocity_sd() < 0.05);
    assert!((1..=10).contains(&base.errors.len()));
}

#[test]
fn lab_thermocouples_or_sound_speeds_serve_a_user_without_clicks() {
    let pipe = pipe(0.25, 1);
    let twin = short(&pipe, 5);
    // The same run, seen by eight thermocouples or eight sound-speed readings instead.
    let truth = Batch::new(&pipe, &twin.record, 1).unwrap();
    for temperature in [true, false] {
        let sensors: Vec<Sensor> = (2..10)
            .map(|k| {
                let place = 0.1 * f64::from(k);
                let kind = if temperature {
                    SensorKind::Temperature { place }
                } else {
                    SensorKind::SoundSpeed { place }
                };
                Sensor { kind, sd: 0.5, bias_sd: 0.0 }
            })
            .collect();
        let record = truth.resampled(&sensors, &twin.scores[..UNKNOWNS], &Streams::new(2)).unwrap();
        let record = record.checked(&pipe).unwrap();
        let estimate = Batch::new(&pipe, &record, 10).unwrap().fit().unwrap();
        let worst = misfit(&estimate.mean, &estimate.covariance, &twin.scores);
        assert!(worst < 3.0, "{temperature}: {worst}");
        assert!(estimate.covariance[(4, 4)] < 0.1);
    }
}

#[test]
fn lab_smoother_agrees_with_the_batch() {
    let pipe = pipe(0.25, 1);
    let twin = short(&pipe, 6);
    let record = twin.record.checked(&pipe).unwrap();
    let batch = Batch::new(&pipe, &record, 10).unwrap();
    let fit = batch.fit().unwrap();
    let smoothed = smooth(&batch, 100, &Smoother::default(), &Streams::new(1)).unwrap();
    for k in 0..6 {
        let sd = fit.covariance[(k, k)].sqrt();
        assert!(
            (fit.mean[k] - smoothed.mean[k]).abs() < 1.5 * sd,
            "{k}: {} {} {sd}",
            fit.mean[k],
            smoothed.mean[k]
        );
    }
}

#[test]
fn exact_filter_gives_the_same_bytes_for_one_and_two_threads() {
    let pipe = pipe(0.25, 1);
    let record = short(&pipe, 7).record.checked(&pipe).unwrap();
    let record = FlowRecord { samples: record.samples[..80].to_vec(), ..record };
    for variant in [Variant::Paper, Variant::SquareRoot] {
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let options = FilterOptions { variant, members: 30, every: 10 };
            let run = pool.install(|| filter(&pipe, &record, &options, &Streams::new(3)).unwrap());
            (run.estimate.mean, run.estimate.covariance, run.history)
        };
        assert_eq!(run(1), run(2));
    }
}

#[test]
fn exact_failed_members_are_counted_and_an_ensemble_of_failures_is_refused() {
    let pipe = pipe(0.25, 1);
    let options = TwinOptions { powers: staircase(&[0.0, 180.0], 10), ..TwinOptions::default() };
    let mut record = Twin::new(&pipe, &options, &Streams::new(3), Some(&[0.0; 18])).unwrap().record;
    let run = |record: &FlowRecord| {
        let options = FilterOptions { members: 40, ..FilterOptions::default() };
        filter(&pipe, record, &options, &Streams::new(3))
    };
    assert_eq!(run(&record).unwrap().failed, 0);
    // No member survives such a power; how single failures are replaced is tested in `rijke-inference`.
    record.samples[10..].iter_mut().for_each(|s| s.power = 1e9);
    let said = run(&record).unwrap_err().to_string();
    assert!(said.starts_with("40 of 40 members failed in step 10; the first says: no mass flow"), "{said}");
}

#[test]
fn exact_messages_say_what_is_wrong_with_numbers() {
    let pipe = pipe(0.25, 1);
    let good = short(&pipe, 8).record;
    let said = |change: &dyn Fn(&mut FlowRecord)| {
        let mut record = good.clone();
        change(&mut record);
        record.checked(&pipe).unwrap_err().to_string()
    };
    let hot = said(&|r| r.samples[0].power = 7.0);
    assert_eq!(
        hot,
        "the first sample was taken at 7 W: start with samples at 0 W and ambient temperature, which calibrate the \
         constant errors of the channels"
    );
    let few = said(&|r| r.samples.truncate(2));
    assert_eq!(few, "16 readings cannot fix 18 unknowns; add samples or sensors");
    for kelvin in [-20.0, 180.0, 2000.0, f64::NAN] {
        assert_eq!(
            said(&|r| r.samples[3].ambient = kelvin),
            format!(
                "sample 3: the ambient temperature is {kelvin} K; the properties of air hold from 210 to 1800 K \
                 (give kelvin, not Celsius)"
            )
        );
    }
    for watts in [-1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(
            said(&|r| r.samples[70].power = watts),
            format!("sample 70: the heater power is {watts} W; it must be zero or positive")
        );
    }
    assert_eq!(said(&|r| r.interval = 0.0), "interval_s = 0; it must be positive");
    assert_eq!(said(&|r| r.ambient_sd = 0.0), "ambient_sd_k = 0; it must be positive");
    let celsius = said(&|r| {
        r.sensors[0].kind = SensorKind::Temperature { place: 0.5 };
        r.sensors[0].sd = 0.5;
        r.samples.iter_mut().for_each(|s| s.readings[0] = 300.0);
        r.samples[9].readings[0] = 27.0;
    });
    assert!(celsius.starts_with("sample 9: the gas at x = 0.5 m is 27 K; the properties"), "{celsius}");
}

#[test]
fn exact_bad_records_are_refused_with_numbers() {
    let pipe = pipe(0.25, 1);
    let good = short(&pipe, 8).record;
    let mut hot = good.clone();
    hot.samples[0].power = 7.0;
    assert!(matches!(hot.checked(&pipe), Err(FlowError::NotCalibrated { watts: 7.0 })));
    let few = FlowRecord { samples: good.samples[..2].to_vec(), ..good.clone() };
    assert!(matches!(few.checked(&pipe), Err(FlowError::TooFewSamples { have: 16, need: 18 })));
    let mut cold = good.clone();
    cold.samples[3].ambient = -1.0;
    assert!(matches!(cold.checked(&pipe), Err(FlowError::Sample { index: 3, .. })));
    let mut gap = good.clone();
    gap.samples[5].readings[2] = f64::NAN;
    assert!(matches!(gap.checked(&pipe), Err(FlowError::Readings { index: 5, .. })));
    let mut outside = good;
    outside.sensors[0].kind = SensorKind::Temperature { place: 1.2 };
    assert!(matches!(outside.checked(&pipe), Err(FlowError::Sensor { .. })));
}
