//! The mean flow and the temperature of the gas along a chain.

use super::campaign::Point;
use super::error::BenchError;
use super::truth::{BenchTruth, Cooling};
use super::value::is_present;
use rijke_rig::{Gas, GasState};
use std::f64::consts::PI;

/// The mean state at one operating point.
#[derive(Clone, Debug)]
pub(crate) struct Base {
    gas: Gas,
    pressure: f64,
    /// Mass flow, kg/s.
    pub(crate) mass_flow: f64,
    /// Length and diameter of the ducts, m.
    pub(crate) ducts: Vec<[f64; 2]>,
    /// From upstream to downstream, without gaps.
    pieces: Vec<Piece>,
    /// Begin, length, and heat to the gas (W) of every source that is there; none for those that are not.
    pub(crate) sources: Vec<Option<[f64; 3]>>,
}

/// A cubic piece of T(x).
#[derive(Clone, Copy, Debug)]
struct Piece {
    x: [f64; 2],
    temperature: [f64; 2],
    slope: [f64; 2],
}

/// Longest step of the energy balance, m.
const STEP: f64 = 2.5e-3;

impl Base {
    /// The mean state of `truth` at `point` when the room is at `ambient`, K.
    pub(crate) fn new(truth: &BenchTruth, point: &Point, ambient: f64) -> Result<Self, BenchError> {
        let ducts: Vec<[f64; 2]> = truth
            .duct
            .iter()
            .map(|duct| Ok([within(point, "duct.length", duct.length.at(point)?, 1e-6, 1e3)?, duct.diameter]))
            .collect::<Result<_, BenchError>>()?;
        let flow = truth.volume_flow.as_ref().map_or(Ok(0.0), |flow| flow.at(point))?;
        let mass_flow = flow * truth.gas.at(ambient, truth.pressure).density;
        let length: f64 = ducts.iter().map(|duct| duct[0]).sum();
        let mut sources = Vec::new();
        for source in &truth.source {
            let power =
                if is_present(source.present.as_ref(), point) { source.power.at(point)? } else { 0.0 };
            if power == 0.0 {
                sources.push(None);
                continue;
            }
            within(point, "volume_flow, where there is heat", flow, 1e-9, 1e3)?;
            let begin = source.at.at(point)? - 0.5 * source.thickness;
            // The duct that holds its beginning must hold all of it.
            let edges = ducts.iter().scan(0.0, |x, duct| {
                let low = *x;
                *x += duct[0];
                Some([low, *x])
            });
            let [low, high] = edges.filter(|edge| edge[0] <= begin).last().unwrap_or([0.0, length]);
            within(point, "beginning of a source, m,", begin, low.max(1e-9), high - source.thickness)?;
            sources.push(Some([begin, source.thickness, source.share * power]));
        }
        let mut base = Self {
            gas: truth.gas.clone(),
            pressure: truth.pressure,
            mass_flow,
            ducts,
            pieces: vec![],
            sources,
        };
        base.heat(truth.cooling, ambient, length);
        Ok(base)
    }

    /// Fills the pieces: a linear rise over each source, cooling behind.
    fn heat(&mut self, cooling: Cooling, ambient: f64, length: f64) {
        let mut sources: Vec<[f64; 3]> = self.sources.iter().flatten().copied().collect();
        sources.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let (mut x, mut t) = (0.0, ambient);
        for [begin, thickness, heat] in sources {
            t = self.cool(cooling, ambient, [x, begin], t);
            let hot = self.heated(t, heat / self.mass_flow);
            let slope = (hot - t) / thickness;
            self.pieces.push(Piece {
                x: [begin, begin + thickness],
                temperature: [t, hot],
                slope: [slope; 2],
            });
            (x, t) = (begin + thickness, hot);
        }
        self.cool(cooling, ambient, [x, length], t);
    }

