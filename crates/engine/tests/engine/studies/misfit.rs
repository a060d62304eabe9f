//! What a misfit of growth rates means: for the probability of instability, and for signs.

use super::{ORIGIN, run};
use crate::common::folder::Folder;
use crate::common::tube::{TUBE, speed};
use rijke_engine::run::{Run, Trusted, forecast};
use rijke_study::Study;

const POINTS: usize = 4;

/// Length of tube `k`, m.
fn length(k: usize) -> f64 {
    1.0 - 0.1 * k as f64
}

/// Tubes whose growth rate (1/s, measured to 0.5) and frequency (Hz) `modes` says, in one stage whose noise
/// floats.
fn tubes(name: &str, rig: &str, modes: impl Fn(usize) -> [f64; 2]) -> Folder {
    let row = |k: usize| {
        let [growth, hertz] = modes(k);
        format!("p{k},{growth:.12},0.5,{hertz:.12},0.05\n")
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
        [c * 0.97_f64.ln() / length(k) + off, 0.5 * c / length(k)]
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

/// Decay rates of four lengths that stand in the table as positive numbers.
#[test]
fn message_decay_rates_that_were_given_as_positive_numbers_are_told_by_training_again() {
    let c = speed();
    let rig = TUBE.replace("sd = 0.2", "sd = 0.01");
    let modes = |k: usize| [-c * 0.9_f64.ln() / length(k), 0.5 * c / length(k)];
    let folder = tubes("decay-rates", &rig, modes);
    let stages = run(&folder.0).unwrap();
    let remark = stages[0].models[0].remark.clone().unwrap_or_default();
    assert!(remark.contains("with the signs of all growth rates turned this model gains"), "{remark}");
}
