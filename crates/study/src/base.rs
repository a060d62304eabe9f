//! The state of the gas at an operating point: temperature along the ducts, mass flow, and their errors.

use crate::rig::{Duct, DuctAt, GasModel, Rig, RigAtPoint, Shape, Value};
use crate::{Cause, Point, StudyProblem};
use rijke_numerics::words::precise;
use rijke_rig::GasState;

/// Temperature along the ducts, mass flow, numbers that laws may name, and independent causes of error.
#[derive(Clone, Debug, PartialEq)]
pub struct PointState {
    /// The gas.
    pub gas: GasModel,
    /// Stretches of the ducts with another gas, m from upstream to downstream, and that.
    pub other_gases: Vec<([f64; 2], GasModel)>,
    /// Mean pressure, Pa.
    pub pressure: f64,
    /// Mass flow from upstream to downstream, kg/s.
    pub mass_flow: f64,
    /// Numbers that the base state brings for laws: place in the scope of the rig, and value.
    pub numbers: Vec<(usize, f64)>,
    /// Places of the profile, m, ascending; two equal ones are a step. The first and last are the ends of the
    /// rig.
    pub places: Vec<f64>,
    /// Temperature at the places, K.
    pub temperature: Vec<f64>,
    /// Zones in which the temperature changes fast, m: elements end at their borders, and more closely beside
    /// them.
    pub kinks: Vec<[f64; 2]>,
    /// Independent contributions to the error.
    pub errors: Vec<BaseError>,
    /// For each factor that is not known exactly, by its place, the state with the factor larger by [`STEP`]
    /// of its standard deviation, where that is another: a heated gauze takes the rise of the gas along.
    pub moved: Vec<(usize, PointState)>,
}

/// Share of a standard deviation by which what is not known exactly is displaced: a slope, to a tenth of a
/// per cent of its change over the error.
pub const STEP: f64 = 0.02;

/// One standard deviation of one independent cause of error.
#[derive(Clone, Debug, PartialEq)]
pub struct BaseError {
    /// What the error comes from: states that name the same cause share it.
    pub cause: Cause,
    /// Change of the mass flow, kg/s.
    pub mass_flow: f64,
    /// Changes of the numbers, in their order.
    pub numbers: Vec<f64>,
    /// Change of the temperature at the places, K.
    pub temperature: Vec<f64>,
}

/// Places closer than this part of the length are the same.
const SAME: f64 = 1e-9;

/// No gas of a rig is hotter, K.
const HOTTEST: f64 = 1e4;

/// The gas in one stretch, averaged so that a short acoustic element keeps the inertance and the compliance
/// of the real one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GasStretch {
    /// Upstream edge, m.
    pub from: f64,
    /// Downstream edge, m.
    pub to: f64,
    /// Mean of the density over the length, kg/m^3.
    pub density: f64,
    /// (mean rho times mean of 1/(rho c^2))^{-1/2}, m/s.
    pub sound_speed: f64,
    /// The gas at the temperature that has the mean density.
    pub gas: GasState,
}

impl PointState {
    /// Gas of one temperature (K) at rest, with the sd of the temperature as the only error (0 for none).
    #[must_use]
    pub fn uniform(rig: &Rig, length: f64, temperature: f64, sd: f64, cause: Cause) -> Self {
        let error = BaseError { cause, mass_flow: 0.0, numbers: Vec::new(), temperature: vec![sd; 2] };
        Self {
            gas: rig.gas.clone(),
            other_gases: Vec::new(),
            pressure: rig.pressure,
            mass_flow: 0.0,
            numbers: Vec::new(),
            places: vec![0.0, length],
            temperature: vec![temperature; 2],
            kinks: Vec::new(),
            errors: if sd > 0.0 { vec![error] } else { Vec::new() },
            moved: Vec::new(),
        }
    }