    /// Cools gas of temperature `t` from `from` to `to`, duct by duct; returns what it has then.
    fn cool(&mut self, cooling: Cooling, ambient: f64, [from, to]: [f64; 2], t: f64) -> f64 {
        let mut edges = vec![from];
        let inside = self.boundaries().into_iter().filter(|x| *x > from && *x < to);
        edges.extend(inside.collect::<Vec<_>>());
        edges.push(to);
        let mut t = t;
        for pair in edges.windows(2) {
            let cells = if t == ambient { 1 } else { ((pair[1] - pair[0]) / STEP).ceil().max(1.0) as usize };
            let h = (pair[1] - pair[0]) / cells as f64;
            let perimeter = PI * self.diameter(0.5 * (pair[0] + pair[1]));
            for k in 0..cells {
                let slope = |t: f64| {
                    let excess = t - ambient;
                    if excess == 0.0 {
                        return 0.0;
                    }
                    let transfer = cooling.coefficient + cooling.per_kelvin * excess.abs();
                    -transfer * perimeter * excess / (self.mass_flow * self.at_temperature(t).specific_heat)
                };
                // Runge and Kutta, fourth order.
                let (k1, before) = (slope(t), t);
                let k2 = slope(t + 0.5 * h * k1);
                let k3 = slope(t + 0.5 * h * k2);
                let k4 = slope(t + h * k3);
                t += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
                let low = pair[0] + k as f64 * h;
                let (temperature, slope) = ([before, t], [k1, slope(t)]);
                self.pieces.push(Piece { x: [low, low + h], temperature, slope });
            }
        }
        t
    }

    /// The temperature of gas of `t` after `heat`, J/kg: Newton on the enthalpy.
    fn heated(&self, t: f64, heat: f64) -> f64 {
        let [c0, c1, c2, c3] = self.gas.heat_capacity;
        let enthalpy =
            |t: f64| t * (c0 + t * (c1 / 2.0 + t * (c2 / 3.0 + t * c3 / 4.0))) / self.gas.molar_mass;
        let mut hot = t;
        for _ in 0..20 {
            hot -= (enthalpy(hot) - enthalpy(t) - heat) / self.at_temperature(hot).specific_heat;
        }
        hot
    }

    fn at_temperature(&self, t: f64) -> GasState {
        self.gas.at(t, self.pressure)
    }

    /// Where one duct ends and the next begins, m.
    pub(crate) fn boundaries(&self) -> Vec<f64> {
        let ends = self.ducts.iter().scan(0.0, |x, duct| {
            *x += duct[0];
            Some(*x)
        });
        let mut all: Vec<f64> = ends.collect();
        all.pop();
        all
    }

    /// The duct that holds `x`; at a boundary, the one downstream.
    pub(crate) fn duct(&self, x: f64) -> usize {
        self.boundaries().iter().filter(|edge| x >= **edge).count()
    }

    fn diameter(&self, x: f64) -> f64 {
        self.ducts[self.duct(x)][1]
    }

    /// Length of all ducts, m.
    pub(crate) fn length(&self) -> f64 {
        self.ducts.iter().map(|duct| duct[0]).sum()
    }

    /// Temperature and its slope at `x`, K and K/m; at an edge, those of the piece upstream.
    pub(crate) fn temperature(&self, x: f64) -> [f64; 2] {
        let k = self.pieces.partition_point(|piece| piece.x[1] < x).min(self.pieces.len() - 1);
        let Piece { x: [x0, x1], temperature: [t0, t1], slope: [d0, d1] } = self.pieces[k];
        let h = x1 - x0;
        let r = (x - x0) / h;
        let (rise, a) = (t1 - t0, (d0 + d1) * h - 2.0 * (t1 - t0));
        let b = rise - d0 * h;
        // Hermite: t0 + d0 h r + (b - a) r^2 + a r^3 with value and slope right at both ends.
        let value = t0 + r * (d0 * h + r * ((b - a) + r * a));
        let slope = (d0 * h + r * (2.0 * (b - a) + 3.0 * r * a)) / h;
        [value, slope]
    }

    /// The gas at `x`.
    pub(crate) fn gas(&self, x: f64) -> GasState {
        self.at_temperature(self.temperature(x)[0])
    }

