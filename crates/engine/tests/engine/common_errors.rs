//! Errors of a factor that all points share, on a tube whose frequencies have a closed form.

use crate::common::folder::Folder;
use crate::common::tube::{TUBE, speed};
use rijke_engine::run::{Run, Trusted};
use rijke_numerics::{Cholesky, Matrix};
use rijke_study::Study;
use std::f64::consts::{PI, TAU};

const LENGTHS: [f64; 2] = [1.0, 0.8];
/// Standard deviation of a measured frequency, Hz.
const SD: f64 = 0.05;

fn folder(name: &str, plan: &str) -> Folder {
    // One ruler, a hundredth too long; the tubes are as long as they are written.
    let row = |(id, length): (&str, f64)| format!("{id},{:.9},{SD}\n", 1.01 * 0.5 * speed() / length);
    let rows: String = [("a", LENGTHS[0]), ("b", LENGTHS[1])].map(row).concat();
    Folder::new(
        &format!("common-{name}"),
        &[
            ("rig.toml", TUBE),
            ("campaign.csv", "point,x [cm],x_sd [cm],T_amb [degC]\na,100,1,20\nb,80,0.8,20\n"),
            ("study.toml", plan),
            ("observations/observations.toml", "kind = \"virtual\"\nsource = \"closed form\"\n"),
            ("observations/modes.csv", &format!("point,frequency [Hz],frequency_sd [Hz]\n{rows}")),
        ],
    )
}

fn plan(key: &str) -> String {
    format!(
        "name = \"t\"\n{key}\n[[stage]]\nid = \"s\"\npoints = {{}}\n[stage.noise]\ngrowth_rate = 0.0\nangular_frequency = 0.0\n"
    )
}

fn ln_evidence(name: &str, key: &str) -> f64 {
    let folder = folder(name, &plan(key));
    let study = Study::open(&folder.0).unwrap();
    let mut run = Run::new(study.clone(), &study.observations().unwrap(), Trusted::Laplace).unwrap();
    run.next_stage().unwrap().unwrap().models[0].ln_evidence()
}

/// The normal density of both residuals, with errors that the points share or not; r does not enter a
/// frequency.
#[test]
fn exact_errors_that_all_points_share() {
    let moved: Vec<f64> = LENGTHS.iter().map(|length| 0.01 * PI * speed() / length).collect();
    let density = |shared: bool| {
        let covariance = Matrix::from_fn(2, 2, |i, j| {
            let noise = if i == j { (TAU * SD).powi(2) } else { 0.0 };
            noise + if shared || i == j { moved[i] * moved[j] } else { 0.0 }
        });
        let factor = Cholesky::new(&covariance).unwrap();
        let white: f64 = factor.whiten(&moved).iter().map(|w| w * w).sum();
        -0.5 * (white + factor.ln_det()) - TAU.ln()
    };
    for (shared, key) in [(false, ""), (true, "common_errors = [\"x\"]")] {
        let found = ln_evidence(&shared.to_string(), key);
        assert!((found - density(shared)).abs() < 2e-3, "{shared}: {found} {}", density(shared));
    }
}

#[test]
fn message_a_factor_without_errors_has_none_in_common() {
    let folder = folder("message", &plan("common_errors = [\"T_amb\"]"));
    let said = Study::open(&folder.0).unwrap_err().to_string();
    assert!(said.contains("study.toml, line 2") && said.contains("`T_amb`") && said.ends_with("x"), "{said}");
}