    /// The temperatures that the file of the rig gives its ducts; `ambient` where it gives none. The error of
    /// the ambient temperature moves all that follow it: those that a formula of T_amb gives, too.
    ///
    /// # Errors
    /// Those of the rig at an ambient temperature that is higher by a fiftieth of its standard deviation.
    pub fn of_the_rig(
        rig: &Rig,
        layout: &RigAtPoint,
        point: &Point,
        ambient: [f64; 2],
    ) -> Result<Self, StudyProblem> {
        let day = Cause::ambient(point);
        let mut state = Self::uniform(rig, layout.length, ambient[0], 0.0, day.clone()).in_ducts(layout);
        let nodes = |layout: &RigAtPoint, ambient: f64| -> (Vec<f64>, Vec<f64>) {
            let at = |duct: &DuctAt| {
                let n = duct.temperatures.len().max(2);
                let share =
                    |k: usize| duct.span[0] + (duct.span[1] - duct.span[0]) * k as f64 / (n - 1) as f64;
                let node = |k: usize| (share(k), duct.temperature_at(share(k)).unwrap_or(ambient));
                (0..n).map(node).collect::<Vec<_>>()
            };
            layout.ducts.iter().flat_map(at).unzip()
        };
        (state.places, state.temperature) = nodes(layout, ambient[0]);
        let error =
            |cause, temperature| BaseError { cause, mass_flow: 0.0, numbers: Vec::new(), temperature };
        if ambient[1] > 0.0 {
            let warmer = ambient[0] + STEP * ambient[1];
            let (_, moved) = nodes(&rig.at(point, warmer)?, warmer);
            let change: Vec<f64> =
                moved.iter().zip(&state.temperature).map(|(there, here)| (there - here) / STEP).collect();
            if change.iter().any(|sd| *sd != 0.0) {
                state.errors.push(error(day, change));
            }
        }
        for duct in &layout.ducts {
            let part = &rig.parts[duct.part];
            let Shape::Duct(Duct { temperature_sd: sd, temperatures, .. }) = &part.shape else { continue };
            // Gas that a factor heats is not wrong by more than it is heated: cold points are as the ambient.
            let of_node = |value: &Value, kelvin: f64| match value {
                Value::Number(_) => *sd,
                _ => sd.min((kelvin - ambient[0]).abs()),
            };
            let own = |d: &DuctAt| {
                let n = d.temperatures.len().max(2);
                let nodes: Vec<f64> =
                    temperatures.iter().zip(&d.temperatures).map(|(v, t)| of_node(v, *t)).collect();
                let node = |k: usize| nodes.get(k).or(nodes.last()).copied().unwrap_or(0.0);
                if d.part == duct.part { (0..n).map(node).collect() } else { vec![0.0; n] }
            };
            let change: Vec<f64> = layout.ducts.iter().flat_map(own).collect();
            if change.iter().any(|sd| *sd > 0.0) {
                state.errors.push(error(Cause::Part(part.name.clone()), change));
            }
        }
        Ok(state)
    }

    /// The same state if it is sound.
    ///
    /// # Errors
    /// A temperature that is not positive, places that do not ascend, lists of different length.
    pub fn checked(self, point: &str) -> Result<Self, StudyProblem> {
        let wrong = |value: String, need| {
            Err(StudyProblem::Value { key: format!("base state of {point}"), value, need })
        };
        if let Some(t) = self.temperature.iter().find(|t| !(**t > 0.0 && **t < HOTTEST)) {
            return wrong(
                format!("{} K", precise(*t)),
                "a temperature above 0 K and below 10 000 K everywhere; where thermometers determine it, look at the power and \
                 the flow of this point, and at the readings of all points, of which heat and cooling are found together",
            );
        }
        let errors = self.errors.iter().flat_map(|e| &e.temperature);
        if let Some(t) = errors.into_iter().find(|t| !(-HOTTEST..HOTTEST).contains(*t)) {
            return wrong(format!("an error of {} K", precise(*t)), "errors below 10 000 K");
        }
        if let Some([from, to]) =
            self.kinks.iter().find(|[from, to]| from > to || from.is_nan() || to.is_nan())
        {
            return wrong(format!("a zone from {from} to {to} m"), "zones that ascend");
        }
        let n = self.places.len();
        let ascending = self.places.windows(2).all(|w| w[0] <= w[1]);
        let whole = self.temperature.len() == n
            && self.errors.iter().all(|e| e.temperature.len() == n && e.numbers.len() == self.numbers.len());
        if n < 2 || !ascending || !whole {
            return wrong(format!("{n} places"), "a profile whose places ascend, with a temperature each");
        }
        Ok(self)
    }

