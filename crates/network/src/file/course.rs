//! What a duct is along its length: gas and area, and the segments that stand for a piece of it.

use super::assembly::LocalGas;
use super::error::FileError;
use super::item::Item;
use super::problem::ElementProblem;
use super::schema::{Duct, Gas};
use super::warning::Warning;
use crate::chain::network::Segment;
use std::f64::consts::PI;

/// Gas and area along a duct.
pub(super) struct Course {
    length: f64,
    /// At its two ends, m^2; its root is linear between.
    pub(super) area: [f64; 2],
    /// At equally spaced places from end to end, K.
    profile: Vec<f64>,
    gamma: f64,
    /// J/(kg K).
    constant: f64,
    /// Pa.
    pressure: f64,
    /// Sound speed (m/s) and density (kg/m^3), where the file says them in place of temperatures.
    pub(super) given: Option<[f64; 2]>,
}

impl Course {
    /// Reads it; what its keys say twice is added to the `warnings`.
    pub(super) fn of(
        item: &Item,
        duct: &Duct,
        gas: &Gas,
        warnings: &mut Vec<Warning>,
    ) -> Result<Self, FileError> {
        let length = item.positive("length", duct.length)?;
        let disc = |d: f64| 0.25 * PI * d * d;
        let area = match (duct.diameter, duct.area) {
            (Some(d), None) => disc(item.positive("diameter", d)?),
            (None, Some(a)) => item.positive("area", a)?,
            _ => return Err(item.fail(ElementProblem::OneOf { one: "diameter", other: "area" })),
        };
        let area_end = match (duct.diameter_end, duct.area_end) {
            (None, None) => area,
            (Some(d), None) => disc(item.positive("diameter_end", d)?),
            (None, Some(a)) => item.positive("area_end", a)?,
            _ => return Err(item.fail(ElementProblem::OneOf { one: "diameter_end", other: "area_end" })),
        };
        let profile = match (duct.temperature, duct.temperature_end, &duct.temperatures) {
            (first, None, None) => vec![first.unwrap_or(gas.temperature)],
            (first, Some(last), None) => vec![first.unwrap_or(gas.temperature), last],
            (None, None, Some(list)) if !list.is_empty() => list.clone(),
            _ => return Err(item.fail(ElementProblem::OneOf { one: "temperature", other: "temperatures" })),
        };
        for &t in &profile {
            item.positive("temperature", t)?;
        }
        let gamma = item.positive("gamma", duct.gamma.unwrap_or(gas.gamma))?;
        if gamma <= 1.0 {
            return Err(item.fail(ElementProblem::Gamma { value: gamma }));
        }
        let constant = item.positive("gas_constant", duct.gas_constant.unwrap_or(gas.gas_constant))?;
        let given = match (duct.sound_speed, duct.density) {
            (None, None) => None,
            (Some(c), Some(rho)) => Some([item.positive("sound_speed", c)?, item.positive("density", rho)?]),
            _ => return Err(item.fail(ElementProblem::Together { one: "sound_speed", other: "density" })),
        };
        if let Some([c, rho]) = given {
            let varied = match (duct.temperature_end, &duct.temperatures) {
                (Some(_), _) => Some("temperature_end"),
                (_, Some(_)) => Some("temperatures"),
                _ => duct.temperature.map(|_| "temperature"),
            };
            let why = "`sound_speed` and `density` say what the gas is";
            let idle = |key| Warning::idle(item, key, why, "leave one or the other out");
            warnings.extend(varied.map(idle));
            let (found, expected) = (rho * c * c / gamma, gas.pressure);
            if (found / expected - 1.0).abs() > 0.01 {
                let (line, place) = (item.line, item.place.clone());
                warnings.push(Warning::Pressure { line, place, found, expected });
            }
        }
        Ok(Self { length, area: [area, area_end], profile, gamma, constant, pressure: gas.pressure, given })
    }

    pub(super) fn is_cone(&self) -> bool {
        self.area[0] != self.area[1]
    }

    pub(super) fn varies(&self) -> bool {
        self.is_cone() || self.profile.len() > 1
    }

    /// Its lowest and its highest temperature, K.
    pub(super) fn span(&self) -> [f64; 2] {
        self.profile.iter().fold([f64::INFINITY, 0.0], |[low, high], t| [t.min(low), t.max(high)])
    }

    /// Temperature (K), area (m^2) and sound speed (m/s) where it begins.
    pub(super) fn beginning(&self) -> [f64; 3] {
        let first = self.profile[0];
        [first, self.area[0], (self.gamma * self.constant * first).sqrt()]
    }

    /// Where the slope of the temperature changes, m.
    pub(super) fn kinks(&self) -> impl Iterator<Item = f64> + '_ {
        let steps = self.profile.len() - 1;
        (1..steps).map(move |k| self.length * k as f64 / steps as f64)
    }

    /// The gas at `x` (m).
    pub(super) fn gas(&self, x: f64) -> LocalGas {
        let position = x / self.length * (self.profile.len() - 1) as f64;
        let k = (position as usize).min(self.profile.len().saturating_sub(2));
        let next = self.profile.get(k + 1).copied().unwrap_or(self.profile[k]);
        let here = self.profile[k] + (position - k as f64) * (next - self.profile[k]);
        let temperature = self.given.map_or(here, |[c, _]| c * c / (self.gamma * self.constant));
        LocalGas { temperature, gamma: self.gamma, heat: self.constant * temperature }
    }

    /// The segment of the gas and the area in the middle of a piece: of second order in its length.
    pub(super) fn segment(&self, [from, to]: [f64; 2]) -> Segment {
        let middle = 0.5 * (from + to);
        let [c, rho] = self.sound(middle);
        Segment::new(to - from, self.area_at(middle), c, rho)
    }

    /// Two segments that stand for a piece, of fourth order in its length ([`Segment::with_first_moment`]).
    pub(super) fn halves(&self, [from, to]: [f64; 2]) -> [Segment; 2] {
        let middle = 0.5 * (from + to);
        let area = self.area_at(middle);
        let half = |from: f64, to: f64| {
            // Three points of Gauss: rho/A and A/(rho c^2) of the half.
            let (centre, node) = (0.5 * (from + to), 0.5 * (to - from) * 0.6_f64.sqrt());
            let points = [(centre - node, 5.0), (centre, 8.0), (centre + node, 5.0)];
            let [inertance, compliance] = points.into_iter().fold([0.0; 2], |[m, k], (x, weight)| {
                let ([c, rho], area) = (self.sound(x), self.area_at(x));
                [m + weight / 18.0 * rho / area, k + weight / 18.0 * area / (rho * c * c)]
            });
            Segment::new(to - from, area, (inertance * compliance).sqrt().recip(), inertance * area)
        };
        Segment::with_first_moment([half(from, middle), half(middle, to)])
    }

    /// Sound speed (m/s) and density (kg/m^3) at `x`.
    fn sound(&self, x: f64) -> [f64; 2] {
        let gas = self.gas(x);
        self.given.unwrap_or([(gas.gamma * gas.heat).sqrt(), self.pressure / gas.heat])
    }

    fn area_at(&self, x: f64) -> f64 {
        let [from, to] = self.area.map(f64::sqrt);
        (from + x / self.length * (to - from)).powi(2)
    }
}
