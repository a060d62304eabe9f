//! Pressures by another convention: of time, or of angles.

use super::{ORIGIN, run};
use crate::common::folder::Folder;
use crate::common::tube::{TUBE, speed};
use rijke_engine::EngineError;
use rijke_numerics::{C64, Classify};
use std::f64::consts::PI;

/// Places of the microphones, m; the first is the reference.
const AT: [f64; 3] = [0.3, 0.55, 0.8];
/// Reflection coefficient, with the other sign, of both ends of a tube of 1 m.
const R: f64 = 0.85;

/// Pressures of the first mode over that of the reference: of p = e^(k x) - r e^(-k x) with k = ln r + i pi.
fn pressures() -> [C64; 2] {
    let k = C64::new(R.ln(), PI);
    let p = |x: f64| (k * x).exp() - R * (-k * x).exp();
    [1, 2].map(|m| p(AT[m]) / p(AT[0]))
}

/// The remark on the model that is fitted to pressures which `cells` writes, two columns and two standard
/// deviations of each.
fn said(name: &str, head: &str, cells: impl Fn(C64) -> String) -> Result<String, EngineError> {
    let [a, b, c] = AT;
    let microphones = format!(
        "[microphones]\nat = [{a}, {b}, {c}]\nnames = [\"m0\", \"m1\", \"m2\"]\nreference = \"m0\"\n[upstream]"
    );
    let c = speed();
    let [one, two] = pressures().map(cells);
    let modes = format!(
        "point,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz],{},{}\na,{:.9},0.5,{:.9},0.05,{one},{two}\n",
        head.replace('M', "m1"),
        head.replace('M', "m2"),
        c * R.ln(),
        0.5 * c
    );
    let folder = Folder::new(
        name,
        &[
            ("rig.toml", &TUBE.replace("[upstream]", &microphones)),
            ("campaign.csv", "point,x [cm],T_amb [degC]\na,100,20\n"),
            (
                "study.toml",
                "name = \"t\"\n[[stage]]\nid = \"s\"\npoints = {}\n[stage.noise]\ngrowth_rate = 0.0\nangular_frequency = 0.0\npressure = 0.0\n",
            ),
            ("observations/observations.toml", ORIGIN),
            ("observations/modes.csv", &modes),
        ],
    );
    Ok(run(&folder.0)?[0].models[0].remark.clone().unwrap_or_default())
}

const PARTS: &str = "M_re,M_re_sd,M_im,M_im_sd";

#[test]
fn message_pressures_by_the_other_sign_of_time_are_named() {
    let cells = |p: C64| format!("{:.9},1e-3,{:.9},1e-3", p.re, p.im);
    let right = said("as-they-are", PARTS, cells).unwrap();
    assert!(!right.contains("conjugate"), "{right}");
    let turned = said("conjugated", PARTS, |p| cells(p.conj())).unwrap();
    assert!(turned.contains("with the complex conjugates of all pressures this model gains"), "{turned}");
}

#[test]
fn message_degrees_that_are_called_radians_are_refused() {
    let head = |unit: &str| format!("M_abs,M_abs_sd,M_arg [{unit}],M_arg_sd [{unit}]");
    // From 0 to 360 degrees. A small angle in degrees is an angle in radians too.
    let degrees = |p: C64| format!("{:.9},1e-3,{:.9},0.1", p.norm(), p.arg().to_degrees().rem_euclid(360.0));
    assert!(!said("degrees", &head("deg"), degrees).unwrap().contains("conjugate"));
    let refused = said("radians", &head("rad"), degrees).or_bad_input().unwrap_err().to_string();
    assert!(refused.contains("write [deg] in the heading"), "{refused}");
}