    /// The same with the gas of ducts that have another than the rig.
    #[must_use]
    pub fn in_ducts(self, layout: &RigAtPoint) -> Self {
        let other = |duct: &DuctAt| Some((duct.span, duct.gas.clone()?));
        Self { other_gases: layout.ducts.iter().filter_map(other).collect(), ..self }
    }

    /// The gas just upstream (0) or just downstream (1) of `x`; beyond the ends that of the end.
    #[must_use]
    pub fn gas_beside(&self, x: f64, side: usize) -> &GasModel {
        if self.other_gases.is_empty() {
            return &self.gas;
        }
        let length = self.places.last().copied().unwrap_or(0.0);
        let slack = SAME * length;
        let upstream = (side == 0 && x > slack) || x >= length - slack;
        let holds = |[from, to]: [f64; 2]| {
            if upstream { from + slack < x && x <= to + slack } else { from - slack <= x && x < to - slack }
        };
        self.other_gases.iter().find(|(span, _)| holds(*span)).map_or(&self.gas, |(_, gas)| gas)
    }

    /// Whether the temperature is the same everywhere.
    #[must_use]
    pub fn is_uniform(&self) -> bool {
        self.temperature.iter().all(|t| *t == self.temperature[0])
    }

    /// Gas temperature just upstream and just downstream of `x`, K; beyond the ends that of the end. A place
    /// that a file gives as a number is on the border that its lengths add up to, whatever the last digits
    /// of their sum are.
    #[must_use]
    pub fn temperatures(&self, x: f64) -> [f64; 2] {
        let last = self.places.len() - 1;
        let slack = SAME * self.places[last];
        let before = self.places.partition_point(|p| *p < x - slack).clamp(1, last);
        let after = self.places.partition_point(|p| *p <= x + slack).clamp(1, last);
        [self.between(before, x), self.between(after, x)]
    }

    fn between(&self, upper: usize, x: f64) -> f64 {
        let (x0, x1) = (self.places[upper - 1], self.places[upper]);
        let share = if x1 > x0 { ((x - x0) / (x1 - x0)).clamp(0.0, 1.0) } else { 1.0 };
        self.temperature[upper - 1] + share * (self.temperature[upper] - self.temperature[upper - 1])
    }

    /// All gas properties at `x`, on the upstream side of a step.
    #[must_use]
    pub fn at(&self, x: f64) -> GasState {
        self.gas_beside(x, 0).at(self.temperatures(x)[0], self.pressure)
    }

    /// Averages over one stretch, of one gas.
    #[must_use]
    pub fn stretch(&self, from: f64, to: f64) -> GasStretch {
        let [density, compliance] =
            self.means(from, to, |g| [g.density, 1.0 / (g.density * g.sound_speed.powi(2))]);
        let gas = self.gas_beside(0.5 * (from + to), 0);
        let temperature = self.pressure / (gas.constant() * density);
        let sound_speed = (density * compliance).sqrt().recip();
        GasStretch { from, to, density, sound_speed, gas: gas.at(temperature, self.pressure) }
    }

    /// Time that sound needs from `from` to `to` in gas at rest, s.
    #[must_use]
    pub fn travel_time(&self, from: f64, to: f64) -> f64 {
        (to - from) * self.means(from, to, |g| [1.0 / g.sound_speed])[0]
    }

    /// The state with error component k at z_k standard deviations; missing entries of `z` count as zero.
    #[must_use]
    pub fn displaced(&self, z: &[f64]) -> Self {
        let mut state = self.clone();
        for (error, z) in self.errors.iter().zip(z) {
            state.mass_flow += z * error.mass_flow;
            state.numbers.iter_mut().zip(&error.numbers).for_each(|(n, d)| n.1 += z * d);
            state.temperature.iter_mut().zip(&error.temperature).for_each(|(t, d)| *t += z * d);
        }
        state
    }

