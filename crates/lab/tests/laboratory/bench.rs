//! The bench: closed forms, noise as stated, messages, and the data of the example folders made again.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use num_complex::Complex;
use rijke_lab::bench::{Bench, BenchError, BenchObservations, run};
use std::f64::consts::{PI, TAU};
use std::path::{Path, PathBuf};

/// A truth of a plain tube; `parts` follow.
fn tube(parts: &str) -> String {
    format!(
        "name = \"tube\"\ncampaign = \"campaign.csv\"\n{parts}
[search]\ngrowth_rate = [-100.0, -0.01]\nfrequency_hz = [50.0, 700.0]
[microphones]\nat = [0.1, 0.3, 0.55]\nreference = 1
[noise]\ngrowth_rate = 0.2\nfrequency_hz = 0.05\npressure = 0.01\n"
    )
}

fn folder(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("rijke-lab-bench-{}-{name}", std::process::id()))
}

fn observe(name: &str, truth: &str, campaign: &str) -> Result<BenchObservations, BenchError> {
    let folder = folder(name);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("truth.toml"), truth).unwrap();
    std::fs::write(folder.join("campaign.csv"), campaign).unwrap();
    let seen = Bench::read(&folder.join("truth.toml")).and_then(|bench| bench.observe(3));
    std::fs::remove_dir_all(&folder).unwrap();
    seen
}

const CLOSED_OPEN: &str = "upstream = { type = \"rigid\" }\ndownstream = { type = \"reflection\", modulus = 0.95, angle = 3.141592653589793 }
duct = [{ length = 0.8, diameter = 0.05, layers = 0.0 }]";

/// Speed of sound of the bench's air at 293.15 K.
fn sound_speed() -> f64 {
    rijke_rig::Gas::air().at(293.15, 101_325.0).sound_speed
}

#[test]
fn exact_closed_tube_with_a_lossy_end() {
    // R e^{-2 s L/c} = 1 with R = -0.95: s = c/(2 L) (ln 0.95 + i (2 n - 1) pi).
    let seen = observe("closed", &tube(CLOSED_OPEN), "point,T_amb\na,293.15\n").unwrap();
    assert_eq!(seen.modes.len(), 3);
    for (n, mode) in seen.modes.iter().enumerate() {
        let phase = Complex::new(0.95_f64.ln(), (2 * n + 1) as f64 * PI);
        let s = sound_speed() / 1.6 * phase;
        assert!((mode.exact - s).norm() < 1e-9 * s.norm(), "{} against {s}", mode.exact);
    }
}

#[test]
fn exact_mean_flow_of_a_plain_tube_leaves_modes_to_first_order() {
    // R_u R_d e^{-s L (1/(c + u) + 1/(c - u))} = 1: u counts as its square only.
    let truth = tube(&format!("volume_flow = 2e-3\n{CLOSED_OPEN}"));
    let still = observe("still", &tube(CLOSED_OPEN), "point,T_amb\na,293.15\n").unwrap();
    let blown = observe("blown", &truth, "point,T_amb\na,293.15\n").unwrap();
    for (a, b) in still.modes.iter().zip(&blown.modes) {
        assert!((a.exact - b.exact).norm() < 1e-10 * a.exact.norm());
    }
}

#[test]
fn exact_one_end_of_a_tube_that_is_longer_by_a_step_of_no_height() {
    let two = CLOSED_OPEN.replace(
        "{ length = 0.8, diameter = 0.05, layers = 0.0 }",
        "{ length = 0.3, diameter = 0.05, layers = 1.0 }, { length = 0.5, diameter = 0.05, layers = 1.0 }",
    );
    let one = CLOSED_OPEN.replace("layers = 0.0", "layers = 1.0");
    let modes = |name, parts: &str| observe(name, &tube(parts), "point,T_amb\na,293.15\n").unwrap().modes;
    for (a, b) in modes("one", &one).iter().zip(&modes("two", &two)) {
        assert!((a.exact - b.exact).norm() < 1e-10 * a.exact.norm());
    }
}

