//! Points foreseen from all others, against trainings without them.

use super::variants::{QUARTER_WAVE, Variant};
use rijke_engine::run::{Run, Trusted};
use rijke_engine::{Noise, Observed, Training, train};
use rijke_inference::{MapOptions, NoiseMode};

/// ln p(point | others) = ln p(all) - ln p(others), each by a training of its own; the noise is known.
#[test]
fn oracle_points_foreseen_from_all_others_against_trainings_without_them() {
    let last = "with = { heat-release = \"heat.king-lighthill\" }\n[stage.noise]\ngrowth_rate = 0.1\nangular_frequency = 0.5\npressure = 0.001\n";
    let variant = Variant::new("left-out", &QUARTER_WAVE).stage(last);
    // The base states' errors would tie all points together.
    let text = std::fs::read_to_string(variant.path("study.toml")).unwrap();
    std::fs::write(variant.path("study.toml"), text.replace("base_errors = true", "base_errors = false"))
        .unwrap();
    let study = variant.study();
    let observations = study.observations().unwrap();
    let mut run = Run::new(study, &observations, Trusted::Laplace).unwrap();
    while let Some(stage) = run.next_stage().unwrap() {
        if stage.id != "heat" {
            continue;
        }
        let checks = stage.checks.unwrap();
        let chosen = run.chosen("heat").unwrap();
        let fixed = |sd: f64| NoiseMode::Fixed { sd };
        let training = Training {
            microphones: (0..5).collect(),
            noise: Noise {
                of_a_point: [fixed(0.1), fixed(0.5), fixed(0.001)],
                of_an_installation: [fixed(0.0); 2],
                measured: true,
                varying: Vec::new(),
                law: None,
            },
            known: vec![run.chosen("gauze").unwrap().trained.gaussian()],
            channels: None,
            search: MapOptions::default(),
            base_errors: false,
            assemblies: Vec::new(),
            causes: Vec::new(),
            checks: None,
        };
        let evidence =
            |points: &[Observed]| train(&chosen.assembly, points, &training).unwrap().evidence.ln_marginal;
        let all = evidence(&chosen.observed);
        let mut sound = 0;
        for point in &checks.points {
            let rest: Vec<Observed> =
                chosen.observed.iter().filter(|o| o.conditions.id != point.point).cloned().collect();
            let (exact, found) = (all - evidence(&rest), point.ln_left_out.unwrap());
            let apart = (found - exact).abs();
            assert!(apart < 0.05 || point.doubtful, "{point:?}: {exact}");
            sound += usize::from(apart < 0.05);
        }
        assert!(checks.points.len() >= 20 && sound >= 20, "{sound} of {}", checks.points.len());
    }
}