    /// The state that is `times` as far away as `near`, on a straight line through it; none if the two have
    /// other places.
    #[must_use]
    pub fn beyond(&self, near: &Self, times: f64) -> Option<Self> {
        if self.places.len() != near.places.len() || self.numbers.len() != near.numbers.len() {
            return None;
        }
        let along = |from: f64, to: f64| from + times * (to - from);
        let all = |from: &[f64], to: &[f64]| from.iter().zip(to).map(|(a, b)| along(*a, *b)).collect();
        let numbers = self.numbers.iter().zip(&near.numbers).map(|(a, b)| (a.0, along(a.1, b.1)));
        Some(Self {
            mass_flow: along(self.mass_flow, near.mass_flow),
            places: all(&self.places, &near.places),
            temperature: all(&self.temperature, &near.temperature),
            numbers: numbers.collect(),
            ..near.clone()
        })
    }

    /// Mean over [from, to] of properties, by three-point Gauss quadrature on each linear piece: errors below
    /// 1e-9 for pieces over which the temperature changes by less than a fifth.
    fn means<const N: usize>(
        &self,
        from: f64,
        to: f64,
        properties: impl Fn(&GasState) -> [f64; N],
    ) -> [f64; N] {
        if to <= from {
            return properties(&self.at(from));
        }
        let mut sums = [0.0; N];
        let borders = self.other_gases.iter().flat_map(|(span, _)| *span);
        let inner = self.places.iter().copied().chain(borders).filter(|&p| p > from && p < to);
        let mut rights: Vec<f64> = inner.chain([to]).collect();
        rights.sort_by(f64::total_cmp);
        let mut left = from;
        for right in rights {
            let (middle, half) = (0.5 * (left + right), 0.5 * (right - left));
            let node = 0.6_f64.sqrt() * half;
            for (x, weight) in [(middle - node, 5.0 / 9.0), (middle, 8.0 / 9.0), (middle + node, 5.0 / 9.0)] {
                let found = properties(&self.at(x));
                sums.iter_mut().zip(found).for_each(|(sum, value)| *sum += half * weight * value);
            }
            left = right;
        }
        sums.map(|sum| sum / (to - from))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn oracle_a_stretch_has_the_sums_of_many_thin_slices() {
        let gas = GasModel::Perfect { gamma: 1.4, constant: 287.0, viscosity: [1.8e-5, 300.0], prandtl: 0.7 };
        let state = PointState {
            gas: gas.clone(),
            other_gases: Vec::new(),
            pressure: 1e5,
            mass_flow: 0.0,
            numbers: Vec::new(),
            places: vec![0.0, 0.4, 0.5, 1.0],
            temperature: vec![293.0, 293.0, 400.0, 360.0],
            kinks: Vec::new(),
            errors: Vec::new(),
            moved: Vec::new(),
        };
        let (n, mut sums) = (200_000, [0.0; 3]);
        for i in 0..n {
            let x = 0.3 + 0.5 * (f64::from(i) + 0.5) / f64::from(n);
            let part = (x - 0.4) / 0.1;
            let temperature = match x {
                x if x < 0.4 => 293.0,
                x if x < 0.5 => 293.0 + 107.0 * part,
                x => 400.0 - 40.0 * (x - 0.5) / 0.5,
            };
            let (density, speed) = (1e5 / (287.0 * temperature), (1.4 * 287.0 * temperature).sqrt());
            let slice = [density, 1.0 / (density * speed * speed), 1.0 / speed];
            sums.iter_mut().zip(slice).for_each(|(s, v)| *s += v / f64::from(n));
        }
        let [density, compliance, slowness] = sums;
        let stretch = state.stretch(0.3, 0.8);
        assert_relative_eq!(stretch.density, density, max_relative = 1e-7);
        assert_relative_eq!(stretch.sound_speed, (density * compliance).sqrt().recip(), max_relative = 1e-7);
        assert_relative_eq!(state.travel_time(0.3, 0.8), 0.5 * slowness, max_relative = 1e-7);
    }
}