#[test]
fn lab_noise_has_the_stated_standard_deviations() {
    let rows: String = (0..400).map(|k| format!("p{k},293.15\n")).collect();
    let seen = observe("noise", &tube(CLOSED_OPEN), &format!("point,T_amb\n{rows}")).unwrap();
    let ratio = |errors: Vec<f64>| (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    let growth = seen.modes.iter().map(|m| (m.growth_rate - m.exact.re) / 0.2).collect();
    let frequency = seen.modes.iter().map(|m| (m.frequency_hz - m.exact.im / TAU) / 0.05).collect();
    // 1200 draws: the standard deviation of their root mean square is 0.02.
    assert!((ratio(growth) - 1.0).abs() < 0.08 && (ratio(frequency) - 1.0).abs() < 0.08);
    let shapes: Vec<_> = seen.modes.iter().step_by(3).map(|m| m.pressures[1].unwrap()).collect();
    let mean = shapes.iter().sum::<Complex<f64>>() / shapes.len() as f64;
    let scatter = shapes.iter().flat_map(|p| [(p - mean).re / 0.01, (p - mean).im / 0.01]).collect();
    assert!((ratio(scatter) - 1.0).abs() < 0.15);
}

#[test]
fn exact_messages_name_file_line_and_remedy() {
    let message = |name, truth: &str, campaign: &str| observe(name, truth, campaign).unwrap_err().to_string();
    let plain = tube(CLOSED_OPEN);
    let unknown = plain.replace("layers", "layer");
    assert!(message("key", &unknown, "point,T_amb\na,293.15\n").contains("there is no key `layer`; "));
    let factor = plain.replace("length = 0.8", "length = \"reach\"");
    let found = message("factor", &factor, "point,depth [mm],T_amb\na,3,293.15\n");
    assert!(found.contains("point a: `reach` has no value") && found.contains("depth"), "{found}");
    let reference = plain.replace("reference = 1", "reference = 4");
    assert!(message("reference", &reference, "point,T_amb\na,293.15\n").contains("there are 3, from 1"));
    let beyond = plain.replace("0.55]", "0.85]");
    assert!(message("beyond", &beyond, "point,T_amb\na,293.15\n").contains("0.85 is outside 0 to 0.8"));
    let growing = plain.replace("0.95", "1.05").replace("-0.01", "100.0");
    assert!(message("growing", &growing, "point,T_amb\na,293.15\n").contains("leave the point out"));
}

#[test]
fn regress_observations_of_the_examples_are_made_again() {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    for name in ["quarter-wave", "ducted-flame-stages", "helmholtz-combustor"] {
        let (example, out) = (examples.join(name), folder(name));
        run(&example.join("truth.toml"), &out, 1).unwrap();
        for file in std::fs::read_dir(&out).unwrap() {
            let path = file.unwrap().path();
            let kept = example.join("observations").join(path.file_name().unwrap());
            let [new, old] = [&path, &kept].map(|path| std::fs::read_to_string(path).unwrap());
            assert!(new == old, "{} is not what the bench makes today", kept.display());
        }
        std::fs::remove_dir_all(&out).unwrap();
    }
}

#[test]
fn lab_both_truths_of_the_quarter_wave_are_stable_at_every_point() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/quarter-wave");
    for name in ["truth.toml", "truth-2.toml"] {
        let bench = Bench::read(&folder.join(name)).unwrap();
        for seed in 1..=3 {
            let seen = bench.observe(seed).unwrap();
            assert_eq!((seen.modes.len(), seen.readings.len()), (96, 144), "{name}");
            assert!(seen.modes.iter().all(|mode| mode.exact.re < -0.5));
            // Of the dead microphone and the reference there is nothing.
            assert!(seen.modes.iter().all(|mode| mode.pressures[0].is_none() && mode.pressures[3].is_none()));
        }
    }
}