    /// The gas law at this pressure, for films.
    pub(crate) fn law(&self) -> &Gas {
        &self.gas
    }

    /// The gas at another temperature, K.
    pub(crate) fn gas_at(&self, temperature: f64) -> GasState {
        self.at_temperature(temperature)
    }

    /// Whether the gas has one temperature between `a` and `b`.
    pub(crate) fn is_uniform(&self, a: f64, b: f64) -> bool {
        let middle = 0.5 * (a + b);
        let [t, slope] = self.temperature(middle);
        slope == 0.0 && self.temperature(0.999 * a + 0.001 * b)[0] == t && self.temperature(b)[0] == t
    }
}

/// `value`, or what is wrong with it.
pub(crate) fn within(
    point: &Point,
    key: &'static str,
    value: f64,
    low: f64,
    high: f64,
) -> Result<f64, BenchError> {
    if value >= low && value <= high {
        return Ok(value);
    }
    Err(BenchError::OutOfRange { point: point.id.clone(), key, value, low, high })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::campaign;
    use std::path::Path;

    /// 50 W into a duct with a change of area behind it; the heat capacity does not depend on temperature.
    fn truth(at: f64) -> BenchTruth {
        let text = format!(
            "name = \"t\"\ncampaign = \"c\"\nvolume_flow = 1e-3\nupstream = {{ type = \"rigid\" }}
downstream = {{ type = \"rigid\" }}
cooling = {{ coefficient = 8.0 }}
search = {{ growth_rate = [-1.0, 0.0], frequency_hz = [1.0, 2.0] }}
noise = {{ growth_rate = 1.0, frequency_hz = 1.0, pressure = 1.0 }}
microphones = {{ at = [0.1], reference = 1 }}
duct = [{{ length = 0.5, diameter = 0.05, layers = 1.0 }}, {{ length = 0.3, diameter = 0.03, layers = 1.0 }}]
source = [{{ at = {at}, thickness = 0.01, power = 50.0, share = 0.8, times = \"seconds\" }}]
gas = {{ molar_mass = 0.029, heat_capacity = [29.1, 0.0, 0.0, 0.0], viscosity = [1.7e-5, 110.0], conductivity = [0.024, 194.0] }}"
        );
        crate::toml_file::parse(&text, Path::new("t")).unwrap()
    }

    fn base(at: f64) -> Result<Base, BenchError> {
        let points = campaign::parse("point,T_amb\na,293.0\n", Path::new("c")).unwrap();
        Base::new(&truth(at), &points[0], 293.0)
    }

    #[test]
    fn exact_rise_and_cooling_where_the_heat_capacity_is_constant() {
        let base = base(0.2).unwrap();
        let capacity = base.mass_flow * 29.1 / 0.029;
        let rise = 40.0 / capacity;
        assert!((base.temperature(0.205)[0] - 293.0 - rise).abs() < 1e-9 * rise);
        assert!((base.temperature(0.2)[0] - 293.0 - 0.5 * rise).abs() < 1e-9 * rise);
        for x in [0.211, 0.45, 0.5, 0.6003, 0.8] {
            let wetted = PI * (0.05 * (f64::min(x, 0.5) - 0.205) + 0.03 * f64::max(x - 0.5, 0.0));
            let expected = rise * (-8.0 * wetted / capacity).exp();
            let [t, slope] = base.temperature(x);
            assert!((t - 293.0 - expected).abs() < 1e-8 * rise, "{x}: {t}");
            let diameter = if x > 0.5 { 0.03 } else { 0.05 };
            assert!(
                (slope / (-8.0 * PI * diameter / capacity * expected) - 1.0).abs() < 1e-5,
                "{x}: {slope}"
            );
        }
    }

    #[test]
    fn exact_a_source_across_a_change_of_area_is_refused() {
        assert!(base(0.5).unwrap_err().to_string().contains("point a: beginning of a source"));
        assert!(base(0.506).is_ok());
    }
}
