//! The shape of a mode and the effect of small changes along x, as curves; where a small change would
//! stabilise it most.

use super::advice::{BestPlace, SmallChange};
use super::along::{Device, Station};
use rijke_numerics::C64;
use serde::Serialize;
use std::f64::consts::PI;
use std::fmt::Write;

/// A mode along x.
#[derive(Clone, Debug, PartialEq)]
pub struct ModeCurves {
    /// 1/s.
    pub growth_rate: f64,
    /// Hz.
    pub frequency_hz: f64,
    /// m from the upstream end.
    pub x: Vec<f64>,
    /// |p| over its largest value.
    pub pressure: Vec<f64>,
    /// |rho c u| over the largest |p|.
    pub velocity: Vec<f64>,
    /// What small changes at x do to the growth rate ([`SmallChange::of`]).
    pub changes: Vec<(SmallChange, Vec<f64>)>,
}

/// The best place for one change of a mode.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Advice {
    /// Of the mode, Hz.
    pub frequency_hz: f64,
    /// Where, and by how much.
    #[serde(flatten)]
    pub best: BestPlace,
}

impl ModeCurves {
    /// Of the mode `s`, by its stations.
    #[must_use]
    pub fn of(s: C64, stations: &[Station]) -> Self {
        let of = |f: &dyn Fn(&Station) -> f64| stations.iter().map(f).collect();
        Self {
            growth_rate: s.re,
            frequency_hz: s.im / (2.0 * PI),
            x: of(&|s| s.x),
            pressure: of(&|s| s.pressure.norm()),
            velocity: of(&|s| s.velocity.norm()),
            changes: SmallChange::ALL.map(|change| (change, of(&|s| change.of(s)))).to_vec(),
        }
    }

    /// The best place of every change.
    pub fn advice(&self) -> impl Iterator<Item = Advice> {
        let frequency_hz = self.frequency_hz;
        let best = self.changes.iter().filter_map(|(change, curve)| change.best(&self.x, curve));
        best.map(move |best| Advice { frequency_hz, best })
    }

    /// Shapes and sensitivities of modes along x as CSV.
    #[must_use]
    pub fn csv(modes: &[Self]) -> String {
        let mut text = "frequency [Hz],growth_rate [1/s],x [m],pressure,velocity_times_rho_c".to_owned();
        SmallChange::ALL.iter().for_each(|change| text += &format!(",{}", column(*change)));
        for mode in modes {
            for (k, x) in mode.x.iter().enumerate() {
                let numbers = [mode.frequency_hz, mode.growth_rate, *x, mode.pressure[k], mode.velocity[k]];
                let numbers = numbers.into_iter().chain(mode.changes.iter().map(|c| c.1[k]));
                let row: Vec<String> = numbers.map(|v| v.to_string()).collect();
                // Writing to a string cannot fail.
                let _ = write!(text, "\n{}", row.join(","));
            }
        }
        text + "\n"
    }
}

/// The name of the column of a change.
fn column(change: SmallChange) -> &'static str {
    match change {
        SmallChange::Device(Device::Drag) => "by_screen [1/s]",
        SmallChange::Device(Device::Heat) => "by_heat [1/s]",
        SmallChange::Device(Device::Leak) => "by_leak [1/s]",
        SmallChange::Area => "by_area [1/(s m)]",
        SmallChange::Temperature => "by_temperature [1/(s m)]",
    }
}
