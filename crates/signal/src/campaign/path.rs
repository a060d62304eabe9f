//! What is known of the way of sound from the lower end of the duct to each microphone, and how well.

use crate::click::{ClickOptions, Reflection};
use rijke_numerics::Matrix;
use rijke_rig::{GasState, PointRecords, RecordSet, Stretch, Way};

/// Wetted perimeter over twice the open area of the empty duct, 1/m.
fn wetted(set: &RecordSet) -> f64 {
    set.rig.duct.radius().recip()
}

/// Length of a stretch below the place `x`, m.
fn passed(stretch: &Stretch, x: f64) -> f64 {
    (x.min(stretch.to) - stretch.from).max(0.0)
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

/// `options` with what is known of the propagation in the duct of `set` on one day (an index): Kirchhoff's
/// boundary layers on the wall and on what stands along the `way`, and the reflection at the open end, which
/// comes earlier by an unknown factor if the gas is hot. No records: the empty duct of a calibration.
#[must_use]
pub fn click_options(
    set: &RecordSet,
    day: usize,
    records: Option<&PointRecords>,
    options: &ClickOptions,
) -> ClickOptions {
    let (rig, radius) = (&set.rig, set.rig.duct.radius());
    let sound_speed = rig.gas.at(set.days[day].ambient_temperature, rig.pressure).sound_speed;
    // Levine & Schwinger 1948: the reflection seems to come from 0.61 radii beyond the end.
    let (length, end) = (rig.duct.length, rig.duct.length + 0.61 * radius);
    let positions = &rig.microphones.positions;
    let (bare, loss) = (wetted(set), layers(set, day));
    let passing = records.and_then(|r| r.way.as_ref());
    let stretches = passing.map_or(&[][..], |way| &way.stretches);
    let beside = |x: f64| stretches.iter().map(|s| passed(s, x) * (s.wetted - bare)).sum::<f64>();
    let way = |x: f64| loss * (x * bare + beside(x));
    ClickOptions {
        dispersion: positions.iter().map(|x| way(*x)).collect(),
        reflection: Some(Reflection {
            lags: positions.iter().map(|x| 2.0 * (end - x) / sound_speed).collect(),
            strength: -1.0,
            smoothing: radius / sound_speed,
            tolerance: 0.1,
            pace_sd: if passing.is_some_and(|way| way.hot) { 0.2 } else { 0.0 },
            dispersion: positions.iter().map(|x| 2.0 * (way(length) - way(*x))).collect(),
        }),
        leaning: records.is_none(),
        ..options.clone()
    }
}

/// Covariance of what shifts all clicks of a point alike against those of the calibration, s^2: the rig is
/// set anew ([`rijke_rig::Recording::arrival_setting_sd_s`]), and the surface of what stands along the `way`
/// is not well known. A dispersion kappa delays the impulse by kappa times `delay`, s^{-1/2}.
pub(super) fn setting_covariance(set: &RecordSet, day: usize, way: Option<&Way>, delay: f64) -> Matrix {
    let (bare, loss) = (wetted(set), layers(set, day));
    let stretches = way.map_or(&[][..], |way| &way.stretches);
    let late = |x: &f64| -> f64 {
        stretches.iter().map(|s| loss * delay * passed(s, *x) * (s.wetted - bare) * s.excess_sd).sum()
    };
    let late: Vec<f64> = set.rig.microphones.positions.iter().map(late).collect();
    let setting = set.rig.recording.arrival_setting_sd_s.powi(2);
    Matrix::from_fn(late.len(), late.len(), |i, j| setting + late[i] * late[j])
}

#[cfg(test)]
mod tests {
    use super::*;
    use rijke_rig::{Acquisition, Apparatus, Arrays, DataKind, Day, OperatingPoint, RecordTiming};
    use std::path::Path;

    fn set(way: Option<Way>) -> RecordSet {
        let rig = include_str!("../../../rig/data/rig.toml");
        let timing = RecordTiming { rate_hz: 62_500.0, quiet: 100 };
        RecordSet {
            rig: Apparatus::parse(rig, Path::new("rig.toml")).unwrap(),
            kind: DataKind::Measured,
            source: String::new(),
            channels: (0..8).map(Some).collect(),
            arrays: Arrays::default(),
            full_scale: 1.0,
            ping: timing,
            click: timing,
            days: vec![Day { id: "one".into(), ambient_temperature: 293.0, ambient_temperature_sd: 0.1 }],
            points: vec![PointRecords {
                point: OperatingPoint::default(),
                day: 0,
                pings: Vec::new(),
                clicks: Vec::new(),
                way,
            }],
            calibrations: Vec::new(),
            acquisition: Acquisition::default(),
        }
    }

    #[test]
    fn exact_a_bare_duct_has_kirchhoffs_layer_and_a_stretch_adds_its_own() {
        let options = |way| {
            let set = set(way);
            click_options(&set, 0, Some(&set.points[0]), &ClickOptions::default())
        };
        let (bare, empty) = (options(None), set(None));
        let kappa = kirchhoff(&empty.rig.gas.at(293.0, empty.rig.pressure));
        let positions = &empty.rig.microphones.positions;
        for (x, found) in positions.iter().zip(&bare.dispersion) {
            assert!((found - kappa * x * 2.0 / 0.0474).abs() < 1e-15, "{x}: {found}");
        }
        assert_eq!(options(Some(Way::default())).dispersion, bare.dispersion);
        // From 0.3 to 0.5 m twice the layers: 0.05, 0.15 and 0.2 m of them at 0.35, 0.45 and 0.55 m.
        let stretch = Stretch { from: 0.3, to: 0.5, wetted: 4.0 / 0.0474, excess_sd: 0.5 };
        let way = Way { hot: true, stretches: vec![stretch] };
        let with = options(Some(way.clone()));
        let more: Vec<f64> = with.dispersion.iter().zip(&bare.dispersion).map(|(a, b)| a - b).collect();
        for (found, length) in more.iter().zip([0.0, 0.05, 0.15, 0.2, 0.2]) {
            assert!((found - kappa * length * 2.0 / 0.0474).abs() < 1e-15, "{more:?}");
        }
        let pace = |o: &ClickOptions| o.reflection.as_ref().unwrap().pace_sd;
        assert_eq!((pace(&bare), pace(&with)), (0.0, 0.2));
        // Half of what they delay is not known, together with the setting.
        let covariance = setting_covariance(&empty, 0, Some(&way), 1e3);
        let (late, setting) = (0.5e3 * more[4], 2.1e-6_f64.powi(2));
        assert!((covariance[(0, 0)] - setting).abs() < 1e-20);
        assert!((covariance[(4, 7)] - setting - late * late).abs() < 1e-18, "{}", covariance[(4, 7)]);
    }
}
