//! What is known of the way of sound from the bottom of the tube to each microphone, and how well.

use crate::click::{ClickOptions, Reflection};
use rijke_numerics::Matrix;
use rijke_rig::{GasState, OperatingPoint, RecordSet, TubeRig};

/// Relative standard deviation of the boundary layers of the insert: threads and fabric have a larger surface
/// than smooth cylinders, by how much is not known.
const INSERT_SURFACE_SD: f64 = 0.5;

/// Wetted perimeter over twice the open area, 1/m, of the tube and of the tube with insert.
fn wetted(rig: &TubeRig) -> [f64; 2] {
    let (tube, insert) = (&rig.tube, &rig.insert);
    let with = (tube.perimeter() + insert.perimeter()) / (2.0 * (tube.area() - insert.area()));
    [tube.radius().recip(), with]
}

/// Length of the insert at `point`, m: they reach from the bottom to the plates.
fn insert_length(rig: &TubeRig, point: &OperatingPoint) -> f64 {
    let half = if point.plates { 0.5 * rig.plates.length() } else { 0.0 };
    point.position.map_or(0.0, |position| (position - half).max(0.0))
}

/// Kirchhoff's dispersion of a path of which 1 m has a wetted perimeter over twice the open area of 1/m,
/// s^{1/2} per m of path and per (1/m): see [`ClickOptions::dispersion`]. In a round tube that perimeter over
/// twice the area is one over the radius.
#[must_use]
pub(crate) fn kirchhoff(gas: &GasState) -> f64 {
    (0.5 * gas.viscosity / gas.density).sqrt() * (1.0 + (gas.gamma - 1.0) / gas.prandtl.sqrt())
        / gas.sound_speed
}

/// [`kirchhoff`] of the air of one day.
fn layers(set: &RecordSet, day: usize) -> f64 {
    kirchhoff(&set.rig.gas.at(set.days[day].ambient_temperature, set.rig.pressure))
}

/// `options` with what is known of the propagation in the tube of `set` on one day (an index): Kirchhoff's
/// boundary layers on the tube and on the insert below the plates, and the reflection at the open end, which
/// comes earlier by an unknown factor if the gas is hot. No point: the empty tube.
#[must_use]
pub fn click_options(
    set: &RecordSet,
    day: usize,
    point: Option<&OperatingPoint>,
    options: &ClickOptions,
) -> ClickOptions {
    let (rig, radius) = (&set.rig, set.rig.tube.radius());
    let sound_speed = rig.gas.at(set.days[day].ambient_temperature, rig.pressure).sound_speed;
    // Levine & Schwinger 1948: the reflection seems to come from 0.61 radii beyond the end.
    let end = rig.tube.length + 0.61 * radius;
    let positions = &rig.microphones.positions;
    let ([bare, with], loss) = (wetted(rig), layers(set, day));
    let insert = point.map_or(0.0, |p| insert_length(rig, p));
    let way = |x: f64| loss * (x * bare + x.min(insert) * (with - bare));
    ClickOptions {
        dispersion: positions.iter().map(|x| way(*x)).collect(),
        reflection: Some(Reflection {
            lags: positions.iter().map(|x| 2.0 * (end - x) / sound_speed).collect(),
            strength: -1.0,
            smoothing: radius / sound_speed,
            tolerance: 0.1,
            pace_sd: if point.is_some_and(|p| p.power > 0.0) { 0.2 } else { 0.0 },
            dispersion: positions.iter().map(|x| 2.0 * (way(rig.tube.length) - way(*x))).collect(),
        }),
        leaning: point.is_none(),
        ..options.clone()
    }
}

/// Covariance of what shifts all clicks of `point` alike against those of the calibration, s^2: the rig is
/// set anew ([`rijke_rig::Recording::arrival_setting_sd_s`]), and the surface of the insert is not well
/// known. A dispersion kappa delays the impulse by kappa times `delay`, s^{-1/2}.
pub(super) fn setting_covariance(set: &RecordSet, day: usize, point: &OperatingPoint, delay: f64) -> Matrix {
    let (rig, insert) = (&set.rig, insert_length(&set.rig, point));
    let ([bare, with], loss) = (wetted(rig), layers(set, day));
    let late = |x: &f64| loss * delay * x.min(insert) * (with - bare) * INSERT_SURFACE_SD;
    let late: Vec<f64> = rig.microphones.positions.iter().map(late).collect();
    let setting = rig.recording.arrival_setting_sd_s.powi(2);
    Matrix::from_fn(late.len(), late.len(), |i, j| setting + late[i] * late[j])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_bare_tube_has_kirchhoffs_layer_and_an_insert_adds_its_own() {
        let rig = TubeRig::juniper_yoko_2022();
        let [bare, with] = wetted(&rig);
        assert!((bare - 2.0 / 0.0474).abs() < 1e-12);
        let (perimeter, area) =
            (0.0474 + 2.0 * 0.003 + 2.0 * 0.004, 0.0474_f64.powi(2) - 2.0 * (9e-6 + 16e-6));
        assert!((with - 2.0 * perimeter / area).abs() < 1e-9, "{with}");
        let mut point = rijke_rig::TubeCampaign::juniper_yoko_2022().points.remove(0);
        (point.position, point.plates) = (Some(0.4), true);
        assert!((insert_length(&rig, &point) - (0.4 - 0.5 * rig.plates.length())).abs() < 1e-12);
        (point.position, point.plates) = (None, false);
        assert_eq!(insert_length(&rig, &point), 0.0);
    }
}
