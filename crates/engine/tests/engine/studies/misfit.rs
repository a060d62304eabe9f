//! What a misfit of growth rates means: for the probability of instability, and for signs.

use super::{ORIGIN, run};
use crate::common::folder::Folder;
use crate::common::tube::{TUBE, speed};
use rijke_engine::run::{Run, Trusted, forecast};
use rijke_study::Study;
use std::f64::consts::{LN_10, PI, TAU};

const POINTS: usize = 4;

/// Length of tube `k`, m.
fn length(k: usize) -> f64 {
    1.0 - 0.1 * k as f64
}

/// Tubes whose growth rate with its standard deviation (1/s) and frequency (Hz) `modes` says, in one stage
/// whose noise floats.
fn tubes(name: &str, rig: &str, modes: impl Fn(usize) -> [f64; 3]) -> Folder {
    let row = |k: usize| {
        let [growth, sd, hertz] = modes(k);
        format!("p{k},{growth:.12},{sd:.12},{hertz:.12},0.05\n")
    };
    let rows: String = (0..POINTS).map(row).collect();
    let points: String = (0..POINTS).map(|k| format!("p{k},{},20\n", 100.0 * length(k))).collect();
    let head = "point,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n";
    Folder::new(
        name,
        &[
            ("rig.toml", rig),
            ("campaign.csv", &format!("point,x [cm],T_amb [degC]\n{points}")),
            ("study.toml", "name = \"t\"\n[[stage]]\nid = \"s\"\npoints = {}\n"),
            ("observations/observations.toml", ORIGIN),
            ("observations/modes.csv", &format!("{head}{rows}")),
        ],
    )
}

/// Growth rates that scatter by 5 1/s about the model: the misfit counts for stability.
#[test]
fn exact_the_probability_of_instability_counts_the_misfit() {
    let c = speed();
    let modes = |k: usize| {
        let off = if k < 2 { 5.0 } else { -5.0 };
        [c * 0.97_f64.ln() / length(k) + off, 0.5, 0.5 * c / length(k)]
    };
    let folder = tubes("misfit-counts", TUBE, modes);
    let study = Study::open(&folder.0).unwrap();
    let observations = study.observations().unwrap();
    let mut run = Run::new(study.clone(), &observations, Trusted::Laplace).unwrap();
    let stage = run.next_stage().unwrap().unwrap();
    let misfit = stage.models[0].misfit[0];
    assert!(misfit > 3.0 && misfit < 7.0, "{misfit}");
    let found = forecast(&study, &observations, &run.saved("s").unwrap(), &[], &[0]).unwrap().0;
    let [growth, measured, model] = found[0].growth_rate;
    assert!(
        found[0].stability_sd > 0.99 * misfit.hypot(model) && found[0].stability_sd < measured,
        "{found:?}"
    );
    let chance = rijke_inference::normal_cdf(growth / found[0].stability_sd);
    assert!((found[0].unstable - chance).abs() < 1e-12 && chance > 1e-3, "{chance}");
    assert!(rijke_inference::normal_cdf(growth / model) < 0.1 * chance, "{growth} {model}");
}

/// Decays of four lengths that stand in the table as other numbers than growth rates.
#[test]
fn message_other_numbers_of_a_decay_than_the_growth_rate_are_told_by_training_again() {
    let c = speed();
    let rig = TUBE.replace("sd = 0.2", "sd = 0.01");
    let growth = |k: usize| c * 0.9_f64.ln() / length(k);
    let omega = |k: usize| PI * c / length(k);
    let t60 = |k: usize| -3.0 * LN_10 / growth(k);
    // The number in the column, and how much it changes with the growth rate.
    type Column<'a> = (&'a str, &'a dyn Fn(usize) -> f64, &'a dyn Fn(usize) -> f64);
    let columns: [Column<'_>; 10] = [
        ("holds decay rates: ", &|k| -growth(k), &|_| 1.0),
        ("holds widths at half power in Hz: ", &|k| -growth(k) / PI, &|_| 1.0 / PI),
        ("holds half of the widths at half power in Hz: ", &|k| -growth(k) / TAU, &|_| 1.0 / TAU),
        ("holds damping ratios: ", &|k| -growth(k) / omega(k), &|k| 1.0 / omega(k)),
        ("holds reverberation times (60 dB) in s: ", &t60, &|k| -t60(k) / growth(k)),
        ("holds time constants of the amplitude in s: ", &|k| -1.0 / growth(k), &|k| growth(k).powi(-2)),
        ("holds time constants of the amplitude in ms: ", &|k| -1e3 / growth(k), &|k| {
            1e3 * growth(k).powi(-2)
        }),
        ("holds logarithmic decrements: ", &|k| -TAU * growth(k) / omega(k), &|k| TAU / omega(k)),
        ("holds decays of the level in dB/s: ", &|k| -20.0 / LN_10 * growth(k), &|_| 20.0 / LN_10),
        ("holds growth rates over 2 pi, in Hz: ", &|k| growth(k) / TAU, &|_| 1.0 / TAU),
    ];
    for (n, (column, number, slope)) in columns.into_iter().enumerate() {
        let modes = |k: usize| [number(k), 0.5 * slope(k), 0.5 * c / length(k)];
        let folder = tubes(&format!("other-numbers-{n}"), &rig, modes);
        let remark = run(&folder.0).unwrap()[0].models[0].remark.clone().unwrap_or_default();
        assert!(remark.contains(column), "{column}: {remark}");
    }
}
