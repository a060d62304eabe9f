//! Columns of the campaign that were exchanged, or hold half of what is meant.

use super::{ORIGIN, run};
use crate::common::folder::Folder;
use crate::common::tube::{TUBE, speed};
use rijke_numerics::C64;
use std::f64::consts::PI;

/// Two lengths, m, of which the tube has the first and a fifth of the second.
const LENGTHS: [[f64; 2]; 5] = [[1.0, 0.9], [0.9, 0.97], [0.8, 0.87], [0.75, 0.7], [1.1, 0.99]];
/// Reflection coefficient, with the other sign, of both ends.
const R: f64 = 0.85;

/// What is said of the model if `columns` makes of the two lengths what the columns `x` and `y` hold, cm.
fn said(name: &str, columns: impl Fn([f64; 2]) -> [f64; 2]) -> String {
    let mut campaign = "point,x [cm],y [cm],T_amb [degC]\n".to_owned();
    let mut modes =
        "point,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n".to_owned();
    for (k, both) in LENGTHS.into_iter().enumerate() {
        let [x, y] = columns(both);
        campaign += &format!("p{k},{:.4},{:.4},20\n", 100.0 * x, 100.0 * y);
        let s = speed() * C64::new(R.ln(), PI) / (both[0] + 0.2 * both[1]);
        modes += &format!("p{k},{:.6},0.5,{:.6},0.05\n", s.re, s.im / (2.0 * PI));
    }
    let plan = "name = \"t\"\n[[stage]]\nid = \"s\"\npoints = {}\n";
    let rig = TUBE.replace("\"x\"", "\"x + 0.2*y\"");
    let files = [
        ("rig.toml", rig.as_str()),
        ("campaign.csv", &campaign),
        ("study.toml", plan),
        ("observations/observations.toml", ORIGIN),
        ("observations/modes.csv", &modes),
    ];
    let folder = Folder::new(name, &files);
    run(&folder.0).unwrap()[0].models[0].remark.clone().unwrap_or_default()
}

#[test]
fn message_exchanged_and_halved_columns_are_named() {
    let right = said("columns-right", |both| both);
    assert!(!right.contains("column"), "{right}");
    let exchanged = said("columns-exchanged", |[x, y]| [y, x]);
    assert!(exchanged.contains("if the columns `x` and `y` of the campaign are exchanged"), "{exchanged}");
    let halved = said("columns-halved", |[x, y]| [x, 0.5 * y]);
    assert!(
        halved.contains("if all numbers of the column `y` of the campaign are multiplied by 2"),
        "{halved}"
    );
}
