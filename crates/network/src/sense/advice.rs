//! Where a small device or change would stabilise a mode most.

use super::along::{Device, Station};
use serde::Serialize;

/// A small change somewhere along the tube.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SmallChange {
    /// A weak [`Device`].
    Device(Device),
    /// A larger area.
    Area,
    /// A higher temperature.
    Temperature,
}

/// The best place for one change.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BestPlace {
    /// What is proposed.
    pub proposal: &'static str,
    /// m from the upstream end.
    pub at: f64,
    /// Change of the growth rate, 1/s, to first order.
    pub growth_rate_change: f64,
}

impl SmallChange {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Device(Device::Drag),
        Self::Device(Device::Heat),
        Self::Device(Device::Leak),
        Self::Area,
        Self::Temperature,
    ];

    /// Change of the growth rate by one unit of it at a station: 1/s per strength of a device; 1/(s m) per
    /// fraction by which area or temperature are larger.
    #[must_use]
    pub fn of(self, station: &Station) -> f64 {
        match self {
            Self::Device(device) => station.device(device).re,
            Self::Area => station.area.re,
            Self::Temperature => station.temperature.re,
        }
    }

    /// What is proposed, of which sign, and how much of a unit it is.
    fn proposal(self, sign: f64) -> (&'static str, f64) {
        match self {
            Self::Device(Device::Drag) => ("a screen that takes 0.01 rho c u", 0.01),
            Self::Device(Device::Heat) => ("a heat source that adds 0.01 u in phase", 0.01),
            Self::Device(Device::Leak) => ("a leak that takes 0.01 p/(rho c)", 0.01),
            Self::Area if sign > 0.0 => ("0.1 m with 1 % more area", 0.001),
            Self::Area => ("0.1 m with 1 % less area", 0.001),
            Self::Temperature if sign > 0.0 => ("0.1 m warmer by 1 %", 0.001),
            Self::Temperature => ("0.1 m colder by 1 %", 0.001),
        }
    }

    /// Where it lowers the growth rate most, from its curve (that of [`SmallChange::of`]) over the places
    /// `x`. Devices act one way; areas and temperatures can go both ways. None without places.
    #[must_use]
    pub fn best(self, x: &[f64], curve: &[f64]) -> Option<BestPlace> {
        let both = matches!(self, Self::Area | Self::Temperature);
        let gain = |v: f64| if both { -v.abs() } else { v };
        let (&at, &value) = x.iter().zip(curve).min_by(|a, b| gain(*a.1).total_cmp(&gain(*b.1)))?;
        let (proposal, unit) = self.proposal(-value);
        Some(BestPlace { proposal, at, growth_rate_change: unit * gain(value) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_devices_go_where_they_damp_and_areas_where_they_matter() {
        let (x, curve) = ([0.0, 0.5, 1.0], [3.0, -1.0, 2.0]);
        let drag = SmallChange::Device(Device::Drag).best(&x, &curve).unwrap();
        assert_eq!((drag.at, drag.growth_rate_change), (0.5, -0.01));
        let area = SmallChange::Area.best(&x, &curve).unwrap();
        assert_eq!(
            (area.at, area.growth_rate_change, area.proposal),
            (0.0, -0.003, "0.1 m with 1 % less area")
        );
        let warm = SmallChange::Temperature.best(&x, &[0.0, -4.0, 2.0]).unwrap();
        assert_eq!((warm.at, warm.proposal), (0.5, "0.1 m warmer by 1 %"));
        assert_eq!(SmallChange::Area.best(&[], &[]), None);
    }
}
